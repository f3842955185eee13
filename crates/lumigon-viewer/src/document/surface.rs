//! What a light keeps of its faces when its outline changes.

use std::sync::Arc;

use glam::{DAffine2, DVec2, DVec3, Vec2, Vec3, Vec4};
use lumigon_renderer::Material;

/// The material of a light but for what [`super::Light`] says, and where its textures lie.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    /// Emission and sidedness are the light's.
    pub(super) material: Arc<Material>,
    /// Texture coordinates that textures beside the emissive one are read with.
    pub(super) texcoords_from_plane: [Option<DAffine2>; 2],
    /// The colour of all vertices.
    pub(super) color: Option<Vec4>,
    /// Faces that cannot be made anew from an outline.
    pub(super) fixed: Option<Fixed>,
}

/// Faces that move with their light and are never cut anew.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fixed {
    /// A clause.
    pub(super) reason: &'static str,
    pub(super) faces: Arc<Faces>,
    pub(super) plane_from_faces: DAffine2,
}

/// Triangles in the frame of a light as it was read, x and y in the plane.
#[derive(Debug, PartialEq)]
pub(super) struct Faces {
    pub(super) loops: Vec<Vec<DVec2>>,
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) tangents: Vec<Vec4>,
    pub(super) texcoords: [Vec<Vec2>; 2],
    pub(super) colors: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Black, as those of `EXT_lights_area`.
    pub(super) fn black(name: &str) -> Self {
        let material = Material {
            name: name.to_owned(),
            base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
            metallic: 0.0,
            ..Material::default()
        };
        Self {
            material: Arc::new(material),
            texcoords_from_plane: [None; 2],
            color: None,
            fixed: None,
        }
    }

    /// Changes the plane under it.
    pub(super) fn change(&mut self, new_from_old: DAffine2) {
        let old_from_new = new_from_old.inverse();
        for map in self.texcoords_from_plane.iter_mut().flatten() {
            *map *= old_from_new;
        }
        if let Some(fixed) = &mut self.fixed {
            fixed.plane_from_faces = new_from_old * fixed.plane_from_faces;
        }
    }
}

impl Fixed {
    /// Whether loops are those of the faces, moved and scaled as they are.
    pub(super) fn fits(&self, loops: &[Vec<DVec2>]) -> bool {
        let own = self
            .faces
            .loops
            .iter()
            .flatten()
            .map(|&p| self.plane_from_faces.transform_point2(p));
        let own: Vec<DVec2> = own.collect();
        let size = own
            .iter()
            .map(|p| p.abs().max_element())
            .fold(0.0, f64::max);
        loops.len() == self.faces.loops.len()
            && loops
                .iter()
                .zip(&self.faces.loops)
                .all(|(a, b)| a.len() == b.len())
            && own
                .iter()
                .zip(loops.iter().flatten())
                .all(|(a, &b)| a.distance(b) <= 1e-9 * size)
    }
}
