//! Bounce light by virtual lights against the path tracer's.

use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use lumigon::SpecularMethod;
use lumigon_renderer::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, Camera, CpuRenderer, CubeMap,
    EmissivePolygon, Material, Mesh, Pixels, PunctualKind, PunctualLight, ReferenceSettings,
    RenderSettings, Rendering, Scene, VirtualLightKind, VirtualLights, Watch,
};

const SIZE: [u32; 2] = [48, 48];

fn scene(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scene = Scene::load(folder.join(name)).unwrap();
    // What virtual lights stand for is diffuse.
    for material in &mut scene.materials {
        material.specular = 0.0;
    }
    scene
}

/// Diffuse bounce light of a few pixels.
fn bounce(renderer: &CpuRenderer<'_>, camera: &Camera, lights: &VirtualLights) -> Pixels {
    let settings = RenderSettings {
        width: SIZE[0],
        height: SIZE[1],
        samples: 1,
        specular: SpecularMethod::None,
        direct: false,
        ..RenderSettings::default()
    };
    let picture = renderer.render_with_bounce(camera, &settings, lights, Watch::none());
    let Rendering { diffuse, .. } = picture.unwrap();
    diffuse
}

fn truth(
    renderer: &CpuRenderer<'_>,
    camera: &Camera,
    bounces: u32,
    [shadows, bounce_shadows]: [bool; 2],
) -> (Pixels, f32) {
    let settings = ReferenceSettings {
        width: SIZE[0],
        height: SIZE[1],
        samples: 1,
        paths: 512,
        bounces,
        shadows,
        bounce_shadows,
        direct: false,
        seed: 1,
    };
    let picture = renderer
        .reference(camera, &settings, Watch::none())
        .unwrap();
    let noise = picture
        .diffuse_error
        .iter()
        .map(|&e| Vec3::from(e).length_squared())
        .sum();
    (picture.mean.diffuse, noise)
}

/// Root mean square difference, relative to that of the truth, and relative difference of the means.
fn errors(pixels: &Pixels, (truth, noise): &(Pixels, f32)) -> [f32; 2] {
    let (mut squared, mut all, mut sum, mut true_sum) = (0.0, 0.0, 0.0, 0.0);
    for (&a, &b) in pixels.iter().zip(truth) {
        let (a, b) = (Vec3::from(a), Vec3::from(b));
        squared += (a - b).length_squared();
        all += b.length_squared();
        sum += a.element_sum();
        true_sum += b.element_sum();
    }
    [
        ((squared - noise) / all).max(0.0).sqrt(),
        sum / true_sum - 1.0,
    ]
}

/// Quads of one material, seen from where their corners run counter-clockwise.
fn quads(quads: &[[[f32; 3]; 4]], material: usize) -> Mesh {
    let positions: Vec<Vec3> = quads.iter().flatten().map(|&p| p.into()).collect();
    let normals = quads.iter().flat_map(|&[a, b, _, d]| {
        let [a, b, d] = [a, b, d].map(Vec3::from);
        [(b - a).cross(d - a).normalize(); 4]
    });
    Mesh {
        normals: normals.collect(),
        positions,
        material,
        triangles: (0..quads.len() as u32)
            .flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]])
            .collect(),
        ..Mesh::default()
    }
}

fn matte(color: Vec3) -> Material {
    Material {
        base_color: color.extend(1.0),
        metallic: 0.0,
        specular: 0.0,
        ..Material::default()
    }
}

