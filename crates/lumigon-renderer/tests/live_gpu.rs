//! Pictures in a window, on the GPU: drawn into textures, of scenes that are edited.

use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};
use lumigon::SpecularMethod;
use lumigon_renderer::{
    BounceCenters, BounceSettings, BounceVisibility, Camera, CpuRenderer, DisplaySettings, Gpu,
    GpuError, GpuPreference, GpuRenderer, ImageColors, Limits, Material, Mesh, PunctualKind,
    PunctualLight, RenderError, RenderSettings, Rendering, Sampler, Scene, Texture, TextureRef,
    ToneMap, VirtualLights, Watch, srgb8,
};

static GPU: LazyLock<Gpu> = LazyLock::new(new_gpu);

fn new_gpu() -> Gpu {
    Gpu::new(GpuPreference::Any).unwrap_or_else(|fault| panic!("these tests need a GPU: {fault}"))
}

fn load(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::load(folder.join(name)).unwrap()
}

fn small(samples: u32) -> RenderSettings {
    RenderSettings {
        width: 93,
        height: 61,
        samples,
        ..RenderSettings::default()
    }
}

fn texture(gpu: &Gpu, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn target(settings: &RenderSettings) -> wgpu::Texture {
    let size = [settings.width, settings.height];
    texture(&GPU, size, wgpu::TextureFormat::Rgba8Unorm)
}

/// The texture's bytes, red, green, blue and alpha, row by row.
fn read(texture: &wgpu::Texture) -> Vec<[u8; 4]> {
    let size = texture.size();
    let row = (size.width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = GPU.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * size.height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = GPU.device().create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        size,
    );
    GPU.queue().submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    let wait = wgpu::PollType::Wait {
        submission_index: None,
        timeout: None,
    };
    GPU.device().poll(wait).unwrap();
    let bytes = buffer.slice(..).get_mapped_range().unwrap();
    let rows = bytes.chunks(row as usize);
    rows.flat_map(|row| row[..4 * size.width as usize].as_chunks().0.to_vec())
        .collect()
}

/// Asserts that the columns of a drawn picture are those of a rendered one.
fn assert_shows(
    name: &str,
    drawn: &[[u8; 4]],
    rendered: &Rendering,
    display: DisplaySettings,
    columns: Range<u32>,
) {
    let expected = srgb8(&rendered.radiance(), display.exposure_ev, display.tone_map);
    let (mut most, mut bright) = (0, 0);
    for y in 0..rendered.height {
        for x in columns.clone() {
            let i = (y * rendered.width + x) as usize;
            for c in 0..3 {
                most = most.max(drawn[i][c].abs_diff(expected[3 * i + c]));
                bright += usize::from(expected[3 * i + c] > 0);
            }
            assert_eq!(drawn[i][3], 255, "{name}: is opaque");
        }
    }
    assert!(bright > 0, "{name} is black");
    assert!(most <= 1, "{name}: bytes differ by {most}");
}

const PLAIN: DisplaySettings = DisplaySettings {
    exposure_ev: 0.0,
    tone_map: ToneMap::KhronosPbrNeutral,
};

#[test]
fn textures_show_what_is_rendered() {
    let scene = load("cornell.glb");
    let camera = &scene.cameras[0];
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let none = VirtualLights::default();
    let settings = small(3);
    let rendered = renderer.render(camera, &settings, Watch::none()).unwrap();
    let target = target(&settings);
    for (tone_map, exposure_ev) in ToneMap::ALL.into_iter().zip([0.0, 1.3, -2.0, 0.5]) {
        let display = DisplaySettings {
            exposure_ev,
            tone_map,
        };
        renderer
            .draw(camera, &settings, &none, display, &target)
            .unwrap();
        let all = 0..settings.width;
        assert_shows(tone_map.name(), &read(&target), &rendered, display, all);
    }

    // With bounce light.
    let bounce = BounceSettings {
        centers: BounceCenters::Camera,
        virtual_lights: 30,
        face_size: 8,
        ..BounceSettings::default()
    };
    let lights = renderer.virtual_lights(camera, &bounce, Watch::none());
    let lights = lights.unwrap();
    let rendered = renderer.render_with_bounce(camera, &settings, &lights, Watch::none());
    renderer
        .draw(camera, &settings, &lights, PLAIN, &target)
        .unwrap();
    let (rendered, all) = (rendered.unwrap(), 0..settings.width);
    assert_shows("bounce", &read(&target), &rendered, PLAIN, all);

    // A camera without a place sees nothing.
    let mut nowhere = camera.clone();
    nowhere.world_from_camera.translation.x = f32::NAN;
    renderer
        .draw(&nowhere, &settings, &none, PLAIN, &target)
        .unwrap();
    assert!(read(&target).iter().all(|p| *p == [0, 0, 0, 255]));
}

/// Two looks share a texture.
#[test]
fn columns_are_drawn_alone() {
    let scene = load("cornell.glb");
    let camera = &scene.cameras[0];
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let none = VirtualLights::default();
    let settings = small(1);
    let target = target(&settings);
    let rendered = renderer.render(camera, &settings, Watch::none()).unwrap();
    let dark = DisplaySettings {
        exposure_ev: -3.0,
        tone_map: ToneMap::None,
    };
    for divider in [31, 60] {
        let (left, right) = (0..divider, divider..settings.width);
        for (columns, display) in [(left.clone(), PLAIN), (right.clone(), dark)] {
            renderer
                .draw_part(camera, &settings, &none, display, &target, columns)
                .unwrap();
        }
        let drawn = read(&target);
        assert_shows("left", &drawn, &rendered, PLAIN, left);
        assert_shows("right", &drawn, &rendered, dark, right);
    }
    // Nothing, and what is not there.
    for columns in [5..5, 93..200] {
        renderer
            .draw_part(camera, &settings, &none, PLAIN, &target, columns)
            .unwrap();
    }
}

#[test]
fn textures_that_will_not_do_are_refused() {
    let scene = load("cornell.glb");
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let settings = small(1);
    let size = [settings.width, settings.height];
    for (size, format, named) in [
        ([92, 61], wgpu::TextureFormat::Rgba8Unorm, "92 x 61"),
        (size, wgpu::TextureFormat::Rgba8UnormSrgb, "Rgba8UnormSrgb"),
        (size, wgpu::TextureFormat::R32Float, "R32Float"),
    ] {
        let target = texture(&GPU, size, format);
        let none = VirtualLights::default();
        let drawn = renderer.draw(&scene.cameras[0], &settings, &none, PLAIN, &target);
        let fault = drawn.unwrap_err();
        assert!(matches!(fault, RenderError::Target { .. }), "{fault}");
        assert!(fault.to_string().contains(named), "{fault}");
    }
}

#[test]
fn times_come_later() {
    let scene = load("cornell.glb");
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    if !GPU.adapter().has_timestamps {
        return;
    }
    assert_eq!(renderer.timings(), None);
    let settings = small(20);
    let target = target(&settings);
    let none = VirtualLights::default();
    // More than can be on their way at once.
    for _ in 0..7 {
        renderer
            .draw(&scene.cameras[0], &settings, &none, PLAIN, &target)
            .unwrap();
    }
    let start = Instant::now();
    while renderer.timings().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "no times come");
        std::thread::sleep(Duration::from_millis(2));
    }
    let timings = renderer.timings().unwrap();
    assert!(
        timings.visibility > 0.0 && timings.shading > 0.0,
        "{timings:?}"
    );
}

