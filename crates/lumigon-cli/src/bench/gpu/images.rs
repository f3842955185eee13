//! What images on lights cost: averaging them, and filtering new ones on the device.

use std::time::Instant;

use glam::Vec3;
use lumigon::{ImagePyramid, LightImage};
use lumigon_renderer::{
    EmissiveImage, EmissivePolygon, Gpu, GpuRenderer, ImageColors, RenderSettings, Scene, Watch,
};
use lumigon_wgpu::{Light, LightBuffers};
use serde::Serialize;

use super::plain::plain;
use crate::Failure;
use crate::bench::images::{FilterFigures, METHODS, SIDES, SIZE, noise, print_filtering, quad};
use crate::bench::median;
use crate::interrupt::Interrupt;

const LIGHTS: usize = 8;
const FRAMES: usize = 5;

/// All figures.
#[derive(Serialize)]
pub(super) struct ImageFigures {
    /// Whether these are the device's own, of lighting alone, or the wall clock's of all.
    pub(super) clock: &'static str,
    pub(super) lights: Vec<ImageLightFigures>,
    pub(super) filtering: Vec<FilterFigures>,
}

/// One way of averaging.
#[derive(Serialize)]
pub(super) struct ImageLightFigures {
    pub(super) image_method: &'static str,
    pub(super) lights: usize,
    pub(super) width: u32,
    pub(super) height: u32,
    /// A pixel and light.
    pub(super) nanoseconds: f64,
    /// Over the light without an image.
    pub(super) ratio: f64,
}

pub(super) fn measure(gpu: &Gpu, interrupt: &Interrupt) -> Result<ImageFigures, Failure> {
    let is_software = gpu.adapter().is_software();
    let (width, height) = if is_software { (96, 60) } else { (1440, 900) };
    println!(
        "\n{:26} {:>8} {:>10} {:>10} {:>8}",
        "diffuse + LTC, image", "lights", "frame", "ns", "ratio"
    );
    let mut clock = "wall clock";
    let mut lights: Vec<ImageLightFigures> = Vec::new();
    for (image_method, method) in METHODS {
        let scene = scene(method.is_some());
        let mut renderer = GpuRenderer::new(gpu, &scene)?;
        if method.is_some() {
            let colors = noise(SIZE);
            for light in 0..LIGHTS {
                renderer.replace_light_image(light, ImageColors::Linear(&colors))?;
            }
        }
        let settings = RenderSettings {
            width,
            height,
            samples: 1,
            image_method: method.unwrap_or_default(),
            ..RenderSettings::default()
        };
        let watch = Watch {
            cancelled: interrupt.flag(),
            ..Watch::none()
        };
        let mut samples = Vec::new();
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
        let count = f64::from(width * height) * LIGHTS as f64;
        let nanoseconds = median(&mut samples) * 1e6 / count;
        let plain = lights.first().map_or(nanoseconds, |f| f.nanoseconds);
        let one = ImageLightFigures {
            image_method,
            lights: LIGHTS,
            width,
            height,
            nanoseconds,
            ratio: nanoseconds / plain,
        };
        let frame = format!("{width}x{height}");
        println!(
            "{image_method:26} {LIGHTS:>8} {frame:>10} {nanoseconds:>10.3} {:>8.2}",
            one.ratio
        );
        lights.push(one);
    }
    println!("\n{:26} {:>10} {:>10}", "a new image", "ms", "MB");
    let limits = gpu.device().limits();
    let largest = limits
        .max_buffer_size
        .min(limits.max_storage_buffer_binding_size);
    let mut filtering = Vec::new();
    for side in SIDES {
        interrupt.check()?;
        let bytes = ImagePyramid::bytes([side; 2]);
        if bytes > largest {
            println!(
                "{:26} larger than this GPU's buffers",
                format!("{side}x{side}")
            );
            continue;
        }
        let one = FilterFigures {
            side,
            milliseconds: filter(gpu, side)?,
            bytes,
        };
        print_filtering(&one);
        filtering.push(one);
    }
    Ok(ImageFigures {
        clock,
        lights,
        filtering,
    })
}

/// Milliseconds until a new image's levels are there, of bytes in the processor's memory.
fn filter(gpu: &Gpu, side: u32) -> Result<f64, Failure> {
    let (device, queue) = (gpu.device(), gpu.queue());
    let (polygon, corners) = quad(0);
    let light = Light {
        image: Some(LightImage::new(&polygon, corners, [side; 2])?),
        polygon: polygon.cast()?,
        radiance: [1.0; 3],
    };
    let mut buffers = LightBuffers::new(device, queue, &[light])?;
    let frame: Vec<[u8; 4]> = (0..side * side)
        .map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes())
        .collect();
    let mut samples = Vec::new();
    for repetition in 0..=FRAMES {
        let start = Instant::now();
        buffers.replace_image(device, queue, 0, ImageColors::Srgb(&frame))?;
        device.poll(wgpu::PollType::wait_indefinitely())?;
        if repetition > 0 {
            samples.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    Ok(median(&mut samples))
}

/// A plain under [`LIGHTS`] quadrilaterals, and a camera that looks down on it.
fn scene(with_images: bool) -> Scene {
    let lights = (0..LIGHTS).map(|i| light(i, with_images)).collect();
    plain(9.0, Vec3::new(0.0, 6.0, 4.0), lights)
}

fn light(i: usize, with_image: bool) -> EmissivePolygon {
    let (polygon, [corner, edge_u, edge_v]) = quad(i);
    let outline = polygon.loops().next().into_iter().flatten();
    EmissivePolygon {
        name: "screen".to_owned(),
        loops: vec![outline.map(Into::into).collect()],
        radiance: Vec3::ONE,
        image: with_image.then_some(EmissiveImage {
            emission: None,
            mask: None,
            strength: Vec3::ONE,
            corner,
            edge_u,
            edge_v,
            size: SIZE,
        }),
        two_sided: true,
        mesh: 0,
        triangles: Vec::new(),
    }
}
