//! Polygon lights for renderers on wgpu: buffers, tables and shaders.
//!
//! [`LightBuffers`] and [`Tables`] hold what shaders read, [`bind_group`] binds it, and [`wgsl`] is
//! the text to put before a shader of yours. `examples/forward` adds lights to a forward renderer.

mod bindings;
mod cluster;
mod distance_fields;
mod light;
mod light_buffers;
mod tables;

pub use bindings::{MODULES, bind_group, bind_group_layout, bind_group_with_fields, wgsl};
pub use cluster::{CLUSTER_LIGHTS, ClusterRecord, clusters, sort_by_place};
pub use distance_fields::{
    DistanceFieldBaker, DistanceFieldBuffers, LightFieldRecord, TooManyFields,
};
pub use light::{Light, LightRecord, PolygonRecord, VertexRecord, vertex_records};
pub use light_buffers::{LightBuffers, TooManyLights};
pub use tables::{TableFormat, Tables};
