//! Emissive faces to polygon lights.

use glam::{DVec3, Vec3};

use super::{Material, Mesh, Texture};

/// A flat light: the outline of connected coplanar emissive triangles, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct EmissivePolygon {
    /// The name of the mesh.
    pub name: String,
    /// The outer loop, counter-clockwise seen from the emitting side, then the holes, clockwise.
    /// All vertices lie in one plane.
    pub loops: Vec<Vec<[f64; 3]>>,
    /// Linear RGB radiance; with an emissive texture, its mean over the polygon's area.
    pub radiance: Vec3,
    /// It emits from its back too.
    pub two_sided: bool,
    /// Index into [`super::Scene::meshes`] of the faces themselves.
    pub mesh: usize,
    /// Indices into [`Mesh::triangles`] of the faces themselves.
    pub triangles: Vec<u32>,
}

/// One polygon a triangle, until they are joined.
pub(super) fn polygons(
    mesh: &Mesh,
    index: usize,
    positions: &[DVec3],
    material: &Material,
    _textures: &[Texture],
) -> Vec<EmissivePolygon> {
    (0..mesh.triangles.len())
        .map(|t| EmissivePolygon {
            name: mesh.name.clone(),
            loops: vec![
                mesh.triangles[t]
                    .map(|i| positions[i as usize].to_array())
                    .to_vec(),
            ],
            radiance: material.emissive,
            two_sided: material.double_sided,
            mesh: index,
            triangles: vec![t as u32],
        })
        .collect()
}
