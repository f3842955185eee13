//! A window on a glTF scene lit by its emissive polygons.

pub mod document;
