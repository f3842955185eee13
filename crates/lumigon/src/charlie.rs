//! The Charlie sheen BRDF of cloth, as glTF's `KHR_materials_sheen` states it.
//!
//! Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", SIGGRAPH 2017 course "Physically
//! Based Shading": the distribution is their equation 2, the masking their equation 3 with the
//! fitted table. Their softening of the terminator is no part of the glTF extension, nor of this.

use crate::real::Scalar;
use crate::vec3::Vec3;

/// Smallest width of Charlie.
///
/// The lobe is then an edge of 1e-3 radians along the horizon; glTF allows 0, where D has no value.
pub const MINIMUM_SHEEN_ALPHA: f64 = 1e-6;

/// Smallest cosine whose masking is evaluated: below it the fit masks ever less, and the albedo
/// would grow without bound.
const MINIMUM_COSINE: f64 = 1e-5;

/// The BRDF times the cosine at the light, F = 1 and colour 1: D G / (4 n.v), in 1/sr.
///
/// All three vectors are unit and point away from the surface; `alpha` is the sheen's perceptual
/// roughness squared, clamped to \[[`MINIMUM_SHEEN_ALPHA`], 1\]. 0 where light or view is below the
/// horizon. Symmetric about the normal, reciprocal when divided by n.l.
///
/// The model conserves energy only where `alpha` is at least 0.07. Below, D outgrows the fitted
/// masking: the directional albedo at 89 degrees is 1.3 for alpha 0.03, 4.1 for 1e-3 and higher yet
/// for less. Whoever layers it must divide by that albedo where it exceeds 1.
///
/// For one lane only: powers and exponentials have no SIMD form here. They are taken in double
/// precision for f32 too: a power of 1/(2 alpha) magnifies rounding by as much.
pub fn charlie_cosine<T: Scalar>(alpha: T, normal: Vec3<T>, view: Vec3<T>, light: Vec3<T>) -> T {
    let (cos_view, cos_light) = (normal.dot(view).to_f64(), normal.dot(light).to_f64());
    if !(cos_view > 0.0 && cos_light > 0.0) {
        return T::from_f64(0.0);
    }
    let half = (view + light).normalize_or_zero();
    let cos_half = normal.dot(half).to_f64().clamp(0.0, 1.0);
    // NaN too becomes the smallest.
    let alpha = f64::max(alpha.to_f64(), MINIMUM_SHEEN_ALPHA);
    let alpha = alpha.min(1.0);
    let (view, light) = (cos_view.max(MINIMUM_COSINE), cos_light.max(MINIMUM_COSINE));
    let masking = 1.0 + lambda(view, alpha) + lambda(light, alpha);
    let value = distribution(cos_half, alpha) / (4.0 * masking * view) * (cos_light / light);
    T::from_f64(value)
}

/// D = (2 + 1/alpha) sin^(1/alpha) / 2 pi.
fn distribution(cos_half: f64, alpha: f64) -> f64 {
    let exponent = 0.5 / alpha;
    // sin^2 is hardly less than 1 wherever D is not 0: its logarithm comes from the cosine.
    let power = libm::exp(exponent * libm::log1p(-cos_half * cos_half));
    (1.0 + exponent) * power * core::f64::consts::FRAC_1_PI
}

/// Smith's Lambda for this distribution: the fit, which is for angles past 60 degrees, and its
/// mirror image for the rest.
fn lambda(cosine: f64, alpha: f64) -> f64 {
    if cosine < 0.5 {
        libm::exp(log_lambda(cosine, alpha))
    } else {
        libm::exp(2.0 * log_lambda(0.5, alpha) - log_lambda((1.0 - cosine).max(0.0), alpha))
    }
}

