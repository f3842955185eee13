//! The surface's layered BRDF for one view: lobes, their weights, and how directions are drawn from them.

use glam::{DVec2, DVec3};

use crate::albedo::{charlie_albedo, ggx_albedos};
use crate::charlie::{charlie_distribution, charlie_visibility_cosine};
use crate::eon::{eon, eon_multiple_scattering_albedo};
use crate::frame::Frame;
use crate::ggx::{ggx_distribution, ggx_visibility, schlick_weight};
use crate::lobes::Lobes;
use crate::sampling::{
    Random, charlie_reflection, charlie_reflection_density, cosine_density, cosine_hemisphere,
    ggx_reflection, ggx_reflection_density, uniform_density, uniform_hemisphere,
};
use crate::scene::Surface;

/// Width below which a GGX lobe counts as this wide: a true mirror has no density to sample.
const SMALLEST_ALPHA: f64 = 1e-4;

/// Width below which a sheen counts as this wide.
const SMALLEST_SHEEN_ALPHA: f64 = 1e-6;

/// Least share of continued paths for each technique in use: the shares are rough, and any may be the one that finds
/// the light.
const LEAST_SHARE: f64 = 0.1;

/// How a direction can be drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Technique {
    /// Cosine-distributed: the diffuse lobe.
    Cosine,
    /// Uniform over the hemisphere: rough diffuse lobes and sheens have much at grazing angles.
    Uniform,
    /// The GGX lobe's visible normals.
    Ggx,
    /// The sheen's normals.
    Charlie,
    /// The clearcoat's visible normals.
    Clearcoat,
}

/// The diffuse lobe: EON of the base colour, scaled by what gets past the layers over it.
struct Diffuse {
    /// Factors of single and of multiple scattering.
    single: DVec3,
    multiple: DVec3,
    diffuse_roughness: f64,
}

/// The base's GGX lobe.
struct Specular {
    f0: DVec3,
    f90: f64,
    alpha: [f64; 2],
    /// What gets past the layers over it.
    factor: f64,
}

/// The Charlie lobe.
struct Sheen {
    factor: DVec3,
    alpha: f64,
}

/// The clearcoat, in a frame of its own.
struct Clearcoat {
    frame: Frame,
    /// With the Fresnel factor.
    weight: f64,
    alpha: [f64; 2],
}

/// A surface's BRDF for one view. Directions are unit vectors in world space, away from the surface.
pub(crate) struct Bsdf {
    frame: Frame,
    diffuse: Diffuse,
    specular: Specular,
    sheen: Option<Sheen>,
    clearcoat: Option<Clearcoat>,
    /// What gets past the clearcoat.
    below_clearcoat: f64,
    /// The techniques in use, with the share of continued paths that follow each.
    techniques: Vec<(Technique, f64)>,
}

impl Bsdf {
    pub(crate) fn new(surface: &Surface, view: DVec3) -> Self {
        let material = &surface.material;
        let normal = DVec3::from(surface.shading_normal).normalize_or(DVec3::Z);
        let frame = Frame::new(normal, material.tangent.into(), view);
        let base_color = colour(material.base_color);
        let metallic = unit(material.metallic);
        let dielectric_f0 = colour(material.dielectric_f0);
        let dielectric_f90 = unit(material.dielectric_f90);
        let alpha = material.alpha.map(|a| width(a, SMALLEST_ALPHA));
        let diffuse_roughness = unit(material.diffuse_roughness);

        let clearcoat = clearcoat(surface, normal, view);
        let below_clearcoat = 1.0 - clearcoat.as_ref().map_or(0.0, |c| c.weight);

        let sheen_color = colour(material.sheen_color);
        let mut sheen = None;
        let mut below_sheen = below_clearcoat;
        let mut sheen_share = 0.0;
        if sheen_color != DVec3::ZERO {
            let alpha = width(material.sheen_alpha, SMALLEST_SHEEN_ALPHA);
            let albedo = charlie_albedo(frame.view.z, alpha);
            let factor = below_clearcoat / albedo.max(1.0) * sheen_color;
            sheen_share = factor.max_element() * albedo;
            below_sheen *= 1.0 - sheen_color.max_element() * albedo.min(1.0);
            sheen = Some(Sheen { factor, alpha });
        }

        let f0 = dielectric_f0.lerp(base_color, metallic);
        let f90 = dielectric_f90 + (1.0 - dielectric_f90) * metallic;
        let fresnel = f0 + (f90 - f0) * schlick_weight(frame.view.z);
        let mut diffuse_factor = below_sheen * (1.0 - metallic);
        if diffuse_factor > 0.0 && base_color != DVec3::ZERO {
            let [value, schlick] = ggx_albedos(frame.view, alpha);
            let f0 = dielectric_f0.max_element();
            diffuse_factor *= (1.0 - f0 * (value - schlick) - dielectric_f90 * schlick).max(0.0);
        }
        // EON is not linear in its albedo: the rest is a factor of the whole lobe.
        let multiple = base_color.map(|c| eon_multiple_scattering_albedo(c, diffuse_roughness));

        let specular_share = below_sheen * fresnel.max_element();
        let diffuse_share = diffuse_factor * base_color.max_element();
        let clearcoat_share = 1.0 - below_clearcoat;
        let rough = diffuse_roughness > 0.0 && diffuse_share > 0.0;
        let uniform_share = 0.5 * sheen_share + if rough { 0.5 * diffuse_share } else { 0.0 };
        let cosine_share = if rough { 0.5 } else { 1.0 } * diffuse_share;
        Self {
            frame,
            diffuse: Diffuse {
                single: diffuse_factor * base_color,
                multiple: diffuse_factor * multiple,
                diffuse_roughness,
            },
            specular: Specular {
                f0,
                f90,
                alpha,
                factor: below_sheen,
            },
            sheen,
            clearcoat,
            below_clearcoat,
            techniques: shares(&[
                (Technique::Cosine, cosine_share),
                (Technique::Uniform, uniform_share),
                (Technique::Ggx, specular_share),
                (Technique::Charlie, 0.5 * sheen_share),
                (Technique::Clearcoat, clearcoat_share),
            ]),
        }
    }