#[test]
fn a_lost_device_is_told_when_drawing() {
    let gpu = new_gpu();
    let mut scene = load("cornell.glb");
    let camera: Camera = scene.cameras[0].clone();
    let mut renderer = GpuRenderer::new(&gpu, &scene).unwrap();
    let settings = small(1);
    let size = [settings.width, settings.height];
    let target = texture(&gpu, size, wgpu::TextureFormat::Rgba8Unorm);
    let none = VirtualLights::default();
    let draw = |renderer: &GpuRenderer| renderer.draw(&camera, &settings, &none, PLAIN, &target);
    draw(&renderer).unwrap();
    assert_eq!(gpu.is_lost(), None);
    gpu.device().destroy();
    // What was submitted may still be under way.
    let start = Instant::now();
    while gpu.is_lost().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "no loss is told");
        _ = draw(&renderer);
        std::thread::sleep(Duration::from_millis(2));
    }
    for _ in 0..2 {
        let fault = draw(&renderer).unwrap_err();
        let is_lost = matches!(fault, RenderError::Gpu(GpuError::Lost { .. }));
        assert!(is_lost, "{fault}");
    }
    scene.polygon_lights.clear();
    let fault = renderer.set_lights(&scene.polygon_lights).unwrap_err();
    assert!(matches!(fault, GpuError::Lost { .. }), "{fault}");
    let fault = renderer.set_scene(&scene).unwrap_err();
    assert!(matches!(fault, GpuError::Lost { .. }), "{fault}");
    assert!(renderer.timings().is_none_or(|times| times.shading >= 0.0));
}

