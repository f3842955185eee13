//! Polygon lights for renderers on wgpu: buffers, tables and shaders.
//!
//! [`LightBuffers`] and [`Tables`] hold what shaders read, [`bind_group`] binds it, and [`wgsl`] is
//! the text to put before a shader of yours. `examples/forward` adds lights to a forward renderer.

mod bindings;
mod cluster;
mod distance_fields;
mod image_buffers;
mod image_colors;
mod image_filter;
mod light;
mod light_buffers;
mod tables;

pub use bindings::{MODULES, bind_group, bind_group_layout, bind_group_with_fields, wgsl};
pub use cluster::{
    CLUSTER_LIGHTS, ClusterRecord, clusters, light_power, order_by_place, sort_by_place,
};
pub use distance_fields::{
    DistanceFieldBaker, DistanceFieldBuffers, LightFieldRecord, TooManyFields,
};
pub use image_buffers::{ImageBuffers, ImageRecord, ReplaceImageError, TooLargeImages};
pub use image_colors::ImageColors;
pub use light::{Light, LightRecord, PolygonRecord, VertexRecord, vertex_records};
pub use light_buffers::{LightBuffers, LightBuffersError, TooManyLights};
pub use tables::{TableFormat, Tables};