    /// The shading normal, and the clearcoat's where there is one: above either, light may be reflected.
    pub(crate) fn normals(&self) -> (DVec3, Option<DVec3>) {
        let clearcoat = self.clearcoat.as_ref().map(|coat| coat.frame.normal());
        (self.frame.normal(), clearcoat)
    }

    /// What the clearcoat lets through of light emitted beneath it.
    pub(crate) fn below_clearcoat(&self) -> f64 {
        self.below_clearcoat
    }

    /// Each lobe's BRDF times the cosine; zero below the horizon of the lobe's own normal.
    pub(crate) fn evaluate(&self, direction: DVec3) -> Lobes {
        let mut lobes = Lobes::default();
        let light = self.frame.to_shading(direction);
        let view = self.frame.view;
        if light.z > 0.0 {
            let Diffuse {
                single,
                multiple,
                diffuse_roughness,
            } = self.diffuse;
            if single != DVec3::ZERO {
                let tangential = light.truncate().dot(view.truncate());
                let brdf = eon(light.z, view.z, tangential, diffuse_roughness);
                lobes.diffuse = (brdf.single * single + brdf.multiple * multiple) * light.z;
            }
            let Specular {
                f0,
                f90,
                alpha,
                factor,
            } = self.specular;
            let half_vector = view + light;
            let fresnel = f0 + (f90 - f0) * schlick_weight(0.5 * half_vector.length());
            let ggx = ggx_distribution(half_vector, alpha) * ggx_visibility(light, view, alpha);
            lobes.specular = fresnel * (factor * ggx * light.z);
            if let Some(Sheen { factor, alpha }) = self.sheen {
                lobes.specular += factor
                    * charlie_distribution(half_vector, alpha)
                    * charlie_visibility_cosine(light.z, view.z, alpha);
            }
        }
        if let Some(coat) = &self.clearcoat {
            let light = coat.frame.to_shading(direction);
            if light.z > 0.0 {
                let view = coat.frame.view;
                let ggx = ggx_distribution(view + light, coat.alpha)
                    * ggx_visibility(light, view, coat.alpha);
                lobes.specular += coat.weight * ggx * light.z;
            }
        }
        lobes
    }

    /// A direction by one technique; `None` below the horizon of the technique's own lobe.
    fn draw(&self, technique: Technique, u: DVec2) -> Option<DVec3> {
        let frame = match (technique, &self.clearcoat) {
            (Technique::Clearcoat, Some(coat)) => &coat.frame,
            _ => &self.frame,
        };
        let light = match technique {
            Technique::Cosine => cosine_hemisphere(u),
            Technique::Uniform => uniform_hemisphere(u),
            Technique::Ggx => ggx_reflection(frame.view, self.specular.alpha, u),
            Technique::Charlie => charlie_reflection(frame.view, self.sheen.as_ref()?.alpha, u),
            Technique::Clearcoat => ggx_reflection(frame.view, self.clearcoat.as_ref()?.alpha, u),
        };
        (light.z > 0.0).then(|| frame.to_world(light))
    }

