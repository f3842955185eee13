//! Solid angle of a polygon light, exact.

use crate::clip::{Above, Compass, Offsets, Seen, Shared, for_each_edge_above};
use crate::irradiance::FAR;
use crate::polygon::PolygonLight;
use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// Solid angle of the light as seen from `point`, with no horizon, in \[0, 2 pi\] sr.
///
/// Exact. Single precision: farther than twice the light's radius, 2e-6 relative over the cosine
/// at the light, at any distance; closer, 1e-6 absolute over the distance from the nearest edge
/// (in radii, at most 1). 0 behind a one-sided light, in the light's plane and farther than 1e9
/// radii away.
///
/// Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983, over a triangle fan,
/// the complex factors multiplied so that one arctangent serves all. The fan's apex is the
/// light's centre as long as that is far: then nothing cancels. Close by, where the point may be
/// next to an edge of that fan, it is the direction of the light's normal, from which every
/// vertex is within a right angle.
#[inline(always)]
pub fn solid_angle<T: Real>(light: &PolygonLight<T::Scalar>, point: Vec3<T>) -> T {
    let seen = Seen::new(light, point);
    let like = point.x;
    let (zero, one) = (like.constant(0.0), like.constant(1.0));
    let normal = Vec3::broadcast(like, light.normal);
    let far = seen.center.dot(seen.center).gt(like.constant(FAR));
    let mut fan = Fan::new(Vec3::select(far, seen.center, seen.away));
    // The triple product of an edge and the apex: about the centre the plane's distance times the
    // area; with the apex at the normal, of the edge as the point sees it.
    let scale = T::select(far, seen.plane_distance, one);
    let shift = Vec3::select(far, Vec3::new(zero, zero, zero), seen.center);
    let offsets = Shared::new(light, like);
    for range in light.loop_ranges() {
        let mut start = offsets.get(range.end - 1);
        for i in range {
            let end = offsets.get(i);
            let volume = normal.dot((start + shift).cross(end - start)) * scale;
            fan.add(start + seen.center, end + seen.center, volume);
            start = end;
        }
    }
    T::select(seen.lit, fan.solid_angle(), zero)
}

/// Solid angle of the part of the light above the horizon of a surface with unit `normal`, in
/// \[0, 2 pi\] sr.
///
/// Exact. Single precision: 1e-6 absolute over the distance from the nearest edge (in radii, at
/// most 1).
#[inline(always)]
pub fn solid_angle_above<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
) -> T {
    let seen = Seen::new(light, point);
    let like = point.x;
    if normal.dot(seen.center).ge(like.constant(1.0)).all() {
        return solid_angle(light, point);
    }
    let offsets = Shared::new(light, like);
    let north = Compass::new(Above(normal), seen.away).north();
    let mut fan = Fan::new(seen.away);
    let mut chain = Fan::new(seen.away);
    for_each_edge_above(
        light,
        seen.center,
        offsets,
        Above(normal),
        #[inline(always)]
        |edge| {
            let volume = seen.away.dot(edge.cross) * seen.orientation;
            fan.add(edge.start, edge.end, volume);
        },
        // The chain along the horizon, each piece as the difference of two from one direction.
        #[inline(always)]
        |crossing, sign| {
            let volume = seen.away.dot(north.cross(crossing)) * seen.orientation;
            chain.add(north, crossing, volume * sign);
        },
    );
    let zero = like.constant(0.0);
    T::select(seen.lit, fan.times(&chain).solid_angle(), zero)
}

/// Product of exp(i omega / 2) over the triangles between an apex and edges.
struct Fan<T> {
    apex: Vec3<T>,
    apex_distance: T,
    cosine: T,
    sine: T,
}

impl<T: Real> Fan<T> {
    #[inline(always)]
    fn new(apex: Vec3<T>) -> Self {
        Self {
            apex,
            apex_distance: apex.length(),
            cosine: apex.x.constant(1.0),
            sine: apex.x.constant(0.0),
        }
    }

