//! Renders glTF scenes lit by their emissive polygons.
//!
//! Data flows one way: a glTF file becomes a [`Scene`] of world-space meshes, materials and lights;
//! a backend turns the scene into an image.

mod bounce;
mod cpu;
mod gpu;
mod kept_light;
mod picture;
mod prepared_lights;
mod render;
mod scene;
mod whole_file;

pub use bounce::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, CubeMap, CubeTexel,
    MAXIMUM_BOUNCES, MAXIMUM_FACE_SIZE, MAXIMUM_VIRTUAL_LIGHTS, VirtualLightKind, VirtualLights,
};
pub use cpu::{
    CpuRenderer, CpuTimings, PickedSurface, Probe, ProbedLight, ProbedRadiance, STRONGEST_LIGHTS,
};
pub use gpu::{
    AdapterDescription, AdapterKind, DisplaySettings, Gpu, GpuError, GpuPreference, GpuRenderer,
    GpuTimings,
};
pub use lumigon_wgpu::ImageColors;
pub use picture::{
    PictureError, PictureFormat, ToneMap, check_writable, srgb8, write_exr, write_png,
};
pub use render::{
    MAXIMUM_SIDE, Pixels, ReferenceRendering, ReferenceSettings, RenderError, RenderSettings,
    Rendering, Watch,
};
pub use scene::{
    AlphaMask, AlphaMode, Camera, EmissiveImage, EmissivePolygon, Filter, GltfSource, ImageFile,
    Limits, LoadPhase, LoadWatch, Material, Mesh, MeshSource, PlacedTexture, Projection,
    PunctualKind, PunctualLight, Sampler, SaveError, Scene, SceneError, SurfaceSample, Texture,
    TextureMap, TextureRef, TextureTransform, Wrap, decode_image, read_image,
};
pub use whole_file::write_whole;
