//! Bounce light on the GPU is the CPU's.

use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Affine3A, Mat3, Vec2, Vec3};
use lumigon::{DistanceFieldSettings, DistanceFieldSmoothness, SpecularMethod};
use lumigon_renderer::{
    AlphaMode, BounceCenters, BounceMethod, BounceSettings, BounceVisibility, Camera, CpuRenderer,
    Filter, Gpu, GpuPreference, GpuRenderer, Material, Mesh, PunctualKind, PunctualLight,
    RenderError, RenderSettings, Rendering, Sampler, Scene, Texture, TextureRef, ToneMap,
    VirtualLightKind, VirtualLights, Watch, srgb8,
};

static GPU: LazyLock<Gpu> = LazyLock::new(|| {
    Gpu::new(GpuPreference::Any).unwrap_or_else(|fault| panic!("these tests need a GPU: {fault}"))
});

fn load(name: &str) -> (Scene, Camera) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let scene = Scene::load(folder.join(name)).unwrap();
    let camera = scene.cameras[0].clone();
    (scene, camera)
}

fn small() -> RenderSettings {
    RenderSettings {
        width: 48,
        height: 32,
        samples: 2,
        ..RenderSettings::default()
    }
}

/// Few texels and lights.
fn coarse() -> BounceSettings {
    BounceSettings {
        centers: BounceCenters::Camera,
        face_size: 8,
        virtual_lights: 100,
        ..BounceSettings::default()
    }
}

const POINTS: VirtualLightKind = VirtualLightKind::Point {
    least_distance: None,
};

/// Asserts that two pictures differ by a byte at most, and hardly anywhere by that, but for so many
/// pixels, which edges cross.
fn assert_same(name: &str, cpu: &Rendering, gpu: &Rendering, on_edges: usize) {
    for (part, cpu, gpu) in [
        ("emitted", &cpu.emitted, &gpu.emitted),
        ("diffuse", &cpu.diffuse, &gpu.diffuse),
        ("specular", &cpu.specular, &gpu.specular),
    ] {
        let bytes = [cpu, gpu].map(|pixels| srgb8(pixels, 0.0, ToneMap::None));
        let mut pixels: Vec<(f64, u8)> = (0..cpu.len())
            .map(|i| {
                let squares = (0..3).map(|c| f64::from(cpu[i][c] - gpu[i][c]).powi(2));
                let of_bytes = (3 * i..3 * i + 3).map(|i| bytes[0][i].abs_diff(bytes[1][i]));
                (squares.sum(), of_bytes.max().unwrap())
            })
            .collect();
        pixels.sort_by(|a, b| b.0.total_cmp(&a.0));
        let rest = &pixels[on_edges..];
        let squared: f64 = rest.iter().map(|pixel| pixel.0).sum();
        let scale: f64 = cpu.iter().flatten().map(|&x| f64::from(x).powi(2)).sum();
        let error = (squared / scale.max(1e-30)).sqrt();
        let worst = rest.iter().map(|pixel| pixel.1).max().unwrap();
        assert!(
            worst <= 1 && error <= 1e-4,
            "{name}, {part}: bytes differ by {worst}, radiance by {error:e}"
        );
    }
}

fn lit(picture: &Rendering) -> usize {
    let radiance = picture.radiance();
    radiance.iter().filter(|pixel| **pixel != [0.0; 3]).count()
}

#[test]
fn virtual_lights_shine_as_on_the_cpu() {
    for name in ["room.glb", "materials.glb"] {
        let (scene, camera) = load(name);
        let cpu = CpuRenderer::new(&scene);
        let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
        for kind in [VirtualLightKind::Polygon, POINTS] {
            let settings = BounceSettings { kind, ..coarse() };
            let lights = cpu
                .virtual_lights(&camera, &settings, Watch::none())
                .unwrap();
            assert!(lights.len() > 10, "{}", lights.len());
            for direct in [true, false] {
                let settings = RenderSettings { direct, ..small() };
                let render = |lights: &VirtualLights| {
                    let cpu = cpu.render_with_bounce(&camera, &settings, lights, Watch::none());
                    let gpu = gpu.render_with_bounce(&camera, &settings, lights, Watch::none());
                    (cpu.unwrap(), gpu.unwrap())
                };
                let name = format!("{name}, {kind:?}, direct: {direct}");
                let (expected, got) = render(&lights);
                assert!(lit(&expected) > 48 * 32 / 3, "{name}");
                assert_same(&name, &expected, &got, 12);
                // The lights are not kept for a picture without them.
                let (expected, got) = render(&VirtualLights::default());
                assert_eq!(lit(&got) > 0, direct, "{name}");
                assert_same(&name, &expected, &got, 12);
            }
        }
    }
}

