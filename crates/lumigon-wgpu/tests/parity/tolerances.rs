//! How far f32 on a GPU may be from f64 on the CPU, and why.

use crate::cases::Sight;

/// Irradiance, light vector, solid angle of a light beyond 2.7 radii that no horizon cuts, relative,
/// over the cosines at light and place: the crate states 2e-6 for its own f32; a GPU divides and
/// takes roots with an error of 2.5 units in the last place more.
pub(crate) const FAR: f64 = 3e-6;

/// The same near, or cut by a horizon, absolute, over the distance from the nearest edge in radii:
/// next to an edge rounding of the place alone turns the edge's direction. The crate states 2e-6 to
/// 3e-6.
pub(crate) const NEAR: f64 = 4e-6;

/// Whether f32 can tell where the place is: not on an edge, where all directions come together, and
/// not in the plane, where there is a jump. A sliver's width is itself near rounding.
pub(crate) fn is_comparable(sight: &Sight) -> bool {
    let height = sight.plane_height.abs();
    let off_plane = height > 1e-4 && height > 2.0 * sight.in_plane && sight.cos_light > 1e-3;
    sight.nearness > 1e-4 && off_plane && !sight.is_sliver
}

/// Quantities that are additive over a light, from the true one: of a light above the horizon or
/// without one.
pub(crate) fn flux(sight: &Sight, has_horizon: bool, exact: f64) -> Option<f64> {
    if !is_comparable(sight) {
        return None;
    }
    // Heights over the horizon are rounded as the distance is.
    let is_whole = !has_horizon || sight.lowest > 1e-3 + 1e-6 * sight.distance;
    if sight.distance > 2.7 && is_whole {
        let cosines = sight.cos_light * if has_horizon { sight.cos_place } else { 1.0 };
        return Some(FAR * exact.abs() / cosines.max(1e-12) + 1e-37);
    }
    Some(NEAR / sight.nearness * sight.edges)
}
