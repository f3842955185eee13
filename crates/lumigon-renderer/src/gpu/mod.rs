//! The GPU backend: triangles rastered to ids, surfaces and lights in compute.

mod adapter;
mod bounce;
mod clock;
mod cube_faces;
mod device;
mod display;
mod distance_fields;
mod draw;
mod equipment;
mod error;
mod frame;
mod light_set;
mod lighting;
mod mesh_store;
mod methods;
mod parts;
mod pool;
mod rays;
mod record;
mod renderer;
mod scene_buffers;
mod set_scene;
mod shader;
mod shading;
mod stopwatch;
mod storage;
#[cfg(test)]
mod surface_parity;
mod texels;
mod tile;
mod visibility;

pub use adapter::{AdapterDescription, AdapterKind, GpuPreference};
pub use device::Gpu;
pub use display::DisplaySettings;
pub use error::GpuError;
pub use renderer::{GpuRenderer, GpuTimings};
