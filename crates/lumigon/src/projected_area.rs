//! The projected-area approximation of diffuse light, with every projection basis.
//!
//! Petryaev, "Polygons as lights: algebraic approximation of polygonal area lights": the light's
//! area in a perspective projection from the shading point stands for the integral. The missing
//! cosine at the receiver, not the basis, is most of its error.

use crate::clip::{Above, Seen, Shared, for_each_edge_above};
use crate::polygon::PolygonLight;
use crate::pyramid::Pyramid;
use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// Vertices closer to the projection plane than this (in the light's radii), or behind it, are
/// moved here: the area stays finite, but is no longer the light's.
const NEAREST: f64 = 1e-3;

/// The axis along which a light is projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProjectionBasis {
    /// Towards the light's centroid. Vertices may fall behind the projection plane close by.
    Centroid,
    /// Towards the mean of the vertices weighted by inverse distance. Somewhat better close by.
    Weighted,
    /// Towards the centroid, from a point this far behind the shading point (scene units). Keeps
    /// vertices in front at the price of a smaller, differently shaped spot.
    Biased {
        /// How far, in scene units; not negative.
        bias: f64,
    },
    /// The axis of the right pyramid: the one that passes through the centroid of its own
    /// cross-section. Exists and is unique for every polygon; every vertex stays in front.
    Optimal,
}

/// How much of a light that crosses the surface's horizon counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LocalOcclusion {
    /// The light is clipped at the horizon.
    #[default]
    Exact,
    /// A linear ramp over the circumscribed circle's height.
    Circle,
}

/// Area of the light projected on the plane at unit distance along the basis' axis, after local
/// occlusion by the horizon of a surface with unit `normal`. Dimensionless, at least 0.
///
/// Where a vertex falls behind the projection plane (never with [`ProjectionBasis::Optimal`]) the
/// method has no answer and the result is merely finite. 0 behind a one-sided light.
#[inline(always)]
pub fn projected_area<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
    basis: ProjectionBasis,
    occlusion: LocalOcclusion,
) -> T {
    let seen = Seen::new(light, point);
    let (zero, one) = (point.x.constant(0.0), point.x.constant(1.0));
    let height = normal.dot(seen.center);
    let visible = seen.lit & height.gt(-one);
    if !visible.any() {
        return zero;
    }
    let axis = projection_axis(light, point, basis);
    let center = match basis {
        ProjectionBasis::Biased { bias } => axis.mul_add(
            point.x.constant(bias) * point.x.broadcast(light.inverse_radius),
            seen.center,
        ),
        _ => seen.center,
    };
    let area = match occlusion {
        LocalOcclusion::Circle => {
            let ramp = (height + one) * point.x.constant(0.5);
            whole_area(light, center, axis) * ramp.max(zero).min(one)
        }
        LocalOcclusion::Exact if height.ge(one).all() => whole_area(light, center, axis),
        LocalOcclusion::Exact => {
            // Clipped at the point's own horizon, then projected from the biased centre.
            let bias = center - seen.center;
            let clipped = area_above(light, &seen, bias, normal, axis);
            T::select(height.ge(one), whole_area(light, center, axis), clipped)
        }
    };
    T::select(visible, (area * seen.orientation).max(zero), zero)
}

/// Unit axis of the projection, from `point` towards the light.
#[inline(always)]
pub fn projection_axis<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    basis: ProjectionBasis,
) -> Vec3<T> {
    match basis {
        ProjectionBasis::Centroid | ProjectionBasis::Biased { .. } => {
            let seen = Seen::new(light, point);
            (Vec3::broadcast(point.x, light.centroid) + seen.center).normalize_or_zero()
        }
        ProjectionBasis::Weighted => {
            let seen = Seen::new(light, point);
            let zero = point.x.constant(0.0);
            // Weights 1/distance make this the sum of unit directions.
            let mut sum = Vec3::new(zero, zero, zero);
            for &vertex in &light.offsets {
                sum += (Vec3::broadcast(point.x, vertex) + seen.center).normalize_or_zero();
            }
            sum.normalize_or_zero()
        }
        ProjectionBasis::Optimal => Pyramid::new(light, point).axis,
    }
}

/// Signed as the loops.
#[inline(always)]
fn whole_area<T: Real>(light: &PolygonLight<T::Scalar>, center: Vec3<T>, axis: Vec3<T>) -> T {
    let like = axis.x;
    let nearest = like.constant(NEAREST);
    let center_depth = axis.dot(center).max(nearest);
    let inverse = like.constant(1.0) / center_depth;
    let inverse_squared = inverse * inverse;
    let normal = Vec3::broadcast(like, light.normal);
    let mut sum = axis.dot(normal) * like.broadcast(light.doubled_area) * inverse_squared;
    // As for the irradiance of a far light: what each edge differs from the centre, since the
    // cross products sum to a constant.
    for range in light.loop_ranges() {
        let mut start = Vec3::broadcast(like, light.offsets[range.end - 1]);
        let mut start_depth = (center_depth + axis.dot(start)).max(nearest);
        for i in range {
            let end = Vec3::broadcast(like, light.offsets[i]);
            let end_depth = (center_depth + axis.dot(end)).max(nearest);
            let product = start_depth * end_depth;
            let (a, b) = (start_depth - center_depth, end_depth - center_depth);
            let difference = -(center_depth * (a + b) + a * b) * inverse_squared / product;
            let cross = (start + center).cross(end - start);
            sum = axis.dot(cross).mul_add(difference, sum);
            (start, start_depth) = (end, end_depth);
        }
    }
    sum * like.constant(0.5)
}

