//! Whole frames lit by many quads: the table of Petryaev's "Polygons as lights", on the CPU.

use std::time::Instant;

use lumigon::{
    DiffuseMethod, DistanceFieldSettings, DistanceFieldSmoothness, LocalOcclusion, LtcLobes,
    ProjectionBasis, SpecularMethod,
};
use lumigon_renderer::{CpuRenderer, RenderSettings, Scene, Watch};
use serde::Serialize;

use super::median;
use crate::Failure;
use crate::interrupt::Interrupt;

const SCENES: [(u32, &[u8]); 4] = [
    (10, include_bytes!("../../../../scenes/quads-10.glb")),
    (20, include_bytes!("../../../../scenes/quads-20.glb")),
    (50, include_bytes!("../../../../scenes/quads-50.glb")),
    (98, include_bytes!("../../../../scenes/quads-98.glb")),
];

/// One method over all numbers of lights.
#[derive(Serialize)]
pub(super) struct QuadFigures {
    method: String,
    /// Number of quads and milliseconds a frame.
    milliseconds: Vec<(u32, f64)>,
    /// Slope of a least-squares line through them.
    milliseconds_a_light: f64,
}

pub(super) fn measure(interrupt: &Interrupt) -> Result<Vec<QuadFigures>, Failure> {
    println!(
        "\n{:44} {:>10} {:>10} {:>10} {:>10} {:>12}",
        "1440x900, ms a frame", "10 quads", "20 quads", "50 quads", "98 quads", "ms a light",
    );
    let scenes = SCENES
        .iter()
        .map(|&(count, bytes)| Ok((count, Scene::from_slice(bytes, None, "quads")?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let two = SpecularMethod::Ltc {
        lobes: LtcLobes::Two,
    };
    let distances = SpecularMethod::ReflectedDistanceField {
        field: DistanceFieldSettings::default(),
        smoothness: DistanceFieldSmoothness::default(),
    };
    let mut figures = Vec::new();
    for (diffuse_name, diffuse) in methods() {
        for (specular_name, specular) in [
            ("", SpecularMethod::None),
            (" + LTC", SpecularMethod::default()),
            (" + LTC, two lobes", two),
            (" + distance field", distances),
        ] {
            let mut milliseconds = Vec::new();
            for (count, scene) in &scenes {
                let settings = RenderSettings {
                    width: 1440,
                    height: 900,
                    samples: 1,
                    diffuse,
                    specular,
                    ..RenderSettings::default()
                };
                milliseconds.push((*count, frame(scene, &settings, interrupt)? * 1e3));
            }
            let one = QuadFigures {
                method: format!("{diffuse_name}{specular_name}"),
                milliseconds_a_light: slope(&milliseconds),
                milliseconds,
            };
            print!("{:44}", one.method);
            for (_, time) in &one.milliseconds {
                print!(" {time:>10.1}");
            }
            println!(" {:>12.3}", one.milliseconds_a_light);
            figures.push(one);
        }
    }
    Ok(figures)
}

fn methods() -> [(&'static str, DiffuseMethod); 3] {
    let circle = |basis| DiffuseMethod::ProjectedArea {
        basis,
        occlusion: LocalOcclusion::Circle,
    };
    [
        ("projected area, centred", circle(ProjectionBasis::Centroid)),
        (
            "projected area, weighted",
            circle(ProjectionBasis::Weighted),
        ),
        ("exact", DiffuseMethod::default()),
    ]
}

/// Median seconds of three frames.
fn frame(scene: &Scene, settings: &RenderSettings, interrupt: &Interrupt) -> Result<f64, Failure> {
    let camera = scene.cameras.first().ok_or("the scene has no camera")?;
    let renderer = CpuRenderer::new(scene);
    let watch = Watch {
        cancelled: interrupt.flag(),
        ..Watch::none()
    };
    let mut seconds = Vec::new();
    for _ in 0..3 {
        let start = Instant::now();
        renderer.render(camera, settings, watch)?;
        interrupt.check()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(median(&mut seconds))
}

fn slope(points: &[(u32, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean_x = points.iter().map(|p| f64::from(p.0)).sum::<f64>() / n;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / n;
    let (mut xy, mut xx) = (0.0, 0.0);
    for &(x, y) in points {
        let dx = f64::from(x) - mean_x;
        xy += dx * (y - mean_y);
        xx += dx * dx;
    }
    xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_of_a_line() {
        let points = [(10, 7.0), (20, 12.0), (50, 27.0), (98, 51.0)];
        assert!((slope(&points) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn scenes_have_the_lights_they_are_named_for() {
        for (count, bytes) in SCENES {
            let scene = Scene::from_slice(bytes, None, "quads").unwrap();
            assert_eq!(scene.polygon_lights.len(), count as usize);
        }
    }
}
