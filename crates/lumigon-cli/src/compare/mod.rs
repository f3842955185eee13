//! `lumigon compare`: every method beside the path-traced truth, in pictures and numbers.

mod contact_sheet;
mod display;
mod error;
mod false_color;
mod folder;
mod label;
mod machine;
mod method;
mod metrics;
mod picture;
mod quantity;
mod record;
mod report;
mod run;
mod stopwatch;

use std::path::PathBuf;

pub use display::Tonemap;
pub use error::CompareError;
pub use run::run;

/// Renders a scene by every method and by path tracing, and writes what differs.
///
/// The folder gets index.html, a report that opens from disk; contact-sheet.png, all of its
/// pictures on one sheet; metrics.json, all of its numbers; and every picture as tone-mapped PNG
/// and as EXR of linear radiance.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lumigon compare scenes/gallery.glb -o report
  lumigon compare scene.glb -o report --size 360x225 --spp 64     a quick look")]
pub struct Args {
    /// The scene: a .gltf or .glb file.
    pub scene: PathBuf,
    /// The folder for the report: new, empty, or an earlier report, which is replaced.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "720x450", value_parser = parse_size)]
    pub size: (u32, u32),
    /// Camera rays a pixel: 1 through its centre, more stratified.
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub samples: u32,
    /// Light paths a pixel of the path-traced references.
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub spp: u32,
    /// The camera, by its name or its index; the file's first where it is left out.
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    /// Stops of exposure in the PNG pictures and for FLIP.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// How the PNG pictures, and FLIP, show radiance.
    #[arg(long, value_name = "CURVE", value_enum, default_value_t)]
    pub tonemap: Tonemap,
    /// Surfaces at which paths of the shadowed reference scatter: 1 is direct light alone.
    ///
    /// The unshadowed reference, which the methods are measured against, has direct light alone.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub bounces: u32,
    /// How far the biased projection moves back, in scene units; half of the median light's
    /// radius where it is left out.
    #[arg(long, value_name = "LENGTH")]
    pub bias: Option<f64>,
    /// Seed of the references' random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| *side > 0);
    text.split_once(['x', 'X', '×'])
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| "give it as WIDTHxHEIGHT, such as 720x450".to_owned())
}

#[cfg(test)]
mod tests {
    use super::parse_size;

    #[test]
    fn sizes_are_width_by_height() {
        assert_eq!(parse_size("720x450"), Ok((720, 450)));
        for wrong in ["", "720", "x", "720x", "0x4", "-1x4", "720x450x3", "9999999999x1"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
