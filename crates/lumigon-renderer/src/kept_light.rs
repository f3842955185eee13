//! Whether a light is what it was before its scene was edited.

use glam::{DVec2, DVec3};

use crate::scene::{EmissiveImage, EmissivePolygon, PlacedTexture, Texture};

/// Texels by which a picture may seem to have moved on its light and still be where it was: positions in
/// single precision leave no less.
const STAYED: f64 = 2e-3;

/// Whether two lights light alike: `textures` are those of either's scene.
pub(crate) fn is_same_light([a, b]: [&EmissivePolygon; 2], textures: [&[Texture]; 2]) -> bool {
    let is_same_image = match (&a.image, &b.image) {
        (None, None) => true,
        (Some(one), Some(other)) => one == other && shows_same_textures([one, other], textures),
        _ => false,
    };
    is_same_image
        && (&a.name, a.radiance, a.two_sided) == (&b.name, b.radiance, b.two_sided)
        && a.loops == b.loops
}

/// Whether a light shows the picture that it did, and has the outline that it had, but for its place,
/// direction and size.
pub(crate) fn is_moved_light([a, b]: [&EmissivePolygon; 2], textures: [&[Texture]; 2]) -> bool {
    let (Some(one), Some(other)) = (&a.image, &b.image) else {
        return false;
    };
    let images = [one, other];
    let mask = |image: &EmissiveImage| image.mask.map(|mask| (mask.alpha, mask.cutoff));
    if one.size != other.size || mask(one) != mask(other) {
        return false;
    }
    let lengths = images.map(|image| {
        DVec2::new(
            DVec3::from(image.edge_u).length(),
            DVec3::from(image.edge_v).length(),
        )
    });
    let is_alike =
        (lengths[0].perp_dot(lengths[1])).abs() <= 1e-4 * lengths[0].length() * lengths[1].length();
    if !is_alike || !shows_same_textures(images, textures) {
        return false;
    }
    let size = DVec2::new(one.size[0].into(), one.size[1].into());
    let has_stayed =
        |a: DVec2, b: DVec2, texels: DVec2| ((a - b) * texels).abs().max_element() <= STAYED;
    let counts = |light: &EmissivePolygon| light.loops.iter().map(Vec::len).collect::<Vec<_>>();
    let pairs = || a.loops.iter().flatten().zip(b.loops.iter().flatten());
    counts(a) == counts(b)
        && pairs().all(|(&p, &q)| has_stayed(coordinates(one, p), coordinates(other, q), size))
        && placed(one).zip(placed(other)).all(|(placed_a, placed_b)| {
            let texture = &textures[0][placed_a.texture];
            let texels = DVec2::new(texture.width.into(), texture.height.into());
            let corners = images.map(corners);
            let uv = |placed: &PlacedTexture, at| DVec2::from(placed.map.uv(at));
            let [one, other] = corners;
            let mut pairs = one.into_iter().zip(other);
            pairs.all(|(p, q)| has_stayed(uv(&placed_a, p), uv(&placed_b, q), texels))
        })
}

/// The textures that an image is made of.
fn placed(image: &EmissiveImage) -> impl Iterator<Item = PlacedTexture> {
    image
        .emission
        .into_iter()
        .chain(image.mask.map(|mask| mask.placed))
}

fn shows_same_textures([a, b]: [&EmissiveImage; 2], textures: [&[Texture]; 2]) -> bool {
    let parts = |image: &EmissiveImage| [image.emission, image.mask.map(|mask| mask.placed)];
    parts(a).into_iter().zip(parts(b)).all(|pair| match pair {
        (Some(a), Some(b)) => {
            let found = (textures[0].get(a.texture), textures[1].get(b.texture));
            matches!(found, (Some(a), Some(b)) if a.is_same_as(b))
        }
        (a, b) => a.is_none() && b.is_none(),
    })
}

/// Three corners of an image's parallelogram.
fn corners(image: &EmissiveImage) -> [[f64; 3]; 3] {
    let corner = DVec3::from(image.corner);
    let [u, v] = [image.edge_u, image.edge_v].map(DVec3::from);
    [corner, corner + u, corner + v].map(|p| p.to_array())
}

/// Where a point lies along an image's edges, each from 0 to 1.
fn coordinates(image: &EmissiveImage, point: [f64; 3]) -> DVec2 {
    let offset = DVec3::from(point) - DVec3::from(image.corner);
    let [u, v] = [image.edge_u, image.edge_v].map(DVec3::from);
    let normal = u.cross(v);
    let inverse = 1.0 / normal.length_squared();
    DVec2::new(offset.cross(v).dot(normal), u.cross(offset).dot(normal)) * inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn lit(name: &str) -> Scene {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/");
        Scene::load(format!("{folder}{name}")).unwrap()
    }

    #[test]
    fn a_picture_moves_with_its_light_and_not_on_it() {
        let scene = lit("screens.glb");
        let light = &scene.polygon_lights[0];
        let by = DVec3::new(0.5, -0.25, 1.0);
        let plus = |p: &mut [f64; 3]| *p = (DVec3::from(*p) + by).to_array();
        let mut moved = light.clone();
        moved.loops.iter_mut().flatten().for_each(plus);
        let textures = [scene.textures.as_slice(); 2];
        // The outline alone has moved.
        assert!(!is_moved_light([light, &moved], textures));
        let image = moved.image.as_mut().unwrap();
        plus(&mut image.corner);
        // And the parallelogram, but the texture has not.
        assert!(!is_moved_light([light, &moved], textures));
        let image = moved.image.as_mut().unwrap();
        for placed in [&mut image.emission].into_iter().flatten() {
            plus(&mut placed.map.point);
        }
        for mask in [&mut image.mask].into_iter().flatten() {
            plus(&mut mask.placed.map.point);
        }
        assert!(is_moved_light([light, &moved], textures));
        assert!(!is_same_light([light, &moved], textures));
        assert!(is_same_light([light, &light.clone()], textures));
        assert!(!is_same_light([light, light], [&scene.textures, &[]]));
    }
}
