//! glTF's metallic-roughness material.

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

/// glTF's metallic-roughness material, with every factor and texture.
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
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// Whether faces of this material can emit at all.
    #[must_use]
    pub fn is_emissive(&self) -> bool {
        !self.unlit && self.emissive.max_element() > 0.0
    }
}
