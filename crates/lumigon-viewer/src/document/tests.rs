use std::time::Instant;

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3, Vec4};
use lumigon_renderer::{AlphaMode, Material, Mesh, Texture, TextureRef};
use proptest::prelude::*;

use super::properties::{assert_sound, picture};
use super::*;

fn scene(name: &str) -> Scene {
    let scenes = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::load(scenes.join(name)).unwrap()
}

fn own_scene() -> Scene {
    properties::scene()
}

/// One vertex more, on an edge: the shape stays, its faces are made anew.
fn add_middle(light: &mut Light) {
    let edge = outline::Corner {
        loop_index: 0,
        vertex: 0,
    };
    let [a, b] = outline::edge(&light.loops, edge).unwrap();
    outline::insert_vertex(&mut light.loops, edge, (a + b) * 0.5);
}

/// How far the loops of two outlines lie apart, vertex by vertex, wherever they begin.
fn distance(a: &[Vec<[f64; 3]>], b: &[Vec<[f64; 3]>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let of_loops = |(a, b): (&Vec<[f64; 3]>, &Vec<[f64; 3]>)| {
        assert_eq!(a.len(), b.len());
        let turned = |turn: usize| {
            let pairs = a.iter().zip(b.iter().cycle().skip(turn));
            let apart = pairs.map(|(&p, &q)| DVec3::from(p).distance(q.into()));
            apart.fold(0.0, f64::max)
        };
        (0..a.len()).map(turned).fold(f64::INFINITY, f64::min)
    };
    a.iter().zip(b).map(of_loops).fold(0.0, f64::max)
}

#[test]
fn undo_brings_back_the_file_and_redo_what_was_made() {
    let scene = scene("cornell.glb");
    let mut document: Document = Document::new(scene.clone());
    let id = document.ids().next().unwrap();
    let polygon = scene.polygon_lights[document.polygons_of(id)][0].clone();
    let light = document.light(id).unwrap().moved(DVec3::new(0.1, 0.0, 0.0));
    document.set_light(id, light).unwrap();
    let moved = Arc::clone(document.scene());
    assert_eq!(moved.meshes.len(), scene.meshes.len() + 1);
    assert_eq!(moved.polygon_lights.len(), scene.polygon_lights.len());
    // Nothing else is touched.
    for (mesh, before) in scene.meshes.iter().enumerate() {
        assert!(mesh == polygon.mesh || Arc::ptr_eq(before, &moved.meshes[mesh]));
    }
    assert_eq!(moved.materials[..scene.materials.len()], scene.materials);
    assert!(!document.is_saved());
    assert_sound(&document);
    assert_eq!(document.can_undo(), Some("edit light"));
    assert_eq!(document.undo().as_deref(), Some("edit light"));
    assert_eq!(**document.scene(), scene);
    assert!(document.is_saved());
    assert_eq!(document.can_redo(), Some("edit light"));
    document.redo();
    assert_eq!(*document.scene(), moved);
    assert_eq!(
        (document.undo(), document.undo()),
        (Some("edit light".to_owned()), None)
    );
}

#[test]
fn a_gesture_is_one_step_and_one_that_comes_back_is_none() {
    let mut document: Document = Document::new(own_scene());
    let id = document.ids().nth(1).unwrap();
    let start = document.light(id).unwrap().clone();
    document.begin("drag");
    for i in 1..=10 {
        let version = document.version();
        let moved = start.moved(DVec3::X * f64::from(i));
        document.set_light(id, moved).unwrap();
        assert_ne!(document.version(), version);
    }
    document.end();
    assert_eq!(document.scene().meshes.len(), 4);
    document.begin("there and back");
    document.set_light(id, start.clone()).unwrap();
    document
        .set_light(id, start.moved(DVec3::X * 10.0))
        .unwrap();
    document.end();
    assert_eq!(document.can_undo(), Some("drag"));
    document.begin("dropped");
    document.set_light(id, start.moved(DVec3::Y)).unwrap();
    let first = document.ids().next().unwrap();
    document.remove_light(first);
    document.cancel();
    assert_eq!(document.light(id), Some(&start.moved(DVec3::X * 10.0)));
    assert_eq!(document.undo().as_deref(), Some("drag"));
    assert_eq!(
        (document.can_undo(), document.light(id)),
        (None, Some(&start))
    );
    // A new edit forgets what was undone.
    document.set_light(id, start.moved(DVec3::Z)).unwrap();
    assert_eq!(document.can_redo(), None);
}

#[test]
fn what_is_no_light_is_refused() {
    let mut document: Document = Document::new(own_scene());
    let id = document.ids().next().unwrap();
    let light = document.light(id).unwrap().clone();
    let before = Arc::clone(document.scene());
    let mut crossed = light.clone();
    crossed.loops[0].swap(0, 1);
    let crossed = document.set_light(id, crossed);
    assert!(
        matches!(crossed, Err(EditError::Outline(OutlineFault::Crossing(_)))),
        "{crossed:?}"
    );
    let with = |change: &dyn Fn(&mut Light)| {
        let mut light = light.clone();
        change(&mut light);
        light
    };
    let nan = with(&|light| light.radiance.y = f32::NAN);
    assert_eq!(document.set_light(id, nan), Err(EditError::Radiance));
    let negative = with(&|light| light.radiance.x = -1.0);
    assert_eq!(document.add_light(negative), Err(EditError::Radiance));
    let sheared = with(&|light| light.world_from_plane.matrix3.x_axis *= 2.0);
    assert_eq!(document.set_light(id, sheared), Err(EditError::Frame));
    let mirrored = with(&|light| light.world_from_plane.matrix3.z_axis *= -1.0);
    assert_eq!(document.set_light(id, mirrored), Err(EditError::Frame));
    for far in [f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(
            document.set_light(id, light.moved(DVec3::X * far)),
            Err(EditError::Frame)
        );
    }
    // In single precision its corners fall together.
    assert_eq!(
        document.set_light(id, light.moved(DVec3::X * 1e12)),
        Err(EditError::Vanishes)
    );
    let no_loops = with(&|light| light.loops.clear());
    assert_eq!(
        document.add_light(no_loops),
        Err(EditError::Outline(OutlineFault::NoLoop))
    );
    let elsewhere = LightId(1000);
    assert_eq!(
        document.set_light(elsewhere, light.clone()),
        Err(EditError::NoSuchLight)
    );
    assert_eq!(document.duplicate(elsewhere), Err(EditError::NoSuchLight));
    document.remove_light(elsewhere);
    assert!(Arc::ptr_eq(document.scene(), &before));
    assert_eq!((document.can_undo(), document.version()), (None, 0));
    assert_eq!(document.lights().count(), 5);
}

/// Every light of the shipped scenes, put on a mesh of its own, lights as before.
#[test]
fn lights_of_files_come_back_from_their_own_meshes() {
    for name in [
        "cornell.glb",
        "gallery.glb",
        "neon.glb",
        "screens.glb",
        "stained-glass.glb",
    ] {
        let scene = scene(name);
        let mut document: Document = Document::new(scene.clone());
        let ids: Vec<LightId> = document.ids().collect();
        for &id in &ids {
            let mut light = document.light(id).unwrap().clone();
            assert_eq!(light.can_reshape(), Ok(()), "{name}: {}", light.name);
            assert!(light.centroid().length() <= 1e-9);
            add_middle(&mut light);
            document.set_light(id, light).unwrap();
        }
        assert_sound(&document);
        if let Some(job) = document.finish_images() {
            assert!(document.apply_images(job.run()));
        }
        for (id, before) in ids.into_iter().zip(&scene.polygon_lights) {
            let light = document.light(id).unwrap();
            assert!((light.area() - before.area()).abs() <= 1e-9 * before.area());
            let polygons = &document.scene().polygon_lights[document.polygons_of(id)];
            let [after] = polygons else {
                panic!("{name}: {} polygons", polygons.len())
            };
            let apart = distance(&before.loops, &after.loops);
            assert!(apart <= 2e-6, "{name}: {} is {apart} m off", before.name);
            assert!(
                (after.area() - before.area()).abs() <= 1e-5 * before.area(),
                "{name}: {} {}",
                after.area(),
                before.area()
            );
            let difference = (after.radiance - before.radiance).abs().max_element();
            assert!(
                difference <= 1e-4 * before.radiance.max_element(),
                "{name}: {} {}",
                before.radiance,
                after.radiance
            );
            assert_eq!(
                after.image.is_some(),
                before.image.is_some(),
                "{name}: {}",
                before.name
            );
            let (Some(a), Some(b)) = (&before.image, &after.image) else {
                continue;
            };
            assert_eq!(
                (a.size, a.strength),
                (b.size, b.strength),
                "{name}: {}",
                before.name
            );
            for &p in before.loops.iter().flatten() {
                let uv = |image: &lumigon_renderer::EmissiveImage| {
                    image.emission.map(|placed| DVec2::from(placed.map.uv(p)))
                };
                let (Some(a), Some(b)) = (uv(a), uv(b)) else {
                    panic!("{name}: a picture without texture")
                };
                let apart = a - b;
                // Whole repeats apart shows the same.
                assert!((apart - apart.round()).length() < 1e-4, "{name}: {a} {b}");
            }
        }
        assert_sound(&document);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn outlines_come_back_from_meshes(
        radii in prop::collection::vec(0.6..1.0_f64, 3..40),
        holes in prop::collection::vec(0.02..0.09_f64, 0..4),
        normal in [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0],
        origin in [-3.0..3.0_f64, -3.0..3.0, -3.0..3.0],
        size in 0.1..10.0_f64,
        radiance in [0.0..9.0_f32, 0.0..9.0, 0.1..9.0],
    ) {
        let step = std::f64::consts::TAU / radii.len() as f64;
        let outer: Vec<DVec2> = radii
            .iter()
            .enumerate()
            .map(|(i, r)| DVec2::from_angle(step * i as f64) * *r * size)
            .collect();
        let mut loops = vec![outer];
        // Diamonds inside the least triangle that three radii make.
        for (i, r) in holes.iter().enumerate() {
            let center = DVec2::new(0.13 * (i % 2) as f64, 0.13 * (i / 2) as f64) * size;
            let corner = |k: u32| center + DVec2::from_angle(-f64::from(k) * 0.5 * std::f64::consts::PI) * *r * 0.6 * size;
            loops.push((0..4).map(corner).collect());
        }
        prop_assume!(check(&loops).is_ok());
        let frame = plane_frame(origin.into(), normal.into());
        let mut light = Light::new("lamp", frame, loops);
        light.radiance = radiance.into();
        let mut document: Document = Document::new(Scene::default());
        let id = document.add_light(light.clone()).unwrap();
        let polygons = &document.scene().polygon_lights[document.polygons_of(id)];
        prop_assert_eq!(polygons.len(), 1);
        let polygon = &polygons[0];
        prop_assert_eq!(polygon.radiance, light.radiance);
        prop_assert_eq!(polygon.loops.len(), light.loops.len());
        // Positions are rounded to single precision, of the largest coordinate.
        let scale = DVec3::from(origin).length() + size;
        prop_assert!((polygon.area() - light.area()).abs() <= 1e-6 * light.area() * (scale / size));
        let expected: Vec<Vec<[f64; 3]>> = light
            .loops
            .iter()
            .map(|points| points.iter().map(|&p| light.to_world(p).to_array()).collect())
            .collect();
        // Vertices on a line, within rounding, are dropped; all others are there.
        let to_boundary = |p: DVec3, loops: &[Vec<[f64; 3]>]| {
            let edges = loops.iter().flat_map(|e| e.iter().zip(e.iter().cycle().skip(1)));
            let apart = edges.map(|(&a, &b)| {
                let (a, b) = (DVec3::from(a), DVec3::from(b));
                let t = (p - a).dot(b - a) / (b - a).length_squared();
                p.distance(a.lerp(b, t.clamp(0.0, 1.0)))
            });
            apart.fold(f64::INFINITY, f64::min)
        };
        for (points, others) in [(&polygon.loops, &expected), (&expected, &polygon.loops)] {
            for &p in points.iter().flatten() {
                let apart = to_boundary(p.into(), others);
                prop_assert!(apart <= 1e-6 * scale, "{apart}");
            }
        }
        // And from the polygon to a light again.
        let again = Document::<()>::new(Scene::clone(document.scene()));
        let (_, read) = again.lights().next().unwrap();
        prop_assert!((read.area() - light.area()).abs() <= 1e-6 * light.area() * (scale / size));
        prop_assert!((read.normal() - light.normal()).length() < 1e-6 * scale / size);
    }
}

#[test]
fn presets_become_lights_that_are_found_again() {
    let mut document: Document = Document::new(own_scene());
    let frame = plane_frame(DVec3::new(0.0, 9.0, 0.0), DVec3::Z);
    let letter = Preset::Letter {
        character: 'B',
        height: 1.0,
    }
    .light(frame)
    .unwrap();
    let id = document.add_light(letter).unwrap();
    let i = Preset::Letter {
        character: 'i',
        height: 1.0,
    }
    .light(frame)
    .unwrap();
    let both = document.add_light(i.moved(DVec3::X * 2.0)).unwrap();
    // The dot is a light of its own in the scene, not here.
    assert_eq!(
        (
            document.polygons_of(id).len(),
            document.polygons_of(both).len()
        ),
        (1, 2)
    );
    assert_eq!(
        document.scene().polygon_lights[document.polygons_of(id)][0].hole_count(),
        2
    );
    assert_sound(&document);
    let copy = document.duplicate(id).unwrap();
    assert_eq!(document.can_undo(), Some("duplicate light"));
    document.remove_light(id);
    assert_eq!(document.can_undo(), Some("remove light"));
    assert!(document.light(copy).is_some() && document.light(id).is_none());
    assert_sound(&document);
    let flux = flux::luminance(document.flux_of(copy).as_vec3());
    let expected = document.light(copy).unwrap().lumens();
    assert!(
        (flux - expected).abs() < 1e-5 * expected,
        "{flux} {expected}"
    );
}

#[test]
fn removing_one_light_of_a_mesh_leaves_the_others_theirs() {
    let mut document: Document = Document::new(own_scene());
    let ids: Vec<LightId> = document.ids().collect();
    document.remove_light(ids[1]);
    assert_eq!(document.scene().meshes[0].triangles.len(), 6);
    assert_sound(&document);
    assert_eq!(document.light_at(0, 2), document.light_at(0, 3));
    let light = document.light(ids[0]).unwrap().moved(DVec3::Y * -4.0);
    document.set_light(ids[0], light).unwrap();
    document.remove_light(ids[3]);
    document.remove_light(ids[2]);
    // The mesh keeps its place.
    assert_eq!(document.scene().meshes[0].positions.len(), 0);
    assert_eq!(document.scene().meshes[0].name, "panels");
    assert_eq!(document.scene().meshes.len(), 4);
    assert_eq!(
        document.lights().map(|(id, _)| id).collect::<Vec<_>>(),
        [ids[0], ids[4]]
    );
    assert_eq!(document.light_at(3, 0), Some(ids[0]));
    assert_eq!(document.light_at(2, 0), None);
    assert_sound(&document);
}

#[test]
fn a_dropped_picture_stands_upright_and_is_finished_beside() {
    let mut document: Document = Document::new(own_scene());
    let id = document.ids().next().unwrap();
    let file = picture();
    let light = document
        .light(id)
        .unwrap()
        .with_picture(&file, PictureFit::Stretched);
    document.begin("drop");
    document.set_light(id, light.clone()).unwrap();
    document.set_light(id, light.moved(DVec3::X)).unwrap();
    assert!(document.finish_images().is_none());
    document.end();
    assert_eq!(document.picture_files().collect::<Vec<_>>(), [(1, &file)]);
    let job = document.finish_images().unwrap();
    let late = document.finish_images().unwrap();
    let made = job.run();
    let version = document.version();
    assert!(document.apply_images(made));
    assert_ne!(document.version(), version);
    assert!(document.finish_images().is_none());
    // What it was made for is gone.
    assert!(!document.apply_images(late.run()));
    assert_sound(&document);

    let scene = document.scene();
    let polygon = &scene.polygon_lights[document.polygons_of(id)][0];
    let image = polygon.image.unwrap();
    assert_eq!(image.strength, light.radiance);
    // Dark on the left, four times as bright on the right, seen from the front.
    let seen = |x: f64| {
        let at = document.light(id).unwrap().to_world(DVec2::new(x, 0.0));
        image.color(&scene.textures, at.to_array())[0]
    };
    assert!((seen(0.9) / seen(-0.9) - 4.0).abs() < 1e-4);
    let up = DVec3::from(image.edge_v);
    assert!(up.normalize().y < -0.999);
    assert!(document.is_sound_for_rays(id));

    // A second light with the same file shares its texture; without it, one colour is left.
    let copy = document.duplicate(id).unwrap();
    assert_eq!(document.scene().textures.len(), 2);
    let plain = document.light(copy).unwrap().without_picture();
    document.set_light(copy, plain).unwrap();
    let polygon = &document.scene().polygon_lights[document.polygons_of(copy)][0];
    assert_eq!((polygon.image, polygon.radiance), (None, light.radiance));
    while document.undo().is_some() {}
    assert_eq!(
        (
            document.scene().textures.len(),
            document.picture_files().count()
        ),
        (1, 0)
    );
}

impl<S: Clone + PartialEq> Document<S> {
    /// Whether rays that meet a light's face see what its polygon shows there.
    fn is_sound_for_rays(&self, id: LightId) -> bool {
        let scene = self.scene();
        self.polygons_of(id).all(|index| {
            let polygon = &scene.polygon_lights[index];
            let mesh = &scene.meshes[polygon.mesh];
            polygon.triangles.iter().all(|&t| {
                let [a, b, c] = mesh.corners(t as usize).map(Vec3::as_dvec3);
                let barycentric = Vec2::new(0.3, 0.45);
                let p = a + (b - a) * f64::from(barycentric.x) + (c - a) * f64::from(barycentric.y);
                let view = self.light(id).unwrap().normal().as_vec3();
                let seen = scene
                    .surface(polygon.mesh, t as usize, barycentric, -view)
                    .emissive;
                let shown = match &polygon.image {
                    Some(image) => {
                        Vec3::from(image.color(&scene.textures, p.to_array())) * image.strength
                    }
                    None => polygon.radiance,
                };
                (seen - shown).length() <= 1e-3 * shown.length() + 1e-6
            })
        })
    }
}

#[test]
fn textures_move_with_a_light_and_stay_where_an_outline_changes() {
    let mut document: Document = Document::new(own_scene());
    let id = document.ids().nth(4).unwrap();
    let light = document.light(id).unwrap().clone();
    let shown = light.picture.as_ref().unwrap();
    assert_eq!(shown.image, PictureImage::Scene(0));
    // Moved alone, it needs no image to be read again.
    let mut only_turned = light
        .turned(DVec3::new(-1.0, 0.3, 0.5), 1.7)
        .moved(DVec3::X);
    only_turned.radiance *= 2.0;
    document.set_light(id, only_turned).unwrap();
    assert!(document.finish_images().is_none());
    assert!(document.is_sound_for_rays(id));
    assert_sound(&document);
    let (shown, before) = (
        document.polygons_of(id).start,
        &own_scene().polygon_lights[4],
    );
    let shown = document.scene().polygon_lights[shown].clone();
    assert_eq!(shown.image.unwrap().size, before.image.unwrap().size);
    let read = &document
        .scene()
        .lights_of_mesh(shown.mesh, &Limits::default())
        .0[0];
    let difference = (read.radiance - shown.radiance).abs().max_element();
    assert!(difference < 1e-5 && (read.area() - shown.area()).abs() < 1e-5);
    let (shown, read) = (shown.image.unwrap(), read.image.unwrap());
    assert_eq!(shown.strength, read.strength);
    for (a, b) in [
        (shown.corner, read.corner),
        (shown.edge_u, read.edge_u),
        (shown.edge_v, read.edge_v),
    ] {
        assert!(DVec3::from(a).distance(b.into()) < 1e-5);
    }

    let turned = light
        .turned(DVec3::new(1.0, 2.0, 0.5), 0.7)
        .scaled(2.0, 0.5)
        .unwrap();
    document.set_light(id, turned.clone()).unwrap();
    let coarse = document.scene().polygon_lights[document.polygons_of(id)][0].clone();
    let job = document.finish_images().unwrap();
    assert!(document.apply_images(job.run()));
    let polygon = document.scene().polygon_lights[document.polygons_of(id)][0].clone();
    let before = &own_scene().polygon_lights[4];
    let difference = (polygon.radiance - before.radiance).abs().max_element();
    assert!(
        difference < 1e-5,
        "{} {}",
        polygon.radiance,
        before.radiance
    );
    // Until then it is close.
    let (image, finer) = (coarse.image.unwrap(), polygon.image.unwrap());
    assert_eq!((coarse.loops, image.size), (polygon.loops, finer.size));
    let apart = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).distance(b.into());
    assert!(apart(image.corner, finer.corner) < 1e-5 && apart(image.edge_u, finer.edge_u) < 1e-5);
    let difference = (coarse.radiance - before.radiance).abs().max_element();
    assert!(
        difference < 0.02 * before.radiance.max_element(),
        "{}",
        coarse.radiance
    );
    assert!(document.is_sound_for_rays(id));
    assert_sound(&document);

    // Cut to its left half: the texture's left half is shown.
    let mut half = light.clone();
    for p in &mut half.loops[0] {
        p.x = p.x.min(0.0);
    }
    document.set_light(id, half).unwrap();
    let job = document.finish_images().unwrap();
    assert!(document.apply_images(job.run()));
    let image = document.scene().polygon_lights[document.polygons_of(id)][0]
        .image
        .unwrap();
    let placed = image.emission.unwrap();
    let end = DVec3::from(image.corner) + DVec3::from(image.edge_u);
    assert!((placed.map.uv(image.corner)[0]).abs() < 1e-6);
    assert!((placed.map.uv(end.to_array())[0] - 0.5).abs() < 1e-6);
    assert!(document.is_sound_for_rays(id));
}

#[test]
fn what_no_other_outline_could_carry_stays() {
    let mut scene = own_scene();
    // The base colour of one panel lies on its halves differently, and its mask with it.
    let texcoords = (0..16).map(|i| Vec2::new((i % 3) as f32 * 0.3, (i * i % 5) as f32 * 0.2));
    let mut panels = Mesh::clone(&scene.meshes[0]);
    panels.texcoords[0] = texcoords.collect();
    panels.colors = vec![Vec4::ONE; 16];
    scene.meshes[0] = Arc::new(panels);
    scene.materials[0] = Material {
        base_color_texture: Some(TextureRef::default()),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..scene.materials[0].clone()
    };
    let mut document: Document = Document::new(scene);
    let id = document.ids().next().unwrap();
    let light = document.light(id).unwrap().clone();
    assert!(light.can_reshape().is_err());
    let mut cut = light.clone();
    cut.loops[0].pop();
    assert!(matches!(
        document.set_light(id, cut),
        Err(EditError::Fixed(_))
    ));
    let mut changed = light
        .moved(DVec3::Z)
        .turned(DVec3::X, 0.3)
        .scaled(2.0, 3.0)
        .unwrap();
    changed.radiance = Vec3::ONE;
    document.set_light(id, changed.recentred()).unwrap();
    assert_sound(&document);
    let polygon = &document.scene().polygon_lights[document.polygons_of(id)][0];
    assert!((polygon.area() - 6.0 * light.area()).abs() < 1e-5);
    let mesh = &document.scene().meshes[polygon.mesh];
    assert_eq!(mesh.texcoords[0].len(), mesh.positions.len());
    assert!(document.light(id).unwrap().can_reshape().is_err());
    let pictured = document
        .light(id)
        .unwrap()
        .with_picture(&picture(), PictureFit::Cropped);
    document.set_light(id, pictured).unwrap();
    assert_sound(&document);
}

#[test]
fn settings_are_undone_too() {
    let mut document: Document<u8> = Document::new(own_scene());
    let scene = Arc::clone(document.scene());
    document.begin("exposure");
    for value in 1..5 {
        document.set_settings(value);
    }
    document.end();
    document.set_settings(4);
    document.set_settings(9);
    assert!(Arc::ptr_eq(document.scene(), &scene));
    assert_eq!(document.undo().as_deref(), Some("settings"));
    assert_eq!(*document.settings(), 4);
    assert_eq!(document.undo().as_deref(), Some("exposure"));
    assert_eq!((*document.settings(), document.undo()), (0, None));
}

#[test]
fn dark_lights_can_be_lit_again() {
    let mut document: Document = Document::new(own_scene());
    let id = document.ids().next().unwrap();
    let mut light = document.light(id).unwrap().clone();
    let radiance = std::mem::replace(&mut light.radiance, Vec3::ZERO);
    document.set_light(id, light.clone()).unwrap();
    assert!(document.polygons_of(id).is_empty());
    assert_eq!(document.light_at(3, 0), Some(id));
    assert_sound(&document);
    light.radiance = radiance;
    document.set_light(id, light).unwrap();
    assert_eq!(document.polygons_of(id).len(), 1);
}

/// Five thousand lights: nothing is read before it is asked for, and an edit does not read them all.
#[test]
fn many_lights_cost_little() {
    let mut scene = own_scene();
    for k in 0..5000_u16 {
        let place = DVec3::new(f64::from(k % 100), f64::from(k / 100), -9.0);
        let light = Preset::Rectangle {
            width: 0.5,
            height: 0.5,
        }
        .loops()
        .unwrap();
        let light = Light::new("tile", DAffine3::from_translation(place), light);
        let (mesh, _) = faces::faces(&light, 0, None);
        scene.meshes.push(Arc::new(mesh));
        let (lights, _) = scene.lights_of_mesh(scene.meshes.len() - 1, &Limits::default());
        scene.polygon_lights.extend(lights);
    }
    let start = Instant::now();
    let mut document: Document = Document::new(scene);
    let opened = start.elapsed();
    let id = document.ids().nth(2500).unwrap();
    let light = document.light(id).unwrap().clone();
    document.begin("drag");
    document.set_light(id, light.moved(DVec3::X)).unwrap();
    let start = Instant::now();
    let count = 100;
    for i in 0..count {
        document
            .set_light(id, light.moved(DVec3::Y * f64::from(i)))
            .unwrap();
    }
    let edit = start.elapsed() / count;
    document.end();
    let start = Instant::now();
    assert_eq!(document.lights().count(), 5005);
    let read = start.elapsed();
    // Scenes that somebody holds stay as they are.
    let held = Arc::clone(document.scene());
    let copy = Scene::clone(&held);
    for i in 0..4 {
        document
            .set_light(id, light.moved(DVec3::Z * f64::from(i)))
            .unwrap();
    }
    while document.undo().is_some() {}
    assert_eq!(*held, copy);
    println!("opened in {opened:?}, an edit {edit:?}, all lights read in {read:?}");
    assert!(opened.as_millis() < 50 && edit.as_micros() < 2000 && read.as_millis() < 500);
}

#[test]
fn a_large_texture_does_not_slow_a_drag() {
    let mut scene = own_scene();
    let texels = (0..1_u32 << 22).map(|i| (i.wrapping_mul(2_654_435_761)).to_le_bytes());
    let sampler = scene.textures[0].sampler;
    let large = Texture::from_rgba8("", [2048; 2], texels.collect(), true, sampler);
    scene.textures[0] = large.unwrap();
    scene.polygon_lights[4] = scene.lights_of_mesh(1, &Limits::default()).0.remove(0);
    let mut document: Document = Document::new(scene);
    let id = document.ids().nth(4).unwrap();
    let mut light = document.light(id).unwrap().clone();
    document.begin("drag");
    let start = Instant::now();
    let count = 20;
    for _ in 0..count {
        light.loops[0][2] += DVec2::splat(0.01);
        document.set_light(id, light.clone()).unwrap();
    }
    let edit = start.elapsed() / count;
    document.end();
    let start = Instant::now();
    let images = document.finish_images().unwrap().run();
    println!("an edit {edit:?}, finishing {:?}", start.elapsed());
    assert!(document.apply_images(images));
    assert!(edit.as_millis() < 10, "{edit:?}");
}

#[test]
fn a_picture_is_upright_whichever_way_the_axes_run() {
    let frame = plane_frame(DVec3::new(1.0, 2.0, 3.0), DVec3::X);
    let preset = Preset::Rectangle {
        width: 3.0,
        height: 1.0,
    };
    let light = preset.light(frame).unwrap();
    let file = picture();
    for fit in [PictureFit::Cropped, PictureFit::Stretched] {
        for quarters in 0..4 {
            let turned = light.with_axes_turned(f64::from(quarters) * std::f64::consts::FRAC_PI_2);
            let shown = turned.with_picture(&file, fit).picture.unwrap();
            let uv = |x: f64, y: f64| {
                let at = turned.to_plane(light.to_world(DVec2::new(x, y)));
                shown.texture_from_plane.transform_point2(at)
            };
            // The image is twice as wide as high, the light three times: cropped, above and below.
            let top = if fit == PictureFit::Cropped {
                1.0 / 6.0
            } else {
                0.0
            };
            assert!(
                uv(-1.5, 0.5).distance(DVec2::new(0.0, top)) < 1e-12,
                "{}",
                uv(-1.5, 0.5)
            );
            assert!(uv(1.5, -0.5).distance(DVec2::new(1.0, 1.0 - top)) < 1e-12);
        }
    }
}

#[test]
fn the_oldest_steps_are_forgotten() {
    let mut document: Document<u32> = Document::new(Scene::default());
    for value in 1..=1100 {
        document.set_settings(value);
    }
    let mut steps = 0;
    while document.undo().is_some() {
        steps += 1;
    }
    assert_eq!((steps, *document.settings()), (1000, 100));
    // Settings are not in what is saved.
    assert!(document.is_saved());
}

#[test]
fn pictures_keep_to_the_memory_that_they_may_have() {
    let limits = Limits {
        light_image_bytes: 64 * 32 * 22,
        ..Limits::default()
    };
    let mut scene = own_scene();
    let texels = vec![[255, 0, 0, 255]; 512 * 512 - 1]
        .into_iter()
        .chain([[0, 0, 255, 255]]);
    let sampler = scene.textures[0].sampler;
    let large = Texture::from_rgba8("", [512; 2], texels.collect(), true, sampler);
    scene.textures[0] = large.unwrap();
    let mut document = Document::with_settings(scene, (), limits);
    let id = document.ids().nth(4).unwrap();
    let light = document.light(id).unwrap().scaled(2.0, 2.0).unwrap();
    document.set_light(id, light).unwrap();
    let job = document.finish_images().unwrap();
    assert!(document.apply_images(job.run()));
    let image = document.scene().polygon_lights[document.polygons_of(id)][0]
        .image
        .unwrap();
    assert_eq!(image.size, [64; 2]);
}

#[test]
fn a_picture_that_cannot_be_read_says_which_and_why() {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits::default();
    let path = folder.path().join("broken.png");
    for write in [false, true] {
        if write {
            std::fs::write(&path, b"\x89PNG\r\n\x1a\nand no more").unwrap();
        }
        let fault = PictureFile::read(&path, &limits).unwrap_err();
        assert!(
            fault.path.ends_with("broken.png") && !fault.mend.is_empty(),
            "{fault}"
        );
    }
    let good = folder.path().join("good.hdr");
    std::fs::write(&good, &picture().bytes).unwrap();
    let read = PictureFile::read(&good, &limits).unwrap();
    assert_eq!(
        (read.name.as_str(), &read.bytes),
        ("good.hdr", &picture().bytes)
    );
    assert_eq!(read.image.size, [2, 1]);
}

/// Lights that were put on their own meshes light a picture as before; what was removed does not.
#[test]
fn edited_scenes_render() {
    use lumigon_renderer::{CpuRenderer, RenderSettings, Watch};

    let scene = scene("screens.glb");
    let camera = scene.cameras[0].clone();
    let settings = RenderSettings {
        width: 48,
        height: 30,
        samples: 1,
        specular: lumigon::SpecularMethod::None,
        ..RenderSettings::default()
    };
    let render = |scene: &Scene| -> Vec<[f32; 3]> {
        let renderer = CpuRenderer::new(scene);
        let warnings = renderer.warnings();
        assert!(
            warnings.iter().all(|w| !w.contains("lights nothing")),
            "{warnings:?}"
        );
        let rendering = renderer.render(&camera, &settings, Watch::none()).unwrap();
        let pixels: Vec<[f32; 3]> = rendering
            .diffuse
            .iter()
            .map(|p| [p[0], p[1], p[2]])
            .collect();
        assert!(pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
        pixels
    };
    let sum = |pixels: &[[f32; 3]]| -> f64 { pixels.iter().flatten().map(|&x| f64::from(x)).sum() };
    let before = render(&scene);
    let mut document: Document = Document::new(scene);
    let ids: Vec<LightId> = document.ids().collect();
    for &id in &ids {
        let mut light = document.light(id).unwrap().clone();
        add_middle(&mut light);
        document.set_light(id, light).unwrap();
    }
    let coarse = render(document.scene());
    let job = document.finish_images().unwrap();
    assert!(document.apply_images(job.run()));
    let after = render(document.scene());
    let apart = |pixels: &[[f32; 3]]| -> f64 {
        let pairs = pixels.as_flattened().iter().zip(before.as_flattened());
        pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / sum(&before)
    };
    println!("coarse {}, finished {}", apart(&coarse), apart(&after));
    assert!(apart(&after) < 1e-4, "{}", apart(&after));
    assert!(apart(&coarse) < 0.05, "{}", apart(&coarse));
    // A few are removed, one gets a letter's shape; meshes without triangles stay behind.
    document.remove_light(ids[0]);
    let mut light = document.light(ids[1]).unwrap().clone();
    light.loops = Preset::Letter {
        character: 'R',
        height: 0.5,
    }
    .loops()
    .unwrap();
    document.set_light(ids[1], light).unwrap();
    assert!(sum(&render(document.scene())) < sum(&before));
    for &id in &ids[1..] {
        document.remove_light(id);
    }
    assert_eq!(sum(&render(document.scene())), 0.0);
}
