//! Truth to measure lumigon against: adaptive cubature and a path tracer in f64.

mod polygon;

pub use polygon::{Polygon, PolygonError};
