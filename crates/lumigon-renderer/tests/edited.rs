//! A renderer that lives while its scene is edited.

use std::f32::consts::FRAC_PI_6;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Vec3};
use lumigon::{
    DistanceFieldSettings, DistanceFieldSmoothness, ImageMethod, LtcLobes, SpecularMethod,
};
use lumigon_renderer::{
    BounceSettings, BounceVisibility, Camera, CpuRenderer, Limits, Pixels, ReferenceSettings,
    RenderError, RenderSettings, Scene, Watch,
};

fn load(name: &str) -> (Scene, Camera) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let scene = Scene::load(format!("{folder}/{name}.glb")).unwrap();
    let camera = scene.cameras[0].clone();
    (scene, camera)
}

fn small() -> RenderSettings {
    RenderSettings {
        width: 48,
        height: 30,
        samples: 1,
        ..RenderSettings::default()
    }
}

/// Finds the lights of a mesh anew.
fn find_lights(scene: &mut Scene, mesh: usize) {
    let (lights, _) = scene.lights_of_mesh(mesh, &Limits::default());
    let all = &mut scene.polygon_lights;
    let place = all.iter().position(|light| light.mesh == mesh);
    let place = place.unwrap_or(all.len());
    all.retain(|light| light.mesh != mesh);
    all.splice(place..place, lights);
}

/// Moves the vertices of a mesh.
fn place(scene: &mut Scene, mesh: usize, by: impl Fn(Vec3) -> Vec3) {
    let edited = Arc::make_mut(&mut scene.meshes[mesh]);
    for position in &mut edited.positions {
        *position = by(*position);
    }
    find_lights(scene, mesh);
}

fn light_mesh(scene: &Scene, light: usize) -> usize {
    scene.polygon_lights[light].mesh
}

fn middle(scene: &Scene, mesh: usize) -> Vec3 {
    let (low, high) = scene.meshes[mesh].bounds().unwrap();
    0.5 * (low + high)
}

type Edit = (&'static str, fn(&mut Scene));

/// One after the other.
const EDITS: [Edit; 8] = [
    ("nothing", |_| {}),
    ("moved", |scene| {
        let mesh = light_mesh(scene, 0);
        let about = middle(scene, mesh);
        let turn = Affine3A::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), FRAC_PI_6);
        let by = Vec3::new(0.125, -0.25, 0.0625);
        place(scene, mesh, |p| {
            turn.transform_vector3(p - about) + about + by
        });
    }),
    ("reshaped", |scene| {
        let mesh = light_mesh(scene, 1);
        let about = middle(scene, mesh);
        place(scene, mesh, |p| {
            about + (p - about) * Vec3::new(1.5, 1.25, 0.75)
        });
    }),
    ("its picture slid over it", |scene| {
        let mesh = light_mesh(scene, 0);
        for at in &mut Arc::make_mut(&mut scene.meshes[mesh]).texcoords[0] {
            at.x += 0.125;
        }
        find_lights(scene, mesh);
    }),
    ("brighter and two-sided", |scene| {
        let mesh = light_mesh(scene, 0);
        let material = scene.meshes[mesh].material;
        scene.materials[material].emissive *= 2.0;
        scene.materials[material].double_sided = true;
        for mesh in 0..scene.meshes.len() {
            if scene.meshes[mesh].material == material {
                find_lights(scene, mesh);
            }
        }
    }),
    ("added", |scene| {
        let mesh = light_mesh(scene, 0);
        let about = middle(scene, mesh);
        let mut copy = (*scene.meshes[mesh]).clone();
        for position in &mut copy.positions {
            *position = about + (*position - about) * 0.5 - Vec3::new(0.25, 0.125, 0.375);
        }
        scene.meshes.push(Arc::new(copy));
        let added = scene.meshes.len() - 1;
        find_lights(scene, added);
    }),
    ("removed", |scene| {
        let mesh = light_mesh(scene, 1);
        Arc::make_mut(&mut scene.meshes[mesh]).triangles.clear();
        find_lights(scene, mesh);
    }),
    // Whatever has another index now.
    ("the first mesh gone from its list", |scene| {
        let gone = (0..scene.meshes.len())
            .find(|&mesh| scene.polygon_lights.iter().all(|light| light.mesh != mesh))
            .unwrap();
        scene.meshes.remove(gone);
        for light in &mut scene.polygon_lights {
            light.mesh -= usize::from(light.mesh > gone);
        }
    }),
];

