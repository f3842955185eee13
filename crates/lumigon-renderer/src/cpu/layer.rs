//! Some meshes' triangles in one hierarchy.

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::triangle::Triangle;

use crate::scene::{AlphaMode, Mesh, Scene};

/// Triangles of some meshes, and a hierarchy of them.
pub(super) struct Layer {
    /// None where there are no triangles.
    pub(super) hierarchy: Option<CwBvh>,
    pub(super) triangles: Vec<TracedTriangle>,
    /// Keeping them, their places in memory stay theirs.
    pub(super) meshes: Vec<LayerMesh>,
}

/// A mesh as it was when its layer was built.
pub(super) struct LayerMesh {
    pub(super) mesh: Arc<Mesh>,
    pub(super) there: There,
    /// None without triangles.
    pub(super) bounds: Option<(Vec3, Vec3)>,
}

/// A triangle with where it comes from.
pub(super) struct TracedTriangle {
    pub(super) corners: Triangle,
    /// Index into the layer's meshes.
    pub(super) mesh: u32,
    pub(super) index: u32,
    pub(super) there: There,
}

/// From where a triangle can be met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum There {
    Always,
    /// Seen from where it runs counter-clockwise.
    FromItsFront,
    /// Where the alpha mask leaves it, and from its front where it is single-sided.
    WhereOpaque,
}

impl There {
    /// What holds for a mesh of the scene.
    pub(super) fn of(scene: &Scene, mesh: usize) -> Self {
        let material = &scene.materials[scene.meshes[mesh].material];
        match material.alpha_mode {
            AlphaMode::Mask { .. } => Self::WhereOpaque,
            _ if material.double_sided => Self::Always,
            _ => Self::FromItsFront,
        }
    }
}

impl Layer {
    /// `meshes` are indices into the scene's.
    pub(super) fn new(scene: &Scene, meshes: &[usize]) -> Self {
        let mut triangles = Vec::new();
        for (mesh_index, &index) in (0..).zip(meshes) {
            let mesh = &scene.meshes[index];
            let there = There::of(scene, index);
            for index in 0..mesh.triangles.len() {
                let [v0, v1, v2] = mesh.corners(index).map(Into::into);
                triangles.push(TracedTriangle {
                    corners: Triangle { v0, v1, v2 },
                    mesh: mesh_index,
                    index: index as u32,
                    there,
                });
            }
        }
        let hierarchy = (!triangles.is_empty()).then(|| {
            let corners: Vec<Triangle> = triangles.iter().map(|t| t.corners).collect();
            build_cwbvh_from_tris(
                &corners,
                BvhBuildParams::medium_build(),
                &mut Duration::default(),
            )
        });
        let meshes = meshes.iter().map(|&index| LayerMesh {
            mesh: Arc::clone(&scene.meshes[index]),
            there: There::of(scene, index),
            bounds: scene.meshes[index].bounds(),
        });
        Self {
            meshes: meshes.collect(),
            hierarchy,
            triangles,
        }
    }

    #[inline(always)]
    pub(super) fn triangle(&self, hierarchy: &CwBvh, slot: usize) -> &TracedTriangle {
        &self.triangles[hierarchy.primitive_indices[slot] as usize]
    }
}
