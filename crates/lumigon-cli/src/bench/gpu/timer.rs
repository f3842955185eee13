//! What takes how long on a GPU.

use std::time::{Duration, Instant};

use crate::Failure;
use crate::bench::median;

/// No submission of the benchmark is meant to take a second.
const PATIENCE: Duration = Duration::from_secs(60);

/// Submits work and tells how long it took.
pub(super) struct Timer<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) queue: &'a wgpu::Queue,
    queries: Option<Queries>,
    /// Wall seconds of a submission that does nothing.
    empty_seconds: f64,
}

/// Timestamps before and after a pass.
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    /// Seconds a tick.
    period: f64,
}

const QUERY_BYTES: u64 = 16;

impl<'a> Timer<'a> {
    /// A timer by the wall clock.
    pub(super) fn new(device: &'a wgpu::Device, queue: &'a wgpu::Queue) -> Result<Self, Failure> {
        let mut timer = Self {
            device,
            queue,
            queries: None,
            empty_seconds: 0.0,
        };
        let mut samples = (0..21)
            .map(|_| timer.wall_seconds(&mut |_| {}))
            .collect::<Result<Vec<_>, _>>()?;
        timer.empty_seconds = median(&mut samples);
        Ok(timer)
    }

    /// Takes timestamps from now on, if the device has them and they agree with the wall clock about
    /// `work`, which should take some milliseconds. Some software drivers have them wrong.
    pub(super) fn try_timestamps(
        &mut self,
        work: &mut dyn FnMut(&mut wgpu::ComputePass<'_>),
    ) -> Result<(), Failure> {
        if !self
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
        {
            return Ok(());
        }
        let queries = Queries::new(self.device, self.queue);
        for _ in 0..5 {
            let start = Instant::now();
            let told = self.stamped_seconds(&queries, work)?;
            let wall = start.elapsed().as_secs_f64();
            let most = wall;
            let least = 0.5 * (wall - 4.0 * self.empty_seconds);
            if !(least..=most).contains(&told) {
                return Ok(());
            }
        }
        self.queries = Some(queries);
        Ok(())
    }

    /// How time is taken, in words.
    pub(super) fn clock(&self) -> &'static str {
        match self.queries {
            Some(_) => "timestamp queries",
            None => "wall clock, less an empty submission",
        }
    }

    /// Wall seconds of a submission that does nothing.
    pub(super) fn empty_seconds(&self) -> f64 {
        self.empty_seconds
    }

    /// Seconds that one pass of `work` takes.
    pub(super) fn seconds(
        &self,
        work: &mut dyn FnMut(&mut wgpu::ComputePass<'_>),
    ) -> Result<f64, Failure> {
        match &self.queries {
            Some(queries) => self.stamped_seconds(queries, work),
            None => Ok((self.wall_seconds(work)? - self.empty_seconds).max(1e-9)),
        }
    }

    fn wall_seconds(
        &self,
        work: &mut dyn FnMut(&mut wgpu::ComputePass<'_>),
    ) -> Result<f64, Failure> {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        work(&mut encoder.begin_compute_pass(&Default::default()));
        let commands = encoder.finish();
        let start = Instant::now();
        self.queue.submit([commands]);
        self.wait()?;
        Ok(start.elapsed().as_secs_f64())
    }

    fn stamped_seconds(
        &self,
        queries: &Queries,
        work: &mut dyn FnMut(&mut wgpu::ComputePass<'_>),
    ) -> Result<f64, Failure> {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        work(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: None,
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: &queries.set,
                    beginning_of_pass_write_index: Some(0),
                    end_of_pass_write_index: Some(1),
                }),
            }),
        );
        encoder.resolve_query_set(&queries.set, 0..2, &queries.resolved, 0);
        encoder.copy_buffer_to_buffer(&queries.resolved, 0, &queries.readable, 0, QUERY_BYTES);
        self.queue.submit([encoder.finish()]);
        let bytes = self.mapped(&queries.readable)?;
        let ticks: &[u64] = bytemuck::cast_slice(&bytes);
        Ok(ticks[1].saturating_sub(ticks[0]) as f64 * queries.period)
    }

    /// The bytes of a buffer that can be copied from.
    pub(super) fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, Failure> {
        let readable = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &readable, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        self.mapped(&readable)
    }

    /// The bytes of a buffer that can be mapped, once all submitted work is done.
    fn mapped(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, Failure> {
        let (told, answer) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more only where waiting has failed.
            let _ = told.send(result);
        });
        self.wait()?;
        answer.recv()??;
        let bytes = buffer.get_mapped_range(..)?.to_vec();
        buffer.unmap();
        Ok(bytes)
    }

    fn wait(&self) -> Result<(), Failure> {
        self.device
            .poll(wgpu::PollType::Wait {
                submission_index: None,
                timeout: Some(PATIENCE),
            })
            .map_err(|error| {
                format!(
                    "the GPU did not finish within {} s: {error}",
                    PATIENCE.as_secs()
                )
            })?;
        Ok(())
    }
}

impl Queries {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: QUERY_BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("start and end"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(
                "timestamps",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            readable: buffer(
                "timestamps to read",
                wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            ),
            period: f64::from(queue.get_timestamp_period()) * 1e-9,
        }
    }
}
