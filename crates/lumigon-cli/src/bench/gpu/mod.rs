//! `lumigon bench --backend gpu`: what light costs on a GPU, beside what the GPU can do at most and
//! beside common practice.

mod images;
mod kernel;
mod lighting;
mod many_lights;
mod markdown;
mod peak;
mod plain;
mod shading;
mod timer;
mod workload;

use lumigon_renderer::Gpu;
use serde::Serialize;

use self::lighting::{Method, Stage};
use self::shading::Shading;
use self::timer::Timer;
use self::workload::{Lights, counted_operations, lights, truth};
use super::kernels::Placement;
use crate::Failure;
use crate::interrupt::Interrupt;

/// How many lights frames are lit by.
const COUNTS: [usize; 6] = [1, 10, 50, 98, 1_000, 10_000];
/// How many vertices each has.
const VERTICES: [usize; 3] = [3, 4, 10];
/// How many lights methods are compared on.
const COMPARED_LIGHTS: usize = 98;

/// A frame is made smaller until it takes no longer: software takes minutes for what hardware does
/// in a second.
const BUDGET_SECONDS: f64 = 2.0;
const BUDGET_SECONDS_IN_SOFTWARE: f64 = 0.15;

/// Bytes that a kernel reads and writes a pixel and light at least.
const BYTES_A_PIXEL: f64 = 48.0 + 16.0;
const BYTES_A_LIGHT: f64 = 96.0;
const BYTES_A_VERTEX: f64 = 16.0;

/// All figures.
#[derive(Serialize)]
pub(super) struct Figures {
    device: DeviceFigures,
    lights: Vec<LightFigures>,
    methods: Vec<MethodFigures>,
    many_lights: Vec<many_lights::ManyLightsFigures>,
    images: images::ImageFigures,
}

impl Figures {
    /// As tables.
    pub(super) fn markdown(&self) -> String {
        markdown::markdown(self)
    }
}

/// The device, and what it can do at most.
#[derive(Serialize)]
struct DeviceFigures {
    name: String,
    kind: String,
    backend: String,
    driver: String,
    clock: &'static str,
    empty_submission_microseconds: f64,
    giga_fma_per_second: f64,
    giga_bytes_per_second: f64,
}

/// Exact light from so many lights.
#[derive(Serialize)]
struct LightFigures {
    shading: Shading,
    vertices: usize,
    lights: usize,
    measured_width: u32,
    measured_height: u32,
    /// Of a frame of 1440x900.
    milliseconds: f64,
    milliseconds_a_light: f64,
    /// A pixel and light, counted on the CPU's twins.
    operations: f64,
    /// Milliseconds of a frame, however well the device were used.
    floor_milliseconds: f64,
    times_the_floor: f64,
}

/// One method beside the others.
#[derive(Serialize)]
struct MethodFigures {
    method: &'static str,
    shading: Shading,
    vertices: usize,
    placement: &'static str,
    milliseconds_a_light: f64,
    /// Exact light's time over this one's.
    exact_over_this: f64,
    /// Of a pixel, over the mean of all.
    greatest_error: f64,
    rms_error: f64,
}

pub(super) fn measure(gpu: &Gpu, interrupt: &Interrupt) -> Result<Figures, Failure> {
    let adapter = gpu.adapter();
    println!(
        "GPU        {} ({}, {}, {})",
        adapter.name, adapter.kind, adapter.backend, adapter.driver
    );
    let mut timer = Timer::new(gpu.device(), gpu.queue())?;
    let fma = peak::multiply_adds_per_second(&mut timer, adapter.is_software())?;
    interrupt.check()?;
    let bandwidth = peak::bytes_per_second(&timer, adapter.is_software())?;
    let device = DeviceFigures {
        name: adapter.name.clone(),
        kind: adapter.kind.to_string(),
        backend: adapter.backend.clone(),
        driver: adapter.driver.clone(),
        clock: timer.clock(),
        empty_submission_microseconds: timer.empty_seconds() * 1e6,
        giga_fma_per_second: fma * 1e-9,
        giga_bytes_per_second: bandwidth * 1e-9,
    };
    println!(
        "clock      {}; an empty submission takes {:.0} us",
        device.clock, device.empty_submission_microseconds
    );
    println!("FMA peak   {:.1} G/s", device.giga_fma_per_second);
    println!("copying    {:.1} GB/s", device.giga_bytes_per_second);
    let budget = if adapter.is_software() {
        println!("\nThis GPU is software: nothing here says how fast a GPU is.");
        BUDGET_SECONDS_IN_SOFTWARE
    } else {
        BUDGET_SECONDS
    };
    let mut stage = Stage::new(&timer, interrupt, budget);
    let lights = measure_lights(&mut stage, fma, bandwidth)?;
    let methods = measure_methods(&mut stage)?;
    let many_lights = many_lights::measure(gpu, interrupt)?;
    let images = images::measure(gpu, interrupt)?;
    Ok(Figures {
        device,
        lights,
        methods,
        many_lights,
        images,
    })
}

