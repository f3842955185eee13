//! Edges of a light as a shading point sees them, clipped at its horizon without a vertex array.

use crate::polygon::{PolygonLight, Sides};
use crate::real::{Mask, Real, Scalar};
use crate::vec3::Vec3;

/// In radii: from farther away a light is dark.
///
/// Its irradiance would be below 1e-17; products of four distances would overflow single
/// precision at ten times as far.
const FARTHEST: f64 = 1e9;

/// A light as one shading point sees it, in units of the light's radius.
#[derive(Clone, Copy)]
pub(crate) struct Seen<T: Real> {
    /// From the shading point to the centre of the circumscribed circle.
    pub(crate) center: Vec3<T>,
    /// Unit normal of the light's plane, away from the shading point.
    pub(crate) away: Vec3<T>,
    /// Distance to the light's plane, not negative.
    pub(crate) plane_distance: T,
    /// -1 where the point sees the front: there, loops run clockwise about `away`; else +1.
    pub(crate) orientation: T,
    /// Whether the light has a solid angle: the point is off its plane and not out of reach.
    pub(crate) in_reach: T::Mask,
    /// Whether the point sees an emitting side.
    pub(crate) lit: T::Mask,
}

impl<T: Real> Seen<T> {
    #[inline(always)]
    pub(crate) fn new(light: &PolygonLight<T::Scalar>, point: Vec3<T>) -> Self {
        let like = point.x;
        let center =
            (Vec3::broadcast(like, light.center) - point) * like.broadcast(light.inverse_radius);
        let normal = Vec3::broadcast(like, light.normal);
        let distance = normal.dot(center);
        let zero = like.constant(0.0);
        let front = distance.lt(zero);
        let one = like.constant(1.0);
        let orientation = T::select(front, -one, one);
        let plane_distance = distance.abs();
        // Within rounding of the plane the side is unknown: on an edge any direction might come out,
        // and a two-sided light would fill the hemisphere of half the points of its own faces.
        let mut in_plane = like.broadcast(light.plane_tolerance);
        if light.sides == Sides::Both {
            let reach = center.x.abs() + center.y.abs() + center.z.abs();
            in_plane = reach.mul_add(
                like.broadcast(T::Scalar::epsilon()) * like.constant(4.0),
                in_plane,
            );
        }
        let in_reach =
            plane_distance.gt(in_plane) & center.dot(center).lt(like.constant(FARTHEST * FARTHEST));
        Self {
            center,
            away: normal * orientation,
            plane_distance,
            orientation,
            in_reach,
            lit: match light.sides {
                Sides::Front => front & in_reach,
                Sides::Both => in_reach,
            },
        }
    }
}

/// Vertices relative to the light's centre, as a shading point wants them.
///
/// A trait and not a closure, because a closure that the compiler chooses not to inline loses
/// the processor's SIMD instructions.
pub(crate) trait Offsets<T>: Copy {
    fn get(self, i: usize) -> Vec3<T>;
}

/// The light's own vertices, the same in every lane.
#[derive(Clone, Copy)]
pub(crate) struct Shared<'a, T: Real> {
    light: &'a PolygonLight<T::Scalar>,
    like: T,
}

impl<'a, T: Real> Shared<'a, T> {
    #[inline(always)]
    pub(crate) fn new(light: &'a PolygonLight<T::Scalar>, like: T) -> Self {
        Self { light, like }
    }
}

impl<T: Real> Offsets<T> for Shared<'_, T> {
    #[inline(always)]
    fn get(self, i: usize) -> Vec3<T> {
        Vec3::broadcast(self.like, self.light.offsets[i])
    }
}

/// The plane through the shading point above which light arrives.
pub(crate) trait Horizon<T: Real>: Copy {
    /// Component along the normal.
    fn height(self, v: Vec3<T>) -> T;
    /// The normal.
    fn normal(self, like: T) -> Vec3<T>;
}

/// A horizon with any unit normal.
#[derive(Clone, Copy)]
pub(crate) struct Above<T>(pub(crate) Vec3<T>);

impl<T: Real> Horizon<T> for Above<T> {
    #[inline(always)]
    fn height(self, v: Vec3<T>) -> T {
        self.0.dot(v)
    }
    #[inline(always)]
    fn normal(self, _: T) -> Vec3<T> {
        self.0
    }
}

/// The horizon of a frame whose third axis is the normal.
#[derive(Clone, Copy)]
pub(crate) struct AboveZ;

impl<T: Real> Horizon<T> for AboveZ {
    #[inline(always)]
    fn height(self, v: Vec3<T>) -> T {
        v.z
    }
    #[inline(always)]
    fn normal(self, like: T) -> Vec3<T> {
        let zero = like.constant(0.0);
        Vec3::new(zero, zero, like.constant(1.0))
    }
}

/// Azimuths on a horizon, measured from the light plane's normal.
///
/// Every point of the light is in front of its plane, so every azimuth is within a quarter turn:
/// no branch cut.
#[derive(Clone, Copy)]
pub(crate) struct Compass<T> {
    north: Vec3<T>,
    east: Vec3<T>,
}