/// A box from -1 to 1, seen from inside, under a light from straight above: of its faces only the
/// floor is lit, evenly.
fn lit_floor() -> Scene {
    let corner = |x: i32, y: i32, z: i32| [x as f32, y as f32, z as f32];
    let floor = [
        corner(-1, -1, 1),
        corner(1, -1, 1),
        corner(1, -1, -1),
        corner(-1, -1, -1),
    ];
    let ceiling = [
        corner(-1, 1, -1),
        corner(1, 1, -1),
        corner(1, 1, 1),
        corner(-1, 1, 1),
    ];
    let left = [
        corner(-1, -1, -1),
        corner(-1, 1, -1),
        corner(-1, 1, 1),
        corner(-1, -1, 1),
    ];
    let right = [
        corner(1, -1, 1),
        corner(1, 1, 1),
        corner(1, 1, -1),
        corner(1, -1, -1),
    ];
    let back = [
        corner(-1, -1, -1),
        corner(1, -1, -1),
        corner(1, 1, -1),
        corner(-1, 1, -1),
    ];
    let front = [
        corner(1, -1, 1),
        corner(-1, -1, 1),
        corner(-1, 1, 1),
        corner(1, 1, 1),
    ];
    Scene {
        meshes: vec![
            quads(&[floor], 0).into(),
            quads(&[ceiling, left, right, back, front], 1).into(),
        ],
        materials: vec![matte(Vec3::new(0.5, 0.25, 0.125)), matte(Vec3::ONE)],
        punctual_lights: vec![PunctualLight {
            name: String::new(),
            kind: PunctualKind::Directional,
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            color: Vec3::splat(PI),
            range: None,
        }],
        ..Scene::default()
    }
}

/// Virtual lights with the CPU's rays.
fn lights(renderer: &CpuRenderer<'_>, settings: &BounceSettings) -> VirtualLights {
    let camera = Camera::framing(&Scene::default());
    renderer
        .virtual_lights(&camera, settings, Watch::none())
        .unwrap()
}

fn from(center: [f32; 3]) -> BounceCenters {
    BounceCenters::Points(vec![center])
}

#[test]
fn an_evenly_lit_floor_becomes_its_own_outline() {
    let mut scene = lit_floor();
    let renderer = CpuRenderer::new(&scene);
    let made = lights(
        &renderer,
        &BounceSettings {
            centers: from([0.1, 0.2, -0.3]),
            ..BounceSettings::default()
        },
    );
    assert_eq!(made.len(), 1);
    // The floor sends off its albedo times pi watts for each of its four square metres; texels on its
    // edge are on it or not.
    let flux = made.flux().map(|x| x as f32 / (4.0 * PI));
    for (flux, albedo) in flux.into_iter().zip([0.5, 0.25, 0.125]) {
        assert!((flux / albedo - 1.0).abs() < 0.02, "{flux} for {albedo}");
    }
    // The ceiling is lit as by an emitter of the floor's outline.
    let camera = CubeMap::camera([0.0; 3], 2);
    let bounced = bounce(&renderer, &camera, &made);
    scene.punctual_lights.clear();
    scene.polygon_lights = vec![EmissivePolygon {
        name: "floor".to_owned(),
        loops: vec![vec![
            [-1.0, -1.0, 1.0],
            [1.0, -1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, -1.0, -1.0],
        ]],
        radiance: Vec3::from(flux),
        image: None,
        two_sided: false,
        mesh: 0,
        triangles: vec![0, 1],
    }];
    let emitting = CpuRenderer::new(&scene);
    let settings = RenderSettings {
        width: SIZE[0],
        height: SIZE[1],
        samples: 1,
        specular: SpecularMethod::None,
        ..RenderSettings::default()
    };
    let direct = emitting.render(&camera, &settings, Watch::none()).unwrap();
    for (a, b) in bounced.iter().zip(&direct.diffuse) {
        let (a, b) = (Vec3::from(*a), Vec3::from(*b));
        assert!(
            (a - b).abs().max_element() <= 1e-5 * b.max_element(),
            "{a} {b}"
        );
    }
}

