//! A lit plain seen from above: what whole frames are measured on.

use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec3, Vec4};
use lumigon_renderer::{Camera, EmissivePolygon, Material, Mesh, Projection, Scene};

/// A plain that reaches so far from the origin, and a camera that looks at the origin from `eye`.
pub(super) fn plain(half: f32, eye: Vec3, polygon_lights: Vec<EmissivePolygon>) -> Scene {
    let material = Material {
        base_color: Vec4::new(0.8, 0.8, 0.8, 1.0),
        metallic: 0.0,
        perceptual_roughness: 0.5,
        ..Material::default()
    };
    let ground = Mesh {
        positions: [(-half, -half), (-half, half), (half, half), (half, -half)]
            .map(|(x, z)| Vec3::new(x, 0.0, z))
            .to_vec(),
        normals: vec![Vec3::Y; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let back = eye.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let axes = Mat3A::from_cols(right.into(), back.cross(right).into(), back.into());
    let camera = Camera {
        name: "above".to_owned(),
        world_from_camera: Affine3A::from_mat3_translation(axes.into(), eye),
        projection: Projection::Perspective {
            yfov: 0.6,
            aspect: None,
        },
    };
    Scene {
        meshes: vec![Arc::new(ground)],
        materials: vec![material],
        cameras: vec![camera],
        polygon_lights,
        ..Scene::default()
    }
}
