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
    "frame", "geometry", "lobes", "material", "punctual", "surface", "texture",
];

pub(super) const VISIBILITY: &str = include_str!("shaders/visibility.wesl");
pub(super) const SHADE: &str = include_str!("shaders/shade.wesl");

/// A linked shader and its WGSL.
pub(super) struct Shader {
    pub(super) module: wgpu::ShaderModule,
    wgsl: String,
}

impl Shader {
    pub(super) fn new(gpu: &Gpu, label: &str, root: &str) -> Result<Self, GpuError> {
        let wgsl = wgsl(root)?;
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
pub(super) fn wgsl(root: &str) -> Result<String, GpuError> {
    let modules: Vec<_> = MODULES
        .iter()
        .chain(lumigon_wgpu::MODULES)
        .copied()
        .collect();
    lumigon_shaders::link(root, &modules, &[]).map_err(|fault| GpuError::Refused {
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
