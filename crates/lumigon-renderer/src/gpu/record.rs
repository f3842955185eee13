//! The scene as shaders read it: their structs, field by field.

use bytemuck::{Pod, Zeroable};

use crate::scene::{AlphaMode, Material, TextureRef};

/// What a list lacks.
pub(super) const NONE: u32 = u32::MAX;

/// `TriangleRecord` of `geometry.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct TriangleRecord {
    pub(super) corners: [u32; 3],
    pub(super) mesh: u32,
}

/// `MeshRecord` of `geometry.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct MeshRecord {
    pub(super) material: u32,
    pub(super) first_vertex: u32,
    pub(super) first_number: u32,
    pub(super) stride: u32,
    pub(super) normal: u32,
    pub(super) tangent: u32,
    pub(super) color: u32,
    pub(super) texcoord: [u32; 2],
}

/// `TextureRecord` of `texture.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct TextureRecord {
    pub(super) first_word: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) format: u32,
    pub(super) wrap: [u32; 2],
    pub(super) is_linear: u32,
    pub(super) padding: u32,
}

/// `TextureUse` of `texture.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct TextureUse {
    pub(super) columns: [f32; 4],
    pub(super) offset: [f32; 2],
    pub(super) texture: u32,
    pub(super) texcoord: u32,
}

/// `MaterialRecord` of `surface.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct MaterialRecord {
    pub(super) base_color: [f32; 4],
    pub(super) emissive: [f32; 3],
    pub(super) flags: u32,
    pub(super) specular_color: [f32; 3],
    pub(super) specular: f32,
    pub(super) sheen_color: [f32; 3],
    pub(super) sheen_perceptual_roughness: f32,
    pub(super) metallic: f32,
    pub(super) perceptual_roughness: f32,
    pub(super) ior: f32,
    pub(super) diffuse_roughness: f32,
    pub(super) anisotropy_rotation: [f32; 2],
    pub(super) anisotropy_strength: f32,
    pub(super) normal_scale: f32,
    pub(super) clearcoat: f32,
    pub(super) clearcoat_perceptual_roughness: f32,
    pub(super) clearcoat_normal_scale: f32,
    pub(super) cutoff: f32,
    pub(super) textures: [TextureUse; 13],
}

const DOUBLE_SIDED: u32 = 1;
const UNLIT: u32 = 2;
const MASKED: u32 = 4;

impl From<&Option<TextureRef>> for TextureUse {
    fn from(texture: &Option<TextureRef>) -> Self {
        let TextureRef {
            texture: index,
            texcoord,
            transform,
        } = texture.unwrap_or_default();
        let [x, y, offset] = transform.texture_from_texcoord.to_cols_array_2d();
        Self {
            columns: [x[0], x[1], y[0], y[1]],
            offset: [offset[0], offset[1]],
            texture: texture.map_or(NONE, |_| index as u32),
            texcoord: texcoord as u32,
        }
    }
}

impl From<&Material> for MaterialRecord {
    fn from(material: &Material) -> Self {
        let (mask, cutoff) = match material.alpha_mode {
            AlphaMode::Mask { cutoff } => (MASKED, cutoff),
            _ => (0, 0.0),
        };
        let flag = |is_set, bit| if is_set { bit } else { 0 };
        let (sin, cos) = material.anisotropy_rotation.sin_cos();
        Self {
            base_color: material.base_color.into(),
            emissive: material.emissive.into(),
            flags: mask | flag(material.double_sided, DOUBLE_SIDED) | flag(material.unlit, UNLIT),
            specular_color: material.specular_color.into(),
            specular: material.specular,
            sheen_color: material.sheen_color.into(),
            sheen_perceptual_roughness: material.sheen_perceptual_roughness,
            metallic: material.metallic,
            perceptual_roughness: material.perceptual_roughness,
            ior: material.ior,
            diffuse_roughness: material.diffuse_roughness,
            anisotropy_rotation: [cos, sin],
            anisotropy_strength: material.anisotropy_strength,
            normal_scale: material.normal_scale,
            clearcoat: material.clearcoat,
            clearcoat_perceptual_roughness: material.clearcoat_perceptual_roughness,
            clearcoat_normal_scale: material.clearcoat_normal_scale,
            cutoff,
            // In the order of the shader's TEXTURE constants.
            textures: textures(material).map(TextureUse::from),
        }
    }
}

/// The textures that a renderer reads, in the order of the shader's TEXTURE constants.
pub(super) fn textures(material: &Material) -> [&Option<TextureRef>; 13] {
    [
        &material.base_color_texture,
        &material.metallic_roughness_texture,
        &material.normal_texture,
        &material.emissive_texture,
        &material.specular_texture,
        &material.specular_color_texture,
        &material.anisotropy_texture,
        &material.diffuse_roughness_texture,
        &material.sheen_color_texture,
        &material.sheen_roughness_texture,
        &material.clearcoat_texture,
        &material.clearcoat_roughness_texture,
        &material.clearcoat_normal_texture,
    ]
}
