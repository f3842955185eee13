//! glTF's metallic-roughness material and the layers that its extensions add.

use glam::{Mat3, Vec2, Vec3, Vec4};

/// How a material's alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Present where alpha is at least the cutoff, absent elsewhere.
    Mask {
        /// The cutoff.
        cutoff: f32,
    },
    /// Blended over what lies behind. Drawn as opaque, and reported so.
    Blend,
}

/// Where a texture sits on a surface: `uv' = offset + R(rotation) · (scale ∘ uv)` as in
/// `KHR_texture_transform`, rotating counter-clockwise about the image's upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureTransform {
    /// The third column is the offset, the upper 2×2 block rotation times scale.
    pub texture_from_texcoord: Mat3,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self {
            texture_from_texcoord: Mat3::IDENTITY,
        }
    }
}

impl TextureTransform {
    /// From the extension's three properties; `rotation` in radians.
    #[must_use]
    pub fn new(offset: Vec2, rotation: f32, scale: Vec2) -> Self {
        let (sin, cos) = rotation.sin_cos();
        Self {
            texture_from_texcoord: Mat3::from_cols(
                Vec3::new(cos * scale.x, -sin * scale.x, 0.0),
                Vec3::new(sin * scale.y, cos * scale.y, 0.0),
                offset.extend(1.0),
            ),
        }
    }

    /// Texture coordinates of the mesh to coordinates in the image.
    #[must_use]
    pub fn apply(&self, texcoord: Vec2) -> Vec2 {
        self.texture_from_texcoord.transform_point2(texcoord)
    }
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureRef {
    /// Index into [`super::Scene::textures`].
    pub texture: usize,
    /// Which of [`super::Mesh::texcoords`], 0 or 1.
    pub texcoord: usize,
    /// Where the texture sits.
    pub transform: TextureTransform,
}

/// glTF's metallic-roughness material, with every factor and texture, and those of
/// `KHR_materials_specular`, `_ior`, `_anisotropy`, `_sheen`, `_clearcoat` and the draft
/// `KHR_materials_diffuse_roughness`. Textures multiply the factors they are named after.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The material's name, where the file has one.
    pub name: String,
    /// Linear RGBA factor of the base colour.
    pub base_color: Vec4,
    /// Multiplies [`Material::base_color`].
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// Square root of the GGX width alpha, 0 to 1.
    pub perceptual_roughness: f32,
    /// Green multiplies [`Material::perceptual_roughness`], blue [`Material::metallic`].
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Strength of the dielectric reflection, 0 to 1.
    pub specular: f32,
    /// Alpha multiplies [`Material::specular`].
    pub specular_texture: Option<TextureRef>,
    /// Linear RGB, at least 0, that multiplies the dielectric's reflectance at normal incidence.
    pub specular_color: Vec3,
    /// Multiplies [`Material::specular_color`].
    pub specular_color_texture: Option<TextureRef>,
    /// Index of refraction, at least 1; 0 stands for an infinite one, which reflects everything.
    pub ior: f32,
    /// How much wider the specular lobe is along its direction than across it, 0 to 1.
    pub anisotropy_strength: f32,
    /// Radians from the tangent towards the bitangent to that direction.
    pub anisotropy_rotation: f32,
    /// Red and green are the direction that is turned so, blue multiplies
    /// [`Material::anisotropy_strength`].
    pub anisotropy_texture: Option<TextureRef>,
    /// Width r of the diffuse lobe's facets, 0 (Lambertian) to 1.
    pub diffuse_roughness: f32,
    /// Red multiplies [`Material::diffuse_roughness`].
    pub diffuse_roughness_texture: Option<TextureRef>,
    /// Linear RGB reflectance of the fibres over the surface; black for none.
    pub sheen_color: Vec3,
    /// Multiplies [`Material::sheen_color`].
    pub sheen_color_texture: Option<TextureRef>,
    /// Square root of the Charlie lobe's alpha, 0 to 1.
    pub sheen_perceptual_roughness: f32,
    /// Alpha multiplies [`Material::sheen_perceptual_roughness`].
    pub sheen_roughness_texture: Option<TextureRef>,
    /// How much of the surface is coated, 0 to 1.
    pub clearcoat: f32,
    /// Red multiplies [`Material::clearcoat`].
    pub clearcoat_texture: Option<TextureRef>,
    /// Square root of the coat's GGX width, 0 to 1.
    pub clearcoat_perceptual_roughness: f32,
    /// Green multiplies [`Material::clearcoat_perceptual_roughness`].
    pub clearcoat_roughness_texture: Option<TextureRef>,
    /// The coat's own tangent-space normals: the surface's do not touch it.
    pub clearcoat_normal_texture: Option<TextureRef>,
    /// Scales the coat's normal texture's x and y.
    pub clearcoat_normal_scale: f32,
    /// Tangent-space normals.
    pub normal_texture: Option<TextureRef>,
    /// Scales the normal texture's x and y.
    pub normal_scale: f32,
    /// Red darkens ambient light. This renderer has none, so it is unused.
    pub occlusion_texture: Option<TextureRef>,
    /// How far the occlusion texture acts, 0 to 1.
    pub occlusion_strength: f32,
    /// Linear RGB radiance: the emissive factor times the emissive strength.
    pub emissive: Vec3,
    /// Multiplies [`Material::emissive`].
    pub emissive_texture: Option<TextureRef>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Back faces are drawn, and emit, like front faces; otherwise they are absent.
    pub double_sided: bool,
    /// Shown as its base colour, unlit (`KHR_materials_unlit`).
    pub unlit: bool,
    /// Index among the file's materials of the one it was read from; a copy that was changed keeps it.
    pub source: Option<usize>,
}

impl Default for Material {
    /// The material glTF gives to primitives without one: white, rough metal.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            perceptual_roughness: 1.0,
            metallic_roughness_texture: None,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            ior: 1.5,
            anisotropy_strength: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            diffuse_roughness: 0.0,
            diffuse_roughness_texture: None,
            sheen_color: Vec3::ZERO,
            sheen_color_texture: None,
            sheen_perceptual_roughness: 0.0,
            sheen_roughness_texture: None,
            clearcoat: 0.0,
            clearcoat_texture: None,
            clearcoat_perceptual_roughness: 0.0,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
            clearcoat_normal_scale: 1.0,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            source: None,
        }
    }
}

impl Material {
    /// Whether faces of this material can emit at all.
    #[must_use]
    pub fn is_emissive(&self) -> bool {
        !self.unlit && self.emissive.max_element() > 0.0
    }

    /// Whether any part of it shows that texture.
    pub(super) fn shows(&self, texture: usize) -> bool {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.anisotropy_texture,
            &self.diffuse_roughness_texture,
            &self.sheen_color_texture,
            &self.sheen_roughness_texture,
            &self.clearcoat_texture,
            &self.clearcoat_roughness_texture,
            &self.clearcoat_normal_texture,
            &self.normal_texture,
            &self.occlusion_texture,
            &self.emissive_texture,
        ]
        .into_iter()
        .flatten()
        .any(|reference| reference.texture == texture)
    }
}
