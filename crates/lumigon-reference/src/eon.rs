//! Rough diffuse reflection: EON, the energy-preserving Oren-Nayar BRDF of Portsmouth, Kutz and Hill 2025.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

/// 1/2 - 2 / (3 pi) (Portsmouth et al. 2025, listing 1).
const C1: f64 = 0.5 - 2.0 / (3.0 * PI);
/// 2/3 - 28 / (15 pi).
const C2: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// The two scattering orders of a rough diffuse BRDF, apart because each depends on the albedo in its own way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EonBrdf {
    /// Single scattering at albedo 1, per steradian.
    pub single: f64,
    /// Multiple scattering at multiple-scattering albedo 1, per steradian.
    pub multiple: f64,
}

impl EonBrdf {
    /// The BRDF of a surface with this albedo in [0, 1] and `diffuse_roughness`.
    pub fn with_albedo(self, albedo: f64, diffuse_roughness: f64) -> f64 {
        albedo * self.single
            + eon_multiple_scattering_albedo(albedo, diffuse_roughness) * self.multiple
    }
}

/// What multiple scattering is multiplied by at a single-scattering albedo in [0, 1]
/// (Portsmouth et al. 2025, listing 1: `rho_ms`).
///
/// At albedo 1 it is 1, whatever the `diffuse_roughness` in [0, 1].
pub fn eon_multiple_scattering_albedo(albedo: f64, diffuse_roughness: f64) -> f64 {
    let average = (1.0 + C2 * diffuse_roughness) / (1.0 + C1 * diffuse_roughness);
    albedo * albedo * average / (1.0 - albedo * (1.0 - average))
}

/// The EON rough diffuse BRDF (Portsmouth, Kutz and Hill 2025, listing 1, with the exact albedo of Fujii's single
/// scattering).
///
/// All directions are unit vectors away from the surface, in one frame; `diffuse_roughness` is the paper's r in
/// [0, 1], where 0 is Lambert. It is zero unless both directions are above the surface. Reciprocal; with albedo 1 it
/// reflects all light.
pub fn eon_brdf(
    normal: [f64; 3],
    view: [f64; 3],
    light: [f64; 3],
    diffuse_roughness: f64,
) -> EonBrdf {
    let [normal, view, light] = [normal, view, light].map(DVec3::from);
    let (cos_theta_view, cos_theta_light) = (normal.dot(view), normal.dot(light));
    if cos_theta_view <= 0.0 || cos_theta_light <= 0.0 {
        return EonBrdf {
            single: 0.0,
            multiple: 0.0,
        };
    }
    let tangential = light.dot(view - cos_theta_view * normal);
    eon(
        cos_theta_light,
        cos_theta_view,
        tangential,
        diffuse_roughness,
    )
}

/// The BRDF from the cosines, in (0, 1], and the product of the directions' parts along the surface.
pub(crate) fn eon(
    cos_theta_light: f64,
    cos_theta_view: f64,
    tangential: f64,
    diffuse_roughness: f64,
) -> EonBrdf {
    if diffuse_roughness == 0.0 {
        return EonBrdf {
            single: FRAC_1_PI,
            multiple: 0.0,
        };
    }
    let scale = FRAC_1_PI / (1.0 + C1 * diffuse_roughness);
    let s_over_t = match tangential > 0.0 {
        true => tangential / cos_theta_light.max(cos_theta_view),
        false => tangential,
    };
    EonBrdf {
        single: scale * (1.0 + diffuse_roughness * s_over_t),
        multiple: scale * diffuse_roughness * missing(cos_theta_light) * missing(cos_theta_view)
            / (C1 - C2),
    }
}

/// (1 - E(cos theta)) (1 + c1 r) / r, where E is the albedo of single scattering: what it lacks, free of r and of the
/// cancellation in the difference. In [0, c1], zero at the horizon.
fn missing(cos_theta: f64) -> f64 {
    let sine = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    // (1 - sine^3) / cos theta, which the paper leaves as 0 / 0 at the horizon.
    let cube = cos_theta * (1.0 + sine + sine * sine) / (1.0 + sine);
    let g = sine * (cos_theta.min(1.0).acos() - sine * cos_theta) + 2.0 / 3.0 * sine * (cube - 1.0);
    (C1 - FRAC_1_PI * g).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn brdf_is_reciprocal_dark_below_and_lambert_without_roughness() {
        let v = DVec3::new(0.3, 0.1, 0.4).normalize().into();
        for l in [[0.6, 0.2, 0.1], [-0.6, 0.2, 0.7]] {
            let l = DVec3::from(l).normalize().into();
            for r in [0.0, 0.3, 1.0] {
                let (forward, back) = (eon_brdf(UP, v, l, r), eon_brdf(UP, l, v, r));
                assert!((forward.single - back.single).abs() < 1e-15);
                assert!((forward.multiple - back.multiple).abs() < 1e-15);
                assert!(forward.single > 0.0 && (r == 0.0 || forward.multiple > 0.0));
            }
            let smooth = eon_brdf(UP, v, l, 0.0);
            assert_eq!([smooth.single, smooth.multiple], [FRAC_1_PI, 0.0]);
        }
        let below = eon_brdf(UP, v, [0.0, 0.0, -1.0], 0.5);
        assert_eq!([below.single, below.multiple], [0.0, 0.0]);
    }

    #[test]
    fn matches_the_listing_as_printed() {
        let v = DVec3::new(0.3, 0.1, 0.4).normalize();
        let l = DVec3::new(0.5, -0.2, 0.9).normalize();
        let (r, rho) = (0.7, 0.6);
        let af = 1.0 / (1.0 + C1 * r);
        let e_fon = |mu: f64| {
            let si = (1.0 - mu * mu).sqrt();
            let g = si * (mu.acos() - si * mu) + 2.0 / 3.0 * (si / mu * (1.0 - si.powi(3)) - si);
            af + r * af / PI * g
        };
        let average = af * (1.0 + C2 * r);
        let s = v.dot(l) - v.z * l.z;
        let single = rho / PI * af * (1.0 + r * s / v.z.max(l.z));
        let rho_ms = rho * rho * average / (1.0 - rho * (1.0 - average));
        let multiple = rho_ms / PI * (1.0 - e_fon(v.z)) * (1.0 - e_fon(l.z)) / (1.0 - average);
        let value = eon_brdf(UP, v.into(), l.into(), r).with_albedo(rho, r);
        assert!(s > 0.0 && (value - single - multiple).abs() < 1e-14);
        assert!((eon_multiple_scattering_albedo(1.0, r) - 1.0).abs() < 1e-15);
    }
}
