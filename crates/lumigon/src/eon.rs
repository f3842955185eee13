//! EON, the energy-preserving Oren-Nayar BRDF of rough diffuse surfaces.
//!
//! Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1),
//! 2025. Light scattered once is Fujii's variant of Oren and Nayar's model (FON); a second lobe
//! gives back what that loses, after Kulla and Conty. Both lobes are white here: the surface's
//! colour weighs the first as it is and the second as [`eon_multiple_albedo`], which is not linear.
//!
//! `diffuse_roughness` is the paper's r in \[0, 1\], which is glTF's `diffuseRoughnessFactor`: 0 is
//! Lambert. It and albedos are clamped to \[0, 1\].

use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// FON's c1 = 1/2 - 2/(3 pi): its A coefficient is 1 / (1 + c1 r).
const C1: f64 = 0.5 - 2.0 / 3.0 * core::f64::consts::FRAC_1_PI;
/// c2 = 2/3 - 28/(15 pi): FON's average albedo is A (1 + c2 r).
const C2: f64 = 2.0 / 3.0 - 28.0 / 15.0 * core::f64::consts::FRAC_1_PI;

/// The BRDF times the cosine at the light, for single-scattering albedo `rho`, in 1/sr.
///
/// All three vectors are unit and point away from the surface. 0 where light or view is below the
/// horizon. For colours, take the two lobes apart: they are the same in every channel.
#[inline(always)]
pub fn eon_cosine<T: Real>(
    rho: T,
    diffuse_roughness: T,
    normal: Vec3<T>,
    view: Vec3<T>,
    light: Vec3<T>,
) -> T {
    let rho = unit_interval(rho);
    rho * eon_single_cosine(diffuse_roughness, normal, view, light)
        + eon_multiple_albedo(rho, diffuse_roughness)
            * eon_multiple_cosine(diffuse_roughness, normal, view, light)
}

/// Light scattered once by a white surface, times the cosine: the paper's equation for FON,
/// A (1 + r s/t) / pi, in 1/sr.
#[inline(always)]
pub fn eon_single_cosine<T: Real>(
    diffuse_roughness: T,
    normal: Vec3<T>,
    view: Vec3<T>,
    light: Vec3<T>,
) -> T {
    let (zero, one) = (normal.x.constant(0.0), normal.x.constant(1.0));
    let (cos_view, cos_light) = (normal.dot(view), normal.dot(light));
    let above = cos_view.gt(zero) & cos_light.gt(zero);
    if !above.any() {
        return zero;
    }
    let r = unit_interval(diffuse_roughness);
    let s = view.dot(light) - cos_view * cos_light;
    let t = T::select(above & s.gt(zero), cos_view.max(cos_light), one);
    let response = (r * (s / t) + one).max(zero);
    let value = response * a_coefficient(r) * cos_light * r.constant(core::f64::consts::FRAC_1_PI);
    T::select(above, value, zero)
}

/// Light scattered more than once, for [`eon_multiple_albedo`] 1, times the cosine:
/// (1 - E(v)) (1 - E(l)) / (pi (1 - average E)), in 1/sr.
#[inline(always)]
pub fn eon_multiple_cosine<T: Real>(
    diffuse_roughness: T,
    normal: Vec3<T>,
    view: Vec3<T>,
    light: Vec3<T>,
) -> T {
    let zero = normal.x.constant(0.0);
    let (cos_view, cos_light) = (normal.dot(view), normal.dot(light));
    let above = cos_view.gt(zero) & cos_light.gt(zero);
    if !above.any() {
        return zero;
    }
    let r = unit_interval(diffuse_roughness);
    // 1 - E = A r (c1 - G/pi), and the average of E leaves A r (c1 - c2): A r divides out, and
    // with it the 0/0 of a smooth surface.
    let scale = r.constant(core::f64::consts::FRAC_1_PI / (C1 - C2));
    let value = loss(cos_view) * loss(cos_light) * a_coefficient(r) * r * cos_light * scale;
    T::select(above, value, zero)
}

