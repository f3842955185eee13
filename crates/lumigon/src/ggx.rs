//! The GGX microfacet BRDF with height-correlated Smith shadowing, and Schlick's Fresnel term.
//!
//! Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007; Heitz,
//! "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014;
//! Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994. Anisotropic: Burley,
//! "Physically Based Shading at Disney", 2012.

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

/// [`ggx_cosine`] of a surface that is rougher one way than the other, F = 1, in 1/sr.
///
/// All vectors are unit, `tangent`, `bitangent` and `normal` orthogonal; `view` and `light` point
/// away from the surface. `alpha` are the widths along tangent and bitangent, raised to
/// [`MINIMUM_ALPHA`]. 0 where light or view is below the horizon.
#[inline(always)]
pub fn ggx_anisotropic_cosine<T: Real>(
    alpha: [T; 2],
    tangent: Vec3<T>,
    bitangent: Vec3<T>,
    normal: Vec3<T>,
    view: Vec3<T>,
    light: Vec3<T>,
) -> T {
    let like = normal.x;
    let zero = like.constant(0.0);
    let alpha = alpha.map(
        #[inline(always)]
        |width| width.max(like.constant(MINIMUM_ALPHA)),
    );
    let (cos_view, cos_light) = (normal.dot(view), normal.dot(light));
    let above = cos_view.gt(zero) & cos_light.gt(zero);
    if !above.any() {
        return zero;
    }
    let half = (view + light).normalize_or_zero();
    let (x, y) = (tangent.dot(half) / alpha[0], bitangent.dot(half) / alpha[1]);
    let z = normal.dot(half);
    // The squared length of h seen through the inverse widths; D is 1 / (pi times both widths) at h = n.
    let squared = x * x + y * y + z * z;
    let distribution = like.constant(core::f64::consts::FRAC_1_PI)
        / (alpha[0] * alpha[1] * squared * squared).max(like.constant(1e-30));
    // Smith's roots: |(alpha_t v.t, alpha_b v.b, n.v)|.
    let root_view = Vec3::new(
        tangent.dot(view) * alpha[0],
        bitangent.dot(view) * alpha[1],
        cos_view,
    )
    .length();
    let root_light = Vec3::new(
        tangent.dot(light) * alpha[0],
        bitangent.dot(light) * alpha[1],
        cos_light,
    )
    .length();
    let shadowing = cos_light * root_view + cos_view * root_light;
    let value = distribution * cos_light / (shadowing + shadowing).max(like.constant(1e-30));
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

    fn frame() -> [Vec3<f64>; 3] {
        let normal = Vec3::new(0.48, 0.6, 0.64);
        let (tangent, bitangent) = normal.orthonormal_basis();
        [tangent, bitangent, normal]
    }

    #[test]
    fn equal_widths_are_isotropic() {
        let [t, b, n] = frame();
        for alpha in [0.0, 1e-4, 0.01, 0.3, 1.0] {
            for (x, y) in [(0.3, -0.4), (-0.9, 0.2), (0.0, 0.999)] {
                let z = libm::sqrt(1.0 - x * x - y * y);
                let view = t * 0.6 + n * 0.8;
                for light in [t * x + b * y + n * z, t * (x - 0.6) + n * 0.8] {
                    let light = light.normalize_or_zero();
                    let got = ggx_anisotropic_cosine([alpha; 2], t, b, n, view, light);
                    let want = ggx_cosine(alpha, n, view, light);
                    assert!((got - want).abs() <= 1e-9 * want, "{alpha}: {got} {want}");
                }
            }
        }
    }

    /// The mirror direction, by hand: D = 1/(pi a b) for the widths a and b, and both roots
    /// are sqrt((0.6 a)^2 + 0.64) for a view that leans along the tangent.
    #[test]
    fn anisotropic_peak() {
        let [t, b, n] = frame();
        let (view, light) = (t * 0.6 + n * 0.8, t * -0.6 + n * 0.8);
        for (along, across) in [(0.5, 0.1), (0.1, 0.5), (1.0, 1e-4)] {
            let got = ggx_anisotropic_cosine([along, across], t, b, n, view, light);
            let root = libm::sqrt(0.36 * along * along + 0.64);
            let peak = 1.0 / (core::f64::consts::PI * along * across);
            let want = peak * 0.8 / (2.0 * 2.0 * 0.8 * root);
            assert!((got / want - 1.0).abs() < 1e-9, "{got} {want}");
        }
    }

    #[test]
    fn anisotropic_is_reciprocal_and_dark_below() {
        let [t, b, n] = frame();
        let (v, l) = (t * 0.48 + b * 0.64 + n * 0.6, t * -0.6 + n * 0.8);
        let there = ggx_anisotropic_cosine([0.7, 0.2], t, b, n, v, l) / n.dot(l);
        let back = ggx_anisotropic_cosine([0.7, 0.2], t, b, n, l, v) / n.dot(v);
        assert!((there - back).abs() < 1e-13 * there);
        assert_eq!(ggx_anisotropic_cosine([0.7, 0.2], t, b, n, v, -l), 0.0);
        assert_eq!(ggx_anisotropic_cosine([0.7, 0.2], t, b, n, -v, l), 0.0);
    }

    /// Seen along the normal a narrow lobe masks nothing and gives off all that it gets.
    #[test]
    fn anisotropic_furnace() {
        let [t, b, n] = frame();
        let widths = [0.02, 0.005];
        let (rows, columns) = (1_000, 64);
        let mut sum = 0.0;
        for i in 0..rows {
            // Slopes of the half vector in widths, out to infinity: squared u / (1 - u).
            let u = (f64::from(i) + 0.5) / f64::from(rows);
            let slope = libm::sqrt(u / (1.0 - u));
            for j in 0..columns {
                let azimuth = core::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(columns);
                let (sin, cos) = libm::sincos(azimuth);
                let half = t * (slope * cos * widths[0]) + b * (slope * sin * widths[1]) + n;
                let half = half.normalize_or_zero();
                let cosine = n.dot(half);
                let light = half * (2.0 * cosine) - n;
                let got = ggx_anisotropic_cosine(widths, t, b, n, n, light);
                // dl = 4 cos dh, dh = cos^3 times the area of slopes.
                sum += got * 4.0 * (cosine * cosine * cosine * cosine) / ((1.0 - u) * (1.0 - u));
            }
        }
        let area = core::f64::consts::PI * widths[0] * widths[1];
        let albedo = sum * area / f64::from(rows * columns);
        assert!((albedo - 1.0).abs() < 1e-3, "{albedo}");
    }

    #[test]
    fn anisotropic_is_finite() {
        let numbers = [0.0_f32, -1.0, 1e-38, 1.0, 1e38, f32::NAN];
        let [t, b, n] = frame().map(|v| Vec3::new(v.x as f32, v.y as f32, v.z as f32));
        for along in numbers {
            for across in numbers {
                for x in [0.0, 1e-30, 1e-6, 0.5, 1.0_f32] {
                    let light = (t * (1.0 - x) + n * x).normalize_or_zero();
                    for view in [n, light, (b + n * 1e-7).normalize_or_zero()] {
                        let got = ggx_anisotropic_cosine([along, across], t, b, n, view, light);
                        assert!(got.is_finite() && got >= 0.0, "{along} {across} {x}: {got}");
                    }
                }
            }
        }
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
