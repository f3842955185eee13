//! Shading as if all of a polygon's light came from one direction.
//!
//! "Polygonal Area Light Sources on DX11-Class Hardware" (2013), after Arvo (1994): the light
//! vector, clipped at the horizon and normalised, goes into any BRDF as the direction of a point
//! light. The source drops the vector's length and scales by a free intensity; here the solid
//! angle of what is above the horizon takes its place, so that radiance means radiance.

use alloc::vec::Vec;

use crate::irradiance::{light_vector, light_vector_above};
use crate::polygon::PolygonLight;
use crate::projected_area::LocalOcclusion;
use crate::real::{Real, Scalar};
use crate::solid_angle::{solid_angle, solid_angle_above};
use crate::vec3::Vec3;

/// A light gathered into one direction.
#[derive(Clone, Copy, Debug)]
pub struct LightDirection<T> {
    /// Unit vector towards the light; zero where there is none.
    pub direction: Vec3<T>,
    /// Solid angle of the light that counts, in sr.
    pub solid_angle: T,
}

/// The direction of the light vector and the solid angle behind it, above the horizon of a
/// surface with unit `normal`.
///
/// Exact as a light vector; as shading it is an approximation that ignores the light's extent:
/// for irradiance, good while the light subtends less than a tenth of a steradian.
#[inline(always)]
pub fn light_direction<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
    occlusion: LocalOcclusion,
) -> LightDirection<T> {
    match occlusion {
        LocalOcclusion::Exact => LightDirection {
            direction: light_vector_above(light, point, normal).normalize_or_zero(),
            solid_angle: solid_angle_above(light, point, normal),
        },
        LocalOcclusion::Circle => LightDirection {
            direction: light_vector(light, point).normalize_or_zero(),
            solid_angle: solid_angle(light, point) * circle_occlusion(light, point, normal),
        },
    }
}

/// The share of the light's circumscribed circle above the horizon, as a linear ramp over the
/// centre's height. In \[0, 1\].
#[inline(always)]
pub fn circle_occlusion<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
) -> T {
    let (zero, one) = (point.x.constant(0.0), point.x.constant(1.0));
    let center = Vec3::broadcast(point.x, light.center) - point;
    let height = normal.dot(center) * point.x.broadcast(light.inverse_radius);
    ((height + one) * point.x.constant(0.5)).max(zero).min(one)
}

/// The conventional clip: a loop cut at the plane through the origin with `normal`, as
/// Sutherland and Hodgman do ("Reentrant Polygon Clipping", 1974).
///
/// The twin that the streaming clip is tested against. A concave loop leaves edges that run back
/// and forth along the plane; they add nothing to a sum over edges.
pub fn clip_loop<S: Scalar>(vertices: &[Vec3<S>], normal: Vec3<S>) -> Vec<Vec3<S>> {
    let zero = S::from_f64(0.0);
    let mut kept = Vec::with_capacity(vertices.len() + 2);
    let Some(&last) = vertices.last() else {
        return kept;
    };
    let (mut previous, mut previous_height) = (last, normal.dot(last));
    for &current in vertices {
        let height = normal.dot(current);
        if (height > zero) != (previous_height > zero) {
            let t = previous_height / (previous_height - height);
            kept.push((current - previous).mul_add(t, previous));
        }
        if height > zero {
            kept.push(current);
        }
        (previous, previous_height) = (current, height);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Sides, irradiance};
    use alloc::vec;

    /// Light vector of loops already relative to the shading point, edge by edge.
    fn edge_sum(loops: &[Vec<Vec3<f64>>]) -> Vec3<f64> {
        let mut sum = Vec3::default();
        for vertices in loops {
            for i in 0..vertices.len() {
                let (a, b) = (vertices[i], vertices[(i + 1) % vertices.len()]);
                let cross = a.cross(b);
                sum += cross.normalize_or_zero() * libm::atan2(cross.length(), a.dot(b));
            }
        }
        sum * -0.5
    }

    #[test]
    fn streaming_clip_equals_the_conventional_one() {
        let outline = vec![
            [0.0, 0.0, -1.0],
            [3.0, 0.5, -1.0],
            [0.8, 0.8, -1.0],
            [2.5, 2.5, -1.0],
            [0.7, 1.5, -1.0],
            [-1.0, 3.0, -1.0],
        ];
        let outline: Vec<_> = outline.into_iter().rev().collect();
        let hole = vec![[0.3, 0.3, -1.0], [0.6, 0.4, -1.0], [0.3, 0.7, -1.0]];
        let light = PolygonLight::new(&[outline, hole], Sides::Front).unwrap();
        let mut crossed = 0;
        for i in 0..2_000 {
            let f = f64::from(i);
            let normal =
                Vec3::new(libm::sin(f), libm::sin(f * 1.7), libm::sin(f * 2.3)).normalize_or_zero();
            let point = Vec3::new(
                2.0 * libm::cos(f * 0.9),
                2.0 * libm::sin(f * 0.4),
                -3.0 + libm::cos(f),
            );
            let clipped: Vec<Vec<_>> = light
                .loops()
                .map(|vertices| {
                    let local: Vec<_> = vertices.iter().map(|&v| v - point).collect();
                    clip_loop(&local, normal)
                })
                .collect();
            let twin = edge_sum(&clipped);
            let streamed = light_vector_above(&light, point, normal);
            assert!(
                (twin - streamed).length() < 1e-12,
                "{i}: {twin:?} {streamed:?}"
            );
            let e: f64 = irradiance(&light, point, normal);
            assert!((e - normal.dot(twin).max(0.0)).abs() < 1e-12);
            let whole = light_vector(&light, point);
            crossed += usize::from((whole - streamed).length() > 1e-6);
        }
        assert!(crossed > 500, "{crossed} lights crossed the horizon");
    }

    #[test]
    fn a_small_light_is_its_direction() {
        let outline = vec![
            [-0.1, -0.1, 5.0],
            [-0.1, 0.1, 5.0],
            [0.1, 0.1, 5.0],
            [0.1, -0.1, 5.0],
        ];
        let light = PolygonLight::new(&[outline], Sides::Front).unwrap();
        let normal = Vec3::new(0.6, 0.0, 0.8);
        for occlusion in [LocalOcclusion::Exact, LocalOcclusion::Circle] {
            let seen = light_direction(&light, Vec3::default(), normal, occlusion);
            let exact: f64 = irradiance(&light, Vec3::default(), normal);
            let approximate = seen.solid_angle * normal.dot(seen.direction);
            assert!((approximate / exact - 1.0).abs() < 1e-3);
        }
    }
}
