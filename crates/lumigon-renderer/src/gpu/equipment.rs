//! What a picture's tiles are rendered with.

use std::sync::OnceLock;

use super::device::Gpu;
use super::shading::{PIXEL, Shading, Sums};
use super::tile::Tile;
use super::visibility::Canvas;

/// Memory for the tiles of a picture.
pub(super) struct Equipment {
    tile: [u32; 2],
    pub(super) canvas: Canvas,
    pub(super) ids: wgpu::BindGroup,
    pub(super) sums: Sums,
    /// Made when a picture is first read.
    read: OnceLock<wgpu::Buffer>,
}

impl Equipment {
    /// For tiles of at most so many pixels across and down: what is kept, if it is large enough.
    pub(super) fn at_least<'a>(
        kept: &'a mut Option<Self>,
        gpu: &Gpu,
        shading: &Shading,
        tile: [u32; 2],
    ) -> &'a mut Self {
        let holds = |kept: &Self| kept.tile[0] >= tile[0] && kept.tile[1] >= tile[1];
        if !kept.as_ref().is_some_and(holds) {
            // Not both at once in memory.
            *kept = None;
        }
        kept.get_or_insert_with(|| Self::new(gpu, shading, tile))
    }

    fn new(gpu: &Gpu, shading: &Shading, tile: [u32; 2]) -> Self {
        let pixels = u64::from(tile[0]) * u64::from(tile[1]);
        let canvas = Canvas::new(gpu, tile);
        Equipment {
            tile,
            ids: shading.ids(gpu, &canvas.ids),
            canvas,
            sums: Sums::new(gpu, pixels),
            read: OnceLock::new(),
        }
    }

    /// Copies a finished tile to where it can be read: its three parts, one after the other.
    pub(super) fn copy_out(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        tile: Tile,
    ) -> wgpu::BufferSlice<'_> {
        let read = self.read.get_or_init(|| {
            let pixels = u64::from(self.tile[0]) * u64::from(self.tile[1]);
            gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("read pixels"),
                size: 3 * pixels * PIXEL,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        let bytes = tile.pixels() * PIXEL;
        for (i, part) in (0..).zip(&self.sums.parts) {
            encoder.copy_buffer_to_buffer(part, 0, read, i * bytes, bytes);
        }
        read.slice(..3 * bytes)
    }
}
