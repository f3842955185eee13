//! Finished tiles on a texture, as a display shows them.

use std::sync::{Mutex, OnceLock};

use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, lock};
use super::error::GpuError;
use super::shader::{DISPLAY, Shader};
use super::shading::Sums;
use super::tile::Tile;
use crate::picture::ToneMap;

/// How radiance becomes what a display shows, as [`srgb8`](crate::srgb8) does it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplaySettings {
    /// Radiance is scaled by 2 to this.
    pub exposure_ev: f32,
    /// What then makes it displayable.
    pub tone_map: ToneMap,
}

/// `Display` of `display.wesl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct DisplayRecord {
    pub(super) tile_origin: [u32; 2],
    pub(super) tile_width: u32,
    pub(super) tone_map: u32,
    pub(super) exposure: f32,
    pub(super) padding: u32,
}

impl DisplayRecord {
    pub(super) fn new(tile: Tile, settings: DisplaySettings) -> Self {
        Self {
            tile_origin: tile.origin,
            tile_width: tile.size[0],
            tone_map: tone_map_number(settings.tone_map),
            exposure: libm::exp2f(settings.exposure_ev),
            padding: 0,
        }
    }
}

/// The shaders' `TONE_MAP` constants.
pub(super) fn tone_map_number(tone_map: ToneMap) -> u32 {
    match tone_map {
        ToneMap::None => 0,
        ToneMap::Reinhard => 1,
        ToneMap::Aces => 2,
        ToneMap::KhronosPbrNeutral => 3,
    }
}

/// The pipelines for textures, made when they are first drawn to.
#[derive(Default)]
pub(super) struct Display {
    parts: OnceLock<Parts>,
    pipelines: Mutex<Vec<(wgpu::TextureFormat, wgpu::RenderPipeline)>>,
}

/// What pipelines for all formats share.
struct Parts {
    shader: Shader,
    group_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    /// A [`DisplayRecord`], written before each submission.
    uniform: wgpu::Buffer,
}

impl Parts {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let device = gpu.device();
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let mut entries = vec![entry(0, wgpu::BufferBindingType::Uniform)];
        entries.extend((1..4).map(|binding| entry(binding, read)));
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("display"),
            entries: &entries,
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("display"),
            bind_group_layouts: &[Some(&group_layout)],
            immediate_size: 0,
        });
        Ok(Self {
            shader: Shader::new(gpu, "display", DISPLAY)?,
            group_layout,
            layout,
            uniform: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("display"),
                size: size_of::<DisplayRecord>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        })
    }
}

/// What shows a tile's sums on one texture.
pub(super) struct DisplayPass {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    view: wgpu::TextureView,
}

impl Display {
    fn parts(&self, gpu: &Gpu) -> Result<&Parts, GpuError> {
        if let Some(parts) = self.parts.get() {
            return Ok(parts);
        }
        let parts = Parts::new(gpu)?;
        Ok(self.parts.get_or_init(|| parts))
    }

    fn pipeline(
        &self,
        gpu: &Gpu,
        parts: &Parts,
        format: wgpu::TextureFormat,
    ) -> wgpu::RenderPipeline {
        let mut pipelines = lock(&self.pipelines);
        if let Some((_, pipeline)) = pipelines.iter().find(|(of, _)| *of == format) {
            return pipeline.clone();
        }
        let pipeline = gpu
            .device()
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("display"),
                layout: Some(&parts.layout),
                vertex: wgpu::VertexState {
                    module: &parts.shader.module,
                    entry_point: Some("vertex_of_picture"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &parts.shader.module,
                    entry_point: Some("display_pixel"),
                    compilation_options: Default::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            });
        pipelines.push((format, pipeline.clone()));
        pipeline
    }

    /// What shows the sums on `target`.
    pub(super) fn pass(
        &self,
        gpu: &Gpu,
        sums: &Sums,
        target: &wgpu::Texture,
    ) -> Result<DisplayPass, GpuError> {
        let parts = self.parts(gpu)?;
        let buffers = [&parts.uniform].into_iter().chain(&sums.parts);
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        Ok(DisplayPass {
            pipeline: self.pipeline(gpu, parts, target.format()),
            group: gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("display"),
                layout: &parts.group_layout,
                entries: &entries,
            }),
            uniform: parts.uniform.clone(),
            view: target.create_view(&wgpu::TextureViewDescriptor::default()),
        })
    }
}

