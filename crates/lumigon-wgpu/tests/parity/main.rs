//! Parity: every function of the shader library, on a GPU in f32, equals the crate `lumigon` in f64.
//!
//! Arrays of random and hostile places go through one compute shader a function. Any Vulkan, Metal or
//! DX12 device does, software included; none at all is a failure. `-- --nocapture` prints the worst
//! error of each function.

mod approximations;
mod brdfs;
mod cases;
mod check;
mod compare;
mod distance_fields;
mod gpu;
mod image_filter;
mod images;
mod lights;
mod lobes;
mod numbers;
mod poison;
#[path = "../../../lumigon/tests/polygons/mod.rs"]
mod polygons;
mod tables;
mod tolerances;
