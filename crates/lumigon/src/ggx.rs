//! The GGX microfacet BRDF with height-correlated Smith shadowing, and Schlick's Fresnel term.
//!
//! Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007; Heitz,
//! "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014;
//! Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994.

use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// Smallest GGX width that single precision evaluates without overflow.
pub const MINIMUM_ALPHA: f64 = 1e-4;

/// The BRDF times the cosine at the light, F = 1: D G2 / (4 n.v), in 1/sr.
///
/// All three vectors are unit and point away from the surface; `alpha` is perceptual roughness
/// squared and is raised to [`MINIMUM_ALPHA`]. 0 where light or view is below the horizon.
#[inline(always)]
pub fn ggx_cosine<T: Real>(alpha: T, normal: Vec3<T>, view: Vec3<T>, light: Vec3<T>) -> T {
    let zero = alpha.constant(0.0);
    let alpha = alpha.max(alpha.constant(MINIMUM_ALPHA));
    let squared_alpha = alpha * alpha;
    let (cos_view, cos_light) = (normal.dot(view), normal.dot(light));
    let above = cos_view.gt(zero) & cos_light.gt(zero);
    if !above.any() {
        return zero;
    }
    let half = (view + light).normalize_or_zero();
    // 1 - (n.h)^2 as a cross product: the difference loses everything near the mirror direction.
    let sine = normal.cross(half);
    let squared_cosine = normal.dot(half) * normal.dot(half);
    let denominator = sine.dot(sine) + squared_cosine * squared_alpha;
    let distribution = squared_alpha
        / (denominator * denominator * alpha.constant(core::f64::consts::PI))
            .max(alpha.constant(1e-30));
    // G2 / (4 n.v n.l) = 1 / (2 (n.l sqrt(..v..) + n.v sqrt(..l..)))
    let shadowing = cos_light * smith_root(squared_alpha, cos_view)
        + cos_view * smith_root(squared_alpha, cos_light);
    let value = distribution * cos_light / (shadowing + shadowing).max(alpha.constant(1e-30));
    T::select(above, value, zero)
}

/// The root in Smith's masking term: sqrt(alpha^2 + (1 - alpha^2) cosine^2).
#[inline(always)]
fn smith_root<T: Real>(squared_alpha: T, cosine: T) -> T {
    let one = squared_alpha.constant(1.0);
    (one - squared_alpha)
        .mul_add(cosine * cosine, squared_alpha)
        .sqrt()
}

/// Schlick's Fresnel reflectance with F90 = 1, for `cosine` = h.v in \[0, 1\].
#[inline(always)]
pub fn schlick<T: Real>(f0: T, cosine: T) -> T {
    let one = f0.constant(1.0);
    let x = (one - cosine).max(f0.constant(0.0));
    let squared = x * x;
    (one - f0).mul_add(squared * squared * x, f0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schlick_has_its_ends() {
        assert_eq!(schlick(0.04, 1.0), 0.04);
        assert_eq!(schlick(0.04_f32, 0.0), 1.0);
    }

    #[test]
    fn ggx_is_reciprocal_and_dark_below() {
        let n = Vec3::new(0.0, 0.0, 1.0);
        let v = Vec3::new(0.6, 0.0, 0.8);
        let l = Vec3::new(-0.28, 0.0, 0.96);
        let there = ggx_cosine(0.3, n, v, l) / l.z;
        let back = ggx_cosine(0.3, n, l, v) / v.z;
        assert!((there - back).abs() < 1e-14 * there);
        assert_eq!(ggx_cosine(0.3, n, v, Vec3::new(0.6, 0.0, -0.8)), 0.0);
    }

    /// The mirror direction: h = n, so D = 1/(pi alpha^2) in closed form.
    #[test]
    fn ggx_peak() {
        let n = Vec3::new(0.0_f32, 0.0, 1.0);
        let v = Vec3::new(0.6, 0.0, 0.8);
        let l = Vec3::new(-0.6, 0.0, 0.8);
        for alpha in [1e-4_f32, 0.01, 0.5, 1.0] {
            let got = ggx_cosine(alpha, n, v, l);
            let a2 = alpha * alpha;
            let lambda = (a2 + (1.0 - a2) * 0.64).sqrt();
            let want = 0.8 / (core::f32::consts::PI * a2) / (2.0 * 2.0 * 0.8 * lambda);
            assert!((got / want - 1.0).abs() < 1e-4, "{alpha}: {got} {want}");
        }
    }
}