/// Albedo of the light scattered more than once, for single-scattering albedo `rho`:
/// rho^2 E / (1 - rho (1 - E)) with the average E.
#[inline(always)]
pub fn eon_multiple_albedo<T: Real>(rho: T, diffuse_roughness: T) -> T {
    let one = rho.constant(1.0);
    let rho = unit_interval(rho);
    let r = unit_interval(diffuse_roughness);
    let average = (r * r.constant(C2) + one) * a_coefficient(r);
    rho * rho * average / (one - rho * (one - average))
}

/// Directional albedo of the light scattered once by a white surface, in \[0, 1\], for the cosine of
/// the view or light angle.
///
/// The paper's polynomial fit of FON's, within 6.1e-4 of it. The white surface's second lobe gives
/// the rest up to 1.
#[inline(always)]
pub fn eon_single_albedo<T: Real>(diffuse_roughness: T, cosine: T) -> T {
    let one = cosine.constant(1.0);
    let r = unit_interval(diffuse_roughness);
    one - loss(cosine) * r * a_coefficient(r)
}

/// Directional albedo of the whole BRDF for single-scattering albedo `rho`, in \[0, 1\]; 1 for a
/// white surface.
#[inline(always)]
pub fn eon_albedo<T: Real>(rho: T, diffuse_roughness: T, cosine: T) -> T {
    let rho = unit_interval(rho);
    let single = eon_single_albedo(diffuse_roughness, cosine);
    let multiple = cosine.constant(1.0) - single;
    rho * single + eon_multiple_albedo(rho, diffuse_roughness) * multiple
}

/// NaN is taken for 0.
#[inline(always)]
fn unit_interval<T: Real>(x: T) -> T {
    x.max(x.constant(0.0)).min(x.constant(1.0))
}

/// FON's A.
#[inline(always)]
fn a_coefficient<T: Real>(r: T) -> T {
    let one = r.constant(1.0);
    one / (r * r.constant(C1) + one)
}

