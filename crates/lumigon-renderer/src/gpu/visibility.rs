//! Which triangle each pixel of a tile sees.

use super::device::Gpu;
use super::error::GpuError;
use super::scene_buffers::{DRAWN, Drawn, SceneBuffers};
use super::shader::{Shader, VISIBILITY, scene_constants};

/// Which triangle, counted from 1; 0 for none.
pub(super) const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The pipelines of a scene.
pub(super) struct Visibility {
    /// As [`DRAWN`].
    pipelines: [wgpu::RenderPipeline; 3],
}

/// What a tile is rastered to.
pub(super) struct Canvas {
    pub(super) ids: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Canvas {
    pub(super) fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Self {
        let texture = |label, format, usage| {
            let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        Self {
            ids: texture("visible triangles", ID_FORMAT, read),
            depth: texture("depth", DEPTH_FORMAT, wgpu::TextureUsages::empty()),
        }
    }
}

impl Visibility {
    pub(super) fn new(
        gpu: &Gpu,
        scene_layout: &wgpu::BindGroupLayout,
        scene: &SceneBuffers,
    ) -> Result<Self, GpuError> {
        let shader = Shader::new(gpu, "visibility", VISIBILITY)?;
        let constants = shader.constants(&scene_constants(scene.features));
        let options = wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..Default::default()
        };
        let layout = gpu
            .device()
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("visibility"),
                bind_group_layouts: &[None, Some(scene_layout)],
                immediate_size: 0,
            });
        let pipeline = |drawn| {
            let (cull_mode, entry_point) = match drawn {
                Drawn::FromItsFront => (Some(wgpu::Face::Back), "triangle_here"),
                Drawn::FromBothSides => (None, "triangle_here"),
                Drawn::WhereOpaque => (None, "triangle_where_opaque"),
            };
            gpu.device()
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(entry_point),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &shader.module,
                        entry_point: Some("vertex_of_triangle"),
                        compilation_options: options.clone(),
                        buffers: &[],
                    },
                    primitive: wgpu::PrimitiveState {
                        cull_mode,
                        ..Default::default()
                    },
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: DEPTH_FORMAT,
                        depth_write_enabled: Some(true),
                        // Depth falls with distance.
                        depth_compare: Some(wgpu::CompareFunction::Greater),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &shader.module,
                        entry_point: Some(entry_point),
                        compilation_options: options.clone(),
                        targets: &[Some(ID_FORMAT.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        };
        Ok(Self {
            pipelines: DRAWN.map(pipeline),
        })
    }

    /// Rasters the tile of `size` whose frame starts at `frame_offset`.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        canvas: &Canvas,
        size: [u32; 2],
        frame_offset: u32,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("visibility"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &canvas.ids,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &canvas.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: timestamps,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_viewport(0.0, 0.0, size[0] as f32, size[1] as f32, 0.0, 1.0);
        pass.set_bind_group(1, &scene.bind_group, &[frame_offset]);
        for (pipeline, range) in self.pipelines.iter().zip(&scene.ranges) {
            if !range.is_empty() {
                pass.set_pipeline(pipeline);
                pass.draw(3 * range.start..3 * range.end, 0..1);
            }
        }
    }
}
