//! What images on lights cost: averaging them, and filtering them.

use std::hint::black_box;
use std::time::Instant;

use fearless_simd::{Level, Simd, dispatch};
use lumigon::{
    DiffuseMethod, ImageMethod, ImagePyramid, Lanes, LightImage, Ltc, LtcTable, PolygonLight,
    PreparedLtc, Real, Sides, Vec3, irradiance, ltc_form_factor, ltc_mean_image,
};
use serde::Serialize;

use super::kernels::median_seconds;
use super::median;
use crate::Failure;
use crate::interrupt::Interrupt;

/// How images are averaged; none are, first.
pub(super) const METHODS: [(&str, Option<ImageMethod>); 6] = [
    ("no image", None),
    ("lookup", Some(ImageMethod::Lookup)),
    ("1x1", taps(1)),
    ("2x2", taps(2)),
    ("3x3", taps(3)),
    ("4x4", taps(4)),
];

const fn taps(taps: u32) -> Option<ImageMethod> {
    Some(ImageMethod::Quadrature { taps })
}

/// Sides of the images that are filtered, in texels.
pub(super) const SIDES: [u32; 3] = [256, 1024, 4096];

/// Texels of the images that are averaged.
pub(super) const SIZE: [u32; 2] = [256, 256];

/// Shading points along each axis, and lights.
const SIDE: usize = 16;
const LIGHTS: usize = 8;

/// Filterings of one size.
const REPETITIONS: usize = 5;

/// All figures.
#[derive(Serialize)]
pub(super) struct ImageFigures {
    light: Vec<ImageLightFigures>,
    filtering: Vec<FilterFigures>,
}

/// What a pixel pays for one light.
#[derive(Serialize)]
struct ImageLightFigures {
    kernel: &'static str,
    image_method: &'static str,
    scalar_nanoseconds: f64,
    simd_nanoseconds: f64,
    /// Over the light without an image, on SIMD lanes.
    ratio: f64,
}

/// What a new image costs before anything is lit by it.
#[derive(Serialize)]
pub(super) struct FilterFigures {
    pub(super) side: u32,
    pub(super) milliseconds: f64,
    /// Of all levels.
    pub(super) bytes: u64,
}

#[derive(Clone, Copy, Debug)]
enum Kernel {
    Diffuse,
    Ltc,
}

struct Shown {
    polygon: PolygonLight<f32>,
    image: LightImage<f32>,
}

/// Lights, and what they shine on.
struct Lit {
    lights: Vec<Shown>,
    lobe: Ltc<f32>,
}

impl Lit {
    fn new() -> Self {
        Self {
            lights: lights(),
            lobe: LtcTable::ggx().lookup(0.5, 0.6).lobes[0],
        }
    }
}

pub(super) fn measure(interrupt: &Interrupt) -> Result<ImageFigures, Failure> {
    println!(
        "\n{:26} {:8} {:>10} {:>8} {:>8}",
        "light with an image", "image", "scalar ns", "SIMD ns", "ratio"
    );
    let lit = Lit::new();
    let mut light = Vec::new();
    for (kernel, name) in [
        (Kernel::Diffuse, "diffuse exact"),
        (Kernel::Ltc, "LTC, one lobe"),
    ] {
        let mut plain = 0.0;
        for (image_method, method) in METHODS {
            interrupt.check()?;
            let each = 1e9 / (SIDE * SIDE * LIGHTS) as f64;
            let scalar = each * median_seconds(|| shade_scalar(kernel, method, &lit));
            let simd = each
                * median_seconds(|| {
                    dispatch!(Level::new(), simd => shade_simd(simd, kernel, method, &lit));
                });
            if method.is_none() {
                plain = simd;
            }
            let ratio = simd / plain;
            println!("{name:26} {image_method:8} {scalar:>10.1} {simd:>8.1} {ratio:>8.2}");
            light.push(ImageLightFigures {
                kernel: name,
                image_method,
                scalar_nanoseconds: scalar,
                simd_nanoseconds: simd,
                ratio,
            });
        }
    }
    println!(
        "\n{:26} {:>10} {:>10}",
        "filtering, all threads", "ms", "MB"
    );
    let mut filtering = Vec::new();
    for side in SIDES {
        interrupt.check()?;
        let one = filter(side);
        print_filtering(&one);
        filtering.push(one);
    }
    Ok(ImageFigures { light, filtering })
}

pub(super) fn print_filtering(figures: &FilterFigures) {
    println!(
        "{:26} {:>10.3} {:>10.1}",
        format!("{0}x{0}", figures.side),
        figures.milliseconds,
        figures.bytes as f64 * 1e-6
    );
}

