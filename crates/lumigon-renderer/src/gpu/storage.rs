//! Lists on the device.

use std::ops::Range;

use bytemuck::Pod;

use super::device::Gpu;
use super::error::GpuError;

impl Gpu {
    /// A storage buffer of a list; `what` it is of.
    pub(super) fn storage<T: Pod>(
        &self,
        what: &'static str,
        list: &[T],
    ) -> Result<wgpu::Buffer, GpuError> {
        let limit = self.adapter().largest_storage();
        check(what, list.len() as u64, size_of::<T>(), limit)?;
        Ok(self.storage_for(what, list, list.len()))
    }

    /// The same, for so many; it must be known that they fit.
    fn storage_for<T: Pod>(&self, what: &'static str, list: &[T], capacity: usize) -> wgpu::Buffer {
        let buffer = self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            // A buffer of no bytes cannot be bound.
            size: (capacity.max(list.len()).max(1) * size_of::<T>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if !list.is_empty() {
            self.queue()
                .write_buffer(&buffer, 0, bytemuck::cast_slice(list));
        }
        buffer
    }
}

/// A list on the device that is short enough to be kept here too: where it is replaced, what differs is
/// written.
pub(super) struct Records<T> {
    what: &'static str,
    buffer: wgpu::Buffer,
    list: Vec<T>,
}

/// A list that is to replace another one.
pub(super) struct StagedRecords<T> {
    list: Vec<T>,
    /// Has the list, where the old buffer is too small.
    grown: Option<wgpu::Buffer>,
}

impl<T: Pod> Records<T> {
    pub(super) fn new(gpu: &Gpu, what: &'static str, list: Vec<T>) -> Result<Self, GpuError> {
        Ok(Self {
            what,
            buffer: gpu.storage(what, &list)?,
            list,
        })
    }

    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Changes one record, if there is such a one.
    pub(super) fn change(&mut self, gpu: &Gpu, index: usize, change: impl FnOnce(&mut T)) {
        if let Some(record) = self.list.get_mut(index) {
            change(record);
            let at = (index * size_of::<T>()) as u64;
            let bytes = bytemuck::bytes_of(record);
            gpu.queue().write_buffer(&self.buffer, at, bytes);
        }
    }

    /// Makes room for another list.
    pub(super) fn stage(&self, gpu: &Gpu, list: Vec<T>) -> Result<StagedRecords<T>, GpuError> {
        let limit = gpu.adapter().largest_storage();
        check(self.what, list.len() as u64, size_of::<T>(), limit)?;
        let grows = size_of_val(&*list) as u64 > self.buffer.size();
        let most = (limit / size_of::<T>() as u64) as usize;
        let capacity = (list.len() + list.len() / 2 + 8).min(most);
        let grown = grows.then(|| gpu.storage_for(self.what, &list, capacity));
        Ok(StagedRecords { list, grown })
    }

    /// Takes the other list.
    pub(super) fn commit(&mut self, gpu: &Gpu, staged: StagedRecords<T>) {
        let StagedRecords { list, grown } = staged;
        if let Some(buffer) = grown {
            self.buffer = buffer;
        } else {
            for run in differing(&self.list, &list) {
                let at = (run.start * size_of::<T>()) as u64;
                let bytes = bytemuck::cast_slice(&list[run]);
                gpu.queue().write_buffer(&self.buffer, at, bytes);
            }
        }
        self.list = list;
    }
}

/// Where a list has other items than an old one, bit by bit.
fn differing<T: Pod>(old: &[T], new: &[T]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (i, item) in new.iter().enumerate() {
        let bytes = bytemuck::bytes_of(item);
        if old
            .get(i)
            .is_some_and(|old| bytemuck::bytes_of(old) == bytes)
        {
            continue;
        }
        match runs.last_mut() {
            Some(run) if run.end == i => run.end += 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}

/// Whether a list of `count` fits a buffer of `limit` bytes.
pub(super) fn check(
    what: &'static str,
    count: u64,
    size: usize,
    limit: u64,
) -> Result<(), GpuError> {
    let needed = count.saturating_mul(size as u64);
    if needed > limit {
        return Err(GpuError::TooMuch {
            what,
            count,
            needed,
            limit,
        });
    }
    Ok(())
}

#[cfg(test)]
#[expect(
    clippy::single_range_in_vec_init,
    reason = "lists of ranges, some of one"
)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_written() {
        assert_eq!(differing(&[1, 2, 3, 4], &[1, 5, 6, 4]), [1..3]);
        assert_eq!(differing(&[1, 2], &[0, 2, 3, 4]), [0..1, 2..4]);
        assert!(differing(&[1, 2, 3], &[1, 2]).is_empty());
        // Also where numbers are none.
        assert!(differing(&[f32::NAN], &[f32::NAN]).is_empty());
        assert_eq!(differing(&[0.0_f32], &[-0.0]), [0..1]);
    }
}
