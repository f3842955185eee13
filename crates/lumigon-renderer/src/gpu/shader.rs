//! The backend's shaders.

use super::device::Gpu;
use super::error::GpuError;
use super::scene_buffers::Features;

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("shaders/", $name, ".wesl")))),*]
    };
}

/// What the entry points import, beside the library and the lights' bindings.
const MODULES: &[(&str, &str)] = modules![
    "frame", "geometry", "lobes", "material", "punctual", "rays", "surface", "texture", "tone_map",
];

pub(super) const VISIBILITY: &str = include_str!("shaders/visibility.wesl");
pub(super) const SHADE: &str = include_str!("shaders/shade.wesl");
pub(super) const DISPLAY: &str = include_str!("shaders/display.wesl");

/// What `shadow_rays` is where surfaces block light, and where they do not.
const SHADOW_RAYS: &str = include_str!("shaders/shadow_rays.wesl");
const NO_SHADOW_RAYS: &str = include_str!("shaders/no_shadow_rays.wesl");

/// A linked shader and its WGSL.
pub(super) struct Shader {
    pub(super) module: wgpu::ShaderModule,
    wgsl: String,
}

impl Shader {
    /// Without rays to lights.
    pub(super) fn new(gpu: &Gpu, label: &str, root: &str) -> Result<Self, GpuError> {
        Self::with(gpu, label, root, false)
    }

    /// `traces_lights`: whether surfaces block light.
    pub(super) fn with(
        gpu: &Gpu,
        label: &str,
        root: &str,
        traces_lights: bool,
    ) -> Result<Self, GpuError> {
        let wgsl = wgsl(root, traces_lights)?;
        let module = gpu
            .device()
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl.as_str().into()),
            });
        Ok(Self { module, wgsl })
    }

    /// Those of the constants that the shader has: linking drops what nothing uses.
    pub(super) fn constants<'a>(&self, constants: &[(&'a str, f64)]) -> Vec<(&'a str, f64)> {
        let has = |name: &str| self.wgsl.contains(&format!("override {name}:"));
        constants.iter().copied().filter(|c| has(c.0)).collect()
    }
}

/// The WGSL of an entry point with all that it imports.
fn wgsl(root: &str, traces_lights: bool) -> Result<String, GpuError> {
    let shadow_rays = if traces_lights {
        SHADOW_RAYS
    } else {
        NO_SHADOW_RAYS
    };
    let modules: Vec<_> = MODULES
        .iter()
        .chain(&[("shadow_rays", shadow_rays)])
        .chain(lumigon_wgpu::MODULES)
        .copied()
        .collect();
    lumigon_shaders::link(root, &modules).map_err(|fault| GpuError::Refused {
        what: "to link its shaders",
        reason: fault.to_string(),
    })
}