/// A polygon of `corners` in the plane y = `height`, facing down, with texture coordinates.
fn lamp(material: usize, corners: u32, radius: f32, center: Vec3) -> Mesh {
    let around = (0..corners).map(|i| {
        let angle = i as f32 * std::f32::consts::TAU / corners as f32;
        Vec2::new(angle.cos(), angle.sin())
    });
    let around: Vec<_> = around.collect();
    Mesh {
        name: format!("lamp of {corners}"),
        material,
        positions: around
            .iter()
            .map(|c| center + radius * Vec3::new(c.x, 0.0, c.y))
            .collect(),
        normals: vec![Vec3::NEG_Y; corners as usize],
        texcoords: [
            around.iter().map(|c| 0.5 * (*c + Vec2::ONE)).collect(),
            Vec::new(),
        ],
        triangles: (2..corners).map(|i| [0, i - 1, i]).collect(),
        ..Mesh::default()
    }
}

/// Replaces a mesh or adds one, with the lights that it is.
fn set_mesh(scene: &mut Scene, index: usize, mesh: Mesh) {
    let mesh = Arc::new(mesh);
    if index < scene.meshes.len() {
        scene.meshes[index] = mesh;
    } else {
        scene.meshes.push(mesh);
    }
    scene.polygon_lights.retain(|light| light.mesh != index);
    let (lights, warnings) = scene.lights_of_mesh(index, &Limits::default());
    assert!(warnings.is_empty(), "{warnings:?}");
    scene.polygon_lights.extend(lights);
}

/// Pipelines without specular light are soon made.
fn plain() -> RenderSettings {
    RenderSettings {
        specular: SpecularMethod::None,
        ..small(2)
    }
}

/// Asserts that a renderer whose scene was set shows what one that was made for it does.
fn assert_is_new(name: &str, edited: &GpuRenderer, scene: &Scene, camera: &Camera) -> Rendering {
    let settings = plain();
    let new = GpuRenderer::new(&GPU, scene).unwrap();
    assert_eq!(edited.warnings(), new.warnings(), "{name}");
    let [found, expected] = [edited, &new].map(|renderer| {
        let picture = renderer.render(camera, &settings, Watch::none());
        picture.unwrap()
    });
    assert_near(name, &found, &expected);
    found
}

fn assert_near(name: &str, found: &Rendering, expected: &Rendering) {
    let (found, expected) = (found.radiance(), expected.radiance());
    let brightest = expected.iter().flatten().copied().fold(0.0, f32::max);
    assert!(brightest > 0.0, "{name} is black");
    let mut worst = 0.0_f32;
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        worst = worst.max((found - expected).abs() / expected.max(1e-3 * brightest));
    }
    assert!(worst < 1e-5, "{name}: off by {worst:e}");
}

fn bounced(renderer: &GpuRenderer, scene: &Scene, camera: &Camera) -> (VirtualLights, Rendering) {
    let (low, high) = scene.bounds().unwrap();
    let bounce = BounceSettings {
        centers: BounceCenters::Points(vec![low.midpoint(high).to_array()]),
        virtual_lights: 20,
        face_size: 8,
        visibility: BounceVisibility::Traced,
        ..BounceSettings::default()
    };
    let lights = renderer.virtual_lights(camera, &bounce, Watch::none());
    let lights = lights.unwrap();
    let settings = RenderSettings {
        direct: false,
        ..plain()
    };
    let picture = renderer.render_with_bounce(camera, &settings, &lights, Watch::none());
    (lights, picture.unwrap())
}

