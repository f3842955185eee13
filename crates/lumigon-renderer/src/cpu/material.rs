//! The layered material's numbers at one point, as both the closed forms and the path tracer take
//! them.

use glam::Vec3;
use lumigon::MINIMUM_ALPHA;

use crate::scene::SurfaceSample;

/// Smallest alpha of a sheen: below it the fibres stand upright to within a degree and reflect
/// next to nothing, and Charlie's exponent 1/alpha overflows single precision.
const MINIMUM_SHEEN_ALPHA: f32 = 1e-3;

/// glTF's metallic-roughness material with the layers of its extensions, every number in its
/// range. Black in all of its lobes where the surface is unlit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LayeredMaterial {
    /// In \[0, 1\].
    pub(super) base_color: Vec3,
    /// In \[0, 1\].
    pub(super) metallic: f32,
    /// Reflectance of the dielectric at normal incidence, in \[0, 1\].
    pub(super) dielectric_f0: Vec3,
    /// Reflectance of the dielectric at grazing incidence, in \[0, 1\].
    pub(super) dielectric_f90: f32,
    /// GGX widths along and across the tangent, from [`MINIMUM_ALPHA`] to 1.
    pub(super) alpha: [f32; 2],
    /// In \[0, 1\].
    pub(super) diffuse_roughness: f32,
    /// In \[0, 1\].
    pub(super) sheen_color: Vec3,
    /// From [`MINIMUM_SHEEN_ALPHA`] to 1.
    pub(super) sheen_alpha: f32,
    /// In \[0, 1\].
    pub(super) clearcoat: f32,
    /// GGX width, from [`MINIMUM_ALPHA`] to 1.
    pub(super) clearcoat_alpha: f32,
}

impl LayeredMaterial {
    #[inline(always)]
    pub(super) fn new(surface: &SurfaceSample) -> Self {
        let unit = |x: f32| x.clamp(0.0, 1.0);
        let unit3 = |x: Vec3| x.clamp(Vec3::ZERO, Vec3::ONE);
        let squared = |x: f32, least: f32| (unit(x) * unit(x)).max(least);
        let alpha = squared(surface.perceptual_roughness, MINIMUM_ALPHA as f32);
        let stretch = unit(surface.anisotropy_strength) * unit(surface.anisotropy_strength);
        // KHR_materials_specular, "Interaction with other extensions".
        let specular = if surface.unlit {
            0.0
        } else {
            unit(surface.specular)
        };
        let colored = surface.specular_color.max(Vec3::ZERO) * reflectance(surface.ior);
        let lit = if surface.unlit { 0.0 } else { 1.0 };
        Self {
            base_color: unit3(surface.base_color) * lit,
            metallic: unit(surface.metallic) * lit,
            dielectric_f0: colored.min(Vec3::ONE) * specular,
            dielectric_f90: specular,
            alpha: [alpha + (1.0 - alpha) * stretch, alpha],
            diffuse_roughness: unit(surface.diffuse_roughness),
            sheen_color: unit3(surface.sheen_color) * lit,
            sheen_alpha: squared(surface.sheen_perceptual_roughness, MINIMUM_SHEEN_ALPHA),
            clearcoat: unit(surface.clearcoat) * lit,
            clearcoat_alpha: squared(surface.clearcoat_perceptual_roughness, MINIMUM_ALPHA as f32),
        }
    }
}

/// Reflectance at normal incidence of a dielectric in air; an index of 0 stands for an infinite
/// one (`KHR_materials_ior`).
fn reflectance(ior: f32) -> f32 {
    if ior == 0.0 {
        return 1.0;
    }
    // Not ((ior - 1)/(ior + 1))^2: an index of 3e38 must not become infinity over infinity.
    let root = 1.0 - 2.0 / (ior.max(1.0) + 1.0);
    root * root
}

/// Radiance a surface sends to the viewer by itself, beneath any coat.
pub(super) fn emitted(surface: &SurfaceSample) -> Vec3 {
    if surface.unlit {
        surface.base_color
    } else {
        surface.emissive
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_of_refraction_gives_reflectance() {
        assert!((reflectance(1.5) - 0.04).abs() < 1e-8);
        assert_eq!((reflectance(1.0), reflectance(0.0)), (0.0, 1.0));
        assert_eq!(reflectance(f32::MAX), 1.0);
    }
}
