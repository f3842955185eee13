//! Polygon lights, prepared for shading.

use lumigon::{LightImage, LightImageError, PolygonLight, Sides};
use lumigon_wgpu::Light;

use crate::scene::{EmissiveImage, EmissivePolygon, Texture};

/// The lights whose outlines can be evaluated, and why the others light nothing.
///
/// With the scene's textures, lights show their images, and their radiance is what those are
/// multiplied with. Without, it is the mean.
pub(crate) fn prepared_lights(
    lights: &[EmissivePolygon],
    textures: Option<&[Texture]>,
) -> (Vec<Light>, Vec<String>) {
    let mut prepared = Vec::new();
    let mut warnings = Vec::new();
    for light in lights {
        let sides = if light.two_sided {
            Sides::Both
        } else {
            Sides::Front
        };
        let outline = PolygonLight::<f64>::new(&light.loops, sides);
        let polygon = outline
            .as_ref()
            .map_err(Clone::clone)
            .and_then(PolygonLight::cast);
        let (outline, polygon) = match (outline, polygon) {
            (Ok(outline), Ok(polygon)) => (outline, polygon),
            (Err(fault), _) | (_, Err(fault)) => {
                warnings.push(format!("light \"{}\" lights nothing: {fault}", light.name));
                continue;
            }
        };
        let shown = light.image.as_ref().zip(textures);
        let shown =
            shown.map(|(image, textures)| (image.strength, prefiltered(&outline, image, textures)));
        let (radiance, image) = match shown {
            Some((strength, Ok(image))) => (strength, Some(image)),
            Some((_, Err(fault))) => {
                let name = &light.name;
                warnings.push(format!("light \"{name}\" shows its mean colour: {fault}"));
                (light.radiance, None)
            }
            None => (light.radiance, None),
        };
        prepared.push(Light {
            polygon,
            radiance: radiance.to_array(),
            image,
        });
    }
    (prepared, warnings)
}

fn prefiltered(
    outline: &PolygonLight<f64>,
    image: &EmissiveImage,
    textures: &[Texture],
) -> Result<LightImage<f32>, LightImageError> {
    let frame = [image.corner, image.edge_u, image.edge_v];
    let mut shown = LightImage::new(outline, frame, image.size)?;
    shown.replace(&image.cells(textures, image.size))?;
    Ok(shown)
}
