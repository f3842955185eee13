//! Bounce light by virtual lights against the path tracer's.

use std::f32::consts::PI;
use std::path::Path;

use glam::Vec3;
use lumigon::SpecularMethod;
use lumigon_renderer::{
    BounceCenters, BounceSettings, BounceVisibility, Camera, CpuRenderer, Material, Mesh, Pixels,
    PunctualKind, PunctualLight, ReferenceSettings, RenderSettings, Rendering, Scene,
    VirtualLightKind, VirtualLights, Watch,
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
    [shadows, bounce_shadows]: [bool; 2],
) -> (Pixels, f32) {
    let settings = ReferenceSettings {
        width: SIZE[0],
        height: SIZE[1],
        samples: 1,
        paths: 512,
        bounces: 2,
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

#[test]
fn sketch() {
    for name in ["cornell.glb", "room.glb", "two-rooms.glb"] {
        let scene = scene(name);
        let renderer = CpuRenderer::new(&scene);
        let camera = &scene.cameras[0];
        let start = std::time::Instant::now();
        let references =
            [[false, false], [false, true], [true, true]].map(|s| truth(&renderer, camera, s));
        println!(
            "noise {:?} in {:?}",
            references.each_ref().map(|(t, n)| (n / t
                .iter()
                .map(|&t| Vec3::from(t).length_squared())
                .sum::<f32>())
            .sqrt()),
            start.elapsed()
        );
        for centers in [
            BounceCenters::Camera,
            BounceCenters::Scene(1),
            BounceCenters::Scene(4),
        ] {
            for (face_size, virtual_lights) in [
                (64, 64),
                (64, 256),
                (64, 1024),
                (64, 4096),
                (16, 1024),
                (128, 1024),
            ] {
                for (kind, visibility, shadows) in [
                    (VirtualLightKind::Polygon, BounceVisibility::None, false),
                    (VirtualLightKind::Polygon, BounceVisibility::Traced, false),
                    (VirtualLightKind::Polygon, BounceVisibility::Traced, true),
                    (
                        VirtualLightKind::Point {
                            least_distance: None,
                        },
                        BounceVisibility::None,
                        false,
                    ),
                ] {
                    if virtual_lights > 1024 && visibility == BounceVisibility::Traced {
                        continue;
                    }
                    let settings = BounceSettings {
                        face_size,
                        virtual_lights,
                        kind,
                        visibility,
                        shadows,
                        centers: centers.clone(),
                        ..BounceSettings::default()
                    };
                    let start = std::time::Instant::now();
                    let lights = renderer
                        .virtual_lights(camera, &settings, Watch::none())
                        .unwrap();
                    let made = start.elapsed().as_secs_f64();
                    let picture = bounce(&renderer, camera, &lights);
                    let which =
                        usize::from(visibility == BounceVisibility::Traced) + usize::from(shadows);
                    let [rmse, bias] = errors(&picture, &references[which]);
                    let [full, _] = errors(&picture, &references[2]);
                    println!(
                        "{name} {centers:?} N{face_size} K{virtual_lights}->{} {kind:?} {visibility:?} {shadows}: rmse {rmse:.4} bias {bias:+.4} full {full:.4} flux {:?} made {made:.2}",
                        lights.len(),
                        lights.flux()[0] / lights.gathered_flux()[0] - 1.0
                    );
                }
            }
        }
    }
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
            quads(&[floor], 0),
            quads(&[ceiling, left, right, back, front], 1),
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

#[test]
fn an_evenly_lit_floor_becomes_its_own_outline() {
    let scene = lit_floor();
    let renderer = CpuRenderer::new(&scene);
    let camera = Camera::framing(&scene);
    for (center, face_size) in [
        ([0.1, 0.2, -0.3], 32),
        ([0.0, -0.9, 0.0], 64),
        ([0.9, 0.9, 0.9], 16),
    ] {
        let settings = BounceSettings {
            centers: BounceCenters::Points(vec![center]),
            face_size,
            ..BounceSettings::default()
        };
        let lights = renderer
            .virtual_lights(&camera, &settings, Watch::none())
            .unwrap();
        // The floor sends off its albedo times pi watts for each of its four square metres.
        let flux = Vec3::from(lights.gathered_flux().map(|x| x as f32)) / (4.0 * PI);
        println!(
            "{center:?} {face_size}: {} lights, flux {flux}",
            lights.len()
        );
    }
}