/// The shaders' constants for what the scene has.
pub(super) fn scene_constants(features: Features) -> [(&'static str, f64); 7] {
    let Features {
        textures,
        anisotropy,
        clearcoat,
        sheen,
        diffuse_roughness,
    } = features;
    [
        ("HAS_TEXTURES", textures),
        ("HAS_ANISOTROPIC_SURFACES", anisotropy),
        ("HAS_COATED_SURFACES", clearcoat),
        ("HAS_ANISOTROPIC", anisotropy),
        ("HAS_COATS", clearcoat),
        ("HAS_SHEENS", sheen),
        ("HAS_ROUGH_DIFFUSE", diffuse_roughness),
    ]
    .map(|(name, has)| (name, f64::from(u8::from(has))))
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use lumigon_wgpu::ClusterRecord;

    use super::super::display::DisplayRecord;
    use super::super::frame::FrameRecord;
    use super::super::light_set::PunctualRecord;
    use super::super::rays::RayNodeRecord;
    use super::super::record::{
        MaterialRecord, MeshRecord, TextureRecord, TextureUse, TriangleRecord,
    };
    use super::super::shading::ShadingRecord;
    use super::*;

    fn parsed(root: &str, traces_lights: bool) -> naga::Module {
        let text = wgsl(root, traces_lights).unwrap();
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(&text)));
        naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .unwrap();
        module
    }

    /// Each member's name and offset.
    fn layout<'a>(module: &'a naga::Module, name: &str) -> Vec<(&'a str, usize)> {
        let found = module.types.iter().find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, .. } if ty.name.as_deref() == Some(name) => Some(
                members
                    .iter()
                    .map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize))
                    .collect(),
            ),
            _ => None,
        });
        found.unwrap_or_else(|| panic!("the shaders have no struct {name}"))
    }

    fn stride(module: &naga::Module, list: &str) -> usize {
        let (_, variable) = module
            .global_variables
            .iter()
            .find(|(_, variable)| variable.name.as_deref() == Some(list))
            .unwrap_or_else(|| panic!("the shaders have no {list}"));
        match module.types[variable.ty].inner {
            naga::TypeInner::Array { stride, .. } => stride as usize,
            naga::TypeInner::Struct { span, .. } => span as usize,
            ref other => panic!("{list} is {other:?}"),
        }
    }

    macro_rules! offsets {
        ($record:ty: $($member:ident),* $(,)?) => {
            vec![$((stringify!($member), offset_of!($record, $member))),*]
        };
    }

    #[test]
    fn records_are_laid_out_as_the_shaders_have_them() {
        let shade = parsed(SHADE, true);
        parsed(SHADE, false);
        parsed(VISIBILITY, false);
        let display = parsed(DISPLAY, false);
        assert_eq!(
            layout(&display, "Display"),
            offsets!(DisplayRecord: tile_origin, tile_width, tone_map, exposure)
        );
        assert_eq!(stride(&display, "display"), size_of::<DisplayRecord>());
        for (name, expected) in [
            (
                "Frame",
                offsets!(FrameRecord: camera_from_world, world_from_camera, camera_position, scale,
                    half_size, clip_scale, clip_shift, picture_size, sample_offset, tile_origin,
                    tile_size, depth, is_orthographic, share),
            ),
            ("TriangleRecord", offsets!(TriangleRecord: corners, mesh)),
            (
                "MeshRecord",
                offsets!(MeshRecord: material, first_vertex, first_number, stride, normal, tangent,
                    color, texcoord),
            ),
            (
                "TextureRecord",
                offsets!(TextureRecord: first_word, width, height, format, wrap, is_linear),
            ),
            (
                "TextureUse",
                offsets!(TextureUse: columns, offset, texture, texcoord),
            ),
            (
                "MaterialRecord",
                offsets!(MaterialRecord: base_color, emissive, flags, specular_color, specular,
                    sheen_color, sheen_perceptual_roughness, metallic, perceptual_roughness, ior,
                    diffuse_roughness, anisotropy_rotation, anisotropy_strength, normal_scale,
                    clearcoat, clearcoat_perceptual_roughness, clearcoat_normal_scale, cutoff,
                    textures),
            ),
            (
                "PunctualLight",
                offsets!(PunctualRecord: position, kind, direction, range, color, outer_cosine,
                    cone_scale),
            ),
            (
                "Shading",
                offsets!(ShadingRecord: light_bound, bias, first_light, end_light,
                    first_punctual, end_punctual, adds_emission, smoothness_factor, smoothness, image_taps,
                    targets, ray_epsilon),
            ),
            (
                "RayNode",
                offsets!(RayNodeRecord: low, skip, high, triangle),
            ),
            ("Cluster", offsets!(ClusterRecord: center, radius, power)),
        ] {
            assert_eq!(layout(&shade, name), expected, "{name}");
        }
        for (list, expected) in [
            ("frame", size_of::<FrameRecord>()),
            ("triangles", size_of::<TriangleRecord>()),
            ("meshes", size_of::<MeshRecord>()),
            ("textures", size_of::<TextureRecord>()),
            ("materials", size_of::<MaterialRecord>()),
            ("punctual_lights", size_of::<PunctualRecord>()),
            ("shading", size_of::<ShadingRecord>()),
            ("clusters", size_of::<ClusterRecord>()),
            ("ray_nodes", size_of::<RayNodeRecord>()),
        ] {
            assert_eq!(stride(&shade, list), expected, "{list}");
        }
    }
}
