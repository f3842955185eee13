//! The GPUs of this machine.

use std::fmt;

/// Which adapters will do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuPreference {
    /// Every one: hardware first, then software.
    #[default]
    Any,
    /// Only those that are not the CPU in disguise.
    Hardware,
}

/// What an adapter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AdapterKind {
    /// A GPU with memory of its own.
    Discrete,
    /// A GPU that shares the CPU's memory.
    Integrated,
    /// A GPU lent by another machine or a host.
    Virtual,
    /// Its driver does not say.
    Other,
    /// The CPU does the GPU's work.
    Software,
}

impl From<wgpu::DeviceType> for AdapterKind {
    fn from(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Other => Self::Other,
            wgpu::DeviceType::Cpu => Self::Software,
        }
    }
}

impl fmt::Display for AdapterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Other => "unknown",
            Self::Software => "software",
        })
    }
}

/// What an adapter says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: AdapterKind,
    /// The interface to it: vulkan, metal or dx12.
    pub backend: String,
    /// Its driver's name and version, as far as the driver tells.
    pub driver: String,
    /// Bytes of the largest buffer.
    pub largest_buffer: u64,
    /// Bytes of a buffer that a shader sees: no list of lights, triangles or texels may be longer.
    pub largest_binding: u64,
    /// Storage buffers that a shader sees at once.
    pub storage_buffers: u32,
    /// Texels along a texture's side: no tile may be wider.
    pub largest_texture_side: u32,
    /// Bytes that the threads of a workgroup share.
    pub workgroup_memory: u32,
    /// Threads of a workgroup.
    pub workgroup_threads: u32,
    /// Passes can be timed on the device.
    pub has_timestamps: bool,
    /// Shaders can calculate in half precision.
    pub has_f16: bool,
    /// Single-precision textures can be interpolated.
    pub has_float32_filtering: bool,
    /// Threads can exchange values without memory.
    pub has_subgroups: bool,
}

impl AdapterDescription {
    pub(super) fn new(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let features = adapter.features();
        let driver = [info.driver, info.driver_info];
        Self {
            name: info.name,
            kind: info.device_type.into(),
            backend: info.backend.to_string(),
            driver: driver.join(" ").trim().to_owned(),
            largest_buffer: limits.max_buffer_size,
            largest_binding: limits.max_storage_buffer_binding_size,
            storage_buffers: limits.max_storage_buffers_per_shader_stage,
            largest_texture_side: limits.max_texture_dimension_2d,
            workgroup_memory: limits.max_compute_workgroup_storage_size,
            workgroup_threads: limits.max_compute_invocations_per_workgroup,
            has_timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            has_f16: features.contains(wgpu::Features::SHADER_F16),
            has_float32_filtering: features.contains(wgpu::Features::FLOAT32_FILTERABLE),
            has_subgroups: features.contains(wgpu::Features::SUBGROUP),
        }
    }

    /// Bytes of the longest list that a shader sees.
    pub(super) fn largest_storage(&self) -> u64 {
        self.largest_binding.min(self.largest_buffer)
    }

    /// Whether the CPU does this adapter's work.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.kind == AdapterKind::Software
    }
}
