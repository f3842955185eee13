//! What lies under a point of the picture.

use glam::Vec3;

use super::CpuRenderer;
use super::geometry::TriangleHit;
use crate::scene::{Camera, SurfaceSample};

/// A surface that a camera sees at one place of its picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PickedSurface {
    /// Index into [`Scene::meshes`](crate::Scene::meshes).
    pub mesh: usize,
    /// Index into [`Mesh::triangles`](crate::Mesh::triangles).
    pub triangle: u32,
    /// World space.
    pub position: Vec3,
    /// Unit normal of the triangle's plane, towards the camera.
    pub geometric_normal: Vec3,
    /// Unit normal to shade with: interpolated and normal-mapped, not facing away from the camera.
    pub shading_normal: Vec3,
    /// From where the camera's ray starts, in scene units.
    pub distance: f32,
    /// The name of the mesh's material; empty where the file has none.
    pub material: String,
}

impl CpuRenderer<'_> {
    /// The surface at (`x`, `y`) of the picture, each 0 to 1 from its upper left corner, y down; `aspect`
    /// is the picture's width over its height. Lights are surfaces too.
    ///
    /// None where the camera sees nothing there, and where a number makes no sense.
    #[must_use]
    pub fn pick(&self, camera: &Camera, x: f32, y: f32, aspect: f32) -> Option<PickedSurface> {
        let (_, surface) = self.seen(camera, [x, y], aspect)?;
        Some(surface)
    }

    /// The same, with what a shading point needs: the surface's own numbers and the view.
    pub(super) fn seen(
        &self,
        camera: &Camera,
        [x, y]: [f32; 2],
        aspect: f32,
    ) -> Option<((SurfaceSample, Vec3), PickedSurface)> {
        if !(aspect.is_finite() && aspect > 0.0) {
            return None;
        }
        let (origin, direction) = camera.ray(x, y, aspect);
        let hit = self.geometry.hit(&self.scene, origin, direction, 0.0)?;
        let sample = hit.surface(&self.scene);
        let TriangleHit {
            mesh,
            triangle,
            distance,
            ..
        } = hit;
        let material = &self.scene.materials[self.scene.meshes[mesh].material];
        let picked = PickedSurface {
            mesh,
            triangle: triangle as u32,
            position: sample.position,
            geometric_normal: sample.geometric_normal,
            shading_normal: sample.shading_normal,
            distance,
            material: material.name.clone(),
        };
        Some(((sample, -direction), picked))
    }
}