#[test]
fn other_virtual_lights_take_the_place_of_those_before() {
    let (scene, camera) = load("room.glb");
    let cpu = CpuRenderer::new(&scene);
    let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
    let lights = |virtual_lights| {
        let settings = BounceSettings {
            virtual_lights,
            ..coarse()
        };
        cpu.virtual_lights(&camera, &settings, Watch::none())
            .unwrap()
    };
    let (many, few) = (lights(100), lights(30));
    assert!(many.len() > few.len());
    let settings = RenderSettings {
        direct: false,
        ..small()
    };
    let render = |lights: &VirtualLights| {
        let picture = gpu.render_with_bounce(&camera, &settings, lights, Watch::none());
        picture.unwrap()
    };
    let first = render(&many);
    let other = render(&few);
    assert_ne!(first, other);
    assert_eq!(render(&many), first);
    assert_eq!(render(&many.clone()), first);
    let expected = cpu.render_with_bounce(&camera, &settings, &few, Watch::none());
    assert_same("few", &expected.unwrap(), &other, 12);
}

/// What adds little is left out of virtual lights as of others, and methods that know no virtual
/// light's distance field leave its reflection out.
#[test]
fn methods_hold_for_virtual_lights() {
    let (scene, camera) = load("room.glb");
    let cpu = CpuRenderer::new(&scene);
    let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
    let lights = cpu
        .virtual_lights(&camera, &coarse(), Watch::none())
        .unwrap();
    let field = DistanceFieldSettings::new(16, 2.0, false).unwrap();
    let smoothness = DistanceFieldSmoothness::default();
    let distances = SpecularMethod::ReflectedDistanceField { field, smoothness };
    for (specular, light_bound) in [(SpecularMethod::default(), 1e-7), (distances, 0.0)] {
        let settings = RenderSettings {
            specular,
            light_bound,
            ..small()
        };
        let expected = cpu.render_with_bounce(&camera, &settings, &lights, Watch::none());
        let got = gpu.render_with_bounce(&camera, &settings, &lights, Watch::none());
        let name = format!("{specular:?}");
        assert_same(&name, &expected.unwrap(), &got.unwrap(), 12);
    }
}

/// More than a software driver's shader may go through at once.
#[test]
fn thousands_of_virtual_lights() {
    let (scene, camera) = load("room.glb");
    let cpu = CpuRenderer::new(&scene);
    let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
    let settings = RenderSettings {
        width: 12,
        height: 8,
        samples: 1,
        direct: false,
        ..RenderSettings::default()
    };
    for (kind, face_size) in [(VirtualLightKind::Polygon, 40), (POINTS, 110)] {
        let bounce = BounceSettings {
            face_size,
            kind,
            merges: false,
            clusters: false,
            ..BounceSettings::default()
        };
        let lights = cpu.virtual_lights(&camera, &bounce, Watch::none()).unwrap();
        // Polygons have at least five records, points one.
        let least = if kind == POINTS { 65_536 } else { 9_000 };
        assert!(lights.len() > least, "{kind:?}: {}", lights.len());
        let expected = cpu.render_with_bounce(&camera, &settings, &lights, Watch::none());
        let got = gpu.render_with_bounce(&camera, &settings, &lights, Watch::none());
        assert_same(&format!("{kind:?}"), &expected.unwrap(), &got.unwrap(), 3);
    }
}

