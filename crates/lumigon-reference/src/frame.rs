//! Shading frames, each with the view in it.

use glam::DVec3;

/// Cosine given to views at or below the shading horizon, which interpolated normals and normal maps produce.
const LOWEST_VIEW: f64 = 1e-4;

/// A shading frame with the view in it.
pub(crate) struct Frame {
    /// Rows of the rotation into the frame; the last is the normal.
    world_to_shading: [DVec3; 3],
    /// Unit, raised to [`LOWEST_VIEW`] where it was lower.
    pub(crate) view: DVec3,
}

impl Frame {
    pub(crate) fn new(normal: DVec3, tangent: DVec3, view: DVec3) -> Self {
        let (x, y) = match (tangent - normal * normal.dot(tangent)).try_normalize() {
            Some(x) => (x, normal.cross(x)),
            None => normal.any_orthonormal_pair(),
        };
        let world_to_shading = [x, y, normal];
        let view = DVec3::from(world_to_shading.map(|row| row.dot(view)));
        Self {
            world_to_shading,
            view: view.with_z(view.z.max(LOWEST_VIEW)).normalize(),
        }
    }

    pub(crate) fn normal(&self) -> DVec3 {
        self.world_to_shading[2]
    }

    pub(crate) fn to_shading(&self, direction: DVec3) -> DVec3 {
        DVec3::from(self.world_to_shading.map(|row| row.dot(direction)))
    }

    pub(crate) fn to_world(&self, direction: DVec3) -> DVec3 {
        let [x, y, z] = self.world_to_shading;
        x * direction.x + y * direction.y + z * direction.z
    }
}
