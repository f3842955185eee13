//! Light from polygons.
//!
//! [`PolygonLight`] is any planar polygon, validated and prepared once; the functions evaluate
//! what it does to a shading point, exactly and without noise.

#![cfg_attr(not(feature = "std"), no_std)]
extern crate alloc;

mod clip;
mod ggx;
mod irradiance;
mod lanes;
mod light_direction;
mod ltc;
mod ltc_table;
mod polygon;
mod projected_area;
mod real;
mod reflection;
mod solid_angle;
mod technique;
mod vec3;

pub use ggx::{MINIMUM_ALPHA, ggx_cosine, schlick};
pub use irradiance::{form_factor, irradiance, light_vector, light_vector_above};
pub use lanes::{LaneMask, Lanes};
pub use light_direction::{LightDirection, circle_occlusion, clip_loop, light_direction};
pub use ltc::{Ltc, PreparedLtc, ltc_form_factor};
pub use ltc_table::{LtcTable, LtcTableError};
pub use polygon::{PLANARITY_TOLERANCE, PolygonError, PolygonLight, Sides};
pub use projected_area::{
    LocalOcclusion, ProjectionBasis, Pyramid, projected_area, projection_axis,
};
pub use real::{Mask, Real, Scalar};
pub use reflection::{InclusionRule, reflected_inclusion};
pub use solid_angle::{solid_angle, solid_angle_above};
pub use technique::{DiffuseMethod, SpecularMethod};
pub use vec3::Vec3;
