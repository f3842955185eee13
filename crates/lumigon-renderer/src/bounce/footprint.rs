//! The part of a plane that a texel sees.

use glam::{DVec2, DVec3};

/// Most corners of a footprint: a square has four, and each of the texel's sides may add one.
const MOST_CORNERS: usize = 12;

/// Coordinates in a plane; x, y and the normal are right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaneFrame {
    pub(super) origin: DVec3,
    pub(super) x: DVec3,
    pub(super) y: DVec3,
}

impl PlaneFrame {
    pub(super) fn new(origin: DVec3, normal: DVec3) -> Self {
        let (x, y) = normal.any_orthonormal_pair();
        let y = if x.cross(y).dot(normal) < 0.0 { -y } else { y };
        Self { origin, x, y }
    }

    /// With x as far along a direction as it can be.
    pub(super) fn along(origin: DVec3, normal: DVec3, direction: DVec3) -> Self {
        let across = normal.cross(direction);
        match across.try_normalize() {
            Some(y) => Self {
                origin,
                x: y.cross(normal),
                y,
            },
            None => Self::new(origin, normal),
        }
    }

    pub(super) fn normal(&self) -> DVec3 {
        self.x.cross(self.y)
    }

    pub(super) fn flat(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(offset.dot(self.x), offset.dot(self.y))
    }

    pub(super) fn raised(&self, point: DVec2) -> DVec3 {
        self.origin + self.x * point.x + self.y * point.y
    }
}

/// The least and the greatest coordinates.
pub(super) fn bounds<'a>(points: impl Iterator<Item = &'a DVec2> + Clone) -> [DVec2; 2] {
    [
        points.clone().fold(DVec2::INFINITY, |a, &b| a.min(b)),
        points.fold(DVec2::NEG_INFINITY, |a, &b| a.max(b)),
    ]
}

/// A convex polygon in a plane, counter-clockwise, of few corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Convex {
    corners: [DVec2; MOST_CORNERS],
    count: usize,
}

