//! Polygon lights, prepared for shading.

use std::collections::HashMap;

use lumigon::{LightImage, LightImageError, PolygonLight, Sides};
use lumigon_wgpu::Light;
use rayon::prelude::*;

use crate::kept_light::{is_moved_light, is_same_light};
use crate::scene::{EmissiveImage, EmissivePolygon, Scene, Texture};

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
        let prepare =
            |(index, light)| known(index).unwrap_or_else(|| prepared(light, textures, None));
        Self::collected(lights.par_iter().enumerate().map(prepare).collect())
    }

    /// After edits: lights that are what they were stay, and pictures whose lights have only moved.
    pub(crate) fn edited(scene: &Scene, earlier: &EarlierLights<'_>) -> Self {
        let places = earlier.places();
        let all = scene
            .polygon_lights
            .par_iter()
            .enumerate()
            .map(
                |(i, light)| match earlier.same(i, light, &scene.textures, &places) {
                    Some(same) => (Some(same.clone()), None),
                    None => prepared(
                        light,
                        &scene.textures,
                        earlier.moved(light, &scene.textures),
                    ),
                },
            );
        Self::collected(all.collect())
    }

    fn collected(all: Vec<Prepared>) -> Self {
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

/// The lights of a scene before it was edited.
pub(crate) struct EarlierLights<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) lights: &'a [Light],
    /// For each of them its index among the scene's.
    pub(crate) sources: &'a [usize],
}

/// Lights by the bits of their first vertex: indices into those that were prepared.
type Places = HashMap<[u64; 3], Vec<usize>>;

fn place(light: &EmissivePolygon) -> [u64; 3] {
    let first = light.loops.first().and_then(|vertices| vertices.first());
    first.copied().unwrap_or_default().map(f64::to_bits)
}

impl EarlierLights<'_> {
    fn places(&self) -> Places {
        let mut places = Places::new();
        for (index, &source) in self.sources.iter().enumerate() {
            let key = place(&self.scene.polygon_lights[source]);
            places.entry(key).or_default().push(index);
        }
        places
    }

    /// A light that lights as the one that is `index` now.
    fn same(
        &self,
        index: usize,
        light: &EmissivePolygon,
        textures: &[Texture],
        places: &Places,
    ) -> Option<&Light> {
        let candidates = places.get(&place(light))?;
        let is_same = |&&candidate: &&usize| self.is_same(candidate, light, textures);
        // As a rule the one with its index; where lights lie on each other, any that is the same.
        let mut own = candidates.iter().filter(|&&c| self.sources[c] == index);
        let found = own
            .find(is_same)
            .or_else(|| candidates.iter().find(is_same))?;
        Some(&self.lights[*found])
    }

    fn is_same(&self, candidate: usize, light: &EmissivePolygon, textures: &[Texture]) -> bool {
        let before = &self.scene.polygon_lights[self.sources[candidate]];
        // What could not be shown is said again.
        let is_shown = before.image.is_none() || self.lights[candidate].image.is_some();
        is_shown && is_same_light([before, light], [&self.scene.textures, textures])
    }

    /// The picture of a light of the same mesh that has only moved.
    fn moved(&self, light: &EmissivePolygon, textures: &[Texture]) -> Option<&LightImage<f32>> {
        light.image.as_ref()?;
        let mut lights = self.lights.iter().zip(self.sources);
        lights.find_map(|(prepared, &source)| {
            let before = &self.scene.polygon_lights[source];
            let image = prepared.image.as_ref()?;
            let is_moved = before.mesh == light.mesh
                && is_moved_light([before, light], [&self.scene.textures, textures]);
            is_moved.then_some(image)
        })
    }
}

/// `kept` is the light's picture as it was, if that only moved.
fn prepared(
    light: &EmissivePolygon,
    textures: &[Texture],
    kept: Option<&LightImage<f32>>,
) -> (Option<Light>, Option<String>) {
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
        .map(|shown| picture(&exact, shown, textures, kept))
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
    kept: Option<&LightImage<f32>>,
) -> Result<([f32; 3], LightImage<f32>), LightImageError> {
    let frame = [shown.corner, shown.edge_u, shown.edge_v];
    if let Some(kept) = kept {
        return Ok((shown.strength.to_array(), kept.moved(polygon, frame)?));
    }
    let mut image = LightImage::new(polygon, frame, shown.size)?;
    image.replace(&shown.cells(textures, shown.size))?;
    Ok((shown.strength.to_array(), image))
}
