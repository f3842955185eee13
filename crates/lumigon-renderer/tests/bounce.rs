//! Bounce light by virtual lights against the path tracer's.

use std::path::Path;

use glam::Vec3;
use lumigon::SpecularMethod;
use lumigon_renderer::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, Camera, CpuRenderer, Pixels,
    ReferenceSettings, RenderSettings, Rendering, Scene, VirtualLightKind, VirtualLights, Watch,
};

const SIZE: [u32; 2] = [48, 48];

fn scene(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::load(folder.join(name)).unwrap()
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
) -> Pixels {
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
    picture.mean.diffuse
}

/// Root mean square difference, relative to that of the truth, and relative difference of the means.
fn errors(pixels: &Pixels, truth: &Pixels) -> [f32; 2] {
    let (mut squared, mut all, mut sum, mut true_sum) = (0.0, 0.0, 0.0, 0.0);
    for (&a, &b) in pixels.iter().zip(truth) {
        let (a, b) = (Vec3::from(a), Vec3::from(b));
        squared += (a - b).length_squared();
        all += b.length_squared();
        sum += a.element_sum();
        true_sum += b.element_sum();
    }
    [(squared / all).sqrt(), sum / true_sum - 1.0]
}

#[test]
fn sketch() {
    for name in ["cornell.glb", "room.glb", "two-rooms.glb"] {
        let scene = scene(name);
        let renderer = CpuRenderer::new(&scene);
        let camera = &scene.cameras[0];
        let references =
            [[false, false], [false, true], [true, true]].map(|s| truth(&renderer, camera, s));
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
