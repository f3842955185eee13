//! How long passes take, by the device's own clock.

use super::GpuTimings;
use super::device::Gpu;
use super::scene_buffers::FRAMES;

/// Begin and end of two passes a frame.
const STAMPS: u32 = 4;

/// Timestamps of one submission's frames.
pub(super) struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
    /// Milliseconds a tick.
    tick: f64,
}

impl Clock {
    /// `None` where the device has no clock.
    pub(super) fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.adapter().has_timestamps {
            return None;
        }
        let count = STAMPS * FRAMES as u32;
        let buffer = |label, usage| {
            gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(count) * 8,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer(
                "timestamps",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            read: buffer(
                "read timestamps",
                wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            ),
            tick: f64::from(gpu.queue().get_timestamp_period()) * 1e-6,
        })
    }

    pub(super) fn visibility(&self, frame: usize) -> wgpu::RenderPassTimestampWrites<'_> {
        let first = STAMPS * frame as u32;
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    pub(super) fn shading(&self, frame: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = STAMPS * frame as u32 + 2;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// Ends a submission of `frames`; what to read once it is done.
    pub(super) fn finish(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frames: usize,
    ) -> wgpu::BufferSlice<'_> {
        let count = STAMPS * frames as u32;
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        let bytes = u64::from(count) * 8;
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, bytes);
        self.read.slice(..bytes)
    }

    /// The time of all frames whose stamps were read.
    pub(super) fn timings(&self, bytes: &[u8]) -> GpuTimings {
        let mut timings = GpuTimings::default();
        for frame in bytes
            .as_chunks::<{ size_of::<[u64; STAMPS as usize]>() }>()
            .0
        {
            let stamps: [u64; STAMPS as usize] = bytemuck::pod_read_unaligned(frame);
            // Clocks of some drivers run backwards.
            timings.visibility += stamps[1].saturating_sub(stamps[0]) as f64 * self.tick;
            timings.shading += stamps[3].saturating_sub(stamps[2]) as f64 * self.tick;
        }
        timings
    }
}
