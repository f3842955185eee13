//! What 10,000 small lights cost over 100, where lights that add next to nothing are left out.

use std::time::Instant;

use glam::Vec3;
use lumigon_renderer::{EmissivePolygon, Gpu, GpuRenderer, RenderSettings, Scene, Watch};
use serde::Serialize;

use super::plain::plain;
use crate::Failure;
use crate::bench::median;
use crate::interrupt::Interrupt;

/// Lights stand on a square lattice about the camera's focus, nearest first: what a pixel sees of
/// them stays the same, however many there are.
const SPACING: f64 = 4.0;
const COUNTS: [usize; 2] = [100, 10_000];

/// A light's side and height over the ground, in metres, and its radiance.
const SIDE: f64 = 0.3;
const HEIGHT: f64 = 1.0;
const RADIANCE: f32 = 20.0;

/// Half of one of 255 steps to a display's white.
const LIGHT_BOUND: f32 = 0.002;

const FRAMES: usize = 7;

/// One number of lights.
#[derive(Serialize)]
pub(super) struct ManyLightsFigures {
    pub(super) lights: usize,
    pub(super) light_bound: f32,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) milliseconds: f64,
    /// Whether these are the device's own, of lighting alone, or the wall clock's of all.
    pub(super) clock: &'static str,
    /// Over the time of the fewest lights.
    pub(super) ratio: f64,
}

pub(super) fn measure(gpu: &Gpu, interrupt: &Interrupt) -> Result<Vec<ManyLightsFigures>, Failure> {
    let is_software = gpu.adapter().is_software();
    let (width, height) = if is_software { (180, 113) } else { (1440, 900) };
    println!(
        "\n{:>8} {:>12} {:>10} {:>10} {:>8}  lights of {SIDE} m, {SPACING} m apart",
        "lights", "light bound", "frame", "ms", "ratio"
    );
    let most = COUNTS[COUNTS.len() - 1];
    let scene = scene(most);
    let mut renderer = GpuRenderer::new(gpu, &scene)?;
    let settings = RenderSettings {
        width,
        height,
        samples: 1,
        light_bound: LIGHT_BOUND,
        ..RenderSettings::default()
    };
    let watch = Watch {
        cancelled: interrupt.flag(),
        ..Watch::none()
    };
    let mut figures: Vec<ManyLightsFigures> = Vec::new();
    for count in COUNTS {
        renderer.set_lights(&scene.polygon_lights[..count])?;
        let mut samples = Vec::new();
        let mut clock = "wall clock";
        for frame in 0..=FRAMES {
            let start = Instant::now();
            renderer.render(&scene.cameras[0], &settings, watch)?;
            interrupt.check()?;
            let mut milliseconds = start.elapsed().as_secs_f64() * 1e3;
            // Software has its timestamps wrong at times.
            if let Some(timings) = renderer.timings().filter(|_| !is_software) {
                milliseconds = timings.shading;
                clock = "timestamp queries, lighting alone";
            }
            // The first one builds what the others use.
            if frame > 0 {
                samples.push(milliseconds);
            }
        }
        let milliseconds = median(&mut samples);
        let fewest = figures.first().map_or(milliseconds, |f| f.milliseconds);
        let one = ManyLightsFigures {
            lights: count,
            light_bound: LIGHT_BOUND,
            width,
            height,
            milliseconds,
            clock,
            ratio: milliseconds / fewest,
        };
        println!(
            "{count:>8} {LIGHT_BOUND:>12} {:>10} {milliseconds:>10.3} {:>8.2}",
            format!("{width}x{height}"),
            one.ratio
        );
        figures.push(one);
    }
    Ok(figures)
}

/// A plain of 500 m, lit by so many lights, and a camera that looks down on 30 m of it.
fn scene(count: usize) -> Scene {
    plain(250.0, Vec3::new(0.0, 20.0, 12.0), lights(count))
}

fn lights(count: usize) -> Vec<EmissivePolygon> {
    let reach = ((count as f64).sqrt() / 2.0).ceil() as i32 + 1;
    let mut places: Vec<_> = (-reach..=reach)
        .flat_map(|row| (-reach..=reach).map(move |column| (column, row)))
        .collect();
    places.sort_by_key(|&(x, z)| (x.abs().max(z.abs()), x, z));
    let light = |(column, row): (i32, i32)| {
        let (x, z) = (SPACING * f64::from(column), SPACING * f64::from(row));
        let corner = |dx: f64, dz: f64| [x + SIDE / 2.0 * dx, HEIGHT, z + SIDE / 2.0 * dz];
        EmissivePolygon {
            name: "small".to_owned(),
            // Counter-clockwise seen from below.
            loops: vec![vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]],
            radiance: Vec3::splat(RADIANCE),
            image: None,
            two_sided: false,
            mesh: 0,
            triangles: Vec::new(),
        }
    };
    places.into_iter().take(count).map(light).collect()
}

#[cfg(test)]
mod tests {
    use lumigon_renderer::CpuRenderer;

    use super::*;

    /// What is timed must be light.
    #[test]
    fn the_plain_is_lit_evenly() {
        let scene = scene(100);
        assert_eq!(scene.polygon_lights.len(), 100);
        let renderer = CpuRenderer::new(&scene);
        assert!(renderer.warnings().is_empty());
        let settings = RenderSettings {
            width: 32,
            height: 20,
            samples: 1,
            ..RenderSettings::default()
        };
        let picture = renderer
            .render(&scene.cameras[0], &settings, Watch::none())
            .unwrap();
        for pixel in picture.diffuse {
            assert!(pixel[1] > 5.0 * LIGHT_BOUND, "{pixel:?}");
        }
    }
}
