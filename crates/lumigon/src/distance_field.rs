//! Mirror reflections of a polygon light by a baked distance field: smooth on rough surfaces.
//!
//! Petryaev, "Polygons as lights", section on specular reflections: the distance to the polygon is
//! baked over a square of its plane, once a shape; shading fetches it where the mirrored view meets
//! the plane, at a cost that no outline changes. [`reflected_inclusion`](crate::reflected_inclusion)
//! is the same mirror without the cache.

mod bake;
mod field;
mod reflect;
mod settings;
mod shapes;
mod smoothness;
#[cfg(test)]
mod tests;

pub use field::DistanceField;
pub use reflect::{DISTANCE_FIELD_SPREAD, PlacedDistanceField, reflected_distance};
pub use settings::{
    DistanceFieldError, DistanceFieldSettings, DistanceFieldSmoothness, MAXIMUM_FIELD_RESOLUTION,
    MINIMUM_FIELD_RESOLUTION,
};
pub use shapes::{DistanceFields, FieldPlacement, check_budget, field_shapes};
pub use smoothness::distance_field_smoothness;