fn measure_lights(
    stage: &mut Stage<'_>,
    fma: f64,
    bandwidth: f64,
) -> Result<Vec<LightFigures>, Failure> {
    println!(
        "\n{:26} {:>8} {:>8} {:>10} {:>10} {:>12} {:>11} {:>9}",
        "1440x900", "vertices", "lights", "frame", "ms", "ms a light", "operations", "x floor",
    );
    let most = COUNTS[COUNTS.len() - 1];
    let pixels = f64::from(lighting::WIDTH * lighting::HEIGHT);
    let mut figures = Vec::new();
    for shading in Shading::ALL {
        let kernel = stage.kernel(Method::Exact, 0, shading)?;
        for vertices in VERTICES {
            let list = lights(most, vertices, Lights::Mixed);
            let group = stage.lights(&list)?;
            for count in COUNTS {
                let operations = counted_operations(&list[..count], shading);
                let times = stage.time(&[&kernel], &group, count)?;
                let seconds = times.seconds[0];
                let number = count as f64;
                let records = (vertices + 1) as f64;
                let bytes =
                    pixels * BYTES_A_PIXEL + number * (BYTES_A_LIGHT + records * BYTES_A_VERTEX);
                let floor = (pixels * number * operations / fma).max(bytes / bandwidth);
                let (measured_width, measured_height) = times.measured;
                let one = LightFigures {
                    shading,
                    vertices,
                    lights: count,
                    measured_width,
                    measured_height,
                    milliseconds: seconds * 1e3,
                    milliseconds_a_light: seconds * 1e3 / number,
                    operations,
                    floor_milliseconds: floor * 1e3,
                    times_the_floor: seconds / floor,
                };
                println!(
                    "{:26} {vertices:>8} {count:>8} {:>10} {:>10.3} {:>12.5} {operations:>11.0} \
                     {:>9.2}",
                    shading.name(),
                    format!("{measured_width}x{measured_height}"),
                    one.milliseconds,
                    one.milliseconds_a_light,
                    one.times_the_floor,
                );
                figures.push(one);
            }
        }
    }
    Ok(figures)
}

fn measure_methods(stage: &mut Stage<'_>) -> Result<Vec<MethodFigures>, Failure> {
    println!(
        "\n{:16} {:26} {:>8} {:8} {:>12} {:>12} {:>12} {:>12}",
        "method",
        "98 lights",
        "vertices",
        "light",
        "ms a light",
        "exact/this",
        "worst error",
        "RMS error",
    );
    let mut figures = Vec::new();
    for shading in Shading::ALL {
        for vertices in VERTICES {
            let kernels = Method::ALL
                .iter()
                .map(|&method| stage.kernel(method, vertices, shading))
                .collect::<Result<Vec<_>, _>>()?;
            let kernels: Vec<_> = kernels.iter().collect();
            for (placement, placement_name) in
                [(Placement::Above, "above"), (Placement::Clipped, "clipped")]
            {
                let list = lights(COMPARED_LIGHTS, vertices, Lights::All(placement));
                let group = stage.lights(&list)?;
                let times = stage.time(&kernels, &group, COMPARED_LIGHTS)?;
                let mut exact = None;
                for (i, (method, kernel)) in Method::ALL.iter().zip(&kernels).enumerate() {
                    let (pixels, found) = stage.small_frame(kernel, &group)?;
                    let exact = exact.get_or_insert_with(|| truth(&pixels, &list, shading));
                    let (greatest_error, rms_error) = errors(&found, exact);
                    let one = MethodFigures {
                        method: method.name(),
                        shading,
                        vertices,
                        placement: placement_name,
                        milliseconds_a_light: times.seconds[i] * 1e3 / COMPARED_LIGHTS as f64,
                        exact_over_this: times.first_over[i],
                        greatest_error,
                        rms_error,
                    };
                    println!(
                        "{:16} {:26} {vertices:>8} {placement_name:8} {:>12.5} {:>12.2} \
                         {greatest_error:>12.1e} {rms_error:>12.1e}",
                        one.method,
                        shading.name(),
                        one.milliseconds_a_light,
                        one.exact_over_this,
                    );
                    figures.push(one);
                }
            }
        }
    }
    Ok(figures)
}

/// The greatest error and the root of the mean square, both over the mean of what is exact.
fn errors(found: &[f64], exact: &[f64]) -> (f64, f64) {
    let count = exact.len().max(1) as f64;
    let mean = exact.iter().sum::<f64>() / count;
    let differences = found.iter().zip(exact).map(|(a, b)| (a - b).abs() / mean);
    let greatest = differences.clone().fold(0.0, f64::max);
    let square = differences.map(|d| d * d).sum::<f64>() / count;
    (greatest, square.sqrt())
}

#[cfg(test)]
mod tests {
    use lumigon_renderer::GpuPreference;

    use super::*;

    /// What is compared must do what it says: ours is exact, and common practice is as good as it
    /// can be.
    #[test]
    fn methods_err_as_they_should() {
        let gpu = Gpu::new(GpuPreference::Any)
            .expect("install a Vulkan driver, such as Debian's mesa-vulkan-drivers");
        let timer = Timer::new(gpu.device(), gpu.queue()).unwrap();
        let interrupt = Interrupt::never();
        let mut stage = Stage::new(&timer, &interrupt, 1.0);
        for (vertices, shading) in [
            (4, Shading::Diffuse),
            (4, Shading::TwoLobes),
            (10, Shading::Ltc),
        ] {
            for placement in [Placement::Above, Placement::Clipped] {
                let list = lights(5, vertices, Lights::All(placement));
                let group = stage.lights(&list).unwrap();
                for method in Method::ALL {
                    let kernel = stage.kernel(method, vertices, shading).unwrap();
                    let (pixels, found) = stage.small_frame(&kernel, &group).unwrap();
                    let exact = truth(&pixels, &list, shading);
                    let (_, rms) = errors(&found, &exact);
                    let most = match (method, placement) {
                        (Method::Exact, _) => 2e-6,
                        (Method::ArrayClip, Placement::Above) => 2e-6,
                        // It knows one of two horizons.
                        (Method::ArrayClip, Placement::Clipped) => 2e-3,
                        (Method::ClippedSphere, Placement::Above) => 2e-2,
                        (Method::ClippedSphere, Placement::Clipped) => 2.0,
                    };
                    let name = method.name();
                    assert!(rms <= most, "{name}, {vertices}, {shading:?}: {rms:e}");
                }
            }
        }
    }
}
