//! What a picture's tiles are rendered with.

use super::device::Gpu;
use super::shading::{PIXEL, Shading, Sums};
use super::tile::Tile;
use super::visibility::Canvas;

/// Memory for the tiles of a picture.
pub(super) struct Equipment {
    pub(super) tile: [u32; 2],
    pub(super) canvas: Canvas,
    pub(super) ids: wgpu::BindGroup,
    pub(super) sums: Sums,
    pub(super) read: wgpu::Buffer,
}

impl Equipment {
    /// For tiles of at most so many pixels across and down.
    pub(super) fn new(gpu: &Gpu, shading: &Shading, tile: [u32; 2]) -> Self {
        let pixels = u64::from(tile[0]) * u64::from(tile[1]);
        let canvas = Canvas::new(gpu, tile);
        Equipment {
            tile,
            ids: shading.ids(gpu, &canvas.ids),
            canvas,
            sums: Sums::new(gpu, pixels),
            read: gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("read pixels"),
                size: 3 * pixels * PIXEL,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    /// Copies a finished tile to where it can be read: its three parts, one after the other.
    pub(super) fn copy_out(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        tile: Tile,
    ) -> wgpu::BufferSlice<'_> {
        let bytes = u64::from(tile.size[0]) * u64::from(tile.size[1]) * PIXEL;
        for (i, part) in (0..).zip(&self.sums.parts) {
            encoder.copy_buffer_to_buffer(part, 0, &self.read, i * bytes, bytes);
        }
        self.read.slice(..3 * bytes)
    }
}
