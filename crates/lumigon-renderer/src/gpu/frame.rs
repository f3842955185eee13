//! One sample of one tile, as shaders read it.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3, Vec3};

use super::tile::Tile;
use crate::scene::{Camera, Projection};

/// `Frame` of `frame.wesl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct FrameRecord {
    pub(super) camera_from_world: [[f32; 4]; 3],
    pub(super) world_from_camera: [[f32; 4]; 3],
    pub(super) camera_position: [f32; 3],
    pub(super) scale: f32,
    pub(super) half_size: [f32; 2],
    pub(super) clip_scale: [f32; 2],
    pub(super) clip_shift: [f32; 2],
    pub(super) picture_size: [f32; 2],
    pub(super) sample_offset: [f32; 2],
    pub(super) tile_origin: [u32; 2],
    pub(super) tile_size: [u32; 2],
    pub(super) depth: f32,
    pub(super) is_orthographic: u32,
    pub(super) share: f32,
    pub(super) padding: [u32; 3],
}

/// Nearest distance that a pinhole sees, in distances of the farthest point of the scene.
const NEAREST: f64 = 1e-8;

/// A camera and a picture's size: what the frames of all tiles and samples share.
pub(super) struct View {
    record: FrameRecord,
}

impl View {
    /// `bounds` are those of the scene. `None` where the camera's numbers are no numbers: its rays
    /// meet nothing.
    pub(super) fn new(
        camera: &Camera,
        [width, height]: [u32; 2],
        bounds: Option<(Vec3, Vec3)>,
    ) -> Option<Self> {
        let affine = camera.world_from_camera;
        if !affine.is_finite() {
            return None;
        }
        let position = Vec3::from(affine.translation).as_dvec3();
        let (low, high) = bounds.unwrap_or_default();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let largest = [low, high, position]
            .map(|p| p.abs().max_element())
            .into_iter()
            .fold(0.0, f64::max);
        // Powers of two lose nothing; beyond these the smallest numbers of single precision would.
        let exponent = if largest > 0.0 {
            (-largest.log2().ceil()).clamp(-126.0, 126.0)
        } else {
            0.0
        };
        let scale = exponent.exp2();
        let world_from_camera = affine.matrix3.as_dmat3();
        let determinant = world_from_camera.determinant();
        let camera_from_world = if determinant != 0.0 {
            world_from_camera.inverse()
        } else {
            world_from_camera.transpose()
        };
        let corners = (0..8).map(|i| {
            DVec3::from_array(std::array::from_fn(|axis| [low, high][i >> axis & 1][axis]))
        });
        let seen: Vec<DVec3> = corners
            .map(|corner| camera_from_world * ((corner - position) * scale))
            .collect();
        let aspect = width as f32 / height as f32;
        let (half_size, depth, is_orthographic) = match camera.projection {
            Projection::Perspective {
                yfov,
                aspect: authored,
            } => {
                let half = (yfov * 0.5).tan() * authored.map_or(1.0, |a| (a / aspect).max(1.0));
                let farthest = seen.iter().map(|p| p.length()).fold(0.0, f64::max);
                ([half * aspect, half], farthest * NEAREST, 0)
            }
            Projection::Orthographic { xmag, ymag } => {
                let ymag = f64::from(ymag.max(xmag / aspect)) * scale;
                let farthest = seen.iter().map(|p| -p.z).fold(0.0, f64::max);
                let half_size = [(ymag * f64::from(aspect)) as f32, ymag as f32];
                (half_size, farthest * 1.001, 1)
            }
        };
        let columns = |m: DMat3| {
            m.to_cols_array_2d()
                .map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, 0.0])
        };
        Some(Self {
            record: FrameRecord {
                camera_from_world: columns(camera_from_world),
                world_from_camera: columns(world_from_camera),
                camera_position: (position * scale).as_vec3().into(),
                scale: scale as f32,
                half_size,
                picture_size: [width as f32, height as f32],
                depth: if depth > 0.0 { depth as f32 } else { 1.0 },
                is_orthographic,
                ..FrameRecord::zeroed()
            },
        })
    }

    /// The frame of one sample at `offset` in its pixels, which weighs `share`.
    pub(super) fn frame(&self, tile: Tile, offset: [f64; 2], share: f32) -> FrameRecord {
        // The tile's pixels have their centres where the picture's have the sample.
        let axis = |i: usize| {
            let picture = f64::from(self.record.picture_size[i]);
            let size = f64::from(tile.size[i]);
            let start = f64::from(tile.origin[i]) + offset[i] - 0.5;
            (picture / size, (picture - 2.0 * start) / size - 1.0)
        };
        let ((scale_x, shift_x), (scale_y, shift_y)) = (axis(0), axis(1));
        FrameRecord {
            clip_scale: [scale_x as f32, scale_y as f32],
            // Rows run down, clip space runs up.
            clip_shift: [shift_x as f32, -shift_y as f32],
            sample_offset: offset.map(|x| x as f32),
            tile_origin: tile.origin,
            tile_size: tile.size,
            share,
            ..self.record
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_of_no_numbers_sees_nothing() {
        let mut camera = Camera::framing(&crate::scene::Scene::default());
        assert!(View::new(&camera, [1, 1], None).is_some());
        camera.world_from_camera.translation.x = f32::NAN;
        assert!(View::new(&camera, [1, 1], None).is_none());
    }
}
