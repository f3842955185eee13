//! Which triangle each pixel of a tile sees.

use super::device::Gpu;
use super::error::GpuError;
use super::scene_buffers::{DRAWN, Drawn, Features, SceneBuffers};
use super::shader::{Shader, VISIBILITY, scene_constants};

/// Which triangle, counted from 1; 0 for none.
pub(super) const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What finds the triangles of a scene.
pub(super) struct Visibility {
    raster: Raster,
    to_ids: Pipelines,
}

/// The shader that triangles are rastered by.
pub(super) struct Raster {
    shader: Shader,
    layout: wgpu::PipelineLayout,
    features: Features,
}

/// One for each of [`DRAWN`].
pub(super) struct Pipelines([wgpu::RenderPipeline; 3]);

/// What triangles are rastered onto.
#[derive(Clone, Copy)]
pub(super) struct Onto<'a> {
    pub(super) colors: &'a [&'a wgpu::TextureView],
    pub(super) depth: &'a wgpu::TextureView,
    pub(super) size: [u32; 2],
}

/// What a tile is rastered to.
pub(super) struct Canvas {
    pub(super) ids: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Canvas {
    pub(super) fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let texture = |label, format, usage| target(gpu, label, size, format, usage).1;
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        Self {
            ids: texture("visible triangles", ID_FORMAT, read),
            depth: texture("depth", DEPTH_FORMAT, wgpu::TextureUsages::empty()),
        }
    }
}

/// A texture to raster to.
pub(super) fn target(
    gpu: &Gpu,
    label: &'static str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> (wgpu::Texture, wgpu::TextureView) {
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
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    (texture, view)
}

/// The entry points that find triangles.
const TO_IDS: [&str; 2] = ["triangle_here", "triangle_where_opaque"];

impl Visibility {
    pub(super) fn new(
        gpu: &Gpu,
        scene_layout: &wgpu::BindGroupLayout,
        scene: &SceneBuffers,
    ) -> Result<Self, GpuError> {
        let raster = Raster {
            shader: Shader::new(gpu, "visibility", VISIBILITY)?,
            layout: gpu
                .device()
                .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some("visibility"),
                    bind_group_layouts: &[None, Some(scene_layout)],
                    immediate_size: 0,
                }),
            features: scene.features,
        };
        Ok(Self {
            to_ids: raster.pipelines(gpu, TO_IDS, &[ID_FORMAT]),
            raster,
        })
    }

    /// Pipelines for other features.
    pub(super) fn pipelines_for(&self, gpu: &Gpu, features: Features) -> Pipelines {
        self.raster
            .pipelines_for(gpu, features, TO_IDS, &[ID_FORMAT])
    }

    /// Takes the pipelines for other features.
    pub(super) fn set(&mut self, features: Features, pipelines: Pipelines) {
        self.raster.features = features;
        self.to_ids = pipelines;
    }

    /// What other pipelines are made with.
    pub(super) fn raster(&self) -> &Raster {
        &self.raster
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
        let onto = Onto {
            colors: &[&canvas.ids],
            depth: &canvas.depth,
            size,
        };
        self.to_ids
            .encode(encoder, scene, onto, frame_offset, timestamps);
    }
}

impl Raster {
    /// Pipelines that run the first of two entry points, the second for masked materials.
    pub(super) fn pipelines(
        &self,
        gpu: &Gpu,
        entry_points: [&'static str; 2],
        formats: &[wgpu::TextureFormat],
    ) -> Pipelines {
        self.pipelines_for(gpu, self.features, entry_points, formats)
    }

    fn pipelines_for(
        &self,
        gpu: &Gpu,
        features: Features,
        [here, where_opaque]: [&'static str; 2],
        formats: &[wgpu::TextureFormat],
    ) -> Pipelines {
        let constants = self.shader.constants(&scene_constants(features));
        let options = wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..Default::default()
        };
        let targets: Vec<_> = formats.iter().map(|&format| Some(format.into())).collect();
        let pipeline = |drawn| {
            let (cull_mode, entry_point) = match drawn {
                Drawn::FromItsFront => (Some(wgpu::Face::Back), here),
                Drawn::FromBothSides => (None, here),
                Drawn::WhereOpaque => (None, where_opaque),
            };
            gpu.device()
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(entry_point),
                    layout: Some(&self.layout),
                    vertex: wgpu::VertexState {
                        module: &self.shader.module,
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
                        module: &self.shader.module,
                        entry_point: Some(entry_point),
                        compilation_options: options.clone(),
                        targets: &targets,
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        };
        Pipelines(DRAWN.map(pipeline))
    }
}

impl Pipelines {
    /// Rasters the scene as the frame at `frame_offset` sees it.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        onto: Onto<'_>,
        frame_offset: u32,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let attachment = |view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let colors: Vec<_> = onto.colors.iter().map(|&view| attachment(view)).collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("visibility"),
            color_attachments: &colors,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: onto.depth,
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
        let [width, height] = onto.size.map(|pixels| pixels as f32);
        pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
        pass.set_bind_group(1, &scene.bind_group, &[frame_offset]);
        for (pipeline, draws) in self.0.iter().zip(&scene.draws) {
            if !draws.is_empty() {
                pass.set_pipeline(pipeline);
            }
            for range in draws {
                pass.draw(3 * range.start..3 * range.end, 0..1);
            }
        }
    }
}