impl Convex {
    /// The axis-aligned square about a point.
    pub(super) fn square(center: DVec2, half_side: f64) -> Self {
        let mut corners = [DVec2::ZERO; MOST_CORNERS];
        for (corner, (x, y)) in
            corners
                .iter_mut()
                .zip([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        {
            *corner = center + DVec2::new(x, y) * half_side;
        }
        Self { corners, count: 4 }
    }

    pub(super) fn corners(&self) -> &[DVec2] {
        &self.corners[..self.count]
    }

    /// The part where `height` is not negative; it must be linear.
    pub(super) fn clipped(&self, height: impl Fn(DVec2) -> f64) -> Self {
        let mut part = Self {
            corners: self.corners,
            count: 0,
        };
        let mut push = |corner| {
            // Rounding alone could exceed what a convex polygon can have.
            if part.count < MOST_CORNERS {
                part.corners[part.count] = corner;
                part.count += 1;
            }
        };
        for i in 0..self.count {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (above, next) = (height(from), height(to));
            if above >= 0.0 {
                push(from);
            }
            if (above >= 0.0) != (next >= 0.0) {
                push(from.lerp(to, above / (above - next)));
            }
        }
        part
    }

    pub(super) fn contains(&self, point: DVec2) -> bool {
        let corners = self.corners();
        let following = corners.iter().cycle().skip(1);
        let mut edges = corners.iter().zip(following);
        edges.all(|(&a, &b)| (b - a).perp_dot(point - a) >= 0.0)
    }

    pub(super) fn area(&self) -> f64 {
        let Some(&first) = self.corners().first() else {
            return 0.0;
        };
        let doubled: f64 = self
            .corners()
            .windows(2)
            .map(|pair| (pair[0] - first).perp_dot(pair[1] - first))
            .sum();
        (0.5 * doubled).max(0.0)
    }

    /// Centroid; the mean of the corners where there is no area.
    pub(super) fn centroid(&self) -> DVec2 {
        let corners = self.corners();
        let Some(&first) = corners.first() else {
            return DVec2::ZERO;
        };
        let (mut moment, mut doubled) = (DVec2::ZERO, 0.0);
        for pair in corners.windows(2) {
            let (a, b) = (pair[0] - first, pair[1] - first);
            moment += (a + b) * a.perp_dot(b);
            doubled += a.perp_dot(b);
        }
        if doubled > 0.0 {
            first + moment / (3.0 * doubled)
        } else {
            corners.iter().sum::<DVec2>() / corners.len() as f64
        }
    }
}

/// What a texel sees of the plane through `position`, seen from `eye`; `corners` are the texel's as
/// [`CubeMap::corners`](super::CubeMap) gives them, `spacing` is its width at a distance of 1.
///
/// A plane seen at a grazing angle may fill a texel to infinity: the footprint ends where a texel would
/// that sees it under its central angle, twice over, and four times as far away as the eye is.
pub(super) fn footprint(
    eye: DVec3,
    corners: &[DVec3; 4],
    spacing: f64,
    position: DVec3,
    frame: &PlaneFrame,
) -> Convex {
    let offset = position - eye;
    let distance = offset.length();
    let cosine = (frame.normal().dot(offset) / distance).abs();
    // The largest coordinate is the distance along the face's axis.
    let width = spacing * offset.abs().max_element();
    let half_side = (2.0 * width / cosine).min(4.0 * distance);
    if !(half_side > 0.0 && half_side.is_finite()) {
        return Convex::square(frame.flat(position), 0.0);
    }
    let mut seen = Convex::square(frame.flat(position), half_side);
    for k in 0..4 {
        let side = corners[(k + 1) % 4].cross(corners[k]);
        let (slope_x, slope_y) = (side.dot(frame.x), side.dot(frame.y));
        let constant = side.dot(frame.origin - eye);
        seen = seen.clipped(|p| constant + p.x * slope_x + p.y * slope_y);
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::super::CubeMap;
    use super::*;

    #[test]
    fn footprints_tile_a_plane() {
        // A floor below the centre, out to the edges of the lower face and well beyond.
        let map = CubeMap {
            center: [0.0; 3],
            face_size: 8,
            texels: Vec::new(),
        };
        let normal = DVec3::Y;
        let frame = PlaneFrame::new(DVec3::new(0.3, -1.0, 0.2), normal);
        let mut area = 0.0;
        for index in 3 * 64..4 * 64 {
            let corners = map.corners(index);
            let center: DVec3 = corners.iter().sum::<DVec3>() * 0.25;
            let position = center * (-1.0 / center.y);
            let part = footprint(DVec3::ZERO, &corners, 0.25, position, &frame);
            let own = part.area();
            assert!((own - 1.0 / 16.0).abs() < 1e-12, "{own}");
            let middle = frame.raised(part.centroid());
            assert!(middle.distance(position) < 1e-12);
            area += own;
        }
        assert!((area - 4.0).abs() < 1e-12);
    }

    #[test]
    fn grazing_and_senseless_planes_have_finite_footprints() {
        let map = CubeMap {
            center: [0.0; 3],
            face_size: 1,
            texels: Vec::new(),
        };
        let corners = map.corners(0);
        for (position, normal) in [
            (DVec3::new(1.0, -1e-9, 0.0), DVec3::Y),
            (DVec3::new(1.0, 0.0, 0.0), DVec3::Y),
            (DVec3::ZERO, DVec3::Y),
            (DVec3::NAN, DVec3::Y),
            (DVec3::new(1e30, 0.0, 0.0), DVec3::NEG_X),
        ] {
            let frame = PlaneFrame::new(position, normal);
            let part = footprint(DVec3::ZERO, &corners, 2.0, position, &frame);
            let area = part.area();
            assert!(area.is_finite() && area >= 0.0, "{position}: {area}");
        }
    }

    #[test]
    fn halves_make_up_the_whole() {
        let whole = Convex::square(DVec2::new(0.3, 0.1), 1.5);
        let height = |p: DVec2| p.x * 0.3 - p.y + 0.2;
        let (upper, lower) = (whole.clipped(height), whole.clipped(|p| -height(p)));
        assert!((upper.area() + lower.area() - 9.0).abs() < 1e-12);
        assert_eq!(whole.clipped(|_| -1.0).area(), 0.0);
    }
}
