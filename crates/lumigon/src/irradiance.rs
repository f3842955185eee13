//! Vector irradiance, irradiance and form factor of a polygon light, exact.
//!
//! Lambert's formula ("Photometria", 1760) in Stokes' form: Arvo, "Analytic Methods for Simulated
//! Light Transport", 1995; the derivation by Iwanicki, "Deriving the analytical formula for a
//! diffuse response from a polygonal light source". The light vector is
//! `F = 1/2 sum theta_i gamma_i` over the edges: `theta_i` the angle an edge subtends, `gamma_i` the
//! unit normal of its plane with the shading point. Irradiance is n.F.

use crate::clip::{
    Above, Compass, Edge, Horizon, Offsets, Seen, Shared, for_each_edge, for_each_edge_above,
    height_range,
};
use crate::polygon::PolygonLight;
use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// Farther than this squared distance (in radii) every edge subtends less than 45 degrees.
pub(crate) const FAR: f64 = 7.0;

/// Irradiance at `point` on a surface with unit `normal` from a light of radiance 1, clipped at
/// the surface's horizon. In \[0, pi\].
///
/// Exact: the error is rounding. Double precision: 1e-13 absolute. Single precision: 1e-6
/// absolute over the distance from the nearest edge (in radii, at most 1); for a light wholly
/// above the horizon and farther than twice its radius, 1e-6 relative over the product of the
/// cosines at light and receiver, at any distance. 0 behind a one-sided light, in the light's
/// plane (within rounding), for a light below the horizon, and farther than 1e9 radii away. A
/// point or normal that is not a number gives 0 or NaN.
#[inline(always)]
pub fn irradiance<T: Real>(light: &PolygonLight<T::Scalar>, point: Vec3<T>, normal: Vec3<T>) -> T {
    let seen = Seen::new(light, point);
    let zero = point.x.constant(0.0);
    // The early-outs of "Polygonal Area Light Sources on DX11-Class Hardware" (2013), with both
    // comparisons as they were meant: by the circumscribed circle, wholly below or wholly above.
    let height = normal.dot(seen.center);
    let one = point.x.constant(1.0);
    let visible = seen.lit & height.gt(-one);
    if !visible.any() {
        return zero;
    }
    let offsets = Shared::new(light, point.x);
    let horizon = Above(normal);
    let (least, greatest) = if height.ge(one).all() {
        (zero, one)
    } else {
        height_range(light, seen.center, offsets, horizon)
    };
    if !(visible & greatest.gt(zero)).any() {
        return zero;
    }
    let whole = least.ge(zero);
    let sum = if whole.all() {
        let area = light_area(light, normal);
        unclipped(light, seen.center, offsets, horizon, area)
    } else {
        let clipped = clipped(light, seen.center, offsets, horizon, seen.away);
        let far = whole & squared_length(seen.center).gt(point.x.constant(FAR));
        if far.any() {
            let area = light_area(light, normal);
            let whole = far_sum(light, seen.center, offsets, horizon, area);
            T::select(far, whole, clipped)
        } else {
            clipped
        }
    };
    let value = sum * seen.orientation * point.x.constant(0.5);
    // Next to an edge rounding turns the edge's plane, and the sum might pass its bounds.
    let pi = point.x.constant(core::f64::consts::PI);
    T::select(visible, value.max(zero).min(pi), zero)
}

/// [`irradiance`] over pi: the fraction of a Lambertian receiver's hemisphere, cosine-weighted,
/// that the light fills. In \[0, 1\].
#[inline(always)]
pub fn form_factor<T: Real>(light: &PolygonLight<T::Scalar>, point: Vec3<T>, normal: Vec3<T>) -> T {
    irradiance(light, point, normal) * point.x.constant(core::f64::consts::FRAC_1_PI)
}

/// The light vector at `point` from a light of radiance 1, with no horizon: the integral of the
/// unit direction over the light's solid angle. Towards the light; length in \[0, pi\].
///
/// n.F is the irradiance of any surface whose horizon the light does not cross. Zero behind a
/// one-sided light. Accuracy as [`irradiance`]'s.
#[inline(always)]
pub fn light_vector<T: Real>(light: &PolygonLight<T::Scalar>, point: Vec3<T>) -> Vec3<T> {
    let seen = Seen::new(light, point);
    let offsets = Shared::new(light, point.x);
    let zero = point.x.constant(0.0);
    let mut sum = Vec3::new(zero, zero, zero);
    let far = squared_length(seen.center).gt(point.x.constant(FAR));
    if !far.all() {
        for_each_edge(
            light,
            seen.center,
            offsets,
            #[inline(always)]
            |edge| {
                sum = edge.cross.mul_add(edge.angle_over_sine(), sum);
            },
        );
    }
    if far.any() {
        let doubled_area = point.x.broadcast(light.doubled_area);
        let area = Vec3::broadcast(point.x, light.normal) * doubled_area;
        let over_distance = point.x.constant(1.0) / squared_length(seen.center);
        let mut far_sum = area * over_distance;
        for_each_far_edge(
            light,
            seen.center,
            offsets,
            #[inline(always)]
            |cross, weight| {
                far_sum = cross.mul_add(weight, far_sum);
            },
        );
        sum = Vec3::select(far, far_sum, sum);
    }
    finished(sum, &seen)
}

