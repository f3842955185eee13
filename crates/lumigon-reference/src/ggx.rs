//! The microfacet BRDF that everything here agrees on: GGX with height-correlated Smith shadowing.
//!
//! Two widths throughout, `alpha = [alpha_t, alpha_b]` along the shading frame's x (the tangent) and y (the
//! bitangent); the isotropic BRDF is the one whose widths are equal.

use glam::DVec3;

/// Anisotropic GGX density of microfacet normals (Burley 2012, eq. 13), per steradian.
///
/// `half_vector` is in the shading frame (z along the normal) and may have any length but zero. Written with the sines
/// rather than 1 - cosine^2, it keeps its relative accuracy at the peak for any `alpha`.
pub(crate) fn ggx_distribution(half_vector: DVec3, alpha: [f64; 2]) -> f64 {
    let [alpha_t, alpha_b] = alpha;
    let product = alpha_t * alpha_b;
    let stretched = DVec3::new(
        half_vector.x * alpha_b,
        half_vector.y * alpha_t,
        half_vector.z * product,
    );
    // Everything scales with the length of the half vector.
    let ratio = product * half_vector.length_squared() / stretched.length_squared();
    product * ratio * ratio / std::f64::consts::PI
}

/// G2 / (4 n.l n.v) with height-correlated Smith shadowing (Heitz 2014, eq. 99), for unit directions above the
/// horizon, not both on it.
pub(crate) fn ggx_visibility(light: DVec3, view: DVec3, alpha: [f64; 2]) -> f64 {
    0.5 / (view.z * smith_root(light, alpha) + light.z * smith_root(view, alpha))
}

/// Smith masking G1 of one direction (Heitz 2014, eq. 72 and 86), in [0, 1], for unit directions above the horizon.
pub(crate) fn ggx_masking(direction: DVec3, alpha: [f64; 2]) -> f64 {
    2.0 * direction.z / (direction.z + smith_root(direction, alpha))
}

/// cos theta (1 + 2 Lambda) of the GGX: finite at the horizon, where Lambda is not.
fn smith_root(direction: DVec3, [alpha_t, alpha_b]: [f64; 2]) -> f64 {
    DVec3::new(alpha_t * direction.x, alpha_b * direction.y, direction.z).length()
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
    let tangent = DVec3::from(normal).any_orthonormal_vector();
    ggx_anisotropic_brdf(normal, tangent.into(), view, light, [alpha; 2])
}

/// The BRDF of [`ggx_brdf`] with the widths `alpha = [alpha_t, alpha_b]` along and across `tangent`.
///
/// `normal` and `tangent` are orthogonal unit vectors; widths are in (0, 1]. D as Burley 2012, eq. 13; G2
/// height-correlated as Heitz 2014, eq. 99, with the width of each direction's own azimuth (eq. 80).
pub fn ggx_anisotropic_brdf(
    normal: [f64; 3],
    tangent: [f64; 3],
    view: [f64; 3],
    light: [f64; 3],
    alpha: [f64; 2],
) -> f64 {
    let [normal, tangent, view, light] = [normal, tangent, view, light].map(DVec3::from);
    let rows = [tangent, normal.cross(tangent), normal];
    let [view, light] = [view, light].map(|v| DVec3::from(rows.map(|row| row.dot(v))));
    if view.z <= 0.0 || light.z <= 0.0 {
        return 0.0;
    }
    ggx_distribution(view + light, alpha) * ggx_visibility(light, view, alpha)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn brdf_is_reciprocal_and_dark_below() {
        let v = DVec3::new(0.3, 0.1, 0.4).normalize().into();
        let l = DVec3::new(-0.6, 0.2, 0.1).normalize().into();
        let t = DVec3::new(0.8, 0.6, 0.0).into();
        for alpha in [[1e-3; 2], [0.1, 0.1], [1.0, 0.02], [0.3, 0.9]] {
            let forward = ggx_anisotropic_brdf(UP, t, v, l, alpha);
            let back = ggx_anisotropic_brdf(UP, t, l, v, alpha);
            assert!(forward > 0.0 && (forward - back).abs() <= 1e-13 * forward);
        }
        assert_eq!(ggx_brdf(UP, v, [0.0, 0.0, -1.0], 0.5), 0.0);
        assert_eq!(ggx_brdf(UP, [1.0, 0.0, 0.0], l, 0.5), 0.0);
    }

    #[test]
    fn equal_widths_are_the_isotropic_formulas() {
        let v = DVec3::new(0.3, -0.1, 0.4).normalize();
        let l = DVec3::new(-0.6, 0.5, 0.3).normalize();
        for alpha in [1e-3, 0.2, 1.0_f64] {
            // Walter et al. 2007, eq. 33, and Heitz 2014, eq. 72 and 99, as printed.
            let a2 = alpha * alpha;
            let cosine = (v + l).normalize().z;
            let tan2 = 1.0 / (cosine * cosine) - 1.0;
            let d = a2 / (PI * cosine.powi(4) * (a2 + tan2).powi(2));
            let lambda =
                |w: DVec3| 0.5 * ((1.0 + a2 * (1.0 - w.z * w.z) / (w.z * w.z)).sqrt() - 1.0);
            let expected = d / (1.0 + lambda(v) + lambda(l)) / (4.0 * v.z * l.z);
            let value = ggx_brdf(UP, v.into(), l.into(), alpha);
            assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
        }
    }

    #[test]
    fn swapping_widths_is_turning_the_tangent() {
        let v = DVec3::new(0.3, -0.1, 0.4).normalize().into();
        let l = DVec3::new(-0.6, 0.5, 0.3).normalize().into();
        let [x, y] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let value = ggx_anisotropic_brdf(UP, x, v, l, [0.6, 0.1]);
        let turned = ggx_anisotropic_brdf(UP, y, v, l, [0.1, 0.6]);
        let wrong = ggx_anisotropic_brdf(UP, y, v, l, [0.6, 0.1]);
        assert!((value / turned - 1.0).abs() < 1e-13 && (value / wrong - 1.0).abs() > 0.1);
    }

    #[test]
    fn peak_of_the_distribution_is_exact_for_tiny_alpha() {
        let alpha = 1e-6;
        let tilted = DVec3::new(alpha, 0.0, 1.0) * 1.7;
        let expected = (1.0 + alpha * alpha).powi(2) / (PI * alpha * alpha * 4.0);
        assert!((ggx_distribution(tilted, [alpha; 2]) / expected - 1.0).abs() < 1e-12);
    }
}
