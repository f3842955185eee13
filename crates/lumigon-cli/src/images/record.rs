//! What `metrics.json` holds.

use serde::Serialize;

use super::measure::{METHODS, Numbers, Sample};
use super::statistics::Table;

/// All of a report's numbers.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    pub(super) generator: &'static str,
    pub(super) version: &'static str,
    /// The command that makes it again.
    pub(super) command: String,
    pub(super) seed: u64,
    /// Places of every class.
    pub(super) lights: u32,
    /// Texels a side of every image.
    pub(super) texels: usize,
    pub(super) methods: [&'static str; METHODS.len()],
    /// Errors as shares of the images' means.
    pub(super) tables: Vec<Table>,
    pub(super) nanoseconds: Nanoseconds,
    /// Every file of the report, relative to it.
    pub(super) files: Vec<String>,
}

/// Of one mean image.
#[derive(Debug, Serialize)]
pub(super) struct Nanoseconds {
    pub(super) diffuse: Numbers,
    pub(super) specular: Numbers,
}

/// Every sample, one a line.
pub(super) fn csv(samples: &[Sample]) -> String {
    let names = METHODS.map(|(name, _)| name).join(",");
    let mut text = format!("distance,surface,perceptual_roughness,outline,texture,share,{names}\n");
    for sample in samples {
        let errors = sample.errors.map(|error| format!("{error:.6}")).join(",");
        let roughness = sample.perceptual_roughness;
        let roughness = roughness.map_or(String::new(), |r| format!("{r:.4}"));
        text += &format!(
            "{},{},{roughness},{},{},{:.6},{errors}\n",
            sample.distance.name(),
            sample.surface.name(),
            sample.outline,
            sample.kind.name(),
            sample.share,
        );
    }
    text
}