/// One edit after the other, as somebody at work does them, and back again.
#[test]
fn edited_scenes_look_like_new_ones() {
    let first = load("cornell.glb");
    let camera = first.cameras[0].clone();
    let mut renderer = GpuRenderer::new(&GPU, &first).unwrap();
    let before = renderer.render(&camera, &plain(), Watch::none()).unwrap();
    let (low, high) = first.bounds().unwrap();
    let middle = low.midpoint(high);
    let mut scene = first.clone();
    let mut show = |name: &str, scenes: &[&Scene]| {
        for scene in scenes {
            renderer.set_scene(scene).unwrap();
        }
        assert_is_new(name, &renderer, scenes[scenes.len() - 1], &camera)
    };

    let own = scene.polygon_lights[0].mesh;
    let mut moved = Mesh::clone(&scene.meshes[own]);
    for position in &mut moved.positions {
        position.y -= 0.2 * (high.y - low.y);
    }
    set_mesh(&mut scene, own, moved);
    let after = show("moved", &[&scene]);
    assert_ne!(before, after);

    let material = scene.meshes[own].material;
    let reshaped = [3, 9, 40, 5].map(|corners| {
        let reshaped = lamp(material, corners, 0.15 * (high.x - low.x), middle);
        set_mesh(&mut scene, own, reshaped);
        scene.clone()
    });
    show("reshaped", &reshaped.each_ref());

    let added = scene.meshes.len();
    scene.materials.push(Material {
        emissive: Vec3::new(4.0, 1.0, 0.5),
        double_sided: true,
        ..Material::default()
    });
    let last = scene.materials.len() - 1;
    let place = middle.midpoint(low);
    set_mesh(
        &mut scene,
        added,
        lamp(last, 6, 0.1 * (high.x - low.x), place),
    );
    show("added", &[&scene]);

    let mut without = scene.clone();
    let nothing = Mesh {
        material,
        ..Mesh::default()
    };
    set_mesh(&mut without, own, nothing);
    assert!(without.polygon_lights.len() < scene.polygon_lights.len());
    show("removed", &[&without]);

    // What is no light.
    let mut other = scene.clone();
    other.punctual_lights.push(PunctualLight {
        name: String::new(),
        kind: PunctualKind::Point,
        position: middle,
        direction: Vec3::NEG_Y,
        color: Vec3::splat(0.3 * (high - low).length_squared()),
        range: None,
    });
    for material in &mut other.materials {
        material.base_color.x *= 0.5;
        material.double_sided = !material.double_sided;
    }
    show("other materials", &[&other]);

    // An image on a light, the first texture of all.
    assert!(scene.textures.is_empty(), "so that pipelines change");
    let texels = (0..16 * 8).map(|i: u32| [(i * 40) as u8, (i * 7) as u8, 90, 255]);
    let image = |name: &str, texels: Vec<[u8; 4]>| {
        Texture::from_rgba8(name, [16, 8], texels, true, Sampler::default()).unwrap()
    };
    scene.textures.push(image("stripes", texels.collect()));
    scene.materials[last].emissive_texture = Some(TextureRef::default());
    let again = Mesh::clone(&scene.meshes[added]);
    set_mesh(&mut scene, added, again);
    assert!(
        scene
            .polygon_lights
            .iter()
            .any(|light| light.image.is_some())
    );
    let first_image = scene.clone();

    // It stays where another light moves, which sorts the lights anew, or gets an image too.
    let mut all = vec![first_image];
    for shift in [0.3, -0.3, -0.3] {
        let mut moved = Mesh::clone(&scene.meshes[own]);
        for position in &mut moved.positions {
            position.x += shift * (high.x - low.x);
        }
        set_mesh(&mut scene, own, moved);
        all.push(scene.clone());
    }
    let texels = (0..16 * 8).map(|i: u32| [(i * 3) as u8, 200, (i * 11) as u8, 255]);
    scene
        .textures
        .insert(0, image("other stripes", texels.collect()));
    for (index, texture) in [(last, 1), (material, 0)] {
        scene.materials[index].emissive_texture = Some(TextureRef {
            texture,
            ..TextureRef::default()
        });
    }
    for index in [own, added] {
        let again = Mesh::clone(&scene.meshes[index]);
        set_mesh(&mut scene, index, again);
    }
    all.push(scene.clone());
    show("with two images", &all.iter().collect::<Vec<_>>());

    // All of it undone, done again, and undone.
    let nothing = Scene {
        meshes: first.meshes.clone(),
        materials: first.materials.clone(),
        ..Scene::default()
    };
    for scene in [&first, &scene, &nothing, &first] {
        renderer.set_scene(scene).unwrap();
    }
    let undone = renderer.render(&camera, &plain(), Watch::none()).unwrap();
    assert_near("undone", &undone, &before);
}