/// The light vector of the part of the light above the horizon of a surface with unit `normal`.
///
/// Its component along `normal` is the irradiance. Within rounding of the near form: relative
/// error in single precision grows with the distance in radii.
#[inline(always)]
pub fn light_vector_above<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
) -> Vec3<T> {
    let seen = Seen::new(light, point);
    let offsets = Shared::new(light, point.x);
    let zero = point.x.constant(0.0);
    let mut sum = Vec3::new(zero, zero, zero);
    let mut along_horizon = zero;
    let compass = Compass::new(Above(normal), seen.away);
    for_each_edge_above(
        light,
        seen.center,
        offsets,
        Above(normal),
        #[inline(always)]
        |edge| sum = edge.cross.mul_add(edge.angle_over_sine(), sum),
        #[inline(always)]
        |crossing, sign| along_horizon = compass.azimuth(crossing).mul_add(sign, along_horizon),
    );
    finished(normal.mul_add(along_horizon, sum), &seen)
}

/// The light vector from twice its sum: turned with the light's loops, and within its bounds.
#[inline(always)]
fn finished<T: Real>(sum: Vec3<T>, seen: &Seen<T>) -> Vec3<T> {
    let like = seen.plane_distance;
    let zero = like.constant(0.0);
    let dark = Vec3::new(zero, zero, zero);
    let mut vector = Vec3::select(
        seen.lit,
        sum * (seen.orientation * like.constant(0.5)),
        dark,
    );
    // Next to an edge rounding turns the edge's plane, and the sum might become too long.
    let squared = squared_length(vector);
    let pi = like.constant(core::f64::consts::PI);
    let too_long = squared.gt(pi * pi);
    if too_long.any() {
        let shorter = pi / squared.sqrt();
        vector = vector * T::select(too_long, shorter, like.constant(1.0));
    }
    vector
}

#[inline(always)]
fn squared_length<T: Real>(v: Vec3<T>) -> T {
    v.dot(v)
}

/// Twice the light's area projected on the surface, in squared radii, signed as its loops.
#[inline(always)]
fn light_area<T: Real>(light: &PolygonLight<T::Scalar>, normal: Vec3<T>) -> T {
    let like = normal.x;
    normal.dot(Vec3::broadcast(like, light.normal)) * like.broadcast(light.doubled_area)
}

/// Sum over the edges of a light wholly above the horizon.
#[inline(always)]
pub(crate) fn unclipped<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    horizon: impl Horizon<T>,
    doubled_area: T,
) -> T {
    let far = squared_length(center).gt(center.x.constant(FAR));
    if far.all() {
        return far_sum(light, center, offsets, horizon, doubled_area);
    }
    let mut sum = center.x.constant(0.0);
    for_each_edge(
        light,
        center,
        offsets,
        #[inline(always)]
        |edge: Edge<T>| {
            sum = horizon
                .height(edge.cross)
                .mul_add(edge.angle_over_sine(), sum);
        },
    );
    if far.any() {
        let far_sum = far_sum(light, center, offsets, horizon, doubled_area);
        sum = T::select(far, far_sum, sum);
    }
    sum
}

/// Sum over what of the edges is above the horizon, and along the horizon.
#[inline(always)]
pub(crate) fn clipped<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    horizon: impl Horizon<T>,
    away: Vec3<T>,
) -> T {
    let mut sum = center.x.constant(0.0);
    let mut along_horizon = sum;
    let compass = Compass::new(horizon, away);
    for_each_edge_above(
        light,
        center,
        offsets,
        horizon,
        #[inline(always)]
        |edge| {
            sum = horizon
                .height(edge.cross)
                .mul_add(edge.angle_over_sine(), sum);
        },
        #[inline(always)]
        |crossing, sign| along_horizon = compass.azimuth(crossing).mul_add(sign, along_horizon),
    );
    sum + along_horizon
}

/// [`unclipped`] for a light farther than its edges are long.
///
/// There the edge terms are of order 1/D and cancel to order 1/D^2, which costs single precision
/// everything by D = 1000. Since the cross products sum to twice the area, a constant, the
/// cancellation is done on paper: each edge adds only its weight's difference from 1/D^2.
#[inline(always)]
pub(crate) fn far_sum<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    horizon: impl Horizon<T>,
    doubled_area: T,
) -> T {
    let mut sum = doubled_area / squared_length(center);
    for_each_far_edge(
        light,
        center,
        offsets,
        #[inline(always)]
        |cross, weight| {
            sum = horizon.height(cross).mul_add(weight, sum);
        },
    );
    sum
}

/// Calls `visit` with each edge's cross product and the difference of its weight
/// ([`Edge::angle_over_sine`]) from the inverse squared distance of the light's centre.
#[inline(always)]
fn for_each_far_edge<T: Real>(
    light: &PolygonLight<T::Scalar>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    mut visit: impl FnMut(Vec3<T>, T),
) {
    let one = center.x.constant(1.0);
    let squared_distance = squared_length(center);
    let inverse_squared_distance = one / squared_distance;
    for range in light.loop_ranges() {
        let mut start = offsets.get(range.end - 1);
        for i in range {
            let end = offsets.get(i);
            let cross = (start + center).cross(end - start);
            // start.end = D^2 + excess, both relative to the shading point.
            let excess = center.dot(start + end) + start.dot(end);
            let inverse = one / (squared_distance + excess);
            let squared_tangent = (squared_length(cross) * inverse * inverse).min(one);
            let weight =
                T::angle_over_sine_excess(squared_tangent) - excess * inverse_squared_distance;
            visit(cross, weight * inverse);
            start = end;
        }
    }
}
