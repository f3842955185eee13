//! `lumigon view`: a scene in a window.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use lumigon_renderer::{PictureFormat, ToneMap};
use lumigon_viewer::{BackendChoice, Options, run};

use crate::Failure;
use crate::size::Size;

/// Opens a scene in a window, where its lights can be moved and reshaped
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lumigon view                        the gallery
  lumigon view scene.glb              F1 lists every key
  lumigon view scene.glb --frames 60 --screenshot window.png
  lumigon view scene.glb --record input.txt
  lumigon view scene.glb --replay input.txt --screenshot window.png")]
pub struct ViewCommand {
    /// glTF file, .gltf or .glb; the gallery without one
    scene: Option<PathBuf>,
    /// Window size in points
    #[arg(long, default_value = "1440x900", value_name = "WIDTHxHEIGHT")]
    size: Size,
    /// What computes the picture
    #[arg(long, value_enum, default_value_t)]
    backend: Backend,
    /// Camera to start with, counted from 1 in the file's order
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    camera: u32,
    /// Exposure in stops: radiance is multiplied by 2 to this power
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// How radiance becomes colour: none, reinhard, aces, khronos-pbr-neutral
    #[arg(long, default_value = "khronos-pbr-neutral")]
    tone_map: ToneMap,
    /// Close the window after as many frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Write the last frame's window as PNG
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Replay recorded input, a line an action, then close the window
    #[arg(long, value_name = "FILE", conflicts_with = "record")]
    replay: Option<PathBuf>,
    /// Record all input
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Print how long each frame took
    #[arg(long)]
    timings: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Backend {
    /// A hardware GPU where there is one, else the CPU
    #[default]
    Auto,
    /// The CPU, at a resolution that keeps up
    Cpu,
    /// A GPU, software Vulkan included
    Gpu,
}

impl ViewCommand {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        if self.exposure.is_nan() || self.exposure.abs() > 30.0 {
            return Err("the exposure is out of range: give -30 to 30 stops".into());
        }
        if let Some(path) = &self.screenshot {
            match PictureFormat::from_path(path) {
                Ok(PictureFormat::Png) => lumigon_renderer::check_writable(path)?,
                _ => return Err(format!("{}: the window is saved as .png", path.display()).into()),
            }
        }
        if let Some(path) = &self.record {
            lumigon_renderer::check_writable(path)?;
        }
        let options = Options {
            scene: self.scene.clone(),
            size: [self.size.width, self.size.height],
            backend: match self.backend {
                Backend::Auto => BackendChoice::Auto,
                Backend::Cpu => BackendChoice::Cpu,
                Backend::Gpu => BackendChoice::Gpu,
            },
            camera: self.camera as usize - 1,
            exposure: self.exposure,
            tone_map: self.tone_map,
            frames: self.frames,
            screenshot: self.screenshot.clone(),
            replay: self.replay.clone(),
            record: self.record.clone(),
            timings: self.timings,
        };
        Ok(run(options)?)
    }
}
