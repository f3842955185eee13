//! Random sequences of edits.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use lumigon::{PolygonLight, Sides};
use lumigon_renderer::{Material, Mesh, Sampler, Scene, Texture, TextureRef, Wrap};
use proptest::prelude::*;

use super::outline::{self, Corner};
use super::*;

/// A mesh of several lights, one of them textured as a whole; a lamp; a floor.
pub(super) fn scene() -> Scene {
    let texels =
        (0..64_u32).map(|i| [(i * 4) as u8, 255 - (i * 3) as u8, (i * i % 251) as u8, 255]);
    let sampler = Sampler {
        wrap_s: Wrap::ClampToEdge,
        wrap_t: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    let texture = Texture::from_rgba8("chart", [8, 8], texels.collect(), true, sampler).unwrap();
    let white = |emissive: f32| Material {
        emissive: Vec3::new(emissive, 0.5 * emissive, 0.25),
        ..Material::default()
    };
    let shown = Material {
        emissive_texture: Some(TextureRef::default()),
        base_color: Vec4::new(0.5, 0.25, 0.125, 1.0),
        ..white(2.0)
    };
    let mut scene = Scene {
        materials: vec![white(3.0), shown, Material::default()],
        textures: vec![texture],
        ..Scene::default()
    };
    // Squares side by side in planes of their own, sharing a mesh; two triangles each.
    let mut panels = Mesh {
        name: "panels".to_owned(),
        ..Mesh::default()
    };
    for i in 0..4 {
        panels.append_square(Vec3::new(2.5 * i as f32, 0.0, 0.1 * i as f32), 2.0);
    }
    let mut screen = Mesh {
        name: "screen".to_owned(),
        material: 1,
        ..Mesh::default()
    };
    screen.append_square(Vec3::new(0.0, 3.0, 0.0), 2.0);
    screen.texcoords[0] = [(0., 1.), (1., 1.), (1., 0.), (0., 0.)]
        .map(Vec2::from)
        .to_vec();
    let mut floor = Mesh {
        name: "floor".to_owned(),
        material: 2,
        ..Mesh::default()
    };
    floor.append_square(Vec3::new(-5.0, -5.0, -3.0), 20.0);
    scene.meshes = [panels, screen, floor].map(Arc::new).to_vec();
    for mesh in 0..3 {
        let (lights, warnings) = scene.lights_of_mesh(mesh, &Limits::default());
        assert!(warnings.is_empty());
        scene.polygon_lights.extend(lights);
    }
    assert_eq!(scene.polygon_lights.len(), 5);
    scene
}

trait AppendSquare {
    fn append_square(&mut self, corner: Vec3, side: f32);
}

impl AppendSquare for Mesh {
    fn append_square(&mut self, corner: Vec3, side: f32) {
        let first = self.positions.len() as u32;
        let corners = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
        let place = |(x, y): (f32, f32)| corner + Vec3::new(x, y, 0.0) * side;
        self.positions.extend(corners.map(place));
        self.normals.extend([Vec3::Z; 4]);
        self.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| i + first)));
    }
}

/// All that a renderer relies on, and that lights and faces know each other.
pub(super) fn assert_sound<S: Clone + PartialEq>(document: &Document<S>) {
    let scene = document.scene();
    for mesh in &scene.meshes {
        assert!(mesh.material < scene.materials.len());
        let count = mesh.positions.len();
        assert_eq!(mesh.normals.len(), count);
        for texcoords in &mesh.texcoords {
            assert!(texcoords.is_empty() || texcoords.len() == count);
        }
        assert!(mesh.colors.is_empty() || mesh.colors.len() == count);
        assert!(
            mesh.triangles
                .iter()
                .flatten()
                .all(|&i| (i as usize) < count)
        );
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
    }
    for material in &scene.materials {
        let texture = material
            .emissive_texture
            .map_or(0, |reference| reference.texture);
        assert!(material.emissive_texture.is_none() || texture < scene.textures.len());
    }
    assert!(scene.polygon_lights.is_sorted_by_key(|light| light.mesh));
    for light in &scene.polygon_lights {
        let sides = if light.two_sided {
            Sides::Both
        } else {
            Sides::Front
        };
        let prepared = PolygonLight::new(&light.loops, sides).unwrap();
        prepared.cast::<f32>().unwrap();
        let triangles = &scene.meshes[light.mesh].triangles;
        assert!(
            light
                .triangles
                .iter()
                .all(|&t| (t as usize) < triangles.len())
        );
        assert!(!light.triangles.is_empty());
    }
    let mut polygons = vec![false; scene.polygon_lights.len()];
    for (id, light) in document.lights() {
        let mut area = 0.0;
        for index in document.polygons_of(id) {
            assert!(
                !std::mem::replace(&mut polygons[index], true),
                "{id:?} shares a polygon"
            );
            let polygon = &scene.polygon_lights[index];
            area += polygon.area();
            for &triangle in &polygon.triangles {
                assert_eq!(document.light_at(polygon.mesh, triangle), Some(id));
            }
            let cosine = DVec3::from(polygon.area_vector())
                .normalize()
                .dot(light.normal());
            assert!(cosine > 0.999_99, "{cosine}");
            assert_eq!(polygon.two_sided, light.two_sided);
        }
        if light.radiance.max_element() > 0.0 {
            assert!(
                (area - light.area()).abs() <= 1e-4 * light.area(),
                "{area} {light:?}"
            );
        }
    }
    assert!(polygons.iter().all(|&seen| seen), "a polygon is no light's");
}