/// The greatest difference, relative to the brightest channel.
fn difference(one: &Pixels, other: &Pixels) -> f32 {
    assert_eq!(one.len(), other.len());
    let channels = one.as_flattened().iter().zip(other.as_flattened());
    let brightest = other.as_flattened().iter().fold(0.0_f32, |a, &b| a.max(b));
    let greatest = channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(greatest.is_finite());
    greatest / brightest.max(1e-30)
}

/// Pictures by several methods, by virtual lights behind surfaces, and of paths.
fn pictures(renderer: &CpuRenderer<'_>, camera: &Camera) -> Vec<(&'static str, Pixels)> {
    let field = DistanceFieldSettings::new(32, 2.0, false).unwrap();
    let render = |specular, image_method| {
        let settings = RenderSettings {
            specular,
            image_method,
            ..small()
        };
        let picture = renderer.render(camera, &settings, Watch::none()).unwrap();
        picture.radiance()
    };
    let two = SpecularMethod::Ltc {
        lobes: LtcLobes::Two,
    };
    let distances = SpecularMethod::ReflectedDistanceField {
        field,
        smoothness: DistanceFieldSmoothness::default(),
    };
    let bounce = BounceSettings {
        face_size: 8,
        virtual_lights: 48,
        visibility: BounceVisibility::Traced,
        shadows: true,
        ..BounceSettings::default()
    };
    let lights = renderer
        .virtual_lights(camera, &bounce, Watch::none())
        .unwrap();
    assert!(!lights.is_empty());
    let settings = RenderSettings {
        direct: false,
        ..small()
    };
    let indirect = renderer.render_with_bounce(camera, &settings, &lights, Watch::none());
    let paths = ReferenceSettings {
        width: 48,
        height: 30,
        samples: 1,
        paths: 2,
        bounces: 2,
        ..ReferenceSettings::default()
    };
    let paths = renderer.reference(camera, &paths, Watch::none()).unwrap();
    vec![
        ("two lobes", render(two, ImageMethod::default())),
        ("distance fields", render(distances, ImageMethod::Lookup)),
        ("virtual lights", indirect.unwrap().radiance()),
        ("paths", paths.mean.radiance()),
    ]
}

#[test]
fn an_edited_renderer_renders_what_a_new_one_does() {
    for name in ["room", "screens"] {
        let (mut scene, camera) = load(name);
        let mut living = CpuRenderer::shared(Arc::new(scene.clone()));
        assert!(!living.is_layered());
        // Something to keep.
        pictures(&living, &camera);
        for (what, edit) in EDITS {
            edit(&mut scene);
            let scene = Arc::new(scene.clone());
            living = living.edited(Arc::clone(&scene));
            assert_eq!(living.is_layered(), what != "nothing", "{name}: {what}");
            let anew = CpuRenderer::shared(scene);
            assert_eq!(living.warnings(), anew.warnings());
            let both = pictures(&living, &camera)
                .into_iter()
                .zip(pictures(&anew, &camera));
            for ((picture, one), (_, other)) in both {
                let off = difference(&one, &other);
                println!("{name}, {what}, {picture}: {off:e}");
                assert!(off <= 1e-5, "{name}, {what}, {picture}: {off}");
            }
        }
    }
}

