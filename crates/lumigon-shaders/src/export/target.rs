//! The languages that the library is exported to.

/// A shading language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// WebGPU Shading Language: the library's own text.
    Wgsl,
    /// OpenGL ES Shading Language 3.00, which WebGL 2 runs.
    GlslEs300,
    /// OpenGL Shading Language 4.50, for OpenGL and, through SPIR-V, Vulkan.
    Glsl450,
    /// High-Level Shader Language, shader model 6.0.
    Hlsl,
    /// Metal Shading Language 2.1.
    Msl,
    /// SPIR-V 1.3, as a library to link.
    Spirv,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Wgsl,
        Self::GlslEs300,
        Self::Glsl450,
        Self::Hlsl,
        Self::Msl,
        Self::Spirv,
    ];

    /// The language's name, with its version.
    #[must_use]
    pub fn language(self) -> &'static str {
        match self {
            Self::Wgsl => "WGSL",
            Self::GlslEs300 => "GLSL ES 3.00",
            Self::Glsl450 => "GLSL 4.50",
            Self::Hlsl => "HLSL, shader model 6.0",
            Self::Msl => "Metal Shading Language 2.1",
            Self::Spirv => "SPIR-V 1.3",
        }
    }

    /// What the library's file is called.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Wgsl => "lumigon.wgsl",
            Self::GlslEs300 | Self::Glsl450 => "lumigon.glsl",
            Self::Hlsl => "lumigon.hlsl",
            Self::Msl => "lumigon.metal",
            Self::Spirv => "lumigon.spv",
        }
    }

    /// A complete shader that calls the library: its file's name and its text.
    #[must_use]
    pub fn example(self) -> (&'static str, &'static str) {
        match self {
            Self::Wgsl => ("example.wgsl", include_str!("examples/example.wgsl")),
            Self::GlslEs300 => ("example.frag", include_str!("examples/example.es.frag")),
            Self::Glsl450 => ("example.frag", include_str!("examples/example.frag")),
            Self::Hlsl => ("example.hlsl", include_str!("examples/example.hlsl")),
            Self::Msl => ("example.metal", include_str!("examples/example.metal")),
            // In SPIR-V too: `Library::export_client`.
            Self::Spirv => ("example.wgsl", include_str!("examples/example.wgsl")),
        }
    }

    /// What prepares lights on the host, in a language that goes with the target: its file's name
    /// and its text.
    #[must_use]
    pub fn host_code(self) -> (&'static str, &'static str) {
        match self {
            Self::Wgsl | Self::GlslEs300 => {
                ("prepare_light.js", include_str!("host/prepare_light.js"))
            }
            Self::Glsl450 | Self::Hlsl | Self::Msl | Self::Spirv => {
                ("prepare_light.hpp", include_str!("host/prepare_light.hpp"))
            }
        }
    }
}