    /// Adds the triangle (apex, `start`, `end`), whose triple product is `volume`; nothing where
    /// that is 0.
    #[inline(always)]
    fn add(&mut self, start: Vec3<T>, end: Vec3<T>, volume: T) {
        let (zero, one) = (volume.constant(0.0), volume.constant(1.0));
        let (start_distance, end_distance) = (start.length(), end.length());
        let cosine = self.apex_distance * start_distance * end_distance
            + self.apex.dot(start) * end_distance
            + start.dot(end) * self.apex_distance
            + end.dot(self.apex) * start_distance;
        let flat = volume.le(zero) & (-volume).le(zero);
        // Normalised as it goes: a product of hundreds of factors would overflow.
        let scale = one / (cosine.abs().max(volume.abs())).max(volume.constant(1e-37));
        let cosine = T::select(flat, one, cosine * scale);
        let sine = T::select(flat, zero, volume * scale);
        self.multiply(cosine, sine);
        let scale = one
            / self
                .cosine
                .abs()
                .max(self.sine.abs())
                .max(volume.constant(1e-37));
        self.cosine = self.cosine * scale;
        self.sine = self.sine * scale;
    }

    #[inline(always)]
    fn multiply(&mut self, cosine: T, sine: T) {
        (self.cosine, self.sine) = (
            self.cosine * cosine - self.sine * sine,
            self.cosine * sine + self.sine * cosine,
        );
    }

    /// Both fans together.
    #[inline(always)]
    fn times(mut self, other: &Self) -> Self {
        self.multiply(other.cosine, other.sine);
        self
    }

    #[inline(always)]
    fn solid_angle(&self) -> T {
        let zero = self.sine.constant(0.0);
        // A polygon in front of the point fills at most the hemisphere: rounding alone makes the
        // sine negative, next to 0 or next to 2 pi.
        let angle = self.sine.max(zero).atan2(self.cosine);
        angle + angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sides;
    use alloc::vec;

    /// A rectangle's solid angle from the point under its corner has a closed form of its own.
    fn corner_rectangle(w: f64, h: f64, d: f64) -> f64 {
        libm::atan(w * h / (d * libm::sqrt(d * d + w * w + h * h)))
    }

    #[test]
    fn rectangle_and_its_parts() {
        let outline = vec![
            [0.0, 0.0, 1.0],
            [0.0, 2.0, 1.0],
            [3.0, 2.0, 1.0],
            [3.0, 0.0, 1.0],
        ];
        let light = PolygonLight::new(&[outline], Sides::Front).unwrap();
        for distance in [1e-5, 0.1, 1.0, 100.0, 1e6] {
            let point = Vec3::new(0.0, 0.0, 1.0 - distance);
            let exact = corner_rectangle(3.0, 2.0, distance);
            let got = solid_angle(&light, point);
            // Under a corner, rounding of its place turns the nearest edge.
            let tolerance = 1e-13 + 2e-15 / distance;
            assert!(
                (got / exact - 1.0).abs() < tolerance,
                "{distance}: {got} {exact}"
            );
            let single = solid_angle(
                &light.cast::<f32>().unwrap(),
                Vec3::new(0.0, 0.0, (1.0 - distance) as f32),
            );
            let exact = corner_rectangle(3.0, 2.0, 1.0 - f64::from((1.0 - distance) as f32));
            assert!(
                (f64::from(single) / exact - 1.0).abs() < 1e-6 + 1e-6 / distance,
                "{distance}: {single}"
            );
        }
        // A wall's horizon that cuts the rectangle at x = 1 leaves a smaller rectangle.
        let point = Vec3::new(1.0, 0.0, 0.0);
        let got = solid_angle_above(&light, point, Vec3::new(-1.0, 0.0, 0.0));
        assert!((got - corner_rectangle(1.0, 2.0, 1.0)).abs() < 1e-14);
        let got = solid_angle_above(&light, point, Vec3::new(1.0, 0.0, 0.0));
        assert!((got - corner_rectangle(2.0, 2.0, 1.0)).abs() < 1e-14);
        let all = solid_angle_above(&light, point, Vec3::new(0.0, 0.0, 1.0));
        assert!((all - solid_angle(&light, point)).abs() < 1e-14);
    }

    #[test]
    fn nearly_a_hemisphere_and_behind() {
        let outline = vec![
            [-1.0, -1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, -1.0, 0.0],
        ];
        let mut light = PolygonLight::new(&[outline], Sides::Front).unwrap();
        let near = solid_angle(&light, Vec3::new(0.1, 0.2, -1e-9));
        assert!((near - core::f64::consts::TAU).abs() < 1e-7);
        assert_eq!(solid_angle(&light, Vec3::new(0.1, 0.2, 0.5)), 0.0);
        light.sides = Sides::Both;
        assert!(solid_angle(&light, Vec3::new(0.1, 0.2, 0.5)) > 1.0);
    }
}