/// Edits that change what is seen do so.
#[test]
fn edits_are_seen_and_the_earlier_renderer_shows_what_it_did() {
    let (scene, camera) = load("room");
    let first = CpuRenderer::new(&scene);
    let picture = |renderer: &CpuRenderer<'_>| {
        let picture = renderer.render(&camera, &small(), Watch::none());
        picture.unwrap().radiance()
    };
    let before = picture(&first);
    let mut changed = scene.clone();
    place(&mut changed, light_mesh(&scene, 0), |p| {
        p + Vec3::new(0.5, -0.25, 0.0)
    });
    let second = first.edited(Arc::new(changed));
    assert!(difference(&picture(&second), &before) > 1e-3);
    assert_eq!(picture(&first), before);
    // And back.
    let third = second.edited(Arc::new(scene.clone()));
    assert_eq!(picture(&third), before);
    assert!(!third.is_layered());
}

#[test]
fn all_lights_and_meshes_may_go_and_come() {
    let (scene, camera) = load("cornell");
    let renderer = CpuRenderer::new(&scene);
    let empty = renderer.edited(Arc::new(Scene::default()));
    let picture = empty.render(&camera, &small(), Watch::none()).unwrap();
    assert!(picture.radiance().iter().all(|&pixel| pixel == [0.0; 3]));
    assert!(empty.pick(&camera, 0.5, 0.5, 1.6).is_none());
    let again = empty.edited(Arc::new(scene.clone()));
    let [one, other] = [&renderer, &again].map(|r| r.render(&camera, &small(), Watch::none()));
    assert_eq!(one, other);
}

#[test]
fn a_pick_is_what_is_seen() {
    let (scene, camera) = load("cornell");
    let renderer = CpuRenderer::new(&scene);
    let settings = small();
    let aspect = settings.width as f32 / settings.height as f32;
    let mut lights = 0;
    for y in 0..settings.height {
        for x in 0..settings.width {
            let at = [
                (x as f32 + 0.5) / settings.width as f32,
                (y as f32 + 0.5) / settings.height as f32,
            ];
            let Some(picked) = renderer.pick(&camera, at[0], at[1], aspect) else {
                continue;
            };
            let (origin, direction) = camera.ray(at[0], at[1], aspect);
            let along = origin + direction * picked.distance;
            assert!((along - picked.position).length() < 1e-4, "{picked:?}");
            assert!(picked.geometric_normal.dot(direction) <= 0.0);
            let mesh = &scene.meshes[picked.mesh];
            let [a, b, c] = mesh.corners(picked.triangle as usize);
            let normal = (b - a).cross(c - a).normalize();
            assert!((picked.position - a).dot(normal).abs() < 1e-4);
            assert_eq!(picked.material, scene.materials[mesh.material].name);
            let is_light = |light: &lumigon_renderer::EmissivePolygon| {
                light.mesh == picked.mesh && light.triangles.contains(&picked.triangle)
            };
            lights += u32::from(scene.polygon_lights.iter().any(is_light));
        }
    }
    assert!(lights > 0);
    for hostile in [f32::NAN, f32::INFINITY, -1e30] {
        assert!(renderer.pick(&camera, hostile, 0.5, aspect).is_none());
    }
    assert!(renderer.pick(&camera, 0.5, 0.5, 0.0).is_none());
    assert!(renderer.pick(&camera, 0.5, 0.5, f32::NAN).is_none());
}

