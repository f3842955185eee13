//! Light on what the pixels of a tile see.

use std::ops::Range;
use std::sync::{Mutex, OnceLock};

use bytemuck::{Pod, Zeroable};
use lumigon::SpecularMethod;

use super::device::{Gpu, lock};
use super::error::GpuError;
use super::light_set::LightSet;
use super::methods::{Methods, bias};
use super::parts::Part;
use super::rays::TracedLights;
use super::scene_buffers::Features;
use super::shader::{SHADE, Shader, scene_constants};
use super::tile::Tile;
use crate::render::RenderSettings;

/// Pixels along a side of the square that a workgroup lights.
const WORKGROUP: u32 = 8;

/// `Shading` of `shade.wesl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct ShadingRecord {
    pub(super) light_bound: f32,
    pub(super) bias: f32,
    pub(super) first_light: u32,
    pub(super) end_light: u32,
    pub(super) first_punctual: u32,
    pub(super) end_punctual: u32,
    pub(super) adds_emission: u32,
    pub(super) smoothness_factor: f32,
    pub(super) smoothness: f32,
    pub(super) image_taps: u32,
    pub(super) targets: u32,
    pub(super) ray_epsilon: f32,
}

impl ShadingRecord {
    /// For these of the lights; whether what surfaces emit is added with them.
    pub(super) fn new(
        settings: &RenderSettings,
        part: &Part,
        adds_emission: bool,
        traced: Option<TracedLights<'_>>,
    ) -> Self {
        let [smoothness_factor, smoothness] = match settings.specular {
            SpecularMethod::ReflectedDistanceField { smoothness, .. } => {
                smoothness.factor_and_constant()
            }
            _ => [0.0; 2],
        };
        Self {
            light_bound: settings.light_bound,
            bias: bias(settings.diffuse),
            first_light: part.polygons.start,
            end_light: part.polygons.end,
            first_punctual: part.punctual.start,
            end_punctual: part.punctual.end,
            adds_emission: adds_emission.into(),
            smoothness_factor,
            smoothness,
            image_taps: settings.image_method.taps(),
            targets: traced.map_or(0, |traced| traced.targets.per_light),
            ray_epsilon: traced.map_or(0.0, |traced| traced.rays.epsilon),
        }
    }
}

/// Bytes from one record to the next: what any device aligns uniforms to.
const RECORD_STRIDE: usize = 256;

/// Most parts that the lights of a set are added in.
pub(super) const MOST_PARTS: usize = 2048;

/// Most sets of lights: the scene's, and virtual ones.
const MOST_SETS: usize = 2;

/// The pipelines of a scene, one for each choice of methods that was asked for.
pub(super) struct Shading {
    plain: Variant,
    /// Where surfaces block light; made when it is first asked for.
    traced: OnceLock<Variant>,
    uniform: wgpu::Buffer,
    lights_layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
    ids_layout: wgpu::BindGroupLayout,
    features: Features,
    pipelines: Mutex<Vec<(Methods, wgpu::ComputePipeline)>>,
}

/// The shader and what it is bound to, with rays to lights or without.
struct Variant {
    shader: Shader,
    layout: wgpu::PipelineLayout,
    sums_layout: wgpu::BindGroupLayout,
}

impl Variant {
    fn new(
        gpu: &Gpu,
        [lights, scene, ids]: [&wgpu::BindGroupLayout; 3],
        traces_lights: bool,
    ) -> Result<Self, GpuError> {
        let device = gpu.device();
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let record = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: wgpu::BufferSize::new(size_of::<ShadingRecord>() as u64),
        };
        let read = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let sum = buffer(wgpu::BufferBindingType::Storage { read_only: false });
        let mut entries = vec![
            entry(0, record),
            entry(1, read),
            entry(2, read),
            entry(3, sum),
            entry(4, sum),
            entry(5, sum),
        ];
        if traces_lights {
            entries.extend([entry(6, read), entry(7, read)]);
        }
        let sums_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("sums"),
            entries: &entries,
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("shading"),
            bind_group_layouts: &[Some(lights), Some(scene), Some(&sums_layout), Some(ids)],
            immediate_size: 0,
        });
        Ok(Self {
            shader: Shader::with(gpu, "shading", SHADE, traces_lights)?,
            layout,
            sums_layout,
        })
    }
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

/// The light of a tile's pixels, in its parts: emitted, diffuse and specular.
pub(super) struct Sums {
    pub(super) parts: [wgpu::Buffer; 3],
}

/// Bytes of one part of a pixel's light.
pub(super) const PIXEL: u64 = 16;