fn filter(side: u32) -> FilterFigures {
    let (polygon, corners) = quad(0);
    let mut image: LightImage<f32> =
        LightImage::new(&polygon, corners, [side; 2]).expect("a square has images");
    let colors = noise([side; 2]);
    let mut samples: Vec<f64> = (0..REPETITIONS)
        .map(|_| {
            let start = Instant::now();
            image.replace(&colors).expect("noise is light");
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    FilterFigures {
        side,
        milliseconds: median(&mut samples),
        bytes: ImagePyramid::bytes([side; 2]),
    }
}

/// A quadrilateral over the points, and the frame that it fills.
pub(super) fn quad(i: usize) -> (PolygonLight<f64>, [[f64; 3]; 3]) {
    let (x, y) = (i as f64 * 0.2 - 0.7, 1.5 + 0.1 * i as f64);
    let outline = [
        [x - 0.8, y, 0.5],
        [x + 0.8, y, 0.5],
        [x + 0.8, y + 0.3, 2.5],
        [x - 0.8, y + 0.3, 2.5],
    ];
    let polygon = PolygonLight::new(&[outline], Sides::Both).expect("a rectangle is a light");
    let corners = [outline[0], [1.6, 0.0, 0.0], [0.0, 0.3, 2.0]];
    (polygon, corners)
}

/// Colours that differ from texel to texel.
pub(super) fn noise([width, height]: [u32; 2]) -> Vec<[f32; 3]> {
    let channel = |i: u32| i.wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32;
    (0..width * height)
        .map(|i| [channel(i), channel(i ^ 0x5555), channel(i ^ 0x3333)])
        .collect()
}

fn lights() -> Vec<Shown> {
    (0..LIGHTS)
        .map(|i| {
            let (polygon, corners) = quad(i);
            let mut image = LightImage::new(&polygon, corners, SIZE).expect("a square has images");
            image.replace(&noise(SIZE)).expect("noise is light");
            image.filter_gaussian_levels();
            Shown {
                polygon: polygon.cast().expect("fits"),
                image,
            }
        })
        .collect()
}

fn place(i: usize) -> [f32; 2] {
    // Neighbours in 4 x 4 blocks, as a renderer's tiles are.
    let (block, inner) = (i / 16, i % 16);
    let (column, row) = (block % 4 * 4 + inner % 4, block / 4 * 4 + inner / 4);
    [column, row].map(|at| (at as f32 + 0.5) / SIDE as f32 * 4.0 - 1.0)
}

fn shade_scalar(kernel: Kernel, method: Option<ImageMethod>, scene: &Lit) {
    for i in 0..SIDE * SIDE {
        let [x, z] = place(i);
        black_box(shade(kernel, method, scene, Vec3::new(x, 0.0, z)));
    }
}

#[inline(always)]
fn shade_simd<S: Simd>(simd: S, kernel: Kernel, method: Option<ImageMethod>, scene: &Lit) {
    let width = Lanes::<S>::COUNT;
    let (mut x, mut z) = (vec![0.0; width], vec![0.0; width]);
    for first in (0..SIDE * SIDE).step_by(width) {
        for lane in 0..width {
            [x[lane], z[lane]] = place(first + lane);
        }
        let point = Vec3::new(
            Lanes::from_slice(simd, &x),
            Lanes::splat(simd, 0.0),
            Lanes::from_slice(simd, &z),
        );
        black_box(shade(kernel, method, scene, point));
    }
}

#[inline(always)]
fn add<T: Real>(sum: &mut [T; 3], factor: T, color: [T; 3]) {
    for (sum, color) in sum.iter_mut().zip(color) {
        *sum = color.mul_add(factor, *sum);
    }
}

/// One pixel under all lights.
#[inline(always)]
fn shade<T: Real<Scalar = f32>>(
    kernel: Kernel,
    method: Option<ImageMethod>,
    scene: &Lit,
    point: Vec3<T>,
) -> [T; 3] {
    let (zero, one) = (point.x.constant(0.0), point.x.constant(1.0));
    let normal = Vec3::new(zero, one, zero);
    let view = Vec3::new(point.x.constant(0.8), point.x.constant(0.6), zero);
    let mut sum = [zero; 3];
    match kernel {
        Kernel::Diffuse => {
            for Shown { polygon, image } in &scene.lights {
                let color = match method {
                    Some(method) => {
                        let diffuse = DiffuseMethod::default();
                        diffuse.mean_image(polygon, image, point, normal, method)
                    }
                    None => [one; 3],
                };
                add(&mut sum, irradiance(polygon, point, normal), color);
            }
        }
        Kernel::Ltc => {
            let number = |x| one.broadcast(x);
            let lobe = Ltc {
                shading_to_cosine: scene.lobe.shading_to_cosine.map(number),
                amplitude: number(scene.lobe.amplitude),
                schlick: number(scene.lobe.schlick),
            };
            let lobe = PreparedLtc::new(&lobe, normal, view);
            for Shown { polygon, image } in &scene.lights {
                let color = match method {
                    Some(method) => ltc_mean_image(polygon, image, point, &lobe, method),
                    None => [one; 3],
                };
                add(&mut sum, ltc_form_factor(polygon, point, &lobe), color);
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is timed must be light in colours, and more than one.
    #[test]
    fn every_point_is_lit() {
        let lit = Lit::new();
        for kernel in [Kernel::Diffuse, Kernel::Ltc] {
            for i in 0..SIDE * SIDE {
                let [x, z] = place(i);
                let at = |method| shade(kernel, method, &lit, Vec3::new(x, 0.0, z));
                let plain = at(None);
                assert!(plain[0] > 1e-4, "{kernel:?} at {x} {z}: {plain:?}");
                for (name, method) in &METHODS[1..] {
                    let shown = at(*method);
                    // Noise of mean 1/2.
                    let ratio = shown.map(|x| x / plain[0]);
                    let good = |x: &f32| (0.2..0.8).contains(x);
                    assert!(ratio.iter().all(good), "{kernel:?} {name}: {ratio:?}");
                }
            }
        }
    }
}