/// (1 - E) / (A r) = c1 - G/pi, G/pi by the paper's fit: 0 along the surface, where the fit
/// overshoots by 5e-4.
#[inline(always)]
fn loss<T: Real>(cosine: T) -> T {
    const G_OVER_PI: [f64; 4] = [
        0.057_108_528_9,
        0.491_881_867,
        -0.332_181_442,
        0.071_442_995_3,
    ];
    let x = cosine.constant(1.0) - unit_interval(cosine);
    let mut sum = x.constant(G_OVER_PI[3]);
    for k in (0..3).rev() {
        sum = sum.mul_add(x, x.constant(G_OVER_PI[k]));
    }
    (x.constant(C1) - sum * x).max(x.constant(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMAL: Vec3<f64> = Vec3::new(0.0, 0.0, 1.0);

    fn at(cosine: f64) -> Vec3<f64> {
        Vec3::new(libm::sqrt(1.0 - cosine * cosine), 0.0, cosine)
    }

    /// Midpoints over the hemisphere: uniform in the cosine and the azimuth.
    fn integrate(view: Vec3<f64>, f: impl Fn(Vec3<f64>, Vec3<f64>) -> f64) -> f64 {
        let (rows, columns) = (400, 200);
        let mut sum = 0.0;
        for i in 0..rows {
            let cosine = (f64::from(i) + 0.5) / f64::from(rows);
            let sine = libm::sqrt(1.0 - cosine * cosine);
            for j in 0..columns {
                let azimuth = core::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(columns);
                let (sin, cos) = libm::sincos(azimuth);
                sum += f(view, Vec3::new(sine * cos, sine * sin, cosine));
            }
        }
        sum * core::f64::consts::TAU / f64::from(rows * columns)
    }

    #[test]
    fn smooth_is_lambert() {
        for cosine in [0.01, 0.3, 1.0] {
            let (light, pi) = (at(cosine), core::f64::consts::PI);
            let got = eon_cosine(0.7, 0.0, NORMAL, at(0.4), light);
            assert!((got - 0.7 * cosine / pi).abs() < 1e-15);
            assert_eq!(eon_albedo(0.7, 0.0, cosine), 0.7);
            assert_eq!(eon_multiple_cosine(0.0, NORMAL, at(0.4), light), 0.0);
        }
    }

    /// White light from everywhere: a white surface gives off all of it, others what their albedo
    /// says; both lobes too.
    #[test]
    fn furnace() {
        for r in [0.2, 1.0] {
            for cos_view in [0.05, 0.3, 0.7, 1.0] {
                let view = at(cos_view);
                let single = integrate(view, |v, l| eon_single_cosine(r, NORMAL, v, l));
                // The published closed form, of which the albedo in use is a fit.
                let (pi, sine) = (core::f64::consts::PI, view.x);
                let g = sine * (libm::acos(cos_view) - sine * cos_view)
                    + 2.0 / 3.0 * (sine / cos_view * (1.0 - sine * sine * sine) - sine);
                let exact = (1.0 + r * g / pi) / (1.0 + C1 * r);
                assert!(
                    (single - exact).abs() < 5e-5,
                    "{r} {cos_view}: {single} {exact}"
                );
                let fit = eon_single_albedo(r, cos_view);
                assert!(
                    (fit - exact).abs() < 6.1e-4,
                    "{r} {cos_view}: {fit} {exact}"
                );
                for (rho, want) in [(1.0, 1.0), (0.5, eon_albedo(0.5, r, cos_view))] {
                    let got = integrate(view, |v, l| eon_cosine(rho, r, NORMAL, v, l));
                    assert!((got - want).abs() < 1.5e-3, "{r} {cos_view}: {got} {want}");
                }
            }
        }
        for r in [0.0, 0.3, 1.0] {
            assert!((eon_multiple_albedo(1.0, r) - 1.0_f64).abs() < 1e-15);
            assert!((eon_albedo(1.0, r, 0.2) - 1.0_f64).abs() < 1e-15);
        }
    }

    /// By hand: r = 1, view and light along the normal. s = 0, so the first lobe is A/pi, and
    /// G = 0, so 1 - E = A c1: the second is A c1^2 / (pi (c1 - c2)).
    #[test]
    fn along_the_normal() {
        let pi = core::f64::consts::PI;
        let (c1, c2) = (0.5 - 2.0 / (3.0 * pi), 2.0 / 3.0 - 28.0 / (15.0 * pi));
        let a = 1.0 / (1.0 + c1);
        let single = eon_single_cosine(1.0, NORMAL, NORMAL, NORMAL);
        assert!((single - a / pi).abs() < 1e-15);
        let multiple = eon_multiple_cosine(1.0, NORMAL, NORMAL, NORMAL);
        assert!((multiple - a * c1 * c1 / (pi * (c1 - c2))).abs() < 1e-15);
        let average = a * (1.0 + c2);
        let colour = 0.25 * average / (1.0 - 0.5 * (1.0 - average));
        assert!((eon_multiple_albedo(0.5, 1.0) - colour).abs() < 1e-15);
        let whole = eon_cosine(0.5, 1.0, NORMAL, NORMAL, NORMAL);
        assert!((whole - (0.5 * single + colour * multiple)).abs() < 1e-15);
    }

    #[test]
    fn reciprocal_and_dark_below() {
        let (a, b) = (Vec3::new(0.8, 0.0, 0.6), Vec3::new(0.0, 0.96, 0.28));
        for r in [0.0, 0.4, 1.0] {
            let there = eon_cosine(0.8, r, NORMAL, a, b) / b.z;
            let back = eon_cosine(0.8, r, NORMAL, b, a) / a.z;
            assert!((there - back).abs() < 1e-15, "{r}");
            assert_eq!(eon_cosine(0.8, r, NORMAL, a, -b), 0.0);
            assert_eq!(eon_cosine(0.8, r, NORMAL, -a, b), 0.0);
        }
    }

    #[test]
    fn hostile() {
        let numbers = [0.0_f32, -1.0, 1e-38, 1e38, f32::INFINITY, f32::NAN];
        let normal = Vec3::new(0.0, 0.0, 1.0);
        for &rho in &numbers {
            for &r in &numbers {
                for x in [0.0, 1e-38, 1e-9, 0.5, 1.0_f32] {
                    let light = Vec3::new(Real::sqrt(1.0 - x * x), 0.0, x);
                    for view in [normal, light, -light] {
                        let got = eon_cosine(rho, r, normal, view, light);
                        assert!(got.is_finite() && got >= 0.0, "{rho} {r} {x}: {got}");
                    }
                    let albedo = eon_albedo(rho, r, x);
                    assert!((0.0..=1.0).contains(&albedo), "{rho} {r} {x}: {albedo}");
                }
            }
        }
    }
}
