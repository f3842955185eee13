//! What lights show is what rays see on their faces.

use glam::{Mat3, Vec2};
use proptest::prelude::*;

use super::*;
use crate::scene::{
    EmissivePolygon, Material, Mesh, Sampler, Scene, TextureRef, TextureTransform,
    emissive::MOST_PICTURES,
};

/// Squares in the plane z = 0 with texture coordinates, two triangles each that share no vertex.
struct Squares {
    positions: Vec<DVec3>,
    uv: Vec<Vec2>,
    colors: Vec<Vec4>,
    material: Material,
    textures: Vec<Texture>,
}

impl Squares {
    fn new(texture: Texture) -> Self {
        Self {
            positions: Vec::new(),
            uv: Vec::new(),
            colors: Vec::new(),
            material: Material {
                emissive: Vec3::new(3.0, 2.0, 1.0),
                emissive_texture: Some(TextureRef::default()),
                ..Material::default()
            },
            textures: vec![texture],
        }
    }

    /// The square from (x, y) on, `uv` mapping places to texture coordinates.
    fn square(mut self, x: f64, y: f64, uv: impl Fn(DVec2) -> DVec2) -> Self {
        for (dx, dy) in [(0., 0.), (1., 0.), (1., 1.), (0., 0.), (1., 1.), (0., 1.)] {
            let place = DVec2::new(x + dx, y + dy);
            self.positions.push(place.extend(0.0));
            self.uv.push(uv(place).as_vec2());
        }
        self
    }

    fn mesh(&self) -> Mesh {
        let count = self.positions.len() as u32 / 3;
        Mesh {
            name: "screen".to_owned(),
            positions: self.positions.iter().map(|p| p.as_vec3()).collect(),
            triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            texcoords: [self.uv.clone(), Vec::new()],
            colors: self.colors.clone(),
            ..Mesh::default()
        }
    }

    fn lights(&self) -> (Vec<EmissivePolygon>, Option<String>) {
        let mesh = self.mesh();
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        let largest = positions.iter().map(|p| p.abs().max_element());
        let emitter = Emitter {
            mesh: &mesh,
            index: 0,
            positions: &positions,
            noise: largest.fold(0.0, f64::max) * f64::from(f32::EPSILON),
            material: &self.material,
            textures: &self.textures,
        };
        let emitted = emitter.polygons(64);
        let mut warnings = emitted.warnings;
        // Most of these pictures are bounded by 64 cells a side.
        warnings.retain(|warning| !warning.contains("raise the limit of 64 a side"));
        (emitted.polygons, warnings.pop())
    }

    fn only_light(&self) -> EmissivePolygon {
        let (mut lights, warning) = self.lights();
        assert_eq!((lights.len(), warning), (1, None));
        lights.remove(0)
    }

    /// What rays see at places of the triangles.
    fn seen(&self) -> Vec<(DVec3, Vec3)> {
        let scene = Scene {
            meshes: vec![self.mesh().into()],
            materials: vec![self.material.clone()],
            textures: self.textures.clone(),
            ..Scene::default()
        };
        let triangles = 0..scene.meshes[0].triangles.len();
        let at = |t: usize| {
            [(0.2, 0.3), (0.7, 0.1), (0.12, 0.81), (0.4, 0.45)].map(|(u, v)| {
                let place = Vec2::new(u, v);
                let surface = scene.surface(0, t, place, Vec3::new(0.1, 0.2, -1.0));
                let color = surface.emissive * surface.opacity;
                (surface.position.as_dvec3(), color)
            })
        };
        triangles.flat_map(at).collect()
    }
}

/// Noise of texels in red, green and alpha; blue is 1.
fn noise_texture(size: [u32; 2], sampler: Sampler) -> Texture {
    let texel = |i: u32| {
        let hash = (i + 1).wrapping_mul(2_654_435_761);
        let [a, b, _, d] = (hash ^ (hash >> 15)).to_le_bytes();
        [a, b, 255, d]
    };
    let texels = (0..size[0] * size[1]).map(texel).collect();
    Texture::from_rgba8("", size, texels, true, sampler).unwrap()
}

/// Image coordinates of a square of side 1: v runs down.
fn upright_uv(p: DVec2) -> DVec2 {
    DVec2::new(p.x, 1.0 - p.y)
}

fn mean(cells: &[[f32; 3]]) -> Vec3 {
    let sum: DVec3 = cells.iter().map(|&c| Vec3::from(c).as_dvec3()).sum();
    (sum / cells.len() as f64).as_vec3()
}

