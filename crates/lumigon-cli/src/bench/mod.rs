//! `lumigon bench`: what each method costs on this machine.

mod counted;
mod gpu;
mod images;
mod kernels;
mod lookups;
mod machine;
mod peak;
mod quads;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use lumigon_renderer::{Gpu, GpuPreference};
use serde::Serialize;

use crate::Failure;
use crate::gpu::BackendChoice;
use crate::interrupt::Interrupt;
use kernels::{Placement, Workload, kernels};
use machine::Machine;

/// Measures what each method costs on this machine
#[derive(Debug, Args)]
#[command(after_help = "\
Kernels: nanoseconds a pixel and light, for lights of 3, 4 and 10 vertices, wholly above the
surface's horizon and clipped by it; one lane at a time and on all SIMD lanes. Operations are
counted, not estimated: a fused multiply-add, a division or a comparison is one. \"Of peak\" is
counted operations over the fused multiply-adds that the same thread does in the same run.
\"Diffuse + LTC\" is both in one pass; \"and cosine\" adds the table's cosine term, which shares the
diffuse light's integral.

Lookups: nanoseconds a look into a fitted table, one lane at a time.

Images: nanoseconds a pixel and light, for lights with images by every image method, and milliseconds of
filtering a new image on all threads.

Quads: milliseconds a frame of 1440x900 pixels, all of them lit by 10 to 98 quads, one ray a pixel.

With --backend gpu: milliseconds a light for 1 to 10,000 lights of 3, 4 and 10 vertices on a frame
of 1440x900 surfaces; beside them the floor, the greater of counted operations over the
multiply-adds and of bytes over the copying that the same device does in the same run. The count is
that of the CPU's functions, which compute the same; table lookups are not in it. Half of the lights
are clipped. Then exact light beside two ways of common practice, clipping into an array and clipping
a sphere, with each one's error from double precision over the mean; and 100 beside 10,000 small
lights, with those left out that add next to nothing. Then lights with images by every image method, and
filtering new images on the device. Software GPUs light smaller frames.

Figures are medians. Close other programs; on a shared machine trust ratios alone.

Examples:
  lumigon bench
  lumigon bench --only kernels --json bench.json
  lumigon bench --backend gpu --json gpu.json")]
pub struct Bench {
    /// Measure only this part of the CPU's figures
    #[arg(long, value_enum)]
    only: Option<Part>,
    /// What to measure
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = BackendChoice::Cpu)]
    backend: BackendChoice,
    /// Write the figures to this file too, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write them to this file too, as Markdown tables; with --backend gpu
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    /// One pixel, one light
    Kernels,
    /// One pixel, one table
    Lookups,
    /// Lights with images
    Images,
    /// Whole frames
    Quads,
}

/// All figures.
#[derive(Serialize)]
struct Figures {
    machine: Machine,
    kernels: Vec<KernelFigures>,
    lookups: Vec<lookups::LookupFigures>,
    images: Option<images::ImageFigures>,
    quads: Vec<quads::QuadFigures>,
}

/// One kernel on one kind of light.
#[derive(Serialize)]
struct KernelFigures {
    kernel: &'static str,
    vertices: usize,
    placement: &'static str,
    operations: f64,
    scalar_nanoseconds: f64,
    simd_nanoseconds: f64,
    all_threads_nanoseconds: f64,
    speedup: f64,
    fraction_of_peak: f64,
    all_threads_fraction_of_peak: f64,
}

