//! A surface's BRDF for one view: its lobes, each with all that lies over it folded in.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use lumigon::ggx_cosine;

use super::fitted_lobes::{FittedLobe, FittedLobes};
use super::material::{LayeredMaterial, emitted};
use super::vector;
use crate::scene::SurfaceSample;

/// The coat's reflectance at normal incidence: an index of 1.5, fixed by `KHR_materials_clearcoat`.
const CLEARCOAT_F0: f32 = 0.04;

/// Light scattered by diffuse and specular lobes, or the factors that scatter it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Scattered {
    pub(super) diffuse: Vec3,
    pub(super) specular: Vec3,
}

/// GGX about a normal, with its Fresnel reflectance.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularLobe {
    pub(super) normal: Vec3,
    /// Unit vector, at right angles to the normal.
    pub(super) tangent: Vec3,
    /// Widths along and across the tangent.
    pub(super) alpha: [f32; 2],
    /// Weight at normal incidence.
    pub(super) f0: Vec3,
    /// Weight at grazing incidence.
    pub(super) f90: Vec3,
    pub(super) fitted: FittedLobe,
}

/// glTF's layers at one point, for one view.
///
/// Each layer takes what it reflects towards this view, its directional albedo, from the layers
/// below: a scaling by the view alone, so that a polygon's light stays a closed form for each lobe.
/// `KHR_materials_sheen` calls this albedo scaling; here it holds for the dielectric too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobes {
    pub(super) position: Vec3,
    /// Unit vector to the viewer.
    pub(super) view: Vec3,
    pub(super) normal: Vec3,
    /// Radiance from the surface itself.
    pub(super) emitted: Vec3,
    /// Lambertian reflectance.
    pub(super) diffuse_albedo: Vec3,
    /// The base's own reflection.
    pub(super) specular: SpecularLobe,
    /// The coat's.
    pub(super) clearcoat: Option<SpecularLobe>,
}

impl Lobes {
    pub(super) fn new(surface: &SurfaceSample, view: Vec3, fitted: &FittedLobes) -> Self {
        let material = LayeredMaterial::new(surface);
        let normal = surface.shading_normal;
        let LayeredMaterial {
            base_color,
            metallic,
            dielectric_f0,
            dielectric_f90,
            ..
        } = material;

        let clearcoat = (material.clearcoat > 0.0).then(|| {
            let normal = surface.clearcoat_normal;
            let cosine = normal.dot(view).abs().min(1.0);
            let weight = Vec3::splat(material.clearcoat * lumigon::schlick(CLEARCOAT_F0, cosine));
            SpecularLobe {
                normal,
                tangent: normal.any_orthonormal_vector(),
                alpha: [material.clearcoat_alpha; 2],
                f0: weight,
                f90: weight,
                fitted: fitted.ggx(material.clearcoat_alpha, normal, view),
            }
        });
        let below_coat = clearcoat.map_or(1.0, |coat| 1.0 - coat.f0.x);

        let [along, across] = material.alpha;
        let base = if along == across {
            fitted.ggx(across, normal, view)
        } else {
            fitted.ggx_anisotropic(material.alpha, surface.tangent, normal, view)
        };
        let reflected = base.albedo(dielectric_f0, Vec3::splat(dielectric_f90));
        let entering = (1.0 - reflected.max_element()).max(0.0);
        let f90 = dielectric_f90 + (1.0 - dielectric_f90) * metallic;
        Self {
            position: surface.position,
            view,
            normal,
            emitted: emitted(surface) * below_coat,
            diffuse_albedo: base_color * ((1.0 - metallic) * entering * below_coat),
            specular: SpecularLobe {
                normal,
                tangent: surface.tangent,
                alpha: material.alpha,
                f0: dielectric_f0.lerp(base_color, metallic) * below_coat,
                f90: Vec3::splat(f90 * below_coat),
                fitted: base,
            },
            clearcoat,
        }
    }

    /// Each lobe's BRDF times the cosine for light from the unit vector `light`, in 1/sr.
    pub(super) fn evaluate(&self, light: Vec3) -> Scattered {
        let cosine = self.normal.dot(light).max(0.0);
        let coat = self.clearcoat.map(|coat| coat.evaluate(self.view, light));
        Scattered {
            diffuse: self.diffuse_albedo * (FRAC_1_PI * cosine),
            specular: self.specular.evaluate(self.view, light) + coat.unwrap_or_default(),
        }
    }
}

impl SpecularLobe {
    fn evaluate(&self, view: Vec3, light: Vec3) -> Vec3 {
        let [normal, unit_view, unit_light] = [self.normal, view, light].map(vector);
        let response = ggx_cosine(self.alpha[0], normal, unit_view, unit_light);
        let cosine = (view + light).normalize_or_zero().dot(view).max(0.0);
        let weight = lumigon::schlick(0.0, cosine);
        (self.f0 * (1.0 - weight) + self.f90 * weight) * response
    }
}