/// One thing that a user does; numbers choose lights and vertices, whichever there are.
#[derive(Clone, Debug)]
enum Deed {
    Move(usize, [f64; 3]),
    Turn(usize, [f64; 3], f64),
    Scale(usize, f64, f64),
    MoveVertex(usize, usize, [f64; 2]),
    InsertVertex(usize, usize, [f64; 2]),
    DeleteVertex(usize, usize),
    Hole(usize, f64),
    Color(usize, [f32; 3], bool),
    Picture(usize, bool),
    NoPicture(usize),
    Add(usize),
    Duplicate(usize),
    Remove(usize),
    Settings(u8),
    Begin,
    End,
    Cancel,
    Undo,
    Redo,
    Finish,
}

fn deed() -> impl Strategy<Value = Deed> {
    let which = || 0_usize..64;
    let number = || -2.0..2.0_f64;
    let place = move || [number(), number()];
    let vector = move || [number(), number(), number()];
    prop_oneof![
        (which(), vector()).prop_map(|(i, v)| Deed::Move(i, v)),
        (which(), vector(), number()).prop_map(|(i, v, a)| Deed::Turn(i, v, a)),
        (which(), 0.2..3.0_f64, 0.2..3.0_f64).prop_map(|(i, x, y)| Deed::Scale(i, x, y)),
        (which(), which(), place()).prop_map(|(i, k, p)| Deed::MoveVertex(i, k, p)),
        (which(), which(), place()).prop_map(|(i, k, p)| Deed::InsertVertex(i, k, p)),
        (which(), which()).prop_map(|(i, k)| Deed::DeleteVertex(i, k)),
        (which(), 0.01..0.4_f64).prop_map(|(i, s)| Deed::Hole(i, s)),
        (which(), [0.0..4.0_f32, 0.0..4.0, 0.0..4.0], any::<bool>())
            .prop_map(|(i, c, sides)| Deed::Color(i, c, sides)),
        (which(), any::<bool>()).prop_map(|(i, fit)| Deed::Picture(i, fit)),
        which().prop_map(Deed::NoPicture),
        which().prop_map(Deed::Add),
        which().prop_map(Deed::Duplicate),
        which().prop_map(Deed::Remove),
        any::<u8>().prop_map(Deed::Settings),
        Just(Deed::Begin),
        Just(Deed::End),
        Just(Deed::Cancel),
        Just(Deed::Undo),
        Just(Deed::Redo),
        Just(Deed::Finish),
    ]
}

pub(super) fn picture() -> Arc<PictureFile> {
    // A grey gradient, 2 × 1 texels, in the simplest of formats.
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    bytes.extend([128, 128, 128, 128, 128, 128, 128, 130]);
    PictureFile::from_bytes("gradient.hdr", bytes, &Limits::default()).unwrap()
}

fn finish<S: Clone + PartialEq>(document: &mut Document<S>) {
    if let Some(job) = document.finish_images() {
        assert!(document.apply_images(job.run()));
    }
    assert!(document.finish_images().is_none() || document.in_gesture());
}

