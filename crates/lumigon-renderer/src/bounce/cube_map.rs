//! What a point sees all around.

use glam::{Affine3A, DVec3, Mat3, Vec3};

use crate::scene::{Camera, Projection};

/// Forward and up of each face; right is forward x up.
const FACES: [[Vec3; 2]; 6] = [
    [Vec3::X, Vec3::Y],
    [Vec3::NEG_X, Vec3::Y],
    [Vec3::Y, Vec3::Z],
    [Vec3::NEG_Y, Vec3::Z],
    [Vec3::Z, Vec3::Y],
    [Vec3::NEG_Z, Vec3::Y],
];

/// What a texel's central ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeTexel {
    /// World-space position.
    pub position: [f32; 3],
    /// Unit normal of the triangle's plane, towards the cube map's centre.
    pub normal: [f32; 3],
    /// Linear RGB: the share of irradiance that leaves again as diffuse light.
    pub albedo: [f32; 3],
    /// Linear RGB radiance of that light.
    pub radiance: [f32; 3],
    /// The triangle, counted over all meshes of the scene.
    pub triangle: u32,
}

/// Six square pictures of the surfaces around a point.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    /// Where it looks from, in world space.
    pub center: [f32; 3],
    /// Texels across a face.
    pub face_size: u32,
    /// Face after face (+X, -X, +Y, -Y, +Z, -Z), row after row from the top, as
    /// [`CubeMap::camera`] sees them; `None` where a ray meets nothing.
    pub texels: Vec<Option<CubeTexel>>,
}

impl CubeMap {
    /// The camera of a face: a right angle wide and high. The sides look with Y up, the top and the
    /// bottom with Z up.
    ///
    /// # Panics
    /// Where there is no such face: there are six.
    #[must_use]
    pub fn camera(center: [f32; 3], face: usize) -> Camera {
        let [forward, up] = FACES[face];
        let axes = Mat3::from_cols(forward.cross(up), up, -forward);
        Camera {
            name: format!("cube map {}", ["+X", "-X", "+Y", "-Y", "+Z", "-Z"][face]),
            world_from_camera: Affine3A::from_mat3_translation(axes, center.into()),
            projection: Projection::Perspective {
                yfov: std::f32::consts::FRAC_PI_2,
                aspect: Some(1.0),
            },
        }
    }

    /// Where texels meet: the corners of texel `index`, counter-clockwise seen from the centre, as
    /// vectors whose longest coordinate is 1.
    pub(super) fn corners(&self, index: usize) -> [DVec3; 4] {
        let (face, column, row) = self.place(index);
        [(0, 1), (1, 1), (1, 0), (0, 0)]
            .map(|(dx, dy)| self.direction(face, f64::from(column + dx), f64::from(row + dy)))
    }

    /// Face, column and row of a texel.
    fn place(&self, index: usize) -> (usize, u32, u32) {
        let size = self.face_size as usize;
        let (face, rest) = (index / (size * size), index % (size * size));
        (face, (rest % size) as u32, (rest / size) as u32)
    }

    /// Texels from the left and from the top to a direction.
    fn direction(&self, face: usize, x: f64, y: f64) -> DVec3 {
        let [forward, up] = FACES[face].map(DVec3::from);
        let right = forward.cross(up);
        let size = f64::from(self.face_size);
        forward + right * (2.0 * x / size - 1.0) + up * (1.0 - 2.0 * y / size)
    }

    /// The texel that a direction falls into; `None` for none.
    pub(super) fn texel_towards(&self, direction: DVec3) -> Option<usize> {
        let size = f64::from(self.face_size);
        let along = |axis: Vec3| direction.dot(axis.as_dvec3());
        let (face, depth) = FACES
            .iter()
            .map(|&[forward, _]| along(forward))
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        if !(depth > 0.0 && depth.is_finite()) {
            return None;
        }
        let [forward, up] = FACES[face];
        let texel = |x: f64| ((0.5 + 0.5 * x / depth) * size).clamp(0.0, size - 1.0) as usize;
        let (column, row) = (texel(along(forward.cross(up))), texel(-along(up)));
        let size = self.face_size as usize;
        Some((face * size + row) * size + column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(face_size: u32) -> CubeMap {
        CubeMap {
            center: [0.5, -2.0, 7.0],
            face_size,
            texels: Vec::new(),
        }
    }

    #[test]
    fn cameras_look_through_the_texels() {
        let map = map(5);
        for index in 0..150 {
            let (face, column, row) = map.place(index);
            let camera = CubeMap::camera(map.center, face);
            let middle = |texel: u32| (texel as f32 + 0.5) / 5.0;
            let (origin, direction) = camera.ray(middle(column), middle(row), 1.0);
            assert_eq!(origin, Vec3::from(map.center));
            let corners = map.corners(index);
            let center: DVec3 = corners.iter().sum::<DVec3>() * 0.25;
            assert!(center.normalize().distance(direction.as_dvec3()) < 1e-6);
            assert_eq!(map.texel_towards(center), Some(index));
            // Counter-clockwise seen from inside.
            for k in 0..4 {
                let side = corners[(k + 1) % 4].cross(corners[k]);
                assert!(side.dot(center) > 0.0, "{index}");
            }
        }
    }

    #[test]
    fn directions_without_length_fall_nowhere() {
        let map = map(1);
        for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert_eq!(map.texel_towards(direction), None);
        }
    }
}
