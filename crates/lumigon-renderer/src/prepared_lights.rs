//! Polygon lights, prepared for shading.

use lumigon::{PolygonLight, Sides};
use lumigon_wgpu::Light;

use crate::scene::EmissivePolygon;

/// The lights whose outlines can be evaluated, and why the others light nothing.
pub(crate) fn prepared_lights(lights: &[EmissivePolygon]) -> (Vec<Light>, Vec<String>) {
    let mut prepared = Vec::new();
    let mut warnings = Vec::new();
    for light in lights {
        let sides = if light.two_sided {
            Sides::Both
        } else {
            Sides::Front
        };
        match PolygonLight::new(&light.loops, sides).and_then(|polygon| polygon.cast()) {
            Ok(polygon) => prepared.push(Light {
                polygon,
                radiance: light.radiance.to_array(),
                image: None,
            }),
            Err(fault) => {
                warnings.push(format!("light \"{}\" lights nothing: {fault}", light.name));
            }
        }
    }
    (prepared, warnings)
}
