//! How much memory a scene may ask for.

/// How much a scene may ask for before it is refused: a small file can name huge images and
/// instances, so each is checked before it is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The most bytes of the scene's file, and again of all buffers and encoded images beside it.
    pub file_bytes: u64,
    /// The most objects in the JSON.
    pub json_objects: usize,
    /// The most texels along one side of an image.
    pub image_side: u32,
    /// The most bytes of all images together, decoded.
    pub image_bytes: u64,
    /// The most bytes of all world-space meshes together, every instance counted.
    pub mesh_bytes: u64,
    /// The deepest nesting of nodes.
    pub node_depth: usize,
    /// The most bytes of the prefiltered pictures of all lights together, of 64/3 bytes a texel.
    pub light_image_bytes: u64,
    /// The most texels along one side of a light's picture; larger ones are shown smaller.
    pub light_image_side: u32,
}

impl Default for Limits {
    /// 4 GiB a file, 4 million JSON objects, 16384 texels a side, 2 GiB of images, 8 GiB of meshes, 1024 nested nodes,
    /// 1 GiB of lights' pictures, 4096 texels a side.
    fn default() -> Self {
        Self {
            file_bytes: 4 << 30,
            json_objects: 1 << 22,
            image_side: 16384,
            image_bytes: 2 << 30,
            mesh_bytes: 8 << 30,
            node_depth: 1024,
            light_image_bytes: 1 << 30,
            light_image_side: 4096,
        }
    }
}
