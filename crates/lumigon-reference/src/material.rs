//! What a surface is made of: the numbers of glTF's layered material at one point.

/// The numbers of glTF's layered material at one point, after textures and factors.
///
/// Layers from the bottom: a diffuse and a GGX lobe (`base_color` to `diffuse_roughness`), a Charlie sheen over them, a
/// clearcoat over all. A lobe whose colour or weight is zero costs nothing.
///
/// Each layer leaves to those below what its directional albedo at this view does not reflect, so a white furnace shows
/// at most 1. With a the albedo of the GGX lobe with Fresnel factor 1, s the same weighted by (1 - h.v)^5, and e that
/// of Charlie, which exceeds 1 for small widths at grazing views:
///
/// ```text
/// E         = max3(dielectric_f0) (a - s) + dielectric_f90 s
/// diffuse   = EON(base_color) (1 - metallic) (1 - E)                  (Lambert where diffuse_roughness is 0)
/// specular  = GGX with F = f0 + (f90 - f0) (1 - h.v)^5,
///             f0 = mix(dielectric_f0, base_color, metallic), f90 = mix(dielectric_f90, 1, metallic)
/// layer     = sheen_color Charlie / max(1, e) + (diffuse + specular) (1 - max3(sheen_color) min(1, e))
/// w         = clearcoat (0.04 + 0.96 (1 - |n_c.v|)^5)
/// reflected = layer (1 - w) + w GGX about n_c with F = 1
/// ```
///
/// Numbers out of range, NaN among them, are clamped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Colour of the diffuse lobe, and of the metal at normal incidence, RGB in [0, 1].
    pub base_color: [f64; 3],
    /// From dielectric 0 to metal 1.
    pub metallic: f64,
    /// Reflectance of the dielectric at normal incidence, RGB in [0, 1].
    pub dielectric_f0: [f64; 3],
    /// Reflectance of the dielectric at grazing incidence, in [0, 1].
    pub dielectric_f90: f64,
    /// GGX widths along and across the tangent, in [1e-4, 1].
    pub alpha: [f64; 2],
    /// World direction of the first width; only its part orthogonal to the shading normal counts. Any where it is zero.
    pub tangent: [f64; 3],
    /// EON's r in [0, 1]; 0 is Lambert.
    pub diffuse_roughness: f64,
    /// Colour of the sheen, RGB in [0, 1].
    pub sheen_color: [f64; 3],
    /// Charlie width, the square of glTF's sheen roughness, in [1e-6, 1].
    pub sheen_alpha: f64,
    /// Weight of the clearcoat before its Fresnel factor, in [0, 1].
    pub clearcoat: f64,
    /// GGX width of the clearcoat, in [1e-4, 1].
    pub clearcoat_alpha: f64,
    /// World normal of the clearcoat, a unit vector; the shading normal where it is zero.
    pub clearcoat_normal: [f64; 3],
}

impl Default for Material {
    /// A white, rough dielectric of index 1.5: glTF's default, but not metallic.
    fn default() -> Self {
        Self {
            base_color: [1.0; 3],
            metallic: 0.0,
            dielectric_f0: [0.04; 3],
            dielectric_f90: 1.0,
            alpha: [1.0; 2],
            tangent: [0.0; 3],
            diffuse_roughness: 0.0,
            sheen_color: [0.0; 3],
            sheen_alpha: 1.0,
            clearcoat: 0.0,
            clearcoat_alpha: 1.0,
            clearcoat_normal: [0.0; 3],
        }
    }
}
