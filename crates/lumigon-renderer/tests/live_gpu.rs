//! Pictures in a window, on the GPU: drawn into textures, of scenes that are edited.

use std::ops::Range;
use std::path::Path;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use lumigon_renderer::{
    BounceCenters, BounceSettings, Camera, DisplaySettings, Gpu, GpuError, GpuPreference,
    GpuRenderer, RenderError, RenderSettings, Rendering, Scene, ToneMap, VirtualLights, Watch,
    srgb8,
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
    assert!(renderer.timings().is_none_or(|times| times.shading >= 0.0));
}
