//! Light from polygons: exact, without noise.
//!
//! [`PolygonLight`] is any planar polygon (concave, with holes, one- or two-sided), validated and
//! prepared once. The functions evaluate what it does to a shading point:
//!
//! | function | value, for radiance 1 |
//! | --- | --- |
//! | [`irradiance`], [`form_factor`] | irradiance of a surface, clipped at its horizon |
//! | [`light_vector`], [`light_vector_above`] | vector irradiance, whole and clipped |
//! | [`solid_angle`], [`solid_angle_above`] | solid angle, whole and clipped |
//! | [`ltc_form_factor`] | a fitted lobe's integral over the light: specular light, sheen |
//! | [`irradiance_bound`], [`ltc_form_factor_bound`] | what these are at most |
//!
//! and the approximations that stand beside them: [`projected_area`], [`light_direction`],
//! [`reflected_inclusion`], [`reflected_distance`]. [`DiffuseMethod`] and [`SpecularMethod`] name them as data.
//!
//! The reflection models that lobes are fitted to can be evaluated themselves, for light from one
//! direction: [`ggx_cosine`], [`ggx_anisotropic_cosine`], [`charlie_cosine`] and [`eon_cosine`].
//!
//! # Conventions
//!
//! Radiance is in W m^-2 sr^-1 (or nits: nothing depends on it), lengths in any unit, angles in
//! radians; frames are right-handed. Outer loops run counter-clockwise seen from the emitting
//! side, holes clockwise. `alpha` is the width of GGX; `perceptual_roughness` is its square root.
//! Normals and view vectors are unit vectors and point away from the surface; what is not finite
//! among them may come back as NaN, never as a panic.
//!
//! # Number types
//!
//! Every function is generic over [`Real`]: f64, f32, or [`Lanes`] of f32, one shading point a
//! lane. The light is shared by the lanes and stored in [`Real::Scalar`]. To use the lanes,
//! dispatch once outside the loop with `fearless_simd::dispatch!`, and mark what touches them
//! `#[inline(always)]`, or the processor's instructions are lost.
//!
//! Without the default feature `std` the crate needs `alloc` alone.

#![cfg_attr(not(feature = "std"), no_std)]
extern crate alloc;

mod anisotropic_ltc;
mod bound;
mod charlie;
mod clip;
mod coverage;
mod distance_field;
mod eon;
mod ggx;
mod image_lookup;
mod image_pyramid;
mod image_quadrature;
mod irradiance;
mod lanes;
mod light_direction;
mod light_image;
mod ltc;
mod ltc_table;
mod mean_image;
mod polygon;
mod projected_area;
mod pyramid;
mod real;
mod reflection;
mod solid_angle;
mod technique;
mod vec3;

pub use anisotropic_ltc::AnisotropicLtc;
pub use bound::{irradiance_bound, ltc_density_bound, ltc_form_factor_bound};
pub use charlie::{MINIMUM_SHEEN_ALPHA, charlie_cosine};
pub use distance_field::{
    DISTANCE_FIELD_SPREAD, DistanceField, DistanceFieldError, DistanceFieldSettings,
    DistanceFieldSmoothness, DistanceFields, FieldPlacement, MAXIMUM_FIELD_RESOLUTION,
    MINIMUM_FIELD_RESOLUTION, PlacedDistanceField, check_budget, distance_field_smoothness,
    field_shapes, reflected_distance,
};
pub use eon::{
    eon_albedo, eon_cosine, eon_multiple_albedo, eon_multiple_cosine, eon_single_albedo,
    eon_single_cosine,
};
pub use ggx::{MINIMUM_ALPHA, ggx_anisotropic_cosine, ggx_cosine, schlick};
pub use image_lookup::{GAUSSIAN_LEVELS, GaussianLevel, GaussianLevels};
pub use image_pyramid::{ImagePyramid, Texel};
pub use irradiance::{form_factor, irradiance, light_vector, light_vector_above};
pub use lanes::{LaneMask, Lanes};
pub use light_direction::{LightDirection, circle_occlusion, clip_loop, light_direction};
pub use light_image::{ImageFrame, LightImage, LightImageError};
pub use ltc::{Ltc, PreparedLtc, ltc_form_factor};
pub use ltc_table::{AnisotropicLtcTable, LtcSum, LtcTable, LtcTableError, ggx_polynomial};
pub use mean_image::{ImageMethod, ltc_mean_image};
pub use polygon::{PLANARITY_TOLERANCE, PolygonError, PolygonLight, Sides};
pub use projected_area::{LocalOcclusion, ProjectionBasis, projected_area, projection_axis};
pub use pyramid::Pyramid;
pub use real::{Mask, Real, Scalar};
pub use reflection::{InclusionRule, reflected_image, reflected_inclusion};
pub use solid_angle::{solid_angle, solid_angle_above};
pub use technique::{DiffuseMethod, LtcLobes, SpecularMethod};
pub use vec3::Vec3;

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
