//! Triangles in world space.

use glam::{Vec2, Vec3, Vec4};

/// One primitive of one node, in world space.
///
/// Attributes are one for each vertex or empty where the file has none; only positions and normals
/// are always there. Mirrored nodes have their winding restored: a triangle runs counter-clockwise
/// seen from its front. Triangles without area are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The names of the node and its mesh, where the file has them, and the primitive's index.
    pub name: String,
    /// Index into [`super::Scene::materials`].
    pub material: usize,
    /// World-space positions, finite.
    pub positions: Vec<Vec3>,
    /// World-space unit normals. Flat ones where the file has none, as glTF asks.
    pub normals: Vec<Vec3>,
    /// World-space unit tangents, with the bitangent's sign in w: bitangent = w (normal × tangent).
    pub tangents: Vec<Vec4>,
    /// The two sets of texture coordinates; (0, 0) is the image's upper left corner.
    pub texcoords: [Vec<Vec2>; 2],
    /// Linear RGBA that multiplies the base colour.
    pub colors: Vec<Vec4>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Where in a glTF file it was found.
    pub source: Option<MeshSource>,
}

/// Where in a glTF file a mesh was found; all indices are the file's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshSource {
    /// `meshes[mesh].primitives[primitive]`, placed by `nodes[node]`.
    Primitive {
        /// The node.
        node: usize,
        /// The node's mesh.
        mesh: usize,
        /// The mesh's primitive.
        primitive: usize,
        /// The node mirrors it: the second and third corners of every triangle were exchanged.
        mirrored: bool,
        /// The file has no normals: triangle `t` of the file got the vertices `3 t` to `3 t + 2` for
        /// its own. Otherwise vertices have the file's indices.
        unshared: bool,
    },
    /// The area light (`EXT_lights_area`) of `nodes[node]`.
    AreaLight {
        /// The node.
        node: usize,
    },
}

impl Mesh {
    /// The smallest and largest coordinates of the triangles' corners, or `None` without triangles.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.triangles
            .iter()
            .flatten()
            .map(|&i| self.positions[i as usize])
            .map(|p| (p, p))
            .reduce(|(low, high), (p, _)| (low.min(p), high.max(p)))
    }

    /// The corners of one triangle.
    ///
    /// # Panics
    /// Where `triangle` is not one of this mesh's.
    #[must_use]
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }
}
