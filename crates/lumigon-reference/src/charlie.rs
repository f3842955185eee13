//! Sheen: the "Charlie" microfacet BRDF, as glTF's `KHR_materials_sheen` gives it.

use std::f64::consts::PI;

use glam::DVec3;

/// Charlie density of microfacet normals (Estevez and Kulla 2017, eq. 2), per steradian.
///
/// `half_vector` is in the shading frame and may have any length but zero.
pub(crate) fn charlie_distribution(half_vector: DVec3, alpha: f64) -> f64 {
    let sin2 = half_vector.truncate().length_squared() / half_vector.length_squared();
    let exponent = alpha.recip();
    (2.0 + exponent) * sin2.powf(0.5 * exponent) / (2.0 * PI)
}

/// G2 / (4 n.v) = 1 / ((1 + Lambda(v) + Lambda(l)) 4 n.v), for positive cosines: the visibility times n.l, which stays
/// finite at the light's horizon.
pub(crate) fn charlie_visibility_cosine(
    cos_theta_light: f64,
    cos_theta_view: f64,
    alpha: f64,
) -> f64 {
    let lambdas = charlie_lambda(cos_theta_view, alpha) + charlie_lambda(cos_theta_light, alpha);
    0.25 / ((1.0 + lambdas) * cos_theta_view)
}

/// Lambda of the Smith shadowing, as fitted by Estevez and Kulla 2017, eq. 3 and table 1, for cosines in [0, 1].
///
/// Without the paper's softened terminator (eq. 4), which the glTF extension leaves out and which is not reciprocal.
pub(crate) fn charlie_lambda(cos_theta: f64, alpha: f64) -> f64 {
    if cos_theta < 0.5 {
        charlie_fit(cos_theta, alpha).exp()
    } else {
        (2.0 * charlie_fit(0.5, alpha) - charlie_fit((1.0 - cos_theta).max(0.0), alpha)).exp()
    }
}

fn charlie_fit(x: f64, alpha: f64) -> f64 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let between = |rough: f64, smooth: f64| rough + (smooth - rough) * t;
    let a = between(21.5473, 25.3245);
    let b = between(3.82987, 3.32435);
    let c = between(0.19823, 0.16801);
    let d = between(-1.97760, -1.27393);
    let e = between(-4.32054, -4.85967);
    a / (1.0 + b * x.powf(c)) + d * x + e
}

/// The Charlie sheen BRDF D G2 / (4 n.l n.v) with Fresnel factor 1, per steradian.
///
/// All directions are unit vectors away from the surface, in one frame; `alpha`, the square of glTF's sheen roughness,
/// is in (0, 1]. It is zero unless both directions are above the surface. D and G2 as Estevez and Kulla 2017, without
/// the softened terminator, as in `KHR_materials_sheen`.
pub fn charlie_brdf(normal: [f64; 3], view: [f64; 3], light: [f64; 3], alpha: f64) -> f64 {
    let [normal, view, light] = [normal, view, light].map(DVec3::from);
    let (cos_theta_view, cos_theta_light) = (normal.dot(view), normal.dot(light));
    if cos_theta_view <= 0.0 || cos_theta_light <= 0.0 {
        return 0.0;
    }
    let half_vector = view + light;
    let sine = normal.cross(half_vector).length();
    charlie_distribution(DVec3::new(sine, 0.0, normal.dot(half_vector)), alpha)
        * charlie_visibility_cosine(cos_theta_light, cos_theta_view, alpha)
        / cos_theta_light
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brdf_is_reciprocal_and_dark_below() {
        let n = [0.0, 0.0, 1.0];
        let v = DVec3::new(0.3, 0.1, 0.4).normalize().into();
        let l = DVec3::new(0.6, 0.2, 0.1).normalize().into();
        for alpha in [1e-3, 0.1, 1.0] {
            let forward = charlie_brdf(n, v, l, alpha);
            let back = charlie_brdf(n, l, v, alpha);
            assert!(forward >= 0.0 && (forward - back).abs() <= 1e-13 * forward);
        }
        assert!(charlie_brdf(n, v, l, 0.3) > 0.0);
        assert_eq!(charlie_brdf(n, v, [0.0, 0.0, -1.0], 0.5), 0.0);
        assert_eq!(charlie_brdf(n, [1.0, 0.0, 0.0], l, 0.5), 0.0);
    }

    #[test]
    fn facets_cover_the_surface_once() {
        // The integral of D cos theta over the hemisphere is 1.
        for alpha in [1e-3, 0.1, 0.5, 1.0] {
            let n = 200_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let cosine = (f64::from(i) + 0.5) / f64::from(n);
                    let h = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                    charlie_distribution(h, alpha) * cosine
                })
                .sum();
            let covered = 2.0 * PI * sum / f64::from(n);
            assert!((covered - 1.0).abs() < 1e-6, "{alpha}: {covered}");
        }
    }

    #[test]
    fn lambda_falls_with_the_cosine_without_a_jump() {
        for alpha in [1e-6, 0.04, 0.5, 1.0] {
            let mut last = f64::INFINITY;
            for i in 0..=1000 {
                let lambda = charlie_lambda(f64::from(i) * 1e-3, alpha);
                assert!(lambda < last && lambda >= 0.0, "{alpha} {i}: {lambda}");
                last = lambda;
            }
            let jump = charlie_lambda(0.5, alpha) - charlie_lambda(0.5 - 1e-12, alpha);
            assert!(jump.abs() < 1e-9);
        }
    }
}
