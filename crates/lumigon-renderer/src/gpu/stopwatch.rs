//! How long pictures took that nobody waits for.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use super::clock::Clock;
use super::device::Gpu;

/// Pictures whose times are on their way. Others are not timed.
const MOST_UNDER_WAY: usize = 4;

const WAITING: u8 = 0;
const READABLE: u8 = 1;
const FAILED: u8 = 2;

/// Reads the clock back one or more pictures later.
#[derive(Default)]
pub(super) struct Stopwatch {
    under_way: Vec<Reading>,
    unused: Vec<wgpu::Buffer>,
}

/// The times of one picture: of all its submissions, one after the other.
pub(super) struct Reading {
    pub(super) buffer: wgpu::Buffer,
    pub(super) bytes: u64,
    state: Arc<AtomicU8>,
}

impl Stopwatch {
    /// Begins to time a picture, if there is room; its submissions write at most so many bytes.
    pub(super) fn start(&mut self, gpu: &Gpu, bytes: u64) -> Option<Reading> {
        if self.under_way.len() >= MOST_UNDER_WAY {
            return None;
        }
        let kept = self.unused.pop().filter(|buffer| buffer.size() >= bytes);
        let buffer = kept.unwrap_or_else(|| {
            gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("read times"),
                size: bytes.next_power_of_two(),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        Some(Reading {
            buffer,
            bytes: 0,
            state: Arc::new(AtomicU8::new(WAITING)),
        })
    }

    /// Lets the times come, once all that writes them is submitted.
    pub(super) fn finish(&mut self, reading: Reading) {
        if reading.bytes == 0 {
            self.unused.push(reading.buffer);
            return;
        }
        let state = Arc::clone(&reading.state);
        let tell = move |mapped: Result<(), _>| {
            let told = if mapped.is_ok() { READABLE } else { FAILED };
            state.store(told, Ordering::Release);
        };
        let slice = reading.buffer.slice(..reading.bytes);
        slice.map_async(wgpu::MapMode::Read, tell);
        self.under_way.push(reading);
    }

    /// Milliseconds of visibility and of shading of the newest picture whose times have come since they
    /// were last asked for. Never waits.
    pub(super) fn newest(&mut self, gpu: &Gpu, clock: &Clock) -> Option<[f64; 2]> {
        if self.under_way.is_empty() {
            return None;
        }
        // Calls what is mapped by now; what it returns is about waiting.
        _ = gpu.device().poll(wgpu::PollType::Poll);
        let mut newest = None;
        let mut waiting = Vec::new();
        for reading in self.under_way.drain(..) {
            match reading.state.load(Ordering::Acquire) {
                WAITING => waiting.push(reading),
                READABLE => {
                    let slice = reading.buffer.slice(..reading.bytes);
                    if let Ok(view) = slice.get_mapped_range() {
                        newest = Some(clock.frames(&view));
                    }
                    reading.buffer.unmap();
                    self.unused.push(reading.buffer);
                }
                // Gone with the device.
                _ => {}
            }
        }
        self.under_way = waiting;
        newest
    }
}