impl DisplayPass {
    /// Shows a tile: once in each submission. The rest of the texture stays what it was.
    pub(super) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        tile: Tile,
        settings: DisplaySettings,
    ) {
        let record = DisplayRecord::new(tile, settings);
        gpu.queue()
            .write_buffer(&self.uniform, 0, bytemuck::bytes_of(&record));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("display"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let ([x, y], [width, height]) = (tile.origin, tile.size);
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::GpuPreference;
    use crate::picture::srgb8;

    const ROOT: &str = "
import package::tone_map::{apply_tone_map, displayed_color};

struct Query { radiance: vec3f, tone_map: u32, exposure: f32 }

@group(0) @binding(0) var<storage, read> queries: array<Query>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4f>;

@compute @workgroup_size(64)
fn answer(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let color = displayed_color(query.tone_map, query.radiance, query.exposure);
    answers[2u * id.x] = vec4f(apply_tone_map(query.tone_map, query.radiance), 1.0);
    answers[2u * id.x + 1u] = vec4f(color, 1.0);
}
";

    /// `apply_tone_map` = [`ToneMap::apply`], and `displayed_color` = [`srgb8`].
    #[test]
    fn tone_maps_are_the_same_on_both_devices() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let mut colors: Vec<[f32; 3]> = vec![
            [0.0; 3],
            [-1.0, 0.5, -0.0],
            [f32::MAX, 1.0, 0.0],
            [0.04, 0.04, 0.04],
            [0.08, 0.08, 0.08],
        ];
        for i in 0..2000_u32 {
            let x = |k: u32| {
                let bits = (i * 3 + k + 1).wrapping_mul(2_654_435_761) >> 8;
                let unit = f64::from(bits) / f64::from(1 << 24);
                // From 1e-4 to 1e4, and evenly in between.
                let number = if i % 2 == 0 {
                    1e-4 * 1e8_f64.powf(unit)
                } else {
                    1.5 * unit
                };
                number as f32
            };
            colors.push([x(0), x(1), x(2)]);
        }
        let exposure_ev = -0.7;
        let exposure = libm::exp2f(exposure_ev);
        let wild = [[f32::NAN, 0.0, 1.0], [0.0, f32::INFINITY, 0.0]];
        for tone_map in ToneMap::ALL {
            let all: Vec<_> = colors.iter().chain(&wild).copied().collect();
            let answers = answers(&gpu, tone_map, exposure, &all);
            let bytes = srgb8(&all, exposure_ev, tone_map);
            for (i, &color) in all.iter().enumerate() {
                let [applied, shown] = [answers[2 * i], answers[2 * i + 1]];
                for c in 0..3 {
                    let expected = f32::from(bytes[3 * i + c]);
                    let found = 255.0 * shown[c];
                    assert!(
                        (found - expected).abs() <= 0.51,
                        "{tone_map:?} {color:?}: {found} for {expected}"
                    );
                }
                if i < colors.len() {
                    let expected = tone_map.apply(color);
                    for c in 0..3 {
                        let error = (applied[c] - expected[c]).abs();
                        assert!(error < 2e-6, "{tone_map:?} {color:?}: off by {error:e}");
                    }
                }
            }
        }
    }

    fn answers(gpu: &Gpu, tone_map: ToneMap, exposure: f32, colors: &[[f32; 3]]) -> Vec<[f32; 4]> {
        let queries: Vec<[f32; 8]> = colors
            .iter()
            .map(|&[r, g, b]| {
                let number = f32::from_bits(tone_map_number(tone_map));
                [r, g, b, number, exposure, 0.0, 0.0, 0.0]
            })
            .collect();
        let device = gpu.device();
        let shader = Shader::new(gpu, "parity", ROOT).unwrap();
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &shader.module,
            entry_point: Some("answer"),
            compilation_options: Default::default(),
            cache: None,
        });
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: (colors.len() * 32) as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let written = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let queries = gpu.storage("queries", &queries).unwrap();
        let buffers = [&queries, &written];
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(colors.len().div_ceil(64) as u32, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&written, 0, &read, 0, read.size());
        let submission = gpu.queue().submit([encoder.finish()]);
        let mut numbers = Vec::new();
        let take = |_, bytes: &[u8]| numbers = bytemuck::pod_collect_to_vec(bytes);
        gpu.read(&submission, &[read.slice(..)], || false, take)
            .unwrap();
        numbers
    }
}