impl<T: Real> Compass<T> {
    #[inline(always)]
    pub(crate) fn new(horizon: impl Horizon<T>, away: Vec3<T>) -> Self {
        let normal = horizon.normal(away.x);
        Self {
            north: away - normal * horizon.height(away),
            east: normal.cross(away),
        }
    }

    #[inline(always)]
    pub(crate) fn azimuth(self, v: Vec3<T>) -> T {
        self.east.dot(v).atan2(self.north.dot(v))
    }

    /// The direction of azimuth 0, not normalised.
    #[inline(always)]
    pub(crate) fn north(self) -> Vec3<T> {
        self.north
    }
}

/// A piece of an edge, relative to the shading point.
#[derive(Clone, Copy)]
pub(crate) struct Edge<T> {
    pub(crate) start: Vec3<T>,
    pub(crate) end: Vec3<T>,
    /// start x end, accurate for far edges; zero where nothing of the edge is left.
    pub(crate) cross: Vec3<T>,
    /// 1 where anything of the edge is left, else 0.
    pub(crate) kept: T,
}

impl<T: Real> Edge<T> {
    /// Angle the edge subtends over the length of `cross`: the weight that turns `cross` into
    /// twice the edge's part of the vector irradiance.
    #[inline(always)]
    pub(crate) fn angle_over_sine(self) -> T {
        T::angle_over_sine(self.cross.dot(self.cross), self.start.dot(self.end))
    }
}

/// Least and greatest height of the light's vertices.
#[inline(always)]
pub(crate) fn height_range<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    horizon: impl Horizon<T>,
) -> (T, T) {
    let mut least = horizon.height(offsets.get(0));
    let mut greatest = least;
    for i in 1..light.offsets.len() {
        let height = horizon.height(offsets.get(i));
        least = least.min(height);
        greatest = greatest.max(height);
    }
    let center = horizon.height(center);
    (least + center, greatest + center)
}

/// Calls `visit` with every edge, whole.
#[inline(always)]
pub(crate) fn for_each_edge<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    mut visit: impl FnMut(Edge<T>),
) {
    let one = center.x.constant(1.0);
    for range in light.loop_ranges() {
        let mut start_offset = offsets.get(range.end - 1);
        let mut start = start_offset + center;
        for i in range {
            let end_offset = offsets.get(i);
            let end = end_offset + center;
            visit(Edge {
                start,
                end,
                cross: start.cross(end_offset - start_offset),
                kept: one,
            });
            (start_offset, start) = (end_offset, end);
        }
    }
}

/// Calls `visit` with the part of every edge above the horizon, and `cross` with each crossing:
/// the point and +1 where the edge rises, -1 where it sets, 0 in lanes where it does neither.
///
/// Stokes' theorem sums over the boundary of what is left of the light. That boundary is these
/// pieces and a chain along the horizon, and whatever is additive along the horizon depends on
/// the chain's end points alone: no clipped polygon is ever made. After Stark, "Vertex-based
/// formulations of irradiance from polygonal sources", IEEE TVCG 6(2), 2000.
#[inline(always)]
pub(crate) fn for_each_edge_above<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    horizon: impl Horizon<T>,
    mut visit: impl FnMut(Edge<T>),
    mut cross: impl FnMut(Vec3<T>, T),
) {
    let zero = center.x.constant(0.0);
    let one = center.x.constant(1.0);
    for range in light.loop_ranges() {
        let mut start_offset = offsets.get(range.end - 1);
        let mut start = start_offset + center;
        let mut start_height = horizon.height(start);
        for i in range {
            let end_offset = offsets.get(i);
            let end = end_offset + center;
            let end_height = horizon.height(end);
            let start_up = start_height.gt(zero);
            let end_up = end_height.gt(zero);
            if (start_up | end_up).any() {
                let along = end_offset - start_offset;
                let cross_product = start.cross(along);
                let crosses = start_up ^ end_up;
                if crosses.any() {
                    // The same point from the ascending end for both directions, so that an edge
                    // shared by two lights is cut once.
                    let rise = T::select(crosses, start_height - end_height, one);
                    let t = start_height / rise;
                    let crossing = along.mul_add(t, start);
                    let rises = crosses & end_up;
                    let sets = crosses & start_up;
                    cross(crossing, T::select(rises, one, T::select(sets, -one, zero)));
                    let left = T::select(rises, one - t, T::select(sets, t, one));
                    let kept = T::select(start_up | end_up, one, zero);
                    let left = left * kept;
                    visit(Edge {
                        start: Vec3::select(rises, crossing, start),
                        end: Vec3::select(sets, crossing, end),
                        cross: cross_product * left,
                        kept,
                    });
                } else {
                    let kept = T::select(start_up, one, zero);
                    visit(Edge {
                        start,
                        end,
                        cross: cross_product * kept,
                        kept,
                    });
                }
            }
            (start_offset, start, start_height) = (end_offset, end, end_height);
        }
    }
}