impl Bench {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        interrupt.watch();
        if let Some(gpu) = self.gpu()? {
            if self.only.is_some() {
                return Err(Failure::usage(
                    "bench",
                    "--only is of use with --backend cpu only",
                ));
            }
            let figures = gpu::measure(&gpu, &interrupt)?;
            if let Some(path) = &self.markdown {
                write(path, &figures.markdown())?;
            }
            return self.write_json(&figures);
        }
        if self.markdown.is_some() {
            let message = "--markdown is of use with --backend gpu only";
            return Err(Failure::usage("bench", message));
        }
        let machine = Machine::measure();
        machine.print();
        let mut figures = Figures {
            machine,
            kernels: Vec::new(),
            lookups: Vec::new(),
            images: None,
            quads: Vec::new(),
        };
        let wanted = |part| self.only.is_none_or(|only| only == part);
        if wanted(Part::Kernels) {
            figures.kernels = measure_kernels(&figures.machine, &interrupt)?;
        }
        if wanted(Part::Lookups) {
            figures.lookups = lookups::measure(&interrupt)?;
        }
        if wanted(Part::Images) {
            figures.images = Some(images::measure(&interrupt)?);
        }
        if wanted(Part::Quads) {
            figures.quads = quads::measure(&interrupt)?;
        }
        self.write_json(&figures)
    }

    /// The GPU to measure; none where it is the CPU.
    fn gpu(&self) -> Result<Option<Gpu>, Failure> {
        match self.backend {
            BackendChoice::Cpu => Ok(None),
            BackendChoice::Gpu => Ok(Some(Gpu::new(GpuPreference::Any)?)),
            BackendChoice::Auto => match Gpu::new(GpuPreference::Hardware) {
                Ok(gpu) => Ok(Some(gpu)),
                Err(error) => {
                    eprintln!("the CPU is measured: {error}");
                    Ok(None)
                }
            },
        }
    }

    fn write_json(&self, figures: &impl Serialize) -> Result<(), Failure> {
        if let Some(path) = &self.json {
            write_json(path, figures)?;
        }
        Ok(())
    }
}

/// The median; 0 of nothing.
fn median(samples: &mut [f64]) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples.get(samples.len() / 2).copied().unwrap_or(0.0)
}

/// Figures as JSON.
pub(crate) fn write_json(path: &Path, figures: &impl Serialize) -> Result<(), Failure> {
    write(path, &(serde_json::to_string_pretty(figures)? + "\n"))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))?)
}

fn measure_kernels(
    machine: &Machine,
    interrupt: &Interrupt,
) -> Result<Vec<KernelFigures>, Failure> {
    println!(
        "\n{:26} {:>8} {:8} {:>10} {:>10} {:>8} {:>9} {:>8} {:>12} {:>8}",
        "kernel",
        "vertices",
        "light",
        "operations",
        "scalar ns",
        "SIMD ns",
        "speed-up",
        "of peak",
        "all threads",
        "of peak",
    );
    let mut figures = Vec::new();
    for (name, kernel) in kernels() {
        for vertices in [3, 4, 10] {
            for (placement, placement_name) in
                [(Placement::Above, "above"), (Placement::Clipped, "clipped")]
            {
                interrupt.check()?;
                let workload = Workload::new(vertices, placement);
                let operations = workload.operations(kernel);
                let scalar = workload.time_scalar(kernel);
                let simd = workload.time_simd(kernel);
                let all_threads = workload.time_simd_on_all_threads(kernel);
                let one = KernelFigures {
                    kernel: name,
                    vertices,
                    placement: placement_name,
                    operations,
                    scalar_nanoseconds: scalar,
                    simd_nanoseconds: simd,
                    all_threads_nanoseconds: all_threads,
                    speedup: scalar / simd,
                    fraction_of_peak: operations / simd / machine.giga_fma_per_second,
                    all_threads_fraction_of_peak: operations
                        / all_threads
                        / machine.all_threads_giga_fma_per_second,
                };
                println!(
                    "{name:26} {vertices:>8} {placement_name:8} {operations:>10.0} {scalar:>10.1} \
                     {simd:>8.2} {:>8.1}x {:>7.0}% {all_threads:>12.2} {:>7.0}%",
                    one.speedup,
                    one.fraction_of_peak * 100.0,
                    one.all_threads_fraction_of_peak * 100.0,
                );
                figures.push(one);
            }
        }
    }
    Ok(figures)
}
