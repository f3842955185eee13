//! Lights that were edited in a document, saved, and read again.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use lumigon_renderer::{
    Camera, CpuRenderer, EmissivePolygon, GltfSource, Limits, LoadWatch, RenderSettings, Scene,
    ToneMap, Watch, srgb8,
};
use lumigon_viewer::document::{
    Document as AnyDocument, Light, LightId, PictureFile, PictureFit, Preset,
};

type Document = AnyDocument<()>;

fn open(name: &str) -> (Document, Arc<Scene>, GltfSource) {
    let scenes = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    load(&scenes.join(name))
}

fn load(path: &std::path::Path) -> (Document, Arc<Scene>, GltfSource) {
    let (limits, watch) = (Limits::default(), LoadWatch::none());
    let (scene, source) = Scene::load_watched(path, &limits, watch).unwrap();
    let document = Document::new(scene);
    let original = Arc::clone(document.scene());
    (document, original, source)
}

fn frames(document: &Document) -> HashMap<usize, DAffine3> {
    let of = |id| {
        let light = document.light(id)?;
        Some((document.own_mesh(id)?, light.world_from_plane))
    };
    document.ids().filter_map(of).collect()
}

/// Saves a document and checks that what is read is what was seen.
fn check(document: &Document, original: &Scene, source: &GltfSource) -> Document {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("saved.glb");
    let seen = document.scene();
    source
        .save(original, seen, &frames(document), &path)
        .unwrap();
    let (read, _, _) = load(&path);
    let mut left: Vec<&EmissivePolygon> = read.scene().polygon_lights.iter().collect();
    assert_eq!(left.len(), seen.polygon_lights.len());
    for light in &seen.polygon_lights {
        let found = left.iter().position(|found| is_same(found, light));
        let found = found.unwrap_or_else(|| panic!("{} is not where it was", light.name));
        let found = left.remove(found);
        assert_eq!(found.name, light.name);
        assert!(
            found
                .radiance
                .abs_diff_eq(light.radiance, 1e-6 * light.radiance.max_element()),
            "{}: {} {}",
            light.name,
            found.radiance,
            light.radiance
        );
        let size = |light: &EmissivePolygon| light.image.as_ref().map(|image| image.size);
        assert_eq!(size(found), size(light), "{}", light.name);
    }
    let camera = seen.cameras.first().cloned();
    let camera = camera.unwrap_or_else(|| Camera::framing(seen));
    let (a, b) = (picture(read.scene(), &camera), picture(seen, &camera));
    let apart = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart <= Some(1), "{apart:?}");
    read
}

/// Whether two polygons are the same to 1e-5 of their size, wherever their loops begin.
fn is_same(a: &EmissivePolygon, b: &EmissivePolygon) -> bool {
    let near = 1e-5 * b.area().sqrt();
    let same_loop = |(a, b): (&Vec<[f64; 3]>, &Vec<[f64; 3]>)| {
        let same_from = |start: usize| {
            let mut pairs = a.iter().zip(b.iter().cycle().skip(start));
            pairs.all(|(&p, &q)| DVec3::from(p).distance(DVec3::from(q)) < near)
        };
        a.len() == b.len() && (0..b.len()).any(same_from)
    };
    a.two_sided == b.two_sided
        && a.loops.len() == b.loops.len()
        && a.loops.iter().zip(&b.loops).all(same_loop)
}

fn picture(scene: &Scene, camera: &Camera) -> Vec<u8> {
    let settings = RenderSettings {
        width: 48,
        height: 30,
        samples: 1,
        ..RenderSettings::default()
    };
    let rendering = CpuRenderer::new(scene).render(camera, &settings, Watch::none());
    srgb8(&rendering.unwrap().radiance(), 0.0, ToneMap::None)
}

fn finished(mut document: Document) -> Document {
    if let Some(job) = document.finish_images() {
        document.apply_images(job.run());
    }
    document
}

#[test]
fn every_light_of_our_scenes_can_be_moved_and_saved() {
    for name in [
        "cornell.glb",
        "gallery.glb",
        "neon.glb",
        "screens.glb",
        "stained-glass.glb",
        "two-rooms.glb",
    ] {
        let (mut document, original, source) = open(name);
        let ids: Vec<LightId> = document.ids().collect();
        for (i, id) in ids.into_iter().enumerate() {
            let light = document.light(id).unwrap().clone();
            let light = light.moved(DVec3::new(0.013, 0.007 * i as f64, -0.011));
            let light = light.turned(DVec3::new(0.6, 0.0, 0.8), 0.05);
            document.set_light(id, light).unwrap();
        }
        println!("{name}: {} lights", document.lights().count());
        let document = finished(document);
        let read = check(&document, &original, &source);
        assert_eq!(read.lights().count(), document.lights().count());
    }
}