/// Both backends see the same surfaces, light them alike and make the same lights of them.
#[test]
fn virtual_lights_are_those_of_the_cpu() {
    for (name, kind, method, bounces, most_flux, most_error) in [
        (
            "room.glb",
            VirtualLightKind::Polygon,
            BounceMethod::CubeMap,
            2,
            1e-3,
            2e-3,
        ),
        ("room.glb", POINTS, BounceMethod::CubeMap, 1, 1e-3, 1e-2),
        (
            "two-rooms.glb",
            VirtualLightKind::Polygon,
            BounceMethod::ReflectiveShadowMaps,
            1,
            1e-3,
            2e-3,
        ),
        (
            "materials.glb",
            VirtualLightKind::Polygon,
            BounceMethod::CubeMap,
            1,
            1e-2,
            1e-2,
        ),
    ] {
        let (scene, camera) = load(name);
        let cpu = CpuRenderer::new(&scene);
        let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
        let settings = BounceSettings {
            kind,
            method,
            bounces,
            face_size: 32,
            ..coarse()
        };
        let on_cpu = cpu
            .virtual_lights(&camera, &settings, Watch::none())
            .unwrap();
        let on_gpu = gpu
            .virtual_lights(&camera, &settings, Watch::none())
            .unwrap();
        let name = format!("{name}, {kind:?}, {method:?}");
        assert!(!on_cpu.is_empty(), "{name}");
        for (a, b) in on_cpu.flux().into_iter().zip(on_gpu.flux()) {
            assert!((a - b).abs() <= most_flux * a, "{name}: {a} {b}");
        }
        for (a, b) in on_gpu.flux().into_iter().zip(on_gpu.gathered_flux()) {
            assert!((a - b).abs() <= 1e-4 * b, "{name}: {a} {b}");
        }
        let settings = RenderSettings {
            direct: false,
            ..small()
        };
        let expected = cpu.render_with_bounce(&camera, &settings, &on_cpu, Watch::none());
        let got = gpu.render_with_bounce(&camera, &settings, &on_gpu, Watch::none());
        let error = difference(&expected.unwrap(), &got.unwrap(), 12);
        assert!(error <= most_error, "{name}: {error:e}");
        if GPU.adapter().has_timestamps {
            assert!(gpu.timings().unwrap().bounce > 0.0, "{name}");
        }
    }
}

