//! `lumigon compare`: every method beside the path-traced truth, in pictures and numbers.

pub(crate) mod bounce;
pub(crate) mod contact_sheet;
pub(crate) mod error;
pub(crate) mod false_color;
mod label;
pub(crate) mod machine;
mod method;
mod metrics;
pub(crate) mod quantity;
mod record;
mod report;
mod run;
mod stopwatch;

use std::path::PathBuf;

use clap::Args;
use lumigon_renderer::{RenderError, RenderSettings, Scene, ToneMap};

use crate::Failure;
use crate::camera::choose_camera;
use crate::gpu::BackendChoice;
use crate::interrupt::Interrupt;
use crate::render::{bias, exposure};
use crate::report_folder::ReportFolder;
use crate::size::Size;
use bounce::BounceArguments;
use error::CompareError;

/// Renders a scene by every method and by path tracing, and reports how they differ
#[derive(Debug, Args)]
#[command(after_help = "\
The folder gets
  index.html         a report that opens from disk
  contact-sheet.png  all of its pictures on one sheet
  metrics.json       all of its numbers
  pictures/          each picture and each difference, as PNG and as EXR of linear radiance

Examples:
  lumigon compare scenes/gallery.glb -o report
  lumigon compare scene.glb -o report --size 360x225 --spp 64
  lumigon compare scenes/room.glb -o report --size 360x225 --bounce")]
pub struct Compare {
    /// glTF file, .gltf or .glb
    scene: PathBuf,
    /// Folder for the report: new, empty, or an earlier report, which is replaced
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Width and height of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "720x450")]
    size: Size,
    /// Camera rays a pixel: 1 through its centre, more stratified
    #[arg(long, value_name = "N", default_value_t = RenderSettings::default().samples,
        value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Light paths a pixel of the path-traced references
    #[arg(long, value_name = "N", default_value_t = 256,
        value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Camera by name or by number from 0 [default: the first; one that sees everything where the
    /// file has none]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Exposure of the PNG pictures in stops: radiance is multiplied by 2^EV
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
        value_parser = exposure)]
    exposure: f32,
    /// Tone map of the PNG pictures: none, reinhard, aces or khronos-pbr-neutral
    #[arg(long, value_name = "NAME", default_value = ToneMap::default().name())]
    tonemap: ToneMap,
    /// Surfaces a path of the shadowed reference may scatter at; 1 is direct light alone, as in the
    /// reference without shadows that the methods are measured against
    #[arg(long, value_name = "N", default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..))]
    bounces: u32,
    /// What computes the methods; the references are always the CPU's
    #[arg(long, value_enum, value_name = "WHAT", default_value_t)]
    backend: BackendChoice,
    /// How far behind the point the biased projection starts, in scene units [default: half of the
    /// median light's radius]
    #[arg(long, value_name = "DISTANCE", value_parser = bias)]
    bias: Option<f64>,
    /// Seed of the references' random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    bounce: BounceArguments,
}

impl Compare {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        // Before anything slow: whether the report has a place.
        ReportFolder::check(&self.output, run::GENERATOR)?;
        let scene = Scene::load(&self.scene)?;
        for warning in &scene.warnings {
            eprintln!("warning: {}: {warning}", self.scene.display());
        }
        let camera = choose_camera(&scene, &self.scene, self.camera.as_deref())?;
        // From here on Ctrl-C leaves past the end of the folder, which removes it.
        interrupt.watch();
        let folder = ReportFolder::create(&self.output, run::GENERATOR)?;
        match run::fill(self, &folder, scene, &camera, &interrupt) {
            Ok(()) => {}
            Err(CompareError::Render(RenderError::Cancelled)) => return Err(Failure::Interrupted),
            Err(error) => return Err(error.into()),
        }
        interrupt.check()?;
        folder.commit()?;
        let index = self.output.join(report::INDEX);
        println!("{}", index.display());
        Ok(())
    }
}