impl Shading {
    pub(super) fn new(
        gpu: &Gpu,
        lights_layout: &wgpu::BindGroupLayout,
        scene_layout: &wgpu::BindGroupLayout,
        features: Features,
    ) -> Result<Self, GpuError> {
        let device = gpu.device();
        let ids = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let ids_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("visible triangles"),
            entries: &[entry(0, ids)],
        });
        Ok(Self {
            plain: Variant::new(gpu, [lights_layout, scene_layout, &ids_layout], false)?,
            traced: OnceLock::new(),
            lights_layout: lights_layout.clone(),
            scene_layout: scene_layout.clone(),
            uniform: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("shading"),
                size: (MOST_SETS * MOST_PARTS * RECORD_STRIDE) as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            ids_layout,
            features,
            pipelines: Mutex::default(),
        })
    }

    /// Pipelines are made for other features from now on.
    pub(super) fn set_features(&mut self, features: Features) {
        self.features = features;
        lock(&self.pipelines).clear();
    }

    fn variant(&self, gpu: &Gpu, traces_lights: bool) -> Result<&Variant, GpuError> {
        if !traces_lights {
            return Ok(&self.plain);
        }
        if let Some(traced) = self.traced.get() {
            return Ok(traced);
        }
        let layouts = [&self.lights_layout, &self.scene_layout, &self.ids_layout];
        let traced = Variant::new(gpu, layouts, true)?;
        Ok(self.traced.get_or_init(|| traced))
    }

    /// The pipeline for these methods, made when they are first asked for.
    pub(super) fn pipeline(
        &self,
        gpu: &Gpu,
        methods: Methods,
    ) -> Result<wgpu::ComputePipeline, GpuError> {
        let mut pipelines = lock(&self.pipelines);
        if let Some((_, pipeline)) = pipelines.iter().find(|(of, _)| *of == methods) {
            return Ok(pipeline.clone());
        }
        let variant = self.variant(gpu, methods.traces_lights())?;
        let mut constants = Vec::from(scene_constants(self.features));
        constants.extend(methods.constants());
        let constants = variant.shader.constants(&constants);
        let pipeline = gpu
            .device()
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("shading"),
                layout: Some(&variant.layout),
                module: &variant.shader.module,
                entry_point: Some("shade"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                cache: None,
            });
        pipelines.push((methods, pipeline.clone()));
        Ok(pipeline)
    }

    /// What the next submissions are lit with: the parts of all sets, one after the other.
    pub(super) fn set(&self, gpu: &Gpu, parts: &[ShadingRecord]) {
        let mut bytes = vec![0; parts.len() * RECORD_STRIDE];
        for (slot, part) in bytes.chunks_mut(RECORD_STRIDE).zip(parts) {
            slot[..size_of_val(part)].copy_from_slice(bytemuck::bytes_of(part));
        }
        gpu.queue().write_buffer(&self.uniform, 0, &bytes);
    }

    /// What a set of lights is added to.
    pub(super) fn bind_group(
        &self,
        gpu: &Gpu,
        set: &LightSet<'_>,
        sums: &Sums,
    ) -> Result<wgpu::BindGroup, GpuError> {
        let variant = self.variant(gpu, set.traced.is_some())?;
        let record = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.uniform,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<ShadingRecord>() as u64),
        });
        let of_rays = set
            .traced
            .iter()
            .flat_map(|traced| [&traced.rays.nodes, &traced.targets.points]);
        let lists = [set.clusters, set.punctual]
            .into_iter()
            .chain(&sums.parts)
            .chain(of_rays);
        let entries: Vec<_> = (0..)
            .zip(
                [record]
                    .into_iter()
                    .chain(lists.map(wgpu::Buffer::as_entire_binding)),
            )
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        Ok(gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sums"),
            layout: &variant.sums_layout,
            entries: &entries,
        }))
    }

    pub(super) fn ids(&self, gpu: &Gpu, ids: &wgpu::TextureView) -> wgpu::BindGroup {
        gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("visible triangles"),
            layout: &self.ids_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(ids),
            }],
        })
    }
}

impl Sums {
    /// For so many pixels.
    pub(super) fn new(gpu: &Gpu, pixels: u64) -> Self {
        let parts = ["emitted", "diffuse", "specular"].map(|label| {
            gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: pixels * PIXEL,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        Self { parts }
    }

    /// Forgets what a tile is about to be added to.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, tile: Tile) {
        for part in &self.parts {
            encoder.clear_buffer(part, 0, Some(tile.pixels() * PIXEL));
        }
    }
}

/// A set of lights, ready to be added.
pub(super) struct Pass {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) lights: wgpu::BindGroup,
    /// As [`Shading::bind_group`] makes it.
    pub(super) sums: wgpu::BindGroup,
    /// Indices of its parts among all that [`Shading::set`] was given.
    pub(super) parts: Range<usize>,
}

/// Adds a sample of a tile of `size` to the sums, by all parts of the lights.
pub(super) fn encode(
    encoder: &mut wgpu::CommandEncoder,
    passes: &[Pass],
    [scene, ids]: [&wgpu::BindGroup; 2],
    frame_offset: u32,
    size: [u32; 2],
    timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some("shading"),
        timestamp_writes: timestamps,
    });
    let [across, down] = size.map(|pixels| pixels.div_ceil(WORKGROUP));
    for set in passes {
        pass.set_pipeline(&set.pipeline);
        pass.set_bind_group(0, &set.lights, &[]);
        pass.set_bind_group(1, scene, &[frame_offset]);
        pass.set_bind_group(3, ids, &[]);
        for part in set.parts.clone() {
            pass.set_bind_group(2, &set.sums, &[(part * RECORD_STRIDE) as u32]);
            pass.dispatch_workgroups(across, down, 1);
        }
    }
}