#[test]
fn a_probe_has_the_pictures_radiance() {
    let (scene, camera) = load("screens");
    let renderer = CpuRenderer::new(&scene);
    let settings = [
        small(),
        RenderSettings {
            specular: SpecularMethod::LightVector,
            ..small()
        },
    ];
    let pictures = settings.map(|s| renderer.render(&camera, &s, Watch::none()).unwrap());
    let (width, height) = (settings[0].width, settings[0].height);
    let mut probed = 0;
    for pixel in (0..width * height).step_by(7) {
        let (x, y) = (pixel % width, pixel / width);
        let at = [(x, width), (y, height)]
            .map(|(i, size)| ((f64::from(i) + 0.5) / f64::from(size)) as f32);
        let aspect = width as f32 / height as f32;
        let Some(probe) = renderer.probe(&camera, at, aspect, &settings) else {
            continue;
        };
        for (picture, radiance) in pictures.iter().zip(&probe.radiance) {
            let radiance = radiance.clone().unwrap();
            let pixel = pixel as usize;
            assert_eq!(radiance.emitted, picture.emitted[pixel]);
            // Sums of a tile's hits are rounded elsewhere.
            for (one, other) in [
                (radiance.diffuse, picture.diffuse[pixel]),
                (radiance.specular, picture.specular[pixel]),
            ] {
                for (a, b) in one.into_iter().zip(other) {
                    assert!((a - b).abs() <= 1e-5 * b.abs() + 1e-7, "{a} {b}");
                }
            }
        }
        let point = probe.surface.position.as_dvec3();
        let normal = probe.surface.shading_normal.as_dvec3();
        let mut sum = 0.0;
        for light in &scene.polygon_lights {
            let polygon = lumigon::PolygonLight::new(&light.loops, lumigon::Sides::Front).unwrap();
            let unit = normal.normalize().to_array();
            sum += lumigon::form_factor(&polygon, point.to_array().into(), unit.into());
        }
        assert!(scene.polygon_lights.iter().all(|light| !light.two_sided));
        assert!((probe.form_factor - sum).abs() < 1e-12);
        let strengths: Vec<f64> = probe
            .lights
            .iter()
            .map(|l| l.irradiance.iter().sum())
            .collect();
        assert!(strengths.is_sorted_by(|a, b| a >= b));
        probed += usize::from(sum > 0.0);
    }
    assert!(probed > 50, "{probed}");
}

#[test]
fn light_counts_are_of_lights_that_light() {
    let (scene, camera) = load("room");
    let renderer = CpuRenderer::new(&scene);
    let settings = RenderSettings {
        width: 32,
        height: 20,
        ..small()
    };
    let counts = |light_bound| {
        let settings = RenderSettings {
            light_bound,
            ..settings
        };
        renderer
            .light_counts(&camera, &settings, Watch::none())
            .unwrap()
    };
    let all = counts(0.0);
    let (mut same, mut seen) = (0, 0);
    for pixel in 0..settings.width * settings.height {
        let (x, y) = (pixel % settings.width, pixel / settings.width);
        let at = [(x, settings.width), (y, settings.height)]
            .map(|(i, size)| ((f64::from(i) + 0.5) / f64::from(size)) as f32);
        let Some(probe) = renderer.probe(&camera, at, 1.6, &[]) else {
            assert_eq!(all[pixel as usize], 0);
            continue;
        };
        seen += 1;
        let count = all[pixel as usize] as usize;
        same += usize::from(count.min(lumigon_renderer::STRONGEST_LIGHTS) == probe.lights.len());
    }
    // But where rounding decides what is on a plane.
    assert!(seen > 300 && same * 100 >= seen * 98, "{same} of {seen}");
    let sum = |counts: &[u32]| counts.iter().sum::<u32>();
    let sums = [1e-9, 0.5, 1e9].map(|bound| sum(&counts(bound)));
    println!("{} without a bound, {sums:?} with", sum(&all));
    assert!(sum(&all) >= sums[0] && sums[0] > sums[1] && sums[1] > 0 && sums[2] == 0);
    let watch = Watch {
        cancelled: &AtomicBool::new(true),
        ..Watch::none()
    };
    let cancelled = renderer.light_counts(&camera, &settings, watch);
    assert_eq!(cancelled, Err(RenderError::Cancelled));
}

#[test]
fn pictures_are_timed() {
    let (scene, camera) = load("cornell");
    let renderer = CpuRenderer::new(&scene);
    assert!(renderer.timings().is_none());
    renderer.render(&camera, &small(), Watch::none()).unwrap();
    let direct = renderer.timings().unwrap();
    assert!(direct.rays > 0.0 && direct.lights > 0.0);
    let bounce = BounceSettings::default();
    let lights = renderer
        .virtual_lights(&camera, &bounce, Watch::none())
        .unwrap();
    let picture = renderer.render_with_bounce(&camera, &small(), &lights, Watch::none());
    picture.unwrap();
    let indirect = renderer.timings().unwrap();
    // A thousand lights against one.
    assert!(indirect.virtual_lights > 10.0 * direct.virtual_lights);
}
