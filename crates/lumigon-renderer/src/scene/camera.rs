//! Where the picture is taken from.

use glam::{Affine3A, Mat3, Vec2, Vec3};

use super::Scene;

/// How a camera maps directions to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical field of view in radians, in (0, π).
        yfov: f32,
        /// Width over height the camera was authored for. A narrower picture opens the vertical
        /// field so that nothing of the authored view is lost; a wider one shows more at its sides.
        aspect: Option<f32>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width in metres.
        xmag: f32,
        /// Half the height in metres.
        ymag: f32,
    },
}

/// A camera: looks along its -Z, Y up, X to the right.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The camera's name, or its node's.
    pub name: String,
    /// A rotation and a translation; the node's scale is left out, as glTF asks.
    pub world_from_camera: Affine3A,
    /// How it projects.
    pub projection: Projection,
}

impl Camera {
    /// A camera for a scene without one: it sees all of the scene's bounding sphere from a raised
    /// three-quarter view, in pictures of any aspect.
    #[must_use]
    pub fn framing(scene: &Scene) -> Self {
        let (low, high) = scene.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
        let center = low * 0.5 + high * 0.5;
        // Halved before subtracting: the corners of a huge scene are finite, their distance may not be.
        let half = high * 0.5 - low * 0.5;
        // The farthest vertex, not the box's corner: a sphere's box has corners 1.7 radii away.
        let radius = scene
            .meshes
            .iter()
            .flat_map(|mesh| {
                mesh.triangles
                    .iter()
                    .flatten()
                    .map(|&i| mesh.positions[i as usize])
            })
            .map(|p| p.distance_squared(center))
            .fold(0.0, f32::max)
            .sqrt();
        let radius = if radius.is_finite() {
            radius
        } else {
            half.max_element() * 1.8
        };
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let yfov = 40.0_f32.to_radians();
        let backward = Vec3::new(0.55, 0.42, 1.0).normalize();
        let position = center + backward * (radius / (yfov * 0.5).sin());
        Self {
            name: "framing".to_owned(),
            world_from_camera: looking(position, backward),
            // Aspect 1: a portrait picture widens the field until the sphere fits sideways too.
            projection: Projection::Perspective {
                yfov,
                aspect: Some(1.0),
            },
        }
    }

    /// The world-space origin and unit direction of the ray through (`x`, `y`), each 0 to 1 across
    /// the picture from its upper left corner, y down. `aspect` is the picture's width over height.
    #[must_use]
    pub fn ray(&self, x: f32, y: f32, aspect: f32) -> (Vec3, Vec3) {
        let ndc = Vec2::new(2.0 * x - 1.0, 1.0 - 2.0 * y);
        let (origin, direction) = match self.projection {
            Projection::Perspective {
                yfov,
                aspect: authored,
            } => {
                let half = (yfov * 0.5).tan() * authored.map_or(1.0, |a| (a / aspect).max(1.0));
                let direction = Vec3::new(ndc.x * half * aspect, ndc.y * half, -1.0);
                (Vec3::ZERO, direction.normalize())
            }
            Projection::Orthographic { xmag, ymag } => {
                let ymag = ymag.max(xmag / aspect);
                let origin = Vec3::new(ndc.x * ymag * aspect, ndc.y * ymag, 0.0);
                (origin, Vec3::NEG_Z)
            }
        };
        (
            self.world_from_camera.transform_point3(origin),
            self.world_from_camera
                .transform_vector3(direction)
                .normalize(),
        )
    }
}

/// At `position`, with +Z along the unit vector `backward` and Y as far up as it can be.
fn looking(position: Vec3, backward: Vec3) -> Affine3A {
    let right = Vec3::Y.cross(backward).normalize_or(Vec3::X);
    let up = backward.cross(right);
    Affine3A::from_mat3_translation(Mat3::from_cols(right, up, backward), position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Mesh;
    use std::sync::Arc;

    fn pinhole(yfov: f32, aspect: Option<f32>) -> Camera {
        Camera {
            name: String::new(),
            world_from_camera: Affine3A::IDENTITY,
            projection: Projection::Perspective { yfov, aspect },
        }
    }

    #[test]
    fn rays_span_the_field_of_view() {
        let camera = pinhole(1.0, None);
        let (origin, center) = camera.ray(0.5, 0.5, 2.0);
        assert_eq!((origin, center), (Vec3::ZERO, Vec3::NEG_Z));
        let (_, top) = camera.ray(0.5, 0.0, 2.0);
        assert!((top.angle_between(Vec3::NEG_Z) - 0.5).abs() < 1e-6 && top.y > 0.0);
        let (_, right) = camera.ray(1.0, 0.5, 2.0);
        assert!((right.x / -right.z - 2.0 * 0.5_f32.tan()).abs() < 1e-6);
    }

    #[test]
    fn narrow_picture_keeps_the_authored_width() {
        let camera = pinhole(1.0, Some(2.0));
        for aspect in [0.5, 1.0, 2.0] {
            let (_, right) = camera.ray(1.0, 0.5, aspect);
            assert!((right.x / -right.z - 2.0 * 0.5_f32.tan()).abs() < 1e-5);
        }
    }

    #[test]
    fn framing_holds_every_vertex_in_any_aspect() {
        let corners = [
            [-3.0, 0.0, 1.0],
            [5.0, 0.5, 2.0],
            [0.0, 4.0, -7.0],
            [1.0, 1.0, 9.0],
        ];
        let scene = Scene {
            meshes: vec![Arc::new(Mesh {
                positions: corners.map(Vec3::from).to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            })],
            ..Scene::default()
        };
        let camera = Camera::framing(&scene);
        let camera_from_world = camera.world_from_camera.inverse();
        for aspect in [0.4, 1.0, 2.5] {
            let (_, corner) = camera.ray(1.0, 0.0, aspect);
            let corner = camera_from_world.transform_vector3(corner);
            let limit = Vec2::new(corner.x / -corner.z, corner.y / -corner.z);
            for p in corners {
                let q = camera_from_world.transform_point3(Vec3::from(p));
                assert!(q.z < 0.0 && q.x.abs() <= limit.x * -q.z && q.y.abs() <= limit.y * -q.z);
            }
        }
    }
}