#[test]
fn new_lights_come_back_as_they_were_made() {
    let (mut document, original, source) = open("cornell.glb");
    let first = document.ids().next().unwrap();
    document.remove_light(first);
    let at = |x: f64, y: f64| {
        let rotation = DQuat::from_rotation_x(1.2) * DQuat::from_rotation_z(0.3 * x);
        DAffine3::from_rotation_translation(rotation, DVec3::new(x, y, 0.1))
    };
    let ring = Preset::Ring {
        diameter: 0.5,
        hole: 0.3,
    };
    let mut ring = ring.light(at(0.4, 0.8)).unwrap();
    ring.two_sided = true;
    ring.radiance = Vec3::new(12.0, 3.0, 0.25);
    document.add_light(ring.clone()).unwrap();
    let star = Preset::Star {
        points: 5,
        diameter: 0.4,
    };
    let star = star.light(at(-0.4, 0.6)).unwrap();

    let colors = (0..48_u32).map(|i| [(i * 5 % 256) as u8, (i * 37 % 256) as u8, 200]);
    let png = image::RgbImage::from_raw(8, 6, colors.flatten().collect()).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    png.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let limits = Limits::default();
    let file = PictureFile::from_bytes("dots.png", bytes.into_inner(), &limits).unwrap();
    let mut shown = star.with_picture(&file, PictureFit::Cropped);
    shown.radiance = Vec3::splat(4.0);
    document.add_light(shown).unwrap();
    let document = finished(document);
    let read = check(&document, &original, &source);
    // The frame is the node's, so that other programs turn the light about its middle.
    let (_, found) = read
        .lights()
        .find(|(_, light)| light.name == "ring")
        .unwrap();
    assert_eq!(found.loops.len(), 2);
    assert!((found.area() - ring.area()).abs() < 1e-5 * ring.area());
    assert!(found.two_sided && found.radiance.abs_diff_eq(ring.radiance, 1e-5));
    assert!(found.can_reshape().is_ok());
    let middle = |light: &Light| light.world_from_plane.translation;
    assert!(middle(found).distance(middle(&ring)) < 1e-5);

    // And again, from what was read: a corner is dragged.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("again.gltf");
    source
        .save(&original, document.scene(), &frames(&document), &path)
        .unwrap();
    let (mut document, original, source) = load(&path);
    let id = document
        .lights()
        .find(|(_, light)| light.name == "ring")
        .unwrap()
        .0;
    let mut ring = document.light(id).unwrap().clone();
    ring.loops[0][3] += DVec2::new(0.02, 0.01);
    document.set_light(id, ring).unwrap();
    check(&finished(document), &original, &source);
}

#[test]
fn pictures_in_floating_point_come_back() {
    let (mut document, original, source) = open("cornell.glb");
    let mut hdr = Cursor::new(Vec::new());
    let texels: Vec<_> = (0..64_u32)
        .map(|i| image::Rgb([0.02 * i as f32, 30.0 / (1 + i) as f32, 0.7]))
        .collect();
    let encoder = image::codecs::hdr::HdrEncoder::new(&mut hdr);
    encoder.encode(&texels, 8, 8).unwrap();
    let file = PictureFile::from_bytes("sky.hdr", hdr.into_inner(), &Limits::default()).unwrap();
    let (id, light) = document.lights().next().unwrap();
    let light = light.with_picture(&file, PictureFit::Stretched);
    document.set_light(id, light).unwrap();
    let document = finished(document);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("saved.glb");
    let seen = document.scene();
    source
        .save(&original, seen, &frames(&document), &path)
        .unwrap();
    let (read, _, _) = load(&path);
    let radiance = |scene: &Scene| {
        let shown = scene
            .polygon_lights
            .iter()
            .find(|light| light.image.is_some());
        shown.unwrap().radiance
    };
    let (found, expected) = (radiance(read.scene()), radiance(seen));
    println!("{found} {expected}");
    assert!(found.abs_diff_eq(expected, 1e-5 * expected.max_element()));
    let camera = &seen.cameras[0];
    let (a, b) = (picture(read.scene(), camera), picture(seen, camera));
    assert!(a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 1));
}