    /// Density of [`Bsdf::draw`], per steradian. `light` is the direction in the shading frame.
    fn density(&self, technique: Technique, direction: DVec3, light: DVec3) -> f64 {
        let view = self.frame.view;
        match (technique, &self.sheen, &self.clearcoat) {
            (Technique::Clearcoat, _, Some(coat)) => {
                let light = coat.frame.to_shading(direction);
                match light.z > 0.0 {
                    true => ggx_reflection_density(coat.frame.view, light, coat.alpha),
                    false => 0.0,
                }
            }
            _ if light.z <= 0.0 => 0.0,
            (Technique::Cosine, ..) => cosine_density(light),
            (Technique::Uniform, ..) => uniform_density(light),
            (Technique::Ggx, ..) => ggx_reflection_density(view, light, self.specular.alpha),
            (Technique::Charlie, Some(sheen), _) => {
                charlie_reflection_density(view, light, sheen.alpha)
            }
            _ => 0.0,
        }
    }

    /// One direction by each technique in use.
    pub(crate) fn sample_each<'a>(
        &'a self,
        random: &'a mut Random,
    ) -> impl Iterator<Item = DVec3> + use<'a> {
        self.techniques
            .iter()
            .filter_map(|&(technique, _)| self.draw(technique, random.uniform2()))
    }

    /// Sum of the densities of the directions of [`Bsdf::sample_each`], per steradian.
    pub(crate) fn density_of_each(&self, direction: DVec3) -> f64 {
        let light = self.frame.to_shading(direction);
        let density = |&(technique, _): &_| self.density(technique, direction, light);
        self.techniques.iter().map(density).sum()
    }

    /// A direction by one technique or another, and each lobe's BRDF times cosine over density; `None` where there is
    /// nothing to follow.
    pub(crate) fn sample(&self, random: &mut Random) -> Option<(DVec3, Lobes)> {
        let (mut choice, u) = (random.uniform(), random.uniform2());
        let mut chosen = self.techniques.last()?.0;
        for &(technique, share) in &self.techniques {
            if choice < share {
                chosen = technique;
                break;
            }
            choice -= share;
        }
        let direction = self.draw(chosen, u)?;
        let light = self.frame.to_shading(direction);
        let density: f64 = self
            .techniques
            .iter()
            .map(|&(technique, share)| share * self.density(technique, direction, light))
            .sum();
        // Rounding at a horizon may leave a direction that, looked at again, no technique draws.
        (density > 0.0).then(|| {
            (
                direction,
                self.evaluate(direction) * DVec3::splat(1.0 / density),
            )
        })
    }
}

/// The clearcoat, where there is one.
fn clearcoat(surface: &Surface, normal: DVec3, view: DVec3) -> Option<Clearcoat> {
    let material = &surface.material;
    let amount = unit(material.clearcoat);
    let normal = DVec3::from(material.clearcoat_normal).normalize_or(normal);
    let fresnel = 0.04 + 0.96 * schlick_weight(normal.dot(view).abs());
    (amount > 0.0).then(|| Clearcoat {
        frame: Frame::new(normal, DVec3::ZERO, view),
        weight: amount * fresnel,
        alpha: [width(material.clearcoat_alpha, SMALLEST_ALPHA); 2],
    })
}

/// The techniques whose share is not zero, with shares that add up to 1 and are not too small.
fn shares(rough: &[(Technique, f64)]) -> Vec<(Technique, f64)> {
    let total: f64 = rough.iter().map(|(_, share)| share).sum();
    let mut used: Vec<_> = rough
        .iter()
        .filter(|(_, share)| *share > 0.0)
        .map(|&(technique, share)| (technique, (share / total).max(LEAST_SHARE)))
        .collect();
    let total: f64 = used.iter().map(|(_, share)| share).sum();
    used.iter_mut().for_each(|(_, share)| *share /= total);
    used
}

/// In [0, 1]; NaN counts as 0.
fn unit(x: f64) -> f64 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

fn colour(rgb: [f64; 3]) -> DVec3 {
    DVec3::from(rgb.map(unit))
}

/// In [least, 1]; NaN counts as 0.
fn width(alpha: f64, least: f64) -> f64 {
    unit(alpha).max(least)
}

#[cfg(test)]
mod tests;
