//! Filters images of lights on the device.

use bytemuck::{Pod, Zeroable};

use crate::image_colors::{DECODED, ImageColors};

/// The shaders' struct `FilterJob`, field by field: one level to write.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct FilterJob {
    /// The level's size; that of the level before, where there is one.
    pub(crate) size: [u32; 2],
    /// Index of its first texel.
    pub(crate) first_texel: u32,
    /// Of the level before.
    pub(crate) first_larger: u32,
    /// Index of the image's first source.
    pub(crate) first_source: u32,
    pub(crate) is_srgb: u32,
}

impl FilterJob {
    /// Instead of a first source: the outline covers the whole image.
    pub(crate) const EVERY_TEXEL_ITS_OWN: u32 = u32::MAX;
}

/// Bytes from one job to the next: what any device aligns uniforms to.
const JOB_STRIDE: usize = 256;

/// As many as the largest image has.
const MOST_JOBS: usize = 16;

/// Pixels along a side of the square that a workgroup writes.
const WORKGROUP: u32 = 8;

const SHADER: &str = include_str!("../shaders/filter_image.wesl");

/// Pipelines, and colours on their way.
#[derive(Debug)]
pub(crate) struct ImageFilter {
    layout: wgpu::BindGroupLayout,
    weigh: wgpu::ComputePipeline,
    halve: wgpu::ComputePipeline,
    jobs: wgpu::Buffer,
    decoded: wgpu::Buffer,
    colors: wgpu::Buffer,
}

impl ImageFilter {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let entry = |binding, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset,
                min_binding_size: None,
            },
            count: None,
        };
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("image filter"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform, true),
                entry(
                    1,
                    wgpu::BufferBindingType::Storage { read_only: false },
                    false,
                ),
                entry(2, read, false),
                entry(3, read, false),
                entry(4, read, false),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("image filter"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let text = lumigon_shaders::link(SHADER, &[]);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("image filter"),
            // The text is this crate's own, and a test links it; what is empty is refused.
            source: wgpu::ShaderSource::Wgsl(text.unwrap_or_default().into()),
        });
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("image filter"),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let decoded = buffer(device, "decoded sRGB", size_of_val(&*DECODED) as u64);
        queue.write_buffer(&decoded, 0, bytemuck::cast_slice(&*DECODED));
        Self {
            weigh: pipeline("weigh"),
            halve: pipeline("halve"),
            layout,
            jobs: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("image filter"),
                size: (MOST_JOBS * JOB_STRIDE) as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            decoded,
            colors: buffer(device, "colours", 4),
        }
    }

    /// Writes all levels of the image that `first`, the job of the largest one, tells.
    pub(crate) fn run(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        [texels, sources]: [&wgpu::Buffer; 2],
        first: FilterJob,
        colors: ImageColors<'_>,
    ) {
        let bytes = colors.bytes();
        if self.colors.size() < bytes.len() as u64 {
            self.colors = buffer(device, "colours", bytes.len() as u64);
        }
        queue.write_buffer(&self.colors, 0, bytes);
        let jobs = jobs(first);
        let mut slots = vec![0; jobs.len() * JOB_STRIDE];
        for (slot, job) in slots.chunks_mut(JOB_STRIDE).zip(&jobs) {
            slot[..size_of_val(job)].copy_from_slice(bytemuck::bytes_of(job));
        }
        queue.write_buffer(&self.jobs, 0, &slots);
        let job = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.jobs,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<FilterJob>() as u64),
        });
        let lists = [texels, sources, &self.colors, &self.decoded];
        let resources = [job]
            .into_iter()
            .chain(lists.map(wgpu::Buffer::as_entire_binding));
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("image filter"),
            layout: &self.layout,
            entries: &entries,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (i, job) in jobs.iter().enumerate() {
            let (pipeline, size) = if i == 0 {
                (&self.weigh, job.size)
            } else {
                (&self.halve, halved(job.size))
            };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[(i * JOB_STRIDE) as u32]);
            let [across, down] = size.map(|side| side.div_ceil(WORKGROUP));
            pass.dispatch_workgroups(across, down, 1);
        }
        drop(pass);
        queue.submit([encoder.finish()]);
    }
}

/// The jobs of all levels, the largest first.
fn jobs(first: FilterJob) -> Vec<FilterJob> {
    let mut jobs = vec![first];
    let mut larger = first.size;
    let mut first_larger = first.first_texel;
    while larger != [1, 1] {
        let first_texel = first_larger + larger[0] * larger[1];
        jobs.push(FilterJob {
            size: larger,
            first_texel,
            first_larger,
            ..first
        });
        larger = halved(larger);
        first_larger = first_texel;
    }
    jobs
}

fn halved(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| (side / 2).max(1))
}

fn buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    #[test]
    fn jobs_are_laid_out_as_the_shader_has_them() {
        let text = lumigon_shaders::link(SHADER, &[]).unwrap();
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(&text)));
        let members = module.types.iter().find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, .. } if ty.name.as_deref() == Some("FilterJob") => {
                let offsets = members.iter().map(|m| m.offset as usize);
                Some(offsets.collect::<Vec<_>>())
            }
            _ => None,
        });
        let expected = [
            offset_of!(FilterJob, size),
            offset_of!(FilterJob, first_texel),
            offset_of!(FilterJob, first_larger),
            offset_of!(FilterJob, first_source),
            offset_of!(FilterJob, is_srgb),
        ];
        assert_eq!(members.unwrap(), expected);
    }

    #[test]
    fn the_largest_image_has_a_job_for_every_level() {
        for size in [[1 << 14, 1], [1 << 14, 1 << 14], [1, 1], [4, 32]] {
            let jobs = jobs(FilterJob {
                size,
                first_texel: 3,
                first_larger: 0,
                first_source: FilterJob::EVERY_TEXEL_ITS_OWN,
                is_srgb: 0,
            });
            assert_eq!(jobs.len() as u32, size[0].max(size[1]).ilog2() + 1);
            assert!(jobs.len() <= MOST_JOBS);
            let last = u64::from(jobs[jobs.len() - 1].first_texel) - 3;
            assert_eq!((last + 1) * 16, lumigon::ImagePyramid::bytes(size));
        }
    }
}