/// Bounce light is that of the scene that was set: what rays meet, and what cube maps see.
#[test]
fn edited_scenes_bounce_light_like_new_ones() {
    let mut scene = load("cornell.glb");
    let camera = scene.cameras[0].clone();
    let mut renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let before = bounced(&renderer, &scene, &camera);
    let own = scene.polygon_lights[0].mesh;
    let (low, high) = scene.bounds().unwrap();
    for (corners, height) in [(7, 0.7), (3, 0.4)] {
        let center = low.midpoint(high).with_y(low.y + height * (high.y - low.y));
        let material = scene.meshes[own].material;
        let reshaped = lamp(material, corners, 0.2 * (high.x - low.x), center);
        set_mesh(&mut scene, own, reshaped);
        renderer.set_scene(&scene).unwrap();
    }
    let found = bounced(&renderer, &scene, &camera);
    let new = GpuRenderer::new(&GPU, &scene).unwrap();
    let expected = bounced(&new, &scene, &camera);
    let is_same = format!("{:?}", found.0) == format!("{:?}", expected.0);
    assert!(is_same, "other virtual lights");
    assert_near("bounce", &found.1, &expected.1);
    assert_ne!(before.1, found.1);
    // What is seen is what the CPU sees.
    let cpu = CpuRenderer::new(&scene);
    let [on_gpu, on_cpu] = [
        renderer.render(&camera, &plain(), Watch::none()).unwrap(),
        cpu.render(&camera, &plain(), Watch::none()).unwrap(),
    ]
    .map(|picture| srgb8(&picture.radiance(), 0.0, ToneMap::None));
    let differing = on_gpu.iter().zip(&on_cpu);
    let differing = differing.filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert!(differing <= 30, "{differing} bytes differ from the CPU's");
}

/// Pictures that a light was given give way to the scene's, as they do in a new renderer.
#[test]
fn videos_end_with_a_scene() {
    let mut scene = load("cornell.glb");
    let texels = (0..64).map(|i: u32| [(i * 4) as u8, 255 - i as u8, 30, 255]);
    let texture = Texture::from_rgba8("", [8, 8], texels.collect(), true, Sampler::default());
    scene.textures.push(texture.unwrap());
    let own = scene.polygon_lights[0].mesh;
    let material = scene.meshes[own].material;
    scene.materials[material].emissive_texture = Some(TextureRef::default());
    let (low, high) = scene.bounds().unwrap();
    let center = low.midpoint(high);
    set_mesh(
        &mut scene,
        own,
        lamp(material, 4, 0.2 * (high.x - low.x), center),
    );
    let camera = scene.cameras[0].clone();
    let mut renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let before = assert_is_new("with a picture", &renderer, &scene, &camera);
    let light = scene.polygon_lights.iter().position(|l| l.image.is_some());
    let light = light.unwrap();
    let [width, height] = scene.polygon_lights[light].image.unwrap().size;
    let black = vec![[0; 4]; (width * height) as usize];
    renderer
        .replace_light_image(light, ImageColors::Srgb(&black))
        .unwrap();
    let dark = renderer.render(&camera, &plain(), Watch::none()).unwrap();
    assert_ne!(before, dark);
    renderer.set_scene(&scene).unwrap();
    assert_is_new("after a video", &renderer, &scene, &camera);
}

/// What moving one light costs in a small scene and in one of half a million triangles.
#[test]
fn one_light_moves_at_little_cost() {
    let mut scene = load("cornell.glb");
    let side = 500_u32;
    let (low, high) = scene.bounds().unwrap();
    let at = |i: u32| Vec3::new((i % side) as f32, 0.0, (i / side) as f32) / side as f32;
    let squares = (0..(side - 1) * (side - 1)).map(|i| i / (side - 1) * side + i % (side - 1));
    let floor = Mesh {
        positions: (0..side * side)
            .map(|i| low - 0.01 * (high - low) + at(i))
            .collect(),
        normals: vec![Vec3::Y; (side * side) as usize],
        triangles: squares
            .flat_map(|a| [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]])
            .collect(),
        ..Mesh::default()
    };
    let own = scene.polygon_lights[0].mesh;
    let small = scene.clone();
    scene.meshes.push(Arc::new(floor));
    for mut scene in [small, scene] {
        let triangles: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
        let start = Instant::now();
        let mut renderer = GpuRenderer::new(&GPU, &scene).unwrap();
        let whole = start.elapsed();
        let mut all = Vec::new();
        for _ in 0..20 {
            let mut moved = Mesh::clone(&scene.meshes[own]);
            for position in &mut moved.positions {
                position.y -= 1e-3 * (high.y - low.y);
            }
            set_mesh(&mut scene, own, moved);
            let start = Instant::now();
            renderer.set_scene(&scene).unwrap();
            all.push(start.elapsed());
        }
        all.sort();
        println!(
            "{triangles} triangles: {whole:?} for all, {:?} a move",
            all[10]
        );
        // Many times that is usual: other work goes on beside tests.
        assert!(all[10] < Duration::from_millis(20), "{all:?}");
    }
}
