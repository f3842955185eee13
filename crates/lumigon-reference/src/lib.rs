//! Truth to measure lumigon against: adaptive cubature and a path tracer in f64.

mod bsdf;
mod cubature;
mod emitter;
mod ggx;
mod path_tracer;
mod polygon;
mod quadrature;
mod sampling;
mod scene;

pub use cubature::{
    CubatureError, GgxIntegral, Integral, VectorIntegral, form_factor, ggx, ggx_albedo, irradiance,
    light_vector, solid_angle,
};
pub use emitter::Emitter;
pub use ggx::ggx_brdf;
pub use path_tracer::{Channel, Estimate, RenderError, Settings, render};
pub use polygon::{Polygon, PolygonError};
pub use quadrature::Tolerance;
pub use scene::{PunctualLight, Ray, Scene, Surface};
