//! Distance fields of lights in storage buffers.

use bytemuck::{Pod, Zeroable};
use lumigon::{DistanceFieldSettings, DistanceFields, FieldPlacement, PolygonLight};
use lumigon_shaders::LinkError;

use crate::bindings::MODULES;
use crate::light_buffers::LightBuffers;

/// The shaders' struct `LightField`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightFieldRecord {
    /// As [`FieldPlacement::light_to_field`].
    pub light_to_field: [f32; 4],
    /// Index of the field's first texel.
    pub first_texel: u32,
    /// Texels along a side of its finest level; 0 for no field.
    pub resolution: u32,
    /// As [`DistanceFieldSettings::phi`].
    pub phi: f32,
    /// What a struct of 16-byte alignment is padded with.
    pub padding: u32,
}

/// Fields that do not fit the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{fields} distance fields of {resolution} x {resolution} texels need a buffer of {needed} bytes, \
     but the device's hold {limit}: give a lower resolution, or use fewer shapes of lights"
)]
pub struct TooManyFields {
    /// How many fields.
    pub fields: usize,
    /// Texels along a side.
    pub resolution: u32,
    /// Bytes of the greater buffer.
    pub needed: u64,
    /// Bytes that a storage buffer binding may have on this device.
    pub limit: u64,
}

/// The distance fields of lights on a device.
#[derive(Debug)]
pub struct DistanceFieldBuffers {
    texels: wgpu::Buffer,
    records: wgpu::Buffer,
}

impl DistanceFieldBuffers {
    /// Of lights without fields: what reads them finds no reflection.
    #[must_use]
    pub fn none(device: &wgpu::Device) -> Self {
        // wgpu's buffers start as zeros: the one record has no texels.
        Self {
            texels: storage_buffer(device, "distance fields", size_of::<f32>()),
            records: storage_buffer(device, "light fields", size_of::<LightFieldRecord>()),
        }
    }

    /// Fields that the CPU has baked.
    ///
    /// # Errors
    /// Where the device's storage buffers are too small.
    pub fn upload(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        fields: &DistanceFields<f32>,
    ) -> Result<Self, TooManyFields> {
        let Some(first) = fields.fields().first() else {
            return Ok(Self::none(device));
        };
        let settings = first.settings();
        let count = fields.fields().len();
        let buffers = Self::sized(device, queue, count, fields.placements(), settings)?;
        for (i, field) in fields.fields().iter().enumerate() {
            let texels = bytemuck::cast_slice(field.texels());
            queue.write_buffer(&buffers.texels, (i * texels.len()) as u64, texels);
        }
        Ok(buffers)
    }

    /// Room for `count` fields, and the records of all lights.
    fn sized(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        count: usize,
        placements: &[FieldPlacement<f32>],
        settings: DistanceFieldSettings,
    ) -> Result<Self, TooManyFields> {
        let texels = count as u64 * (settings.texel_count() * size_of::<f32>()) as u64;
        let needed = texels.max((size_of::<LightFieldRecord>() * placements.len()) as u64);
        let limits = device.limits();
        let limit = limits
            .max_buffer_size
            .min(limits.max_storage_buffer_binding_size);
        if needed > limit {
            return Err(TooManyFields {
                fields: count,
                resolution: settings.resolution(),
                needed,
                limit,
            });
        }
        let record = |placement: &FieldPlacement<f32>| LightFieldRecord {
            light_to_field: placement.light_to_field,
            first_texel: (placement.field * settings.texel_count()) as u32,
            resolution: settings.resolution(),
            phi: settings.phi(),
            padding: 0,
        };
        let records: Vec<_> = placements.iter().map(record).collect();
        let bytes = bytemuck::cast_slice(&records);
        let buffers = Self {
            texels: storage_buffer(device, "distance fields", texels as usize),
            records: storage_buffer(device, "light fields", bytes.len()),
        };
        queue.write_buffer(&buffers.records, 0, bytes);
        Ok(buffers)
    }

    /// The buffer of the shaders' `distance_fields`.
    #[must_use]
    pub fn texels(&self) -> &wgpu::Buffer {
        &self.texels
    }

    /// The buffer of the shaders' `light_fields`.
    #[must_use]
    pub fn records(&self) -> &wgpu::Buffer {
        &self.records
    }
}

fn storage_buffer(device: &wgpu::Device, label: &str, size: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size as u64,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// Edges times texels of one submission: some tenths of a second on a slow GPU.
const MOST_WORK: u64 = 1 << 31;

/// Most workgroups along an axis of a dispatch, on any device.
const MOST_WORKGROUPS: usize = 65_535;

/// Threads along a side of a workgroup.
const WORKGROUP: u32 = 8;

/// The shaders' struct `Bake`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct BakeRecord {
    phi: f32,
    resolution: u32,
    is_signed: u32,
    first_field: u32,
    first_row: u32,
    level: u32,
}

/// Bakes distance fields on a device.
#[derive(Debug)]
pub struct DistanceFieldBaker {
    lights_layout: wgpu::BindGroupLayout,
    fields_layout: wgpu::BindGroupLayout,
    measure: wgpu::ComputePipeline,
    average: wgpu::ComputePipeline,
}

