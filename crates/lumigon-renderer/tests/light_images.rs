//! Pictures on lights, through the whole renderer.

use lumigon::{ImageMethod, LightImageError, SpecularMethod};
use lumigon_renderer::{
    Camera, CpuRenderer, ImageFile, Limits, Pixels, ReferenceSettings, RenderError, RenderSettings,
    Scene, Watch,
};

fn scene(name: &str) -> (Scene, Camera) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/");
    let scene = Scene::load(format!("{folder}{name}.glb")).unwrap();
    let camera = scene.cameras[0].clone();
    (scene, camera)
}

fn small(taps: u32) -> RenderSettings {
    RenderSettings {
        width: 72,
        height: 45,
        samples: 1,
        specular: SpecularMethod::None,
        image_method: ImageMethod::Quadrature { taps },
        ..RenderSettings::default()
    }
}

/// Sum of a channel.
fn sum(pixels: &Pixels, channel: usize) -> f64 {
    pixels.iter().map(|p| f64::from(p[channel])).sum()
}

/// The scenes' diffuse light has the path tracer's colours.
#[test]
fn colours_are_the_path_tracers() {
    for name in ["screens", "stained-glass", "neon"] {
        let (scene, camera) = scene(name);
        assert!(
            scene
                .polygon_lights
                .iter()
                .all(|light| light.image.is_some())
        );
        let renderer = CpuRenderer::new(&scene);
        let truth = ReferenceSettings {
            width: 72,
            height: 45,
            samples: 1,
            paths: 512,
            shadows: false,
            ..ReferenceSettings::default()
        };
        let truth = renderer.reference(&camera, &truth, Watch::none()).unwrap();
        let found = renderer.render(&camera, &small(4), Watch::none()).unwrap();
        for channel in 0..3 {
            let (found, truth) = (
                sum(&found.diffuse, channel),
                sum(&truth.mean.diffuse, channel),
            );
            println!("{name} {channel}: {found} {truth}");
            assert!(
                (found / truth - 1.0).abs() < 0.02,
                "{name}: {found} {truth}"
            );
        }
    }
}

/// A picture that is replaced in place lights as if the scene had been read with it.
#[test]
fn replaced_pictures_are_the_new_ones() {
    let (mut scene, camera) = scene("screens");
    let plain = scene.clone();
    let mut renderer = CpuRenderer::new(&plain);
    let light = 7;
    let image = plain.polygon_lights[light].image.unwrap();
    let before = renderer.render(&camera, &small(2), Watch::none()).unwrap();
    let [width, height] = image.size;
    let texels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| {
            [
                (i % width) as f32 / width as f32,
                0.2,
                (i / width) as f32 / height as f32,
            ]
        })
        .collect();
    let file = ImageFile::from_linear("frame", image.size, &texels).unwrap();
    let name = &plain.polygon_lights[light].name;
    let count = scene.replace_light_image(name, &file, &Limits::default());
    assert_eq!(count.unwrap(), 1);
    let shown = scene.polygon_lights[light].image.unwrap();
    assert_eq!(shown.size, image.size);

    // A bad frame between two good ones.
    let cells = shown.cells(&scene.textures, shown.size);
    let mut bad = cells.clone();
    bad[5][0] = f32::NAN;
    let fault = renderer.replace_light_image(light, &bad).unwrap_err();
    assert!(
        matches!(
            fault,
            RenderError::Picture(LightImageError::Value { x: 5, y: 0, .. })
        ),
        "{fault}"
    );
    let still = renderer.render(&camera, &small(2), Watch::none()).unwrap();
    assert!(still.diffuse == before.diffuse);
    let fault = renderer.replace_light_image(99, &cells).unwrap_err();
    assert!(
        fault.to_string().contains("light 99 shows no picture"),
        "{fault}"
    );

    renderer.replace_light_image(light, &cells).unwrap();
    let replaced = renderer.render(&camera, &small(2), Watch::none()).unwrap();
    let read = CpuRenderer::new(&scene)
        .render(&camera, &small(2), Watch::none())
        .unwrap();
    let apart = |a: &Pixels, b: &Pixels| {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    assert!(apart(&replaced.diffuse, &before.diffuse) > 1e-4);
    assert!(apart(&replaced.diffuse, &read.diffuse) < 1e-6);
}