#[test]
fn whole_texture_is_the_picture_texel_by_texel() {
    let squares =
        Squares::new(noise_texture([8, 4], Sampler::default())).square(0.0, 0.0, upright_uv);
    let light = squares.only_light();
    let image = light.image.unwrap();
    let frame = [image.corner, image.edge_u, image.edge_v].map(DVec3::from);
    for (found, expected) in frame.into_iter().zip([DVec3::Y, DVec3::X, DVec3::NEG_Y]) {
        assert!(found.distance(expected) < 1e-12, "{frame:?}");
    }
    assert_eq!(image.size, [8, 4]);
    assert_eq!((image.strength, image.mask), (Vec3::new(3., 2., 1.), None));
    let cells = image.cells(&squares.textures, image.size);
    let texel = |i: u32| squares.textures[0].texel(i % 8, i / 8).xyz().to_array();
    assert_eq!(cells, (0..32).map(texel).collect::<Vec<_>>());
    let error = light.radiance - image.strength * mean(&cells);
    assert!(error.abs().max_element() < 1e-6, "{error}");
    assert_eq!(image.pyramid_bytes(), 16 * (32 + 8 + 2 + 1));
}

#[test]
fn faces_that_disagree_are_lights_of_their_own() {
    let texture = || noise_texture([16, 16], Sampler::default());
    let beside = |uv: fn(DVec2) -> DVec2| {
        let squares = Squares::new(texture()).square(0.0, 0.0, upright_uv);
        squares.square(1.0, 0.0, uv).lights().0
    };
    // The same map, moved by whole repeats or by less than a tolerable part of a texel.
    for uv in [
        upright_uv,
        |p| upright_uv(p) + DVec2::new(-1.0, 3.0),
        |p| upright_uv(p) + 0.1 / 16.0,
    ] {
        assert_eq!(beside(uv).len(), 1);
    }
    for uv in [
        |p: DVec2| upright_uv(p) + 0.5 / 16.0,
        |p: DVec2| DVec2::new(2.0 - p.x, 1.0 - p.y),
        |p: DVec2| upright_uv(p) * 1.1,
    ] {
        let lights = beside(uv);
        assert_eq!(lights.len(), 2);
        assert!(lights.iter().all(|light| light.image.is_some()));
    }
    // Mirrored repeats need two to be the same, clamped ones never are.
    for (wrap, shift, count) in [
        (Wrap::MirroredRepeat, 2.0, 1),
        (Wrap::MirroredRepeat, 1.0, 2),
        (Wrap::ClampToEdge, 2.0, 2),
    ] {
        let sampler = Sampler {
            wrap_s: wrap,
            wrap_t: wrap,
            ..Sampler::default()
        };
        let squares = Squares::new(noise_texture([4, 4], sampler)).square(0.0, 0.0, upright_uv);
        let squares = squares.square(1.0, 0.0, |p| upright_uv(p) + DVec2::new(shift, 0.0));
        assert_eq!(squares.lights().0.len(), count, "{wrap:?} {shift}");
    }
}

#[test]
fn points_of_a_palette_are_plain_colors() {
    let texels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 0, 255]];
    let sampler = Sampler {
        wrap_s: Wrap::ClampToEdge,
        filter: Filter::Nearest,
        ..Sampler::default()
    };
    let texture = Texture::from_rgba8("", [3, 1], texels, true, sampler).unwrap();
    let at = |i: f64| move |_| DVec2::new((i + 0.5) / 3.0, 0.5);
    let squares = Squares::new(texture).square(0.0, 0.0, at(0.0));
    let squares = squares.square(1.0, 0.0, at(1.0)).square(2.0, 0.0, at(2.0));
    let (mut lights, _) = squares.lights();
    lights.sort_by(|a, b| b.radiance.x.total_cmp(&a.radiance.x));
    let found: Vec<_> = lights.iter().map(|l| (l.radiance, l.image)).collect();
    // The black one is none.
    assert_eq!(found, [(Vec3::X * 3.0, None), (Vec3::Y * 2.0, None)]);
    // Without texture coordinates all of them show one texel.
    let mut squares = squares;
    squares.uv.clear();
    let light = squares.only_light();
    assert_eq!((light.image, light.vertex_count()), (None, 4));
}