/// The module of the kernels, in WESL.
const BAKE: &str = include_str!("../shaders/bake_distance_fields.wesl");

impl DistanceFieldBaker {
    /// Makes the pipelines.
    ///
    /// # Errors
    /// Where the library is broken.
    pub fn new(device: &wgpu::Device) -> Result<Self, LinkError> {
        let text = lumigon_shaders::link(BAKE, MODULES)?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("distance field baking"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = |label, types: &[wgpu::BufferBindingType]| {
            let entries: Vec<_> = (0..)
                .zip(types)
                .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
                    binding,
                    visibility: wgpu::ShaderStages::COMPUTE,
                    ty: wgpu::BindingType::Buffer {
                        ty,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                })
                .collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        };
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let write = wgpu::BufferBindingType::Storage { read_only: false };
        let lights_layout = layout("lights to bake", &[read, read]);
        let uniform = wgpu::BufferBindingType::Uniform;
        let fields_layout = layout("fields to bake", &[uniform, read, write]);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("distance field baking"),
            bind_group_layouts: &[Some(&lights_layout), Some(&fields_layout)],
            immediate_size: 0,
        });
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        Ok(Self {
            measure: pipeline("measure"),
            average: pipeline("average"),
            lights_layout,
            fields_layout,
        })
    }

    /// Bakes the fields of `lights`, whose polygons are `polygons`; `shapes` and `placements` are theirs,
    /// by [`lumigon::field_shapes`].
    ///
    /// Every texel goes through all edges; long outlines are baked in several submissions. Mesa's llvmpipe ends loops after 65,535 rounds: there, outlines as long as that are to be baked
    /// by the CPU ([`DistanceFieldBuffers::upload`]).
    ///
    /// # Errors
    /// Where the device's storage buffers are too small.
    pub fn bake(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lights: &LightBuffers,
        polygons: &[&PolygonLight<f32>],
        (shapes, placements): (&[usize], &[FieldPlacement<f32>]),
        settings: DistanceFieldSettings,
    ) -> Result<DistanceFieldBuffers, TooManyFields> {
        if shapes.is_empty() {
            return Ok(DistanceFieldBuffers::none(device));
        }
        let count = shapes.len();
        let buffers = DistanceFieldBuffers::sized(device, queue, count, placements, settings)?;
        let indices: Vec<u32> = shapes.iter().map(|&shape| shape as u32).collect();
        let bytes = bytemuck::cast_slice(&indices);
        let shape_list = storage_buffer(device, "shapes", bytes.len());
        queue.write_buffer(&shape_list, 0, bytes);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("distance field baking"),
            size: size_of::<BakeRecord>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = |layout, buffers: &[&wgpu::Buffer]| {
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("distance field baking"),
                layout,
                entries: &entries,
            })
        };
        let groups = [
            group(&self.lights_layout, &[lights.lights(), lights.vertices()]),
            group(
                &self.fields_layout,
                &[&uniform, &shape_list, &buffers.texels],
            ),
        ];
        let dispatch = |pipeline, record: BakeRecord, [across, down]: [u32; 2], fields: usize| {
            queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&record));
            let mut encoder = device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &groups[0], &[]);
            pass.set_bind_group(1, &groups[1], &[]);
            let [across, down] = [across, down].map(|texels| texels.div_ceil(WORKGROUP));
            pass.dispatch_workgroups(across, down, fields as u32);
            drop(pass);
            queue.submit([encoder.finish()]);
        };
        let resolution = settings.resolution();
        let record = |first_field: usize, first_row, level| BakeRecord {
            phi: settings.phi(),
            resolution,
            is_signed: settings.is_signed().into(),
            first_field: first_field as u32,
            first_row,
            level,
        };
        let row_work =
            |field: usize| polygons[shapes[field]].vertex_count() as u64 * u64::from(resolution);
        let work = |field: usize| row_work(field) * u64::from(resolution);
        let mut first = 0;
        while first < count {
            let (mut end, mut sum) = (first + 1, work(first));
            while end < count && end - first < MOST_WORKGROUPS && sum + work(end) <= MOST_WORK {
                sum += work(end);
                end += 1;
            }
            let rows = match sum <= MOST_WORK {
                true => resolution,
                false => ((MOST_WORK / row_work(first)) as u32 / WORKGROUP * WORKGROUP)
                    .clamp(WORKGROUP, resolution),
            };
            for row in (0..resolution).step_by(rows as usize) {
                let record = record(first, row, 0);
                dispatch(&self.measure, record, [resolution, rows], end - first);
            }
            first = end;
        }
        for level in 1..settings.levels() {
            for first in (0..count).step_by(MOST_WORKGROUPS) {
                let fields = (count - first).min(MOST_WORKGROUPS);
                let side = resolution >> level;
                dispatch(&self.average, record(first, 0, level), [side; 2], fields);
            }
        }
        Ok(buffers)
    }
}