#[test]
fn polygons_are_the_path_tracers_bounce() {
    let scene = scene("cornell.glb");
    let renderer = CpuRenderer::new(&scene);
    let camera = &scene.cameras[0];
    let traced = BounceVisibility::Traced;
    for (visibility, shadows, blocked, bound) in [
        (BounceVisibility::None, false, [false, false], 0.03),
        (traced, false, [false, true], 0.035),
        (traced, true, [true, true], 0.055),
    ] {
        let settings = BounceSettings {
            centers: BounceCenters::Scene(4),
            virtual_lights: 512,
            visibility,
            shadows,
            ..BounceSettings::default()
        };
        let truth = truth(&renderer, camera, 2, blocked);
        let polygons = lights(&renderer, &settings);
        assert!((400..=512).contains(&polygons.len()));
        for (own, seen) in polygons.flux().into_iter().zip(polygons.gathered_flux()) {
            assert!((own / seen - 1.0).abs() < 1e-5);
        }
        let [polygon_rmse, bias] = errors(&bounce(&renderer, camera, &polygons), &truth);
        println!("{visibility:?} {shadows}: {polygon_rmse:.4} {bias:+.4}");
        assert!(polygon_rmse < bound && bias.abs() < 0.02);
        let points = BounceSettings {
            kind: VirtualLightKind::Point {
                least_distance: None,
            },
            ..settings
        };
        let points = lights(&renderer, &points);
        let [point_rmse, _] = errors(&bounce(&renderer, camera, &points), &truth);
        println!("points: {point_rmse:.4}");
        assert!(point_rmse > 1.5 * polygon_rmse);
    }
}

#[test]
fn further_bounces_and_shadow_maps() {
    let scene = scene("cornell.glb");
    let renderer = CpuRenderer::new(&scene);
    let camera = &scene.cameras[0];
    let settings = BounceSettings {
        bounces: 3,
        centers: BounceCenters::Scene(4),
        virtual_lights: 256,
        face_size: 32,
        visibility: BounceVisibility::Traced,
        shadows: true,
        ..BounceSettings::default()
    };
    let made = lights(&renderer, &settings);
    let [rmse, bias] = errors(
        &bounce(&renderer, camera, &made),
        &truth(&renderer, camera, 4, [true, true]),
    );
    println!("three bounces: {rmse:.4} {bias:+.4}");
    assert!(rmse < 0.1 && bias.abs() < 0.04);

    let settings = BounceSettings {
        bounces: 1,
        method: BounceMethod::ReflectiveShadowMaps,
        ..settings
    };
    let made = lights(&renderer, &settings);
    let [rmse, bias] = errors(
        &bounce(&renderer, camera, &made),
        &truth(&renderer, camera, 2, [true, true]),
    );
    println!("shadow maps: {rmse:.4} {bias:+.4}");
    assert!(rmse < 0.2 && made.len() <= 256);
    let fault = renderer.virtual_lights(
        camera,
        &BounceSettings {
            bounces: 2,
            ..settings
        },
        Watch::none(),
    );
    let fault = fault.unwrap_err().to_string();
    assert!(fault.contains("reflective shadow maps"), "{fault}");
}

#[test]
fn bounce_light_does_not_flicker() {
    let scene = scene("cornell.glb");
    let camera = scene.cameras[0].clone();
    let settings = BounceSettings {
        virtual_lights: 256,
        ..BounceSettings::default()
    };
    let frame = |scene: &Scene, settings: &BounceSettings| {
        let renderer = CpuRenderer::new(scene);
        bounce(&renderer, &camera, &lights(&renderer, settings))
    };
    let greatest_change = |frames: &[Pixels]| {
        let sum = |p: &[f32; 3]| Vec3::from(*p).element_sum();
        let mean = frames[0].iter().map(sum).sum::<f32>() / frames[0].len() as f32;
        let change = |pair: &[Pixels]| {
            let pixels = pair[0].iter().zip(&pair[1]);
            let changes = pixels.map(|(a, b)| (sum(a) - sum(b)).abs());
            changes.fold(0.0, f32::max)
        };
        frames.windows(2).map(change).fold(0.0, f32::max) / mean
    };
    // The lamp moves by millimetres.
    let mut moving = scene.clone();
    let frames: Vec<_> = (0..6)
        .map(|_| {
            for vertex in moving.polygon_lights[0].loops.iter_mut().flatten() {
                vertex[0] += 0.002;
            }
            frame(&moving, &settings)
        })
        .collect();
    let by_lamp = greatest_change(&frames);
    // The cube map does.
    let frames: Vec<_> = (0..6)
        .map(|step| {
            let centers = from([0.27 + 0.002 * step as f32, 0.3, 0.15]);
            let settings = BounceSettings {
                centers,
                ..settings.clone()
            };
            frame(&scene, &settings)
        })
        .collect();
    let by_cube_map = greatest_change(&frames);
    println!("greatest change a frame: by lamp {by_lamp:.4}, by cube map {by_cube_map:.4}");
    assert!(by_lamp < 0.1 && by_cube_map > by_lamp);
    // Cube maps that were placed in the scene do not know the camera.
    let renderer = CpuRenderer::new(&scene);
    let flux = |camera| {
        let made = renderer.virtual_lights(camera, &settings, Watch::none());
        made.unwrap().flux()
    };
    let first = flux(&scene.cameras[0]);
    assert_eq!(first, flux(&Camera::framing(&scene)));
}