/// Area of what is above the horizon; signed as the loops.
///
/// A shoelace sum over the kept pieces. Its closing chain runs along one straight line, the
/// horizon's image, on which the sum depends on the end points alone.
#[inline(always)]
fn area_above<T: Real>(
    light: &PolygonLight<T::Scalar>,
    seen: &Seen<T>,
    bias: Vec3<T>,
    normal: Vec3<T>,
    axis: Vec3<T>,
) -> T {
    let like = axis.x;
    let nearest = like.constant(NEAREST);
    let mut sum = like.constant(0.0);
    let mut chain = sum;
    // The plane through the biased centre and the line where light and horizon meet.
    let moved =
        normal - seen.away * (normal.dot(bias) / (seen.plane_distance + seen.away.dot(bias)));
    let along = axis.cross(moved);
    let line = -axis.dot(moved) / along.dot(along).max(like.constant(1e-12));
    for_each_edge_above(
        light,
        seen.center,
        Shared::new(light, like),
        Above(normal),
        #[inline(always)]
        |edge| {
            let cross = edge.cross + bias.cross(edge.end - edge.start) * edge.kept;
            sum += axis.dot(cross)
                / (axis.dot(edge.start + bias).max(nearest)
                    * axis.dot(edge.end + bias).max(nearest));
        },
        #[inline(always)]
        |crossing, sign| {
            let crossing = crossing + bias;
            chain += sign * line * along.dot(crossing) / axis.dot(crossing).max(nearest);
        },
    );
    (sum + chain) * like.constant(0.5)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{Sides, solid_angle};
    use alloc::vec;
    use alloc::vec::Vec;

    const UP: Vec3<f64> = Vec3::new(0.0, 0.0, 1.0);
    const ALL: [ProjectionBasis; 4] = [
        ProjectionBasis::Centroid,
        ProjectionBasis::Weighted,
        ProjectionBasis::Biased { bias: 0.3 },
        ProjectionBasis::Optimal,
    ];

    /// A concave outline with a hole, above the plane z = 0, facing down.
    pub(crate) fn frame(height: f64, tilt: f64) -> PolygonLight<f64> {
        let ring = |points: &[[f64; 2]]| -> Vec<[f64; 3]> {
            points
                .iter()
                .map(|p| [p[0], p[1], height + tilt * p[0]])
                .collect()
        };
        let outline = ring(&[
            [-1.0, -1.0],
            [-1.2, 1.0],
            [0.1, 0.5],
            [1.0, 1.1],
            [1.0, -1.0],
        ]);
        let hole = ring(&[[-0.5, -0.5], [0.4, -0.5], [0.2, 0.1]]);
        PolygonLight::new(&[outline, hole], Sides::Front).unwrap()
    }

    #[test]
    fn far_away_area_is_the_solid_angle() {
        for distance in [100.0, 1e4] {
            let light = frame(distance, 0.3);
            let omega: f64 = solid_angle(&light, Vec3::default());
            for basis in ALL {
                let basis = match basis {
                    ProjectionBasis::Biased { .. } => ProjectionBasis::Biased { bias: 0.0 },
                    other => other,
                };
                let area: f64 =
                    projected_area(&light, Vec3::default(), UP, basis, LocalOcclusion::Exact);
                assert!((area / omega - 1.0).abs() < 1e-3, "{basis:?} {distance}");
                let single = projected_area(
                    &light.cast::<f32>().unwrap(),
                    Vec3::default(),
                    Vec3::new(0.0_f32, 0.0, 1.0),
                    basis,
                    LocalOcclusion::Exact,
                );
                assert!(
                    (f64::from(single) / area - 1.0).abs() < 2e-5,
                    "{basis:?} {single} {area}"
                );
            }
        }
    }

    /// A parallel light overhead, seen along its normal: projection divides lengths by distance.
    #[test]
    fn area_overhead_is_area_over_squared_distance() {
        let outline = vec![
            [-1.0, -1.0, 2.0],
            [-1.0, 1.0, 2.0],
            [1.0, 1.0, 2.0],
            [1.0, -1.0, 2.0],
        ];
        let light = PolygonLight::new(&[outline], Sides::Front).unwrap();
        for basis in ALL {
            let distance = match basis {
                ProjectionBasis::Biased { bias } => 2.0 + bias,
                _ => 2.0,
            };
            for occlusion in [LocalOcclusion::Exact, LocalOcclusion::Circle] {
                let got = projected_area(&light, Vec3::default(), UP, basis, occlusion);
                assert!(
                    (got - 4.0 / (distance * distance)).abs() < 1e-12,
                    "{basis:?} {got}"
                );
            }
        }
    }

    /// Cutting by a horizon and its opposite leaves two parts that make the whole.
    #[test]
    fn the_two_sides_of_a_horizon_add_up() {
        let light = frame(1.5, -0.4);
        for basis in ALL {
            for i in 0..24 {
                let angle = f64::from(i) * core::f64::consts::TAU / 24.0;
                let (s, c) = (libm::sin(angle), libm::cos(angle));
                for z in [0.02, 0.3, 0.8] {
                    let t = libm::sqrt(1.0 - z * z);
                    let n = Vec3::new(c * t, s * t, z);
                    let area = |n: Vec3<f64>| {
                        projected_area(&light, Vec3::default(), n, basis, LocalOcclusion::Exact)
                    };
                    let whole = area(UP);
                    let sum = area(n) + area(-n);
                    assert!(
                        (sum - whole).abs() < 1e-10 * whole,
                        "{basis:?} {i} {z}: {sum} {whole}"
                    );
                }
            }
        }
    }
}
