//! Where a texture lies on a plane.

use glam::{DVec2, DVec3};

/// An affine map from world positions on a plane to texture coordinates, where (0, 0) is the image's
/// upper left corner and (1, 1) its lower right one, the texture's transform applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMap {
    /// A point of the plane.
    pub point: [f64; 3],
    /// The texture coordinates at that point.
    pub uv: [f64; 2],
    /// The gradients of u and of v: vectors in the plane, per metre. Those of a texture that is
    /// drawn out to a stripe are parallel, and zero where it is drawn out to one colour.
    pub gradients: [[f64; 3]; 2],
}

impl TextureMap {
    /// The texture coordinates at a point of the plane.
    #[must_use]
    pub fn uv(&self, position: [f64; 3]) -> [f64; 2] {
        self.at(DVec3::from(position)).to_array()
    }

    pub(super) fn at(&self, position: DVec3) -> DVec2 {
        DVec2::from(self.uv) + self.change(position - DVec3::from(self.point))
    }

    /// How much the texture coordinates change along a vector.
    pub(super) fn change(&self, vector: DVec3) -> DVec2 {
        let [u, v] = self.gradients.map(DVec3::from);
        DVec2::new(u.dot(vector), v.dot(vector))
    }

    /// The map that a triangle's corners define, or `None` where it has no area.
    pub(super) fn of_triangle(corners: [DVec3; 3], uv: [DVec2; 3]) -> Option<Self> {
        let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
        let normal = e1.cross(e2);
        let doubled = normal.length();
        let unit = normal.try_normalize()?;
        // The reciprocal basis of the two edges.
        let (r1, r2) = (e2.cross(unit) / doubled, unit.cross(e1) / doubled);
        let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let map = Self {
            point: corners[0].to_array(),
            uv: uv[0].to_array(),
            gradients: [
                (r1 * d1.x + r2 * d2.x).to_array(),
                (r1 * d1.y + r2 * d2.y).to_array(),
            ],
        };
        let numbers = map.gradients.as_flattened().iter().chain(&map.uv);
        numbers.copied().all(f64::is_finite).then_some(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_meets_the_corners_and_is_linear_between() {
        let corners = [
            DVec3::new(1.0, 2.0, -3.0),
            DVec3::new(1.5, 2.5, -1.0),
            DVec3::new(0.0, 4.0, -2.0),
        ];
        for uv in [
            [(0.2, 0.7), (1.9, -0.4), (0.1, 3.0)],
            // A stripe, and a point.
            [(0.0, 0.0), (0.5, 0.25), (1.0, 0.5)],
            [(0.4, 0.6); 3],
        ] {
            let uv = uv.map(DVec2::from);
            let map = TextureMap::of_triangle(corners, uv).unwrap();
            for (p, expected) in corners.into_iter().zip(uv) {
                assert!((map.at(p) - expected).length() < 1e-12);
            }
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let expected = (uv[0] + uv[1] + uv[2]) / 3.0;
            assert!((DVec2::from(map.uv(middle.to_array())) - expected).length() < 1e-12);
            // Off the plane nothing changes.
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            assert!(map.change(normal).length() < 1e-12);
        }
        let flat = [corners[0], corners[1], corners[0]];
        assert!(TextureMap::of_triangle(flat, [DVec2::ZERO; 3]).is_none());
        let uv = [DVec2::ZERO, DVec2::NAN, DVec2::ONE];
        assert!(TextureMap::of_triangle(corners, uv).is_none());
    }
}
