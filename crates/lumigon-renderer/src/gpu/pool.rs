//! Lists one after the other in a buffer on the device, with room for more.

use std::marker::PhantomData;
use std::ops::Range;

use bytemuck::Pod;
use range_alloc::RangeAllocator;

use super::device::Gpu;
use super::error::GpuError;
use super::storage::check;

/// Bytes that a buffer has to spare when it is made.
const SPARE: u64 = 1 << 20;

/// Lists of one kind of items.
pub(super) struct Pool<T> {
    what: &'static str,
    buffer: wgpu::Buffer,
    /// May go beyond the buffer, until [`Pool::grown`] is asked for.
    places: RangeAllocator<u32>,
    /// Items that a buffer may have.
    most: u32,
    items: PhantomData<T>,
}

impl<T: Pod> Pool<T> {
    /// For so many items and some more; `limit` is in bytes, and items are counted in 32 bits.
    pub(super) fn new(
        gpu: &Gpu,
        what: &'static str,
        count: u64,
        limit: u64,
    ) -> Result<Self, GpuError> {
        let size = size_of::<T>() as u64;
        let limit = limit.min(u64::from(u32::MAX) * size);
        check(what, count, size_of::<T>(), limit)?;
        let most = (limit / size) as u32;
        let capacity = (count + SPARE / size).min(most.into()).max(1) as u32;
        Ok(Self {
            what,
            buffer: Self::sized(gpu, what, capacity),
            places: RangeAllocator::new(0..capacity),
            most,
            items: PhantomData,
        })
    }

    fn sized(gpu: &Gpu, what: &'static str, capacity: u32) -> wgpu::Buffer {
        gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: u64::from(capacity) * size_of::<T>() as u64,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        })
    }

    /// A place for so many items; the first ones follow each other from 0. `None` where there is no room
    /// left in any buffer.
    pub(super) fn place(&mut self, count: usize) -> Option<Range<u32>> {
        if count == 0 {
            return Some(0..0);
        }
        let count = u32::try_from(count).ok()?;
        if let Ok(range) = self.places.allocate_range(count) {
            return Some(range);
        }
        let end = self.places.initial_range().end;
        let spare = (SPARE / size_of::<T>() as u64).max(u64::from(end) / 4);
        let grown = (u64::from(end) + u64::from(count) + spare).min(self.most.into());
        if grown > u64::from(end) {
            self.places.grow_to(grown as u32);
        }
        self.places.allocate_range(count).ok()
    }

    /// Gives a place back.
    pub(super) fn free(&mut self, place: Range<u32>) {
        if !place.is_empty() {
            self.places.free_range(place);
        }
    }

    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// A larger buffer with the same items, where places go beyond this one.
    pub(super) fn grown(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Option<wgpu::Buffer> {
        let capacity = self.places.initial_range().end;
        let needed = u64::from(capacity) * size_of::<T>() as u64;
        (needed > self.buffer.size()).then(|| {
            let grown = Self::sized(gpu, self.what, capacity);
            encoder.copy_buffer_to_buffer(&self.buffer, 0, &grown, 0, self.buffer.size());
            grown
        })
    }

    /// Takes a buffer that it grew to.
    pub(super) fn take(&mut self, grown: Option<wgpu::Buffer>) {
        if let Some(buffer) = grown {
            self.buffer = buffer;
        }
    }

    /// Writes a list to its place in this buffer or the one that it grows to.
    pub(super) fn write(gpu: &Gpu, buffer: &wgpu::Buffer, place: &Range<u32>, list: &[T]) {
        if !list.is_empty() {
            let at = u64::from(place.start) * size_of::<T>() as u64;
            gpu.queue()
                .write_buffer(buffer, at, bytemuck::cast_slice(list));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::GpuPreference;

    #[test]
    fn places_are_given_back_and_buffers_grow() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let fault = Pool::<u32>::new(&gpu, "numbers", 4, 15).err().unwrap();
        let is_told = matches!(fault, GpuError::TooMuch { count: 4, .. });
        assert!(is_told, "{fault}");

        let mut pool = Pool::<u32>::new(&gpu, "numbers", 10, 8 << 20).unwrap();
        assert_eq!(pool.place(0), Some(0..0));
        let (a, b) = (pool.place(7).unwrap(), pool.place(3).unwrap());
        assert_eq!((a.clone(), b), (0..7, 7..10));
        pool.free(a);
        assert_eq!(pool.place(6), Some(0..6));
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        assert!(pool.grown(&gpu, &mut encoder).is_none());
        assert_eq!(pool.place(1 << 20).map(|place| place.len()), Some(1 << 20));
        let grown = pool.grown(&gpu, &mut encoder);
        assert!(grown.as_ref().unwrap().size() > 4 << 20);
        pool.take(grown);
        assert!(pool.grown(&gpu, &mut encoder).is_none());
        assert_eq!(pool.place(1 << 20), None, "8 MB are all there may be");
        assert!(pool.place(1000).is_some());
    }
}
