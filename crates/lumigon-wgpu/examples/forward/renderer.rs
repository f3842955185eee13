//! Stands for the renderer that you have: a floor, seen from above, shaded by whatever the shader
//! says.

use lumigon::Vec3;
use wgpu::util::DeviceExt;

/// Pixels along each side.
pub(crate) const SIDE: u32 = 256;
/// Above the floor, looking down; x to the right, z down.
pub(crate) const EYE: [f32; 4] = [0.0, 5.0, 0.0, 1.0];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// One pipeline, one draw.
pub(crate) struct Renderer {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

/// Where a pixel sees the floor.
pub(crate) fn floor_point(pixel: u32) -> Option<Vec3<f32>> {
    let at = |i: u32| (i as f32 + 0.5) / SIDE as f32 * 10.0 - 5.0;
    let point = Vec3::new(at(pixel % SIDE), 0.0, at(pixel / SIDE));
    (point.x.abs().max(point.z.abs()) < 3.0).then_some(point)
}

impl Renderer {
    /// `lights` is the layout of bind group 1.
    pub(crate) fn new(device: &wgpu::Device, shader: &str, lights: &wgpu::BindGroupLayout) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(shader.into()),
        });
        let uniform = |numbers: &[f32]| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: bytemuck::cast_slice(numbers),
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        // A field of view of 90 degrees from 5 above, by columns.
        let clip_from_world = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.1, -1.0],
            [0.0, -1.0, 0.0, 0.0],
            [0.0, 0.0, 0.5, 5.0],
        ];
        let [camera, eye] = [uniform(clip_from_world.as_flattened()), uniform(&EYE)];
        let entry = |binding, visibility| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[
                entry(0, wgpu::ShaderStages::VERTEX),
                entry(1, wgpu::ShaderStages::FRAGMENT),
            ],
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: camera.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: eye.as_entire_binding(),
                },
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout), Some(lights)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::TriangleStrip,
                ..Default::default()
            },
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, group }
    }

    /// Renders, and reads the picture back.
    pub(crate) fn render(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lights: &wgpu::BindGroup,
    ) -> Result<Vec<[f32; 4]>, Box<dyn std::error::Error>> {
        let size = wgpu::Extent3d {
            width: SIDE,
            height: SIDE,
            depth_or_array_layers: 1,
        };
        let target = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let back = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(16 * SIDE * SIDE),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let view = target.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: Default::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_bind_group(1, lights, &[]);
        pass.draw(0..4, 0..1);
        drop(pass);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(16 * SIDE),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo {
            buffer: &back,
            layout,
        };
        encoder.copy_texture_to_buffer(target.as_image_copy(), to, size);
        queue.submit([encoder.finish()]);
        back.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        device.poll(wgpu::PollType::wait_indefinitely())?;
        let bytes = back.slice(..).get_mapped_range()?;
        Ok(bytes
            .chunks_exact(16)
            .map(bytemuck::pod_read_unaligned)
            .collect())
    }
}
