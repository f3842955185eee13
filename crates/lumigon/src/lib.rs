//! Light from polygons.
//!
//! [`PolygonLight`] is any planar polygon, validated and prepared once; the functions evaluate
//! what it does to a shading point, exactly and without noise.

#![cfg_attr(not(feature = "std"), no_std)]
extern crate alloc;

mod clip;
mod irradiance;
mod lanes;
mod polygon;
mod real;
mod vec3;

pub use irradiance::{form_factor, irradiance, light_vector, light_vector_above};
pub use lanes::{LaneMask, Lanes};
pub use polygon::{PLANARITY_TOLERANCE, PolygonError, PolygonLight, Sides};
pub use real::{Mask, Real, Scalar};
pub use vec3::Vec3;
