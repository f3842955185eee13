//! How long passes take, by the device's own clock.

use super::device::Gpu;
use super::scene_buffers::FRAMES;
use super::stopwatch::Reading;

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

    /// The `pass`th render pass of a submission.
    fn raster(&self, pass: usize) -> wgpu::RenderPassTimestampWrites<'_> {
        let first = 2 * pass as u32;
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// A cube map's face, of a submission of nothing else.
    pub(super) fn face(&self, face: usize) -> wgpu::RenderPassTimestampWrites<'_> {
        self.raster(face)
    }

    pub(super) fn visibility(&self, frame: usize) -> wgpu::RenderPassTimestampWrites<'_> {
        self.raster(2 * frame)
    }

    pub(super) fn shading(&self, frame: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = STAMPS * frame as u32 + 2;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// Bytes of the stamps of so many frames.
    pub(super) fn bytes(frames: usize) -> u64 {
        u64::from(STAMPS) * frames as u64 * 8
    }

    /// Ends a submission of `frames`, whose times are read later, after those that are there.
    pub(super) fn append(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frames: usize,
        to: &mut Reading,
    ) {
        let count = STAMPS * frames as u32;
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        let bytes = Self::bytes(frames);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &to.buffer, to.bytes, bytes);
        to.bytes += bytes;
    }

    /// Ends a submission of `frames`; what to read once it is done.
    pub(super) fn finish(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frames: usize,
    ) -> wgpu::BufferSlice<'_> {
        self.resolve(encoder, STAMPS * frames as u32)
    }

    /// The same of a cube map's faces.
    pub(super) fn finish_faces(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        faces: usize,
    ) -> wgpu::BufferSlice<'_> {
        self.resolve(encoder, 2 * faces as u32)
    }

    fn resolve(&self, encoder: &mut wgpu::CommandEncoder, count: u32) -> wgpu::BufferSlice<'_> {
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        let bytes = u64::from(count) * 8;
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, bytes);
        self.read.slice(..bytes)
    }

    /// Milliseconds of visibility and of shading of all frames whose stamps were read.
    pub(super) fn frames(&self, bytes: &[u8]) -> [f64; 2] {
        let passes = self.passes(bytes);
        let every_other = |first| passes.iter().skip(first).step_by(2).sum();
        [every_other(0), every_other(1)]
    }

    /// Milliseconds of all faces whose stamps were read.
    pub(super) fn faces(&self, bytes: &[u8]) -> f64 {
        self.passes(bytes).iter().sum()
    }

    /// Milliseconds of each pass.
    fn passes(&self, bytes: &[u8]) -> Vec<f64> {
        let (passes, _) = bytes.as_chunks::<{ size_of::<[u64; 2]>() }>();
        let passes = passes.iter().map(|pass| {
            let [begin, end]: [u64; 2] = bytemuck::pod_read_unaligned(pass);
            // Clocks of some drivers run backwards.
            end.saturating_sub(begin) as f64 * self.tick
        });
        passes.collect()
    }
}
