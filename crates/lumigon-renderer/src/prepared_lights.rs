//! Polygon lights, prepared for shading.

use lumigon::{LightImage, LightImageError, PolygonLight, Sides};
use lumigon_wgpu::Light;
use rayon::prelude::*;

use crate::scene::{EmissiveImage, EmissivePolygon, Texture};

/// A scene's lights as shading wants them.
pub(crate) struct PreparedLights {
    /// Those whose outlines can be evaluated.
    pub(crate) lights: Vec<Light>,
    /// For each of them its index among the scene's.
    pub(crate) sources: Vec<usize>,
    /// Why the others light nothing, and which show less than they should.
    pub(crate) warnings: Vec<String>,
    /// For each warning the index of its light among the scene's.
    pub(crate) warned: Vec<usize>,
}

/// A light that was prepared, if it can be evaluated, and what is to be said about it.
pub(crate) type Prepared = (Option<Light>, Option<String>);

impl PreparedLights {
    /// `textures` are the scene's.
    pub(crate) fn new(lights: &[EmissivePolygon], textures: &[Texture]) -> Self {
        Self::with_known(lights, textures, |_| None)
    }

    /// The same, but for lights that are `known` already, by their indices.
    pub(crate) fn with_known(
        lights: &[EmissivePolygon],
        textures: &[Texture],
        known: impl Fn(usize) -> Option<Prepared> + Sync,
    ) -> Self {
        let prepare = |(index, light)| known(index).unwrap_or_else(|| prepared(light, textures));
        let all: Vec<_> = lights.par_iter().enumerate().map(prepare).collect();
        let mut prepared = Self {
            lights: Vec::new(),
            sources: Vec::new(),
            warnings: Vec::new(),
            warned: Vec::new(),
        };
        for (source, (light, warning)) in all.into_iter().enumerate() {
            if let Some(warning) = warning {
                prepared.warnings.push(warning);
                prepared.warned.push(source);
            }
            if let Some(light) = light {
                prepared.lights.push(light);
                prepared.sources.push(source);
            }
        }
        prepared
    }
}

fn prepared(light: &EmissivePolygon, textures: &[Texture]) -> Prepared {
    let sides = if light.two_sided {
        Sides::Both
    } else {
        Sides::Front
    };
    let outline = PolygonLight::new(&light.loops, sides);
    let both = outline.and_then(|exact| exact.cast().map(|polygon| (exact, polygon)));
    let (exact, polygon) = match both {
        Ok(both) => both,
        Err(fault) => {
            let warning = format!("light \"{}\" lights nothing: {fault}", light.name);
            return (None, Some(warning));
        }
    };
    let mut prepared = Light {
        polygon,
        radiance: light.radiance.to_array(),
        image: None,
    };
    let warning = match light
        .image
        .as_ref()
        .map(|shown| picture(&exact, shown, textures))
    {
        None => None,
        Some(Ok((strength, image))) => {
            prepared.radiance = strength;
            prepared.image = Some(image);
            None
        }
        Some(Err(fault)) => Some(format!(
            "light \"{}\" shows its mean colour: {fault}",
            light.name
        )),
    };
    (Some(prepared), warning)
}

/// The picture, and the radiance that it multiplies.
fn picture(
    polygon: &PolygonLight<f64>,
    shown: &EmissiveImage,
    textures: &[Texture],
) -> Result<([f32; 3], LightImage<f32>), LightImageError> {
    let frame = [shown.corner, shown.edge_u, shown.edge_v];
    let mut image = LightImage::new(polygon, frame, shown.size)?;
    image.replace(&shown.cells(textures, shown.size))?;
    Ok((shown.strength.to_array(), image))
}