fn apply(document: &mut Document<u8>, deed: &Deed, file: &Arc<PictureFile>) {
    let ids: Vec<LightId> = document.ids().collect();
    let pick = |i: usize| ids.get(i % ids.len().max(1)).copied();
    let change = |document: &mut Document<u8>, i: usize, with: &dyn Fn(&mut Light)| {
        if let Some(id) = pick(i) {
            let mut light = document.light(id).unwrap().clone();
            with(&mut light);
            let before = Arc::clone(document.scene());
            if document.set_light(id, light.clone()).is_ok() {
                assert_eq!(document.light(id), Some(&light));
            } else {
                assert!(Arc::ptr_eq(&before, document.scene()));
            }
        }
    };
    let corner = |light: &Light, k: usize| {
        let count: usize = light.loops.iter().map(Vec::len).sum();
        let mut vertex = k % count;
        let mut loop_index = 0;
        while vertex >= light.loops[loop_index].len() {
            vertex -= light.loops[loop_index].len();
            loop_index += 1;
        }
        Corner { loop_index, vertex }
    };
    match *deed {
        Deed::Move(i, v) => change(document, i, &|light| *light = light.moved(v.into())),
        Deed::Turn(i, v, a) => change(document, i, &|light| *light = light.turned(v.into(), a)),
        Deed::Scale(i, x, y) => change(document, i, &|light| *light = light.scaled(x, y).unwrap()),
        Deed::MoveVertex(i, k, p) => change(document, i, &|light| {
            let corner = corner(light, k);
            assert!(outline::move_vertex(&mut light.loops, corner, p.into()));
        }),
        Deed::InsertVertex(i, k, p) => change(document, i, &|light| {
            let corner = corner(light, k);
            assert!(outline::insert_vertex(&mut light.loops, corner, p.into()).is_some());
        }),
        Deed::DeleteVertex(i, k) => change(document, i, &|light| {
            let corner = corner(light, k);
            outline::delete_vertex(&mut light.loops, corner);
        }),
        Deed::Hole(i, size) => change(document, i, &|light| {
            let points = [(0., 0.), (size, 0.), (0., size)].map(DVec2::from).to_vec();
            outline::add_hole(&mut light.loops, points);
        }),
        Deed::Color(i, color, sides) => change(document, i, &|light| {
            light.radiance = color.into();
            light.two_sided = sides;
        }),
        Deed::Picture(i, fit) => change(document, i, &|light| {
            let fit = if fit {
                PictureFit::Cropped
            } else {
                PictureFit::Stretched
            };
            *light = light.with_picture(file, fit);
        }),
        Deed::NoPicture(i) => change(document, i, &|light| *light = light.without_picture()),
        Deed::Add(i) => {
            let frame = plane_frame(
                DVec3::new(i as f64, -4.0, 1.0),
                DVec3::new(0.3, 1.0, i as f64),
            );
            let preset = match i % 4 {
                0 => Preset::Ring {
                    diameter: 1.0,
                    hole: 0.5,
                },
                1 => Preset::Star {
                    points: 5,
                    diameter: 1.0,
                },
                2 => Preset::Letter {
                    character: 'i',
                    height: 0.5,
                },
                _ => Preset::Rectangle {
                    width: 2.0,
                    height: 0.5,
                },
            };
            document.add_light(preset.light(frame).unwrap()).unwrap();
        }
        Deed::Duplicate(i) => {
            if let Some(id) = pick(i) {
                let copy = document.duplicate(id).unwrap();
                assert_eq!(document.light(copy), document.light(id));
            }
        }
        Deed::Remove(i) => {
            if let Some(id) = pick(i) {
                document.remove_light(id);
                assert_eq!(document.light(id), None);
            }
        }
        Deed::Settings(value) => document.set_settings(value),
        Deed::Begin => document.begin("gesture"),
        Deed::End => document.end(),
        Deed::Cancel => document.cancel(),
        Deed::Undo => {
            document.undo();
        }
        Deed::Redo => {
            document.redo();
        }
        Deed::Finish => finish(document),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn edits_keep_the_scene_sound_and_undo_and_redo_are_exact(
        deeds in prop::collection::vec(deed(), 1..24),
    ) {
        let first = scene();
        let mut document: Document<u8> = Document::new(first.clone());
        let file = picture();
        for deed in &deeds {
            let version = document.version();
            let before = Arc::clone(document.scene());
            apply(&mut document, deed, &file);
            assert_sound(&document);
            prop_assert!(version != document.version() || Arc::ptr_eq(&before, document.scene()));
        }
        document.end();
        finish(&mut document);
        // Forward to the newest state.
        while document.redo().is_some() {}
        finish(&mut document);
        let last = Scene::clone(document.scene());
        let lights: Vec<(LightId, Light)> = document.lights().map(|(id, light)| (id, light.clone())).collect();
        let settings = *document.settings();
        let mut steps = 0;
        while document.undo().is_some() {
            finish(&mut document);
            assert_sound(&document);
            steps += 1;
        }
        prop_assert_eq!(&**document.scene(), &first);
        prop_assert!(document.scene().meshes.len() == 3 && document.is_saved());
        prop_assert_eq!(*document.settings(), 0);
        for _ in 0..steps {
            prop_assert!(document.redo().is_some());
            finish(&mut document);
        }
        prop_assert!(document.redo().is_none());
        prop_assert_eq!(&**document.scene(), &last);
        prop_assert_eq!(*document.settings(), settings);
        let again: Vec<(LightId, Light)> = document.lights().map(|(id, light)| (id, light.clone())).collect();
        prop_assert_eq!(again, lights);
    }
}
