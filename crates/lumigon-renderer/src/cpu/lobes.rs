//! A surface's BRDF for one view: its lobes, each with all that lies over it folded in.

use std::f32::consts::FRAC_1_PI;
use std::ops::{AddAssign, Mul};

use glam::Vec3;
use lumigon::{
    LtcLobes, SpecularMethod, charlie_cosine, eon_multiple_albedo, eon_multiple_cosine,
    eon_single_cosine, ggx_anisotropic_cosine, ggx_cosine,
};

use super::fitted_lobes::{Amplitudes, FittedBrdf, FittedLobes};
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

impl Scattered {
    pub(super) fn diffuse(diffuse: Vec3) -> Self {
        let specular = Vec3::ZERO;
        Self { diffuse, specular }
    }

    pub(super) fn specular(specular: Vec3) -> Self {
        let diffuse = Vec3::ZERO;
        Self { diffuse, specular }
    }

    pub(super) fn is_black(&self) -> bool {
        *self == Self::default()
    }
}

impl AddAssign for Scattered {
    fn add_assign(&mut self, other: Self) {
        self.diffuse += other.diffuse;
        self.specular += other.specular;
    }
}

impl Mul<Vec3> for Scattered {
    type Output = Self;

    fn mul(self, light: Vec3) -> Self {
        Self {
            diffuse: self.diffuse * light,
            specular: self.specular * light,
        }
    }
}

/// Lambert, or EON where it is rough.
#[derive(Clone, Debug)]
pub(super) struct DiffuseLobe {
    /// Weight of the light that is scattered once: all of it, for Lambert.
    pub(super) single: Vec3,
    pub(super) rough: Option<Box<Rough>>,
}

/// What EON adds to Lambert.
#[derive(Clone, Debug)]
pub(super) struct Rough {
    /// EON's r.
    pub(super) roughness: f32,
    /// Weight of the light that is scattered more than once.
    pub(super) multiple: Vec3,
    pub(super) fitted: FittedBrdf,
}

/// GGX about a normal, with its Fresnel reflectance.
#[derive(Clone, Debug)]
pub(super) struct SpecularLobe {
    pub(super) normal: Vec3,
    /// Unit vector, at right angles to the normal; of no use where the widths are equal.
    pub(super) tangent: Vec3,
    /// Widths along and across the tangent.
    pub(super) alpha: [f32; 2],
    /// Weight at normal incidence.
    pub(super) f0: Vec3,
    /// Weight at grazing incidence.
    pub(super) f90: Vec3,
    pub(super) fitted: FittedBrdf,
}

/// Charlie.
#[derive(Clone, Debug)]
pub(super) struct SheenLobe {
    pub(super) alpha: f32,
    pub(super) weight: Vec3,
    pub(super) fitted: FittedBrdf,
}

/// glTF's layers at one point, for one view.
///
/// Each layer takes what it reflects towards this view, its directional albedo, from the layers
/// below: a scaling by the view alone, so that a polygon's light stays a closed form for each lobe.
/// `KHR_materials_sheen` calls this albedo scaling; here it holds for the dielectric too.
#[derive(Clone, Debug)]
pub(super) struct Lobes {
    pub(super) position: Vec3,
    /// Unit vector to the viewer.
    pub(super) view: Vec3,
    pub(super) normal: Vec3,
    /// Radiance from the surface itself.
    pub(super) emitted: Vec3,
    pub(super) diffuse: DiffuseLobe,
    /// The base's own reflection.
    pub(super) specular: SpecularLobe,
    /// Boxed as the coat and the roughness are: few surfaces have them.
    pub(super) sheen: Option<Box<SheenLobe>>,
    pub(super) clearcoat: Option<Box<SpecularLobe>>,
}

