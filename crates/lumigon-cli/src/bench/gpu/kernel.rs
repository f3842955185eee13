//! A compute shader with what it works on.

use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::Failure;

/// A pipeline of the entry point `main`.
///
/// `layouts` are those of its bind groups; a constant is an `override` of the shader.
///
/// # Errors
/// Where the shader does not link or the device does not take it.
pub(super) fn pipeline(
    device: &wgpu::Device,
    label: &str,
    root: &str,
    modules: &[(&str, &str)],
    constants: &[(&str, f64)],
    layouts: &[&wgpu::BindGroupLayout],
) -> Result<wgpu::ComputePipeline, Failure> {
    let text = lumigon_shaders::link(root, modules)?;
    let scopes = [
        wgpu::ErrorFilter::Validation,
        wgpu::ErrorFilter::OutOfMemory,
        wgpu::ErrorFilter::Internal,
    ]
    .map(|filter| device.push_error_scope(filter));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &layouts
            .iter()
            .map(|&layout| Some(layout))
            .collect::<Vec<_>>(),
        ..Default::default()
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            ..Default::default()
        },
        cache: None,
    });
    // Scopes close in the opposite order.
    for scope in scopes.into_iter().rev() {
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(format!("the shader {label:?} does not compile: {error}").into());
        }
    }
    Ok(pipeline)
}

/// What a binding is.
#[derive(Clone, Copy)]
pub(super) enum Binding {
    /// Read at a dynamic offset.
    Settings,
    Read,
    Write,
}

/// The layout of a group of buffers, numbered from 0.
pub(super) fn layout(device: &wgpu::Device, bindings: &[Binding]) -> wgpu::BindGroupLayout {
    let entry = |(binding, kind): (usize, &Binding)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match kind {
                Binding::Settings => wgpu::BufferBindingType::Uniform,
                Binding::Read => wgpu::BufferBindingType::Storage { read_only: true },
                Binding::Write => wgpu::BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: matches!(kind, Binding::Settings),
            min_binding_size: None,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &bindings.iter().enumerate().map(entry).collect::<Vec<_>>(),
    })
}

/// A group of these resources, numbered from 0.
pub(super) fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &resources
            .iter()
            .enumerate()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: binding as u32,
                resource: resource.clone(),
            })
            .collect::<Vec<_>>(),
    })
}

/// A buffer that shaders read.
pub(super) fn filled<T: bytemuck::NoUninit>(
    device: &wgpu::Device,
    label: &str,
    contents: &[T],
) -> wgpu::Buffer {
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some(label),
        contents: bytemuck::cast_slice(contents),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM,
    })
}

/// A buffer that shaders write and the host may read.
pub(super) fn written(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}
