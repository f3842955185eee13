//! Truth to measure lumigon against: adaptive cubature and a path tracer in f64.

mod cubature;
mod ggx;
mod polygon;
mod quadrature;

pub use cubature::{
    CubatureError, GgxIntegral, Integral, VectorIntegral, form_factor, ggx, ggx_albedo, irradiance,
    light_vector, solid_angle,
};
pub use ggx::ggx_brdf;
pub use polygon::{Polygon, PolygonError};
pub use quadrature::Tolerance;