impl Lobes {
    #[inline]
    pub(super) fn new(
        surface: &SurfaceSample,
        view: Vec3,
        fitted: &FittedLobes,
        count: LtcLobes,
    ) -> Self {
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
            Box::new(SpecularLobe {
                normal,
                tangent: Vec3::ZERO,
                alpha: [material.clearcoat_alpha; 2],
                f0: weight,
                f90: weight,
                fitted: fitted.ggx(material.clearcoat_alpha, normal, view, count),
            })
        });
        let below_coat = clearcoat.as_ref().map_or(1.0, |coat| 1.0 - coat.f0.x);

        let mut below_sheen = below_coat;
        let sheen = (material.sheen_color != Vec3::ZERO).then(|| {
            let lobe = fitted.charlie(material.sheen_alpha, normal, view);
            let albedo = lobe.albedos().whole;
            below_sheen *= 1.0 - material.sheen_color.max_element() * albedo.min(1.0);
            Box::new(SheenLobe {
                alpha: material.sheen_alpha,
                // Narrow fibres would give off more light than they get, seen along the surface.
                weight: material.sheen_color * (below_coat / albedo.max(1.0)),
                fitted: lobe,
            })
        });

        let [along, across] = material.alpha;
        let base = if along == across {
            fitted.ggx(across, normal, view, count)
        } else {
            fitted.ggx_anisotropic(material.alpha, surface.tangent, normal, view)
        };
        // What the dielectric does not reflect; a metal lets nothing in.
        let entering = if metallic < 1.0 {
            let f90 = Vec3::splat(dielectric_f90);
            let reflected = base.albedos().reflectance(dielectric_f0, f90);
            (1.0 - reflected.max_element()).max(0.0)
        } else {
            0.0
        };
        let f90 = dielectric_f90 + (1.0 - dielectric_f90) * metallic;
        Self {
            position: surface.position,
            view,
            normal,
            emitted: emitted(surface) * below_coat,
            diffuse: DiffuseLobe::new(
                base_color,
                (1.0 - metallic) * entering * below_sheen,
                material.diffuse_roughness,
                || fitted.eon(material.diffuse_roughness, normal, view),
            ),
            specular: SpecularLobe {
                normal,
                tangent: surface.tangent,
                alpha: material.alpha,
                f0: dielectric_f0.lerp(base_color, metallic) * below_sheen,
                f90: Vec3::splat(f90 * below_sheen),
                fitted: base,
            },
            sheen,
            clearcoat,
        }
    }

    /// As [`Lobes::evaluate`], but for the specular lobes where `specular` has none.
    pub(super) fn evaluate_by(&self, light: Vec3, specular: SpecularMethod) -> Scattered {
        if specular == SpecularMethod::None {
            return Scattered::diffuse(self.diffuse.evaluate(self.normal, self.view, light));
        }
        self.evaluate(light)
    }

    /// Each lobe's BRDF times the cosine for light from the unit vector `light`, in 1/sr.
    pub(super) fn evaluate(&self, light: Vec3) -> Scattered {
        let mut specular = self.specular.evaluate(self.view, light);
        if let Some(sheen) = &self.sheen {
            specular += sheen.evaluate(self.normal, self.view, light);
        }
        if let Some(coat) = &self.clearcoat {
            specular += coat.evaluate(self.view, light);
        }
        Scattered {
            diffuse: self.diffuse.evaluate(self.normal, self.view, light),
            specular,
        }
    }
}

impl DiffuseLobe {
    fn new(color: Vec3, scale: f32, roughness: f32, fitted: impl FnOnce() -> FittedBrdf) -> Self {
        let single = color * scale;
        if roughness == 0.0 || single == Vec3::ZERO {
            return Self {
                single,
                rough: None,
            };
        }
        let multiple = color
            .to_array()
            .map(|rho| eon_multiple_albedo(rho, roughness));
        Self {
            single,
            rough: Some(Box::new(Rough {
                roughness,
                multiple: Vec3::from(multiple) * scale,
                fitted: fitted(),
            })),
        }
    }

    /// Share of light from everywhere that goes towards the view.
    pub(super) fn albedo(&self) -> Vec3 {
        self.rough.as_ref().map_or(self.single, |rough| {
            let Amplitudes { whole, part } = rough.fitted.albedos();
            self.single * whole + rough.multiple * part
        })
    }

    fn evaluate(&self, normal: Vec3, view: Vec3, light: Vec3) -> Vec3 {
        let Some(rough) = &self.rough else {
            return self.single * (FRAC_1_PI * normal.dot(light).max(0.0));
        };
        let [normal, view, light] = [normal, view, light].map(vector);
        self.single * eon_single_cosine(rough.roughness, normal, view, light)
            + rough.multiple * eon_multiple_cosine(rough.roughness, normal, view, light)
    }
}

impl SpecularLobe {
    pub(super) fn is_isotropic(&self) -> bool {
        self.alpha[0] == self.alpha[1]
    }

    fn evaluate(&self, view: Vec3, light: Vec3) -> Vec3 {
        let bitangent = self.normal.cross(self.tangent);
        let cosine = (view + light).normalize_or_zero().dot(view).max(0.0);
        let weight = lumigon::schlick(0.0, cosine);
        let [normal, tangent, bitangent, view, light] =
            [self.normal, self.tangent, bitangent, view, light].map(vector);
        let response = if self.is_isotropic() {
            ggx_cosine(self.alpha[0], normal, view, light)
        } else {
            ggx_anisotropic_cosine(self.alpha, tangent, bitangent, normal, view, light)
        };
        (self.f0 * (1.0 - weight) + self.f90 * weight) * response
    }
}

impl SheenLobe {
    pub(super) fn evaluate(&self, normal: Vec3, view: Vec3, light: Vec3) -> Vec3 {
        let [normal, view, light] = [normal, view, light].map(vector);
        self.weight * charlie_cosine(self.alpha, normal, view, light)
    }
}