#[test]
fn hostile_scenes_and_places_are_answered() {
    let empty = Scene::default();
    let dark = {
        let mut scene = lit_floor();
        scene.punctual_lights.clear();
        scene
    };
    let lit = lit_floor();
    let walled = {
        // A black box around the centre, seen from inside.
        let mut scene = lit_floor();
        scene.materials.push(matte(Vec3::ZERO));
        let mut inner = scene.meshes.clone();
        for mesh in inner.iter_mut().map(Arc::make_mut) {
            mesh.material = 2;
            mesh.positions.iter_mut().for_each(|p| *p *= 0.1);
        }
        scene.meshes.extend(inner);
        scene
    };
    for (scene, center, warning) in [
        (&empty, [0.0; 3], "no surfaces"),
        (&dark, [0.0; 3], "no surface that is lit"),
        (&walled, [0.0; 3], "lit"),
        (&lit, [0.0, 1e6, 0.0], "adds no bounce light"),
        (&lit, [f32::NAN; 3], "sees no surface"),
        (&lit, [f32::INFINITY, 0.0, 0.0], "sees no surface"),
    ] {
        let renderer = CpuRenderer::new(scene);
        let made = lights(
            &renderer,
            &BounceSettings {
                centers: from(center),
                ..BounceSettings::default()
            },
        );
        let said = made.warnings().join("; ");
        assert!(
            made.is_empty() && said.contains(warning),
            "{center:?}: {said}"
        );
        assert_eq!(made.flux(), [0.0; 3]);
    }
    let renderer = CpuRenderer::new(&lit);
    for (face_size, virtual_lights, merges, clusters) in [
        (1, 1, true, true),
        (1, 7, false, true),
        (2, 1, false, false),
        (3, 5, true, false),
    ] {
        for center in [[0.0; 3], [0.0, -0.999_999, 0.0], [1.0, -1.0, 1.0]] {
            let settings = BounceSettings {
                centers: from(center),
                face_size,
                virtual_lights,
                merges,
                clusters,
                ..BounceSettings::default()
            };
            let made = lights(&renderer, &settings);
            assert!(
                made.len()
                    <= if clusters {
                        virtual_lights as usize
                    } else {
                        54
                    }
            );
            assert!(made.flux().iter().all(|flux| flux.is_finite()));
        }
    }
    for settings in [
        BounceSettings {
            bounces: 0,
            ..BounceSettings::default()
        },
        BounceSettings {
            face_size: 0,
            ..BounceSettings::default()
        },
        BounceSettings {
            face_size: 100_000,
            ..BounceSettings::default()
        },
        BounceSettings {
            virtual_lights: 0,
            ..BounceSettings::default()
        },
        BounceSettings {
            centers: BounceCenters::Points(vec![[0.0; 3]; 1_000_000]),
            ..BounceSettings::default()
        },
        BounceSettings {
            centers: BounceCenters::Points(Vec::new()),
            ..BounceSettings::default()
        },
    ] {
        let camera = Camera::framing(&lit);
        let fault = renderer.virtual_lights(&camera, &settings, Watch::none());
        assert!(fault.unwrap_err().to_string().contains("give 1 to"));
    }
}
