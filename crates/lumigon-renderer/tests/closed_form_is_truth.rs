//! The closed forms against the path tracer, through the whole renderer.

use lumigon_renderer::{Camera, CpuRenderer, ReferenceSettings, RenderSettings, Scene, Watch};

/// The exact diffuse light's deviation in standard errors of the reference: its rms over pixels,
/// that of the sum over pixels, and how many pixels there are.
///
/// The mean over pixels of deviation/error is no measure of bias: where a pixel's samples are
/// skewed, its error is small when its mean is.
fn z_scores(scene: &str, seed: u64) -> (f64, f64, u32) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/check/");
    let scene = Scene::load(format!("{folder}{scene}")).unwrap();
    let camera = scene
        .cameras
        .first()
        .cloned()
        .unwrap_or_else(|| Camera::framing(&scene));
    let renderer = CpuRenderer::new(&scene);
    let settings = RenderSettings {
        width: 96,
        height: 60,
        samples: 1,
        ..RenderSettings::default()
    };
    let exact = renderer.render(&camera, &settings, Watch::none()).unwrap();
    let reference = ReferenceSettings {
        width: settings.width,
        height: settings.height,
        samples: 1,
        paths: 1024,
        bounces: 1,
        shadows: false,
        seed,
        ..ReferenceSettings::default()
    };
    let reference = renderer
        .reference(&camera, &reference, Watch::none())
        .unwrap();
    let (mut squares, mut sum, mut variance, mut count) = (0.0, 0.0, 0.0, 0);
    for ((exact, mean), error) in exact
        .diffuse
        .iter()
        .zip(&reference.mean.diffuse)
        .zip(&reference.diffuse_error)
    {
        // One channel of each pixel: the three share their samples.
        let error = f64::from(error[1]);
        if error > 1e-3 * f64::from(exact[1]) && error > 0.0 {
            let deviation = f64::from(exact[1]) - f64::from(mean[1]);
            squares += (deviation / error).powi(2);
            sum += deviation;
            variance += error * error;
            count += 1;
        }
    }
    let rms: f64 = squares / f64::from(count);
    (rms.sqrt(), sum / variance.sqrt(), count)
}

#[test]
fn exact_diffuse_is_within_the_reference_noise() {
    for scene in ["square.glb", "holes.glb", "horizon.glb", "spheres.glb"] {
        let (rms, bias, count) = z_scores(scene, 7);
        println!("{scene}: rms {rms:.3}, bias {bias:.3} over {count}");
        assert!(count > 150, "{scene}: {count}");
        assert!((0.9..1.1).contains(&rms), "{scene}: rms {rms}");
        assert!(bias.abs() < 4.0, "{scene}: bias {bias}");
    }
}
