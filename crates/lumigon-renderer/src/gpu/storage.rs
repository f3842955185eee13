//! Lists on the device.

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
        // A buffer of no bytes cannot be bound.
        let least = [T::zeroed()];
        let list = if list.is_empty() { &least } else { list };
        let buffer = self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: size_of_val(list) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue()
            .write_buffer(&buffer, 0, bytemuck::cast_slice(list));
        Ok(buffer)
    }
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
