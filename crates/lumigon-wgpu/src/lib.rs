//! Polygon lights for renderers on wgpu: buffers, tables and shaders.

mod light;
mod light_buffers;

pub use light::{Light, LightRecord, PolygonRecord, VertexRecord, vertex_records};
pub use light_buffers::{LightBuffers, TooManyLights};
