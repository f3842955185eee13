//! Renders glTF scenes lit by their emissive polygons.