#[test]
fn fine_meshes_turned_in_space_stay_one_light() {
    let texture = noise_texture([256, 256], Sampler::default());
    let mut squares = Squares::new(texture);
    let count = 30;
    for i in 0..count * count {
        let uv = |p: DVec2| p / f64::from(count) * DVec2::new(1.0, -1.0) + DVec2::new(0.25, 7.0);
        squares = squares.square(f64::from(i % count), f64::from(i / count), uv);
    }
    let place = glam::DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.04),
        glam::DQuat::from_scaled_axis(DVec3::new(0.37, -0.71, 0.2)),
        DVec3::new(11.3, -4.7, 29.1),
    );
    let positions = squares.positions.iter();
    squares.positions = positions.map(|p| place.transform_point3(*p)).collect();
    let image = squares.only_light().image.unwrap();
    assert_eq!(image.size, [64, 64]); // the most that the test lets it have
    for (position, color) in squares.seen().iter().step_by(97) {
        let found = Vec3::from(image.color(&squares.textures, position.to_array()));
        assert!((found * image.strength - color).abs().max_element() < 0.02);
    }
}

#[test]
fn mesh_in_too_many_pieces_shows_mean_colors() {
    let mut squares = Squares::new(noise_texture([64, 64], Sampler::default()));
    let side = (MOST_PICTURES as f64).sqrt() as u32 + 1;
    for i in 0..side * side {
        let turn = f64::from(i);
        let uv = |p: DVec2| DVec2::from_angle(turn).rotate(p);
        squares = squares.square(f64::from(i % side), f64::from(i / side), uv);
    }
    let (lights, warning) = squares.lights();
    assert_eq!((lights.len(), lights[0].image), (1, None));
    let warning = warning.unwrap();
    assert!(
        warning.contains("screen") && warning.contains("4225"),
        "{warning}"
    );
}

/// A disk of alpha on a texture of its own.
fn masked() -> Squares {
    let alpha = |i: u32| {
        let (x, y) = (f64::from(i % 32) - 15.5, f64::from(i / 32) - 15.5);
        let alpha = (128.0 + 16.0 * (12.0 - x.hypot(y))).clamp(0.0, 255.0);
        [255, 255, 255, alpha as u8]
    };
    let texels = (0..32 * 32).map(alpha).collect();
    let disk = Texture::from_rgba8("", [32, 32], texels, true, Sampler::default()).unwrap();
    let mut squares =
        Squares::new(noise_texture([4, 4], Sampler::default())).square(0.0, 0.0, upright_uv);
    squares.textures.push(disk);
    squares.material.base_color_texture = Some(TextureRef {
        texture: 1,
        ..TextureRef::default()
    });
    squares.material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    squares
}

#[test]
fn mask_cuts_where_rays_find_nothing() {
    let mut squares = masked();
    let light = squares.only_light();
    let image = light.image.unwrap();
    let mask = image.mask.unwrap();
    assert_eq!(
        (mask.placed.texture, mask.alpha, mask.cutoff),
        (1, 1.0, 0.5)
    );
    // Its border is sharper than its texels.
    assert_eq!(image.size, [64, 64]);
    let cells = image.cells(&squares.textures, image.size);
    let error = light.radiance - image.strength * mean(&cells);
    assert!(error.abs().max_element() < 0.01, "{error}");
    // Blue is 1 in the disk of radius 12 texels.
    let area = light.radiance.z;
    assert!((area - 0.4418).abs() < 0.01, "{area}");
    for (position, color) in squares.seen() {
        let found = Vec3::from(image.color(&squares.textures, position.to_array()));
        assert!((found * image.strength - color).abs().max_element() < 1e-5);
    }

    // The vertices' alpha counts, ...
    squares.colors = vec![Vec4::new(1.0, 1.0, 1.0, 0.5); 6];
    let image = squares.only_light().image.unwrap();
    assert_eq!(image.mask.unwrap().alpha, 0.5);
    for (position, color) in squares.seen() {
        let found = Vec3::from(image.color(&squares.textures, position.to_array()));
        assert!((found * image.strength - color).abs().max_element() < 1e-5);
    }
    // ... where it varies there is no picture, but the mean is right, ...
    squares.colors[2].w = 1.0;
    let (lights, _) = squares.lights();
    assert!(lights.iter().any(|light| light.image.is_none()));
    // ... and where all is cut there is no light.
    squares.colors = vec![Vec4::new(1.0, 1.0, 1.0, 0.4); 6];
    assert!(squares.lights().0.is_empty());
    // A blended face is drawn opaque, and lights so.
    squares.material.alpha_mode = AlphaMode::Blend;
    assert!(squares.only_light().image.unwrap().mask.is_none());
}

