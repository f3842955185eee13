//! The microfacet BRDF that everything here agrees on: GGX with height-correlated Smith shadowing.

use glam::DVec3;

/// GGX density of microfacet normals (Walter et al. 2007, eq. 33), per steradian.
///
/// `half_vector` is in the shading frame (z along the normal) and may have any length but zero. Written with the sine
/// rather than 1 - cosine^2, it keeps its relative accuracy at the peak for any `alpha`.
pub(crate) fn ggx_distribution(half_vector: DVec3, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let sin2 = half_vector.x * half_vector.x + half_vector.y * half_vector.y;
    let cos2 = half_vector.z * half_vector.z;
    // Both terms scale with the squared length of the half vector.
    let scaled = a2 * cos2 + sin2;
    let length2 = sin2 + cos2;
    a2 * length2 * length2 / (std::f64::consts::PI * scaled * scaled)
}

/// G2 / (4 n.l n.v) with height-correlated Smith shadowing (Heitz 2014, eq. 99), for positive cosines.
pub(crate) fn ggx_visibility(cos_theta_light: f64, cos_theta_view: f64, alpha: f64) -> f64 {
    0.5 / (cos_theta_view * smith_root(cos_theta_light, alpha)
        + cos_theta_light * smith_root(cos_theta_view, alpha))
}

/// Smith masking G1 of one direction (Heitz 2014, eq. 72), in [0, 1], for a positive cosine.
pub(crate) fn ggx_masking(cos_theta: f64, alpha: f64) -> f64 {
    2.0 * cos_theta / (cos_theta + smith_root(cos_theta, alpha))
}

/// cos theta (1 + 2 Lambda) of the GGX: finite at the horizon, where Lambda is not.
fn smith_root(cos_theta: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    (a2 + (1.0 - a2) * cos_theta * cos_theta).sqrt()
}

/// Schlick's factor (1 - h.v)^5 (Schlick 1994, eq. 15).
pub(crate) fn schlick_weight(half_dot_view: f64) -> f64 {
    (1.0 - half_dot_view).clamp(0.0, 1.0).powi(5)
}

/// The BRDF D G2 / (4 n.l n.v) with Fresnel factor 1, per steradian.
///
/// All directions are unit vectors away from the surface, in one frame; `alpha` is the GGX width in (0, 1]. It is zero
/// unless both directions are above the surface. D as Walter et al. 2007, eq. 33; G2 height-correlated as Heitz 2014,
/// eq. 99.
pub fn ggx_brdf(normal: [f64; 3], view: [f64; 3], light: [f64; 3], alpha: f64) -> f64 {
    let [normal, view, light] = [normal, view, light].map(DVec3::from);
    let cos_theta_view = normal.dot(view);
    let cos_theta_light = normal.dot(light);
    if cos_theta_view <= 0.0 || cos_theta_light <= 0.0 {
        return 0.0;
    }
    let half_vector = view + light;
    let sine = normal.cross(half_vector).length();
    ggx_distribution(DVec3::new(sine, 0.0, normal.dot(half_vector)), alpha)
        * ggx_visibility(cos_theta_light, cos_theta_view, alpha)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brdf_is_reciprocal_and_dark_below() {
        let n = [0.0, 0.0, 1.0];
        let v = DVec3::new(0.3, 0.1, 0.4).normalize().into();
        let l = DVec3::new(-0.6, 0.2, 0.1).normalize().into();
        for alpha in [1e-3, 0.1, 1.0] {
            let forward = ggx_brdf(n, v, l, alpha);
            let back = ggx_brdf(n, l, v, alpha);
            assert!(forward > 0.0 && (forward - back).abs() <= 1e-13 * forward);
        }
        assert_eq!(ggx_brdf(n, v, [0.0, 0.0, -1.0], 0.5), 0.0);
        assert_eq!(ggx_brdf(n, [1.0, 0.0, 0.0], l, 0.5), 0.0);
    }

    #[test]
    fn peak_of_the_distribution_is_exact_for_tiny_alpha() {
        let alpha = 1e-6;
        let tilted = DVec3::new(alpha, 0.0, 1.0) * 1.7;
        let expected = (1.0 + alpha * alpha).powi(2) / (std::f64::consts::PI * alpha * alpha * 4.0);
        assert!((ggx_distribution(tilted, alpha) / expected - 1.0).abs() < 1e-12);
    }
}