/// The relative root mean square of the differences in radiance, of all pixels but the worst ones.
fn difference(cpu: &Rendering, gpu: &Rendering, on_edges: usize) -> f64 {
    let (cpu, gpu) = (cpu.radiance(), gpu.radiance());
    let squared = |a: &[f32; 3], b: &[f32; 3]| -> f64 {
        (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum()
    };
    let mut squares: Vec<f64> = cpu.iter().zip(&gpu).map(|(a, b)| squared(a, b)).collect();
    squares.sort_by(|a, b| b.total_cmp(a));
    let scale: f64 = cpu.iter().map(|pixel| squared(pixel, &[0.0; 3])).sum();
    (squares[on_edges..].iter().sum::<f64>() / scale).sqrt()
}

#[test]
fn nothing_makes_no_lights() {
    let empty = Scene::default();
    let (mut dark, camera) = load("room.glb");
    let mut nowhere = camera.clone();
    nowhere.world_from_camera.translation.x = f32::NAN;
    let room = dark.clone();
    dark.polygon_lights.clear();
    dark.punctual_lights.clear();
    for (name, scene, camera) in [
        ("empty", &empty, &camera),
        ("dark", &dark, &camera),
        ("from nowhere", &room, &nowhere),
    ] {
        let gpu = GpuRenderer::new(&GPU, scene).unwrap();
        for method in [BounceMethod::CubeMap, BounceMethod::ReflectiveShadowMaps] {
            let settings = BounceSettings {
                method,
                face_size: 3,
                ..coarse()
            };
            let lights = gpu.virtual_lights(camera, &settings, Watch::none());
            let lights = lights.unwrap();
            // Shadow maps look from the lights, wherever the camera is.
            let is_seen = name == "from nowhere" && method != BounceMethod::CubeMap;
            assert_eq!(lights.is_empty(), !is_seen, "{name}, {method:?}");
            assert!(lights.flux().iter().all(|flux| flux.is_finite()));
        }
    }
    let gpu = GpuRenderer::new(&GPU, &room).unwrap();
    let one_texel = BounceSettings {
        face_size: 1,
        ..coarse()
    };
    let lights = gpu
        .virtual_lights(&camera, &one_texel, Watch::none())
        .unwrap();
    assert!((1..=6).contains(&lights.len()), "{}", lights.len());
    let many = BounceSettings {
        face_size: 100_000,
        ..coarse()
    };
    let fault = gpu
        .virtual_lights(&camera, &many, Watch::none())
        .unwrap_err();
    assert!(matches!(fault, RenderError::OutOfRange { .. }), "{fault}");
}

#[test]
fn cube_maps_stop_when_asked() {
    let (scene, camera) = load("room.glb");
    let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
    let cancelled = AtomicBool::new(false);
    let stop = |_, _| cancelled.store(true, Ordering::Relaxed);
    let watch = Watch {
        progress: &stop,
        cancelled: &cancelled,
    };
    let settings = BounceSettings {
        bounces: 3,
        ..coarse()
    };
    let fault = gpu.virtual_lights(&camera, &settings, watch).unwrap_err();
    assert_eq!(fault, RenderError::Cancelled);
    let again = gpu
        .virtual_lights(&camera, &settings, Watch::none())
        .unwrap();
    assert!(!again.is_empty());
}

/// Asserts that hardly a pixel differs by more than two bytes, one in 200, and the others by so little
/// as single rays make that pass an edge on one device and meet it on the other.
fn assert_nearly_same(name: &str, cpu: &Rendering, gpu: &Rendering) {
    let [expected, got] = [cpu.radiance(), gpu.radiance()];
    let bytes = [&expected, &got].map(|pixels| srgb8(pixels, 0.0, ToneMap::None));
    let differing = (0..expected.len())
        .filter(|i| (3 * i..3 * i + 3).any(|i| bytes[0][i].abs_diff(bytes[1][i]) > 2))
        .count();
    let most = expected.len() / 200;
    let error = difference(cpu, gpu, most);
    println!("{name}: {differing} pixels differ, radiance by {error:e}");
    assert!(
        differing <= most && error <= 2e-3,
        "{name}: {differing} pixels differ, radiance by {error:e}"
    );
}

fn traced(kind: VirtualLightKind) -> BounceSettings {
    BounceSettings {
        kind,
        visibility: BounceVisibility::Traced,
        ..coarse()
    }
}

#[test]
fn surfaces_block_virtual_lights_as_on_the_cpu() {
    let field = DistanceFieldSettings::new(16, 2.0, false).unwrap();
    let smoothness = DistanceFieldSmoothness::default();
    for (name, specular, light_bound) in [
        ("cornell.glb", SpecularMethod::default(), 0.0),
        ("cornell.glb", SpecularMethod::default(), 1e-7),
        ("materials.glb", SpecularMethod::default(), 0.0),
        ("cornell.glb", SpecularMethod::LightVector, 0.0),
        (
            "cornell.glb",
            SpecularMethod::ReflectedDistanceField { field, smoothness },
            0.0,
        ),
    ] {
        let (scene, camera) = load(name);
        let cpu = CpuRenderer::new(&scene);
        let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
        let settings = RenderSettings {
            samples: 1,
            direct: false,
            specular,
            light_bound,
            ..small()
        };
        for kind in [VirtualLightKind::Polygon, POINTS] {
            let lights = |settings| {
                cpu.virtual_lights(&camera, &settings, Watch::none())
                    .unwrap()
            };
            let blocked = lights(traced(kind));
            let unblocked = lights(BounceSettings { kind, ..coarse() });
            let render = |lights: &VirtualLights| {
                let picture = gpu.render_with_bounce(&camera, &settings, lights, Watch::none());
                picture.unwrap()
            };
            let expected = cpu.render_with_bounce(&camera, &settings, &blocked, Watch::none());
            let got = render(&blocked);
            let name = format!("{name}, {specular:?}, {light_bound}, {kind:?}");
            assert_nearly_same(&name, &expected.unwrap(), &got);
            // Blocked and unblocked lights take turns.
            assert_ne!(render(&unblocked), got, "{name}");
            assert_eq!(render(&blocked), got, "{name}");
        }
    }
}

/// Lights that surfaces block before the first bounce and after it; further bounces likewise.
#[test]
fn surfaces_block_all_light_as_on_the_cpu() {
    for name in ["cornell.glb", "materials.glb"] {
        let (scene, camera) = load(name);
        let cpu = CpuRenderer::new(&scene);
        let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
        let (low, high) = scene.bounds().unwrap();
        // In the open, off what lies in the middle.
        let center = low + (high - low) * Vec3::new(0.55, 0.7, 0.6);
        for (method, bounces) in [
            (BounceMethod::CubeMap, 2),
            (BounceMethod::ReflectiveShadowMaps, 1),
        ] {
            let settings = BounceSettings {
                method,
                bounces,
                shadows: true,
                centers: BounceCenters::Points(vec![center.to_array()]),
                ..traced(VirtualLightKind::Polygon)
            };
            let [cpu, gpu, bright] = [
                cpu.virtual_lights(&camera, &settings, Watch::none()),
                gpu.virtual_lights(&camera, &settings, Watch::none()),
                gpu.virtual_lights(
                    &camera,
                    &BounceSettings {
                        shadows: false,
                        visibility: BounceVisibility::None,
                        ..settings.clone()
                    },
                    Watch::none(),
                ),
            ]
            .map(|lights| lights.unwrap().flux());
            println!("{name}, {method:?}: {cpu:?}, {gpu:?}, {bright:?} unblocked");
            for channel in 0..3 {
                let off = (cpu[channel] - gpu[channel]).abs();
                // Rays and rasters meet different surfaces at silhouettes.
                assert!(off <= 4e-3 * cpu[channel], "{name}: {cpu:?}, not {gpu:?}");
                assert!(
                    gpu[channel] < bright[channel],
                    "{name}: {gpu:?}, {bright:?}"
                );
            }
        }
    }
}

/// A lamp over a floor, a wall, and a board between that half consists of holes, or has none.
fn behind_a_board(has_holes: bool) -> (Scene, Camera) {
    let square = |center: Vec3, u: Vec3, v: Vec3, material| Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(a, b)| center + u * a + v * b)
            .to_vec(),
        normals: vec![u.cross(v).normalize(); 4],
        texcoords: [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    };
    let is_hole = |i: u32| has_holes && (i / 4 + i % 4).is_multiple_of(2);
    let texels = (0..16).map(|i| [255, 255, 255, if is_hole(i) { 0 } else { 255 }]);
    let sampler = Sampler {
        filter: Filter::Nearest,
        ..Sampler::default()
    };
    let texture = Texture::from_rgba8("", [4; 2], texels.collect(), true, sampler).unwrap();
    let plain = Material {
        metallic: 0.0,
        ..Material::default()
    };
    let masked = Material {
        base_color_texture: Some(TextureRef::default()),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        double_sided: true,
        ..plain.clone()
    };
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let mut scene = Scene {
        meshes: vec![
            square(Vec3::ZERO, z * 2.0, x * 2.0, 0).into(),
            square(x * -2.0 + y, y, z * 2.0, 0).into(),
            square(x * -1.0 + y * 0.8, y * 0.6, z, 1).into(),
        ],
        materials: vec![plain, masked],
        textures: vec![texture],
        ..Scene::default()
    };
    let mut camera = Camera::framing(&scene);
    let eye = Vec3::new(3.0, 2.5, 1.5);
    let back = eye.normalize();
    let right = y.cross(back).normalize();
    let axes = Mat3::from_cols(right, back.cross(right), back);
    camera.world_from_camera = Affine3A::from_mat3_translation(axes, eye);
    scene.punctual_lights.push(PunctualLight {
        name: String::new(),
        kind: PunctualKind::Point,
        position: Vec3::new(1.0, 1.5, 0.3),
        direction: -y,
        color: Vec3::splat(5.0),
        range: None,
    });
    (scene, camera)
}