#[test]
fn mask_alone_and_hidden_masks() {
    let mut squares = masked();
    squares.material.emissive_texture = None;
    let image = squares.only_light().image.unwrap();
    assert!(image.emission.is_none() && image.mask.is_some());
    // In the disk's middle nothing is cut, and one colour is left.
    squares.uv = vec![Vec2::splat(0.5); 6];
    assert_eq!(squares.only_light().image, None);
    squares.uv[1].x = 0.55;
    let (lights, _) = squares.lights();
    assert!(lights.len() == 2 && lights.iter().all(|light| light.image.is_none()));
    squares.uv = vec![Vec2::ZERO; 6];
    assert!(squares.lights().0.is_empty());
}

#[test]
fn sizes_follow_texels_and_limits() {
    let nearest = Sampler {
        filter: Filter::Nearest,
        ..Sampler::default()
    };
    for (size, sampler, scale, expected) in [
        ([5, 3], Sampler::default(), 1.0, [8, 4]),
        ([16, 2], Sampler::default(), 3.0, [64, 8]),
        ([4, 8], nearest, 1.0, [16, 32]),
        ([8, 8], Sampler::default(), 1e3, [64, 64]),
        ([8, 8], Sampler::default(), 1e-3, [1, 1]),
    ] {
        let squares = Squares::new(noise_texture(size, sampler));
        let squares = squares.square(0.0, 0.0, |p| upright_uv(p) * scale);
        let image = squares.only_light().image.unwrap();
        assert_eq!(image.size, expected, "{size:?} {scale}");
    }
}

#[test]
fn hostile_coordinates_leave_lights() {
    for big in [1e3, 1e7, 1e20, 1e38, f32::MAX, f32::INFINITY, f32::NAN] {
        for pattern in [1, 5, 20, 63] {
            let mut squares = masked();
            for (i, uv) in squares.uv.iter_mut().enumerate() {
                if pattern >> i & 1 == 1 {
                    uv.x = big;
                }
            }
            for light in squares.lights().0 {
                assert!(light.radiance.is_finite(), "{big} {pattern}");
                if let Some(image) = light.image {
                    let cells = image.cells(&squares.textures, [4, 4]);
                    assert!(
                        cells
                            .as_flattened()
                            .iter()
                            .all(|x| x.is_finite() && *x >= 0.0)
                    );
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any affine map, wrapping and filter: the image is what rays see, and its picture's mean over a
    /// square that fills it is the light's.
    #[test]
    fn image_is_what_rays_see(
        columns in prop::array::uniform4(-3.0_f32..3.0),
        offset in prop::array::uniform2(-50.0_f32..50.0),
        size in prop::array::uniform2(1_u32..9),
        wrap in 0_usize..9,
        nearest in any::<bool>(),
        turned in any::<bool>(),
    ) {
        let modes = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
        let sampler = Sampler {
            wrap_s: modes[wrap % 3],
            wrap_t: modes[wrap / 3],
            filter: if nearest { Filter::Nearest } else { Filter::Linear },
        };
        let [a, b, c, d] = columns;
        let (b, c) = if turned { (b, c) } else { (0.0, 0.0) };
        let mut squares = Squares::new(noise_texture(size, sampler));
        squares = squares.square(0.0, 0.0, upright_uv);
        squares.material.emissive_texture = Some(TextureRef {
            transform: TextureTransform {
                texture_from_texcoord: Mat3::from_cols(
                    Vec3::new(a, b, 0.0),
                    Vec3::new(c, d, 0.0),
                    Vec3::new(offset[0], offset[1], 1.0),
                ),
            },
            ..TextureRef::default()
        });
        let light = squares.only_light();
        let Some(image) = light.image else {
            return Ok(());
        };
        let mut wrong = 0;
        for (position, color) in squares.seen() {
            let found = Vec3::from(image.color(&squares.textures, position.to_array()));
            wrong += usize::from((found * image.strength - color).abs().max_element() > 1e-3);
        }
        // Rounding may choose another nearest texel.
        prop_assert!(wrong <= usize::from(nearest), "{wrong} places differ");
        let fills = (DVec3::from(image.edge_u).cross(DVec3::from(image.edge_v)).length() - 1.0).abs();
        if fills < 1e-6 && !nearest {
            // Where texels are copied, those at the border stand for what they show outside it too.
            let cells = image.cells(&squares.textures, [60, 60]);
            let error = light.radiance - image.strength * mean(&cells);
            prop_assert!(error.abs().max_element() < 3e-3, "{error}");
        }
    }
}
