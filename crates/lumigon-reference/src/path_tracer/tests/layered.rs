//! The layered material from cubature alone, for the path tracer to be compared with.

use glam::DVec3;

use crate::{
    Material, Polygon, Tolerance, charlie, charlie_albedo, eon, eon_albedo, ggx, ggx_albedo,
    ggx_anisotropic, ggx_anisotropic_albedo,
};

/// What noise hides, and much cheaper than the default.
const COARSE: Tolerance = Tolerance {
    absolute: 1e-6,
    relative: 0.0,
    max_evaluations: 2_000_000,
};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// Integrals of every lobe over the same directions, radiance 1.
pub(super) struct LobeIntegrals {
    diffuse: [f64; 3],
    ggx: [f64; 2],
    sheen: f64,
    clearcoat: f64,
}

/// The material of a surface that faces up, layered by albedos from cubature.
pub(super) struct Layered {
    material: Material,
    view: [f64; 3],
    /// Of the diffuse lobe, the base's GGX lobe, the sheen and the clearcoat.
    pub(super) factors: [f64; 4],
}

impl Layered {
    pub(super) fn new(material: Material, view: [f64; 3]) -> Self {
        let max3 = |c: [f64; 3]| c.into_iter().fold(0.0, f64::max);
        let Material {
            metallic,
            dielectric_f0,
            dielectric_f90,
            alpha,
            ..
        } = material;
        let n_c_dot_v = DVec3::from(Self::clearcoat_normal(&material)).dot(view.into());
        let weight = material.clearcoat * (0.04 + 0.96 * (1.0 - n_c_dot_v.abs()).powi(5));
        let sheen_albedo = match material.sheen_color {
            [0.0, 0.0, 0.0] => 0.0,
            _ => {
                charlie_albedo(view[2], material.sheen_alpha, COARSE)
                    .unwrap()
                    .value
            }
        };
        let base = (1.0 - weight) * (1.0 - max3(material.sheen_color) * sheen_albedo.min(1.0));
        let t = Self::tangent(&material);
        let turned = [t, [-t[1], t[0], 0.0], UP].map(|x| DVec3::from(x).dot(view.into()));
        let a = ggx_anisotropic_albedo(turned, alpha, COARSE).unwrap();
        let e = max3(dielectric_f0) * (a.value - a.schlick) + dielectric_f90 * a.schlick;
        let sheen = (1.0 - weight) / sheen_albedo.max(1.0);
        Self {
            material,
            view,
            factors: [base * (1.0 - metallic) * (1.0 - e), base, sheen, weight],
        }
    }

    fn tangent(material: &Material) -> [f64; 3] {
        match material.tangent {
            [0.0, 0.0, 0.0] => [1.0, 0.0, 0.0],
            tangent => tangent,
        }
    }

    fn clearcoat_normal(material: &Material) -> [f64; 3] {
        match material.clearcoat_normal {
            [0.0, 0.0, 0.0] => UP,
            normal => normal,
        }
    }

    /// Each lobe's share of the light of a polygon.
    pub(super) fn over(&self, light: &Polygon, point: [f64; 3]) -> LobeIntegrals {
        let (material, view) = (&self.material, self.view);
        let r = material.diffuse_roughness;
        let eon = eon(light, point, UP, view, r, COARSE).unwrap();
        let tangent = Self::tangent(material);
        let ggx_base =
            ggx_anisotropic(light, point, UP, tangent, view, material.alpha, COARSE).unwrap();
        let sheen = match material.sheen_color {
            [0.0, 0.0, 0.0] => 0.0,
            _ => {
                charlie(light, point, UP, view, material.sheen_alpha, COARSE)
                    .unwrap()
                    .value
            }
        };
        let normal = Self::clearcoat_normal(material);
        let clearcoat = match material.clearcoat {
            0.0 => 0.0,
            _ => {
                ggx(light, point, normal, view, material.clearcoat_alpha, COARSE)
                    .unwrap()
                    .value
            }
        };
        LobeIntegrals {
            diffuse: material.base_color.map(|c| eon.with_albedo(c, r)),
            ggx: [ggx_base.value, ggx_base.schlick],
            sheen,
            clearcoat,
        }
    }

    /// Each lobe over the hemisphere, for an isotropic material whose clearcoat is not bent.
    pub(super) fn over_hemisphere(&self) -> LobeIntegrals {
        let (material, cosine) = (&self.material, self.view[2]);
        let r = material.diffuse_roughness;
        let eon = eon_albedo(cosine, r, COARSE).unwrap();
        let ggx = ggx_albedo(cosine, material.alpha[0], COARSE).unwrap();
        let coat = ggx_albedo(cosine, material.clearcoat_alpha, COARSE).unwrap();
        LobeIntegrals {
            diffuse: material.base_color.map(|c| eon.with_albedo(c, r)),
            ggx: [ggx.value, ggx.schlick],
            sheen: charlie_albedo(cosine, material.sheen_alpha, COARSE)
                .unwrap()
                .value,
            clearcoat: coat.value,
        }
    }

    /// Diffuse and specular radiance of one channel.
    pub(super) fn reflected(&self, lobes: &LobeIntegrals, channel: usize) -> [f64; 2] {
        let material = &self.material;
        let [diffuse, base, sheen, clearcoat] = self.factors;
        let mix =
            |dielectric: f64, metal: f64| dielectric + (metal - dielectric) * material.metallic;
        let f0 = mix(
            material.dielectric_f0[channel],
            material.base_color[channel],
        );
        let f90 = mix(material.dielectric_f90, 1.0);
        let [value, schlick] = lobes.ggx;
        [
            diffuse * lobes.diffuse[channel],
            base * (f0 * (value - schlick) + f90 * schlick)
                + sheen * material.sheen_color[channel] * lobes.sheen
                + clearcoat * lobes.clearcoat,
        ]
    }
}