#[test]
fn light_passes_the_holes_of_a_mask() {
    let settings = RenderSettings {
        direct: false,
        ..small()
    };
    let [with_holes, without] = [true, false].map(|has_holes| {
        let (scene, camera) = behind_a_board(has_holes);
        let cpu = CpuRenderer::new(&scene);
        let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
        // The same lights for both boards: none is on them.
        let bounce = BounceSettings {
            shadows: true,
            centers: BounceCenters::Points(vec![[1.0, 1.5, 0.3]]),
            ..traced(VirtualLightKind::Polygon)
        };
        let lights = gpu.virtual_lights(&camera, &bounce, Watch::none()).unwrap();
        let on_cpu = cpu.virtual_lights(&camera, &bounce, Watch::none()).unwrap();
        let ([got, ..], [expected, ..]) = (lights.flux(), on_cpu.flux());
        assert!(
            (got - expected).abs() < 2e-3 * expected,
            "{got}, {expected}"
        );
        let expected = cpu.render_with_bounce(&camera, &settings, &lights, Watch::none());
        let got = gpu.render_with_bounce(&camera, &settings, &lights, Watch::none());
        let got = got.unwrap();
        assert!(lit(&got) > 48 * 32 / 4, "{}", lit(&got));
        assert_nearly_same(&format!("holes: {has_holes}"), &expected.unwrap(), &got);
        got
    });
    assert_ne!(with_holes, without);
}

#[test]
fn nothing_blocks_light_where_nothing_is() {
    let (cornell, camera) = load("cornell.glb");
    let lights = CpuRenderer::new(&cornell).virtual_lights(
        &camera,
        &traced(VirtualLightKind::Polygon),
        Watch::none(),
    );
    let scene = Scene::default();
    let gpu = GpuRenderer::new(&GPU, &scene).unwrap();
    let picture = gpu.render_with_bounce(&camera, &small(), &lights.unwrap(), Watch::none());
    assert_eq!(lit(&picture.unwrap()), 0);
    let bounce = BounceSettings {
        shadows: true,
        ..traced(POINTS)
    };
    let lights = gpu.virtual_lights(&camera, &bounce, Watch::none()).unwrap();
    assert!(lights.is_empty());
}