/// a / (1 + b x^c) + d x + e, the coefficients interpolated by (1 - alpha)^2 between the paper's
/// for alpha 1 and for alpha 0.
fn log_lambda(x: f64, alpha: f64) -> f64 {
    const ROUGH: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
    const SMOOTH: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
    let smoothness = (1.0 - alpha) * (1.0 - alpha);
    let coefficient = |i: usize| ROUGH[i] + (SMOOTH[i] - ROUGH[i]) * smoothness;
    let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(coefficient);
    a / (1.0 + b * libm::pow(x, c)) + d * x + e
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMAL: Vec3<f64> = Vec3::new(0.0, 0.0, 1.0);

    /// Worked in 30 digits from the extension's formulas.
    #[test]
    fn values() {
        let high = Vec3::new(0.6, 0.0, 0.8);
        let higher = Vec3::new(-0.28, 0.0, 0.96);
        let low = Vec3::new(0.96, 0.0, 0.28);
        let aside = Vec3::new(0.0, 0.8, 0.6);
        let before = Vec3::new(0.8, 0.0, 0.6);
        let cases = [
            (0.01, low, aside, 3.310_853_652_029_4e-9),
            (0.01, low, before, 2.627_793_534_583_813e-5),
            (0.25, high, higher, 0.000_206_850_396_778_361_86),
            (0.25, low, aside, 0.074_612_244_070_774_48),
            (0.25, low, before, 0.106_855_320_788_271_22),
            (1.0, high, higher, 0.021_834_459_453_850_116),
            (1.0, low, aside, 0.108_369_094_519_641_02),
            (1.0, low, before, 0.118_550_108_879_201_54),
        ];
        for (alpha, view, light, want) in cases {
            let got = charlie_cosine(alpha, NORMAL, view, light);
            // A power of 1/(2 alpha) magnifies the rounding of cos_half.
            assert!(
                (got / want - 1.0).abs() < 1e-14 / alpha,
                "{alpha}: {got} {want}"
            );
            let single = |v: Vec3<f64>| Vec3::new(v.x as f32, v.y as f32, v.z as f32);
            let got = charlie_cosine(alpha as f32, single(NORMAL), single(view), single(light));
            assert!(
                (f64::from(got) / want - 1.0).abs() < 1e-5,
                "{alpha}: {got} {want}"
            );
        }
    }

    #[test]
    fn reciprocal_and_dark_below() {
        let (a, b) = (Vec3::new(0.8, 0.0, 0.6), Vec3::new(0.0, 0.96, 0.28));
        for alpha in [0.0, 1e-3, 0.3, 1.0] {
            let there = charlie_cosine(alpha, NORMAL, a, b) / b.z;
            let back = charlie_cosine(alpha, NORMAL, b, a) / a.z;
            assert!((there - back).abs() <= 1e-13 * there, "{alpha}");
            assert_eq!(charlie_cosine(alpha, NORMAL, a, -b), 0.0);
            assert_eq!(charlie_cosine(alpha, NORMAL, -a, b), 0.0);
        }
    }

    /// White light from everywhere: where alpha is 0.07 and more, a surface of colour 1 never gives
    /// off more than it gets.
    #[test]
    fn furnace() {
        for alpha in [0.07, 0.1, 0.3, 0.6, 1.0] {
            for cos_view in [
                1e-12, 1e-7, 1e-5, 1e-3, 0.01, 0.02, 0.04, 0.1, 0.3, 0.7, 1.0,
            ] {
                let albedo = albedo(alpha, cos_view);
                assert!(albedo < 1.0, "{alpha} {cos_view}: {albedo}");
            }
        }
    }

    /// Against another program's integrals, which also shows where the model gains energy.
    #[test]
    fn albedos() {
        let cases = [
            (1e-3, 0.01, 4.1305),
            (0.01, 0.1, 0.5218),
            (0.03, 0.03, 1.0380),
            (0.1, 0.3, 0.2292),
            (0.3, 0.03, 0.7509),
            (1.0, 0.1, 0.7205),
            (1.0, 1.0, 0.1638),
        ];
        for (alpha, cos_view, want) in cases {
            let got = albedo(alpha, cos_view);
            assert!(
                (got / want - 1.0).abs() < 2e-3,
                "{alpha} {cos_view}: {got} {want}"
            );
        }
    }

    /// Midpoints; in the logarithm of the cosine, because narrow lobes hug the horizon.
    fn albedo(alpha: f64, cos_view: f64) -> f64 {
        let view = Vec3::new(libm::sqrt(1.0 - cos_view * cos_view), 0.0, cos_view);
        let (rows, columns) = (800, 64);
        let least = libm::log(1e-7);
        let mut sum = 0.0;
        for i in 0..rows {
            let cosine = libm::exp(least * (f64::from(i) + 0.5) / f64::from(rows));
            let sine = libm::sqrt(1.0 - cosine * cosine);
            for j in 0..columns {
                let azimuth = core::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(columns);
                let (sin, cos) = libm::sincos(azimuth);
                let light = Vec3::new(sine * cos, sine * sin, cosine);
                sum += charlie_cosine(alpha, NORMAL, view, light) * cosine;
            }
        }
        sum * -least / f64::from(rows) * core::f64::consts::TAU / f64::from(columns)
    }

    #[test]
    fn hostile() {
        let numbers = [0.0, -1.0, 1e-300, 1e300, f64::INFINITY, f64::NAN];
        for &alpha in &numbers {
            for &x in &[0.0, 1e-300, 1e-9, 0.5, 1.0] {
                let light = Vec3::new(libm::sqrt(1.0 - x * x), 0.0, x);
                for view in [NORMAL, light, -light] {
                    let got = charlie_cosine(alpha, NORMAL, view, light);
                    assert!(got.is_finite() && got >= 0.0, "{alpha} {x} {view:?}: {got}");
                    let single = |v: Vec3<f64>| Vec3::new(v.x as f32, v.y as f32, v.z as f32);
                    let got =
                        charlie_cosine(alpha as f32, single(NORMAL), single(view), single(light));
                    assert!(got.is_finite() && got >= 0.0, "{alpha} {x} {view:?}: {got}");
                }
            }
            // No direction at all.
            let none = Vec3::new(alpha, alpha, alpha);
            let got = charlie_cosine(0.5, NORMAL, none, NORMAL);
            assert!(got.is_finite() && got >= 0.0, "{alpha}: {got}");
        }
    }
}
