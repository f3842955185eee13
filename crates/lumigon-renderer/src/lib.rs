//! Renders glTF scenes lit by their emissive polygons.
//!
//! Data flows one way: a glTF file becomes a [`Scene`] of world-space meshes, materials and lights;
//! a backend turns the scene into an image.

mod scene;

pub use scene::{
    AlphaMode, Camera, EmissivePolygon, Filter, Limits, Material, Mesh, Projection, PunctualKind,
    PunctualLight, Sampler, Scene, SceneError, SurfaceSample, Texture, TextureRef,
    TextureTransform, Wrap,
};
