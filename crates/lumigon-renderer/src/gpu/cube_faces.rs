//! What a cube map sees, rastered: one pass a face to several targets.

use glam::{Vec2, Vec3};
use half::f16;

use super::device::Gpu;
use super::frame::View;
use super::mesh_store::TriangleOrder;
use super::scene_buffers::{FRAME_STRIDE, SceneBuffers};
use super::tile::Tile;
use super::visibility::{DEPTH_FORMAT, Onto, Pipelines, Raster, target};
use crate::bounce::{CubeMap, CubeTexel};

/// Faces of a cube.
pub(super) const FACES: usize = 6;

/// Triangle and normal, position, and albedo: 32 bytes a texel, which every device can raster at once.
const FORMATS: [wgpu::TextureFormat; 3] = [
    wgpu::TextureFormat::Rg32Uint,
    wgpu::TextureFormat::Rgba32Float,
    wgpu::TextureFormat::Rgba16Float,
];

/// Bytes of a texel of each.
const BYTES: [usize; 3] = [8, 16, 8];

/// The pipelines of a scene.
pub(super) struct FaceRaster {
    pipelines: Pipelines,
}

/// What faces of one size are rastered to, and read from.
pub(super) struct FaceCanvas {
    pub(super) face_size: u32,
    textures: [wgpu::Texture; 3],
    views: [wgpu::TextureView; 3],
    depth: wgpu::TextureView,
    /// Face after face, target after target, row after row.
    read: wgpu::Buffer,
}

impl FaceRaster {
    pub(super) fn new(gpu: &Gpu, raster: &Raster) -> Self {
        let entry_points = ["surface_here", "surface_where_opaque"];
        Self {
            pipelines: raster.pipelines(gpu, entry_points, &FORMATS),
        }
    }

    /// Rasters a face whose frame starts at `frame_offset`, and copies it to where it is read.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        canvas: &FaceCanvas,
        face: usize,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let size = canvas.face_size;
        let colors = canvas.views.each_ref();
        let onto = Onto {
            colors: &colors,
            depth: &canvas.depth,
            size: [size; 2],
        };
        let frame_offset = (face * FRAME_STRIDE) as u32;
        self.pipelines
            .encode(encoder, scene, onto, frame_offset, timestamps);
        for (i, texture) in canvas.textures.iter().enumerate() {
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &canvas.read,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: canvas.start(face, i) as u64,
                        bytes_per_row: Some(canvas.row(i) as u32),
                        rows_per_image: None,
                    },
                },
                texture.size(),
            );
        }
    }
}

impl FaceCanvas {
    pub(super) fn new(gpu: &Gpu, face_size: u32) -> Self {
        let labels = ["seen triangles", "seen positions", "seen albedos"];
        let targets = [0, 1, 2].map(|i| {
            let usage = wgpu::TextureUsages::COPY_SRC;
            target(gpu, labels[i], [face_size; 2], FORMATS[i], usage)
        });
        let none = wgpu::TextureUsages::empty();
        let depth = target(gpu, "depth", [face_size; 2], DEPTH_FORMAT, none).1;
        let per_face = BYTES.map(|bytes| padded_row(face_size, bytes) * face_size as usize);
        Self {
            face_size,
            textures: targets.each_ref().map(|(texture, _)| texture.clone()),
            views: targets.map(|(_, view)| view),
            depth,
            read: gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("read cube map"),
                size: (FACES * per_face.iter().sum::<usize>()) as u64,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    pub(super) fn all(&self) -> wgpu::BufferSlice<'_> {
        self.read.slice(..)
    }

    /// Bytes of a row of a target.
    fn row(&self, target: usize) -> usize {
        padded_row(self.face_size, BYTES[target])
    }

    /// Where a face's target starts.
    fn start(&self, face: usize, target: usize) -> usize {
        let rows = |targets: std::ops::Range<usize>| targets.map(|i| self.row(i)).sum::<usize>();
        self.face_size as usize * (face * rows(0..FORMATS.len()) + rows(0..target))
    }

    /// The texels that were read; `order` is that of the scene's triangles.
    pub(super) fn texels(&self, bytes: &[u8], order: &TriangleOrder) -> Vec<Option<CubeTexel>> {
        let size = self.face_size as usize;
        let mut texels = Vec::with_capacity(FACES * size * size);
        for face in 0..FACES {
            for row in 0..size {
                for column in 0..size {
                    let [seen, position, albedo] = [0, 1, 2].map(|i| {
                        let at = self.start(face, i) + row * self.row(i) + column * BYTES[i];
                        &bytes[at..at + BYTES[i]]
                    });
                    let [count, normal]: [u32; 2] = bytemuck::pod_read_unaligned(seen);
                    let [x, y, z, _]: [f32; 4] = bytemuck::pod_read_unaligned(position);
                    let albedo: [u16; 4] = bytemuck::pod_read_unaligned(albedo);
                    let [r, g, b, _] = albedo.map(|bits| f16::from_bits(bits).to_f32());
                    texels.push(count.checked_sub(1).map(|triangle| CubeTexel {
                        position: [x, y, z],
                        normal: from_octahedral(normal).to_array(),
                        albedo: [r, g, b],
                        radiance: [0.0; 3],
                        triangle: order.of_scene(triangle),
                    }));
                }
            }
        }
        texels
    }
}

/// The frames of a cube map's faces, one after the other; `None` where its centre is no place.
pub(super) fn frames(center: Vec3, face_size: u32, scene: &SceneBuffers) -> Option<Vec<u8>> {
    let mut bytes = vec![0; FACES * FRAME_STRIDE];
    for (face, slot) in bytes.chunks_mut(FRAME_STRIDE).enumerate() {
        let camera = CubeMap::camera(center.to_array(), face);
        let tile = Tile {
            origin: [0; 2],
            size: [face_size; 2],
        };
        let view = View::new(&camera, tile.size, scene.bounds)?;
        let frame = view.frame(tile, [0.5; 2], 1.0);
        slot[..size_of_val(&frame)].copy_from_slice(bytemuck::bytes_of(&frame));
    }
    Some(bytes)
}

/// Bytes from one row to the next, as copies of textures want them.
fn padded_row(texels: u32, bytes: usize) -> usize {
    (texels as usize * bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize)
}

/// The unit vector that `octahedral` of the shaders makes this of, in 16 bits each.
fn from_octahedral(packed: u32) -> Vec3 {
    let part = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let flat = Vec2::new(part(packed), part(packed >> 16));
    let z = 1.0 - flat.x.abs() - flat.y.abs();
    // What was folded out, below the middle.
    let folded = Vec2::splat((-z).max(0.0));
    let sides = Vec2::new(1.0_f32.copysign(flat.x), 1.0_f32.copysign(flat.y));
    (flat - folded * sides).extend(z).normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octahedral_normals_come_back() {
        // As the shader packs them.
        let pack = |n: Vec3| {
            let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
            let side = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
            let (x, y) = if n.z >= 0.0 {
                (n.x, n.y)
            } else {
                ((1.0 - n.y.abs()) * side(n.x), (1.0 - n.x.abs()) * side(n.y))
            };
            let bits = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
            bits(x) | bits(y) << 16
        };
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter();
        let slanted = (0..500).map(|i| {
            let (a, b) = (i as f32 * 0.61, i as f32 * 0.377);
            Vec3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos())
        });
        for n in axes.chain(slanted).flat_map(|n| [n, -n]) {
            let back = from_octahedral(pack(n));
            assert!(back.distance(n) < 1e-4, "{n} {back}");
        }
    }
}
