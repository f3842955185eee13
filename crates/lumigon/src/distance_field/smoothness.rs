//! From GGX's alpha to the source's k_s.

use crate::real::Real;

/// k_s for a GGX surface of width `alpha` in \[0, 1\], for a field of this `phi`.
#[inline(always)]
pub fn distance_field_smoothness<T: Real>(alpha: T, phi: T) -> T {
    let one = alpha.constant(1.0);
    phi * (one / alpha.max(alpha.constant(1e-6)))
}
