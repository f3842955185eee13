//! What was measured, as `metrics.json` holds it.

use serde::Serialize;

use super::bounce::BounceRecord;
use super::machine::Machine;
use super::method::Part;
use super::metrics::{Difference, Noise, ZScores};

/// The whole of `metrics.json`.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Record {
    /// Marks the file as this command's.
    pub(super) generator: &'static str,
    /// The version of lumigon.
    pub(super) version: &'static str,
    /// What was rendered.
    pub(super) scene: SceneRecord,
    /// How it was rendered.
    pub(super) settings: SettingsRecord,
    /// What it was rendered on.
    pub(super) machine: Machine,
    /// Wall seconds of rendering the same picture without polygon lights: rays, materials, and
    /// punctual lights, which all methods share.
    pub(super) seconds_without_polygon_lights: f64,
    /// The path-traced pictures, without shadows and with them.
    pub(super) references: [ReferenceRecord; 2],
    /// Every method in the order of the report.
    pub(super) methods: Vec<MethodRecord>,
    /// A single bounce by virtual lights, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) bounce: Option<BounceRecord>,
    /// The exact diffuse method against the noise of the unshadowed reference.
    pub(super) exact_diffuse_z_scores: ZScores,
    /// Every file of the report, relative to its folder.
    pub(super) files: Vec<String>,
}

/// What was rendered.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SceneRecord {
    /// The file, as it was named.
    pub(super) path: String,
    /// Triangles of all meshes.
    pub(super) triangles: usize,
    /// Flat emissive faces.
    pub(super) polygon_lights: usize,
    /// Those that show a picture.
    pub(super) light_images: usize,
    /// Point, spot and directional lights.
    pub(super) punctual_lights: usize,
    /// What the file asks for and is not done.
    pub(super) warnings: Vec<String>,
}

/// How it was rendered.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SettingsRecord {
    /// Pixels across.
    pub(super) width: u32,
    /// Pixels down.
    pub(super) height: u32,
    /// The camera's name.
    pub(super) camera: String,
    /// Camera rays a pixel.
    pub(super) samples: u32,
    /// Light paths a pixel of the references.
    pub(super) spp: u32,
    /// Surfaces at which the shadowed reference's paths scatter.
    pub(super) bounces: u32,
    /// Seed of the references.
    pub(super) seed: u64,
    /// Stops of exposure in the PNG pictures.
    pub(super) exposure: f32,
    /// The tone curve of the PNG pictures.
    pub(super) tonemap: &'static str,
    /// The biased projection's bias, in scene units.
    pub(super) bias: f64,
    /// FLIP's viewing distance, in pixels per degree.
    pub(super) pixels_per_degree: f32,
}

/// One path-traced picture.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ReferenceRecord {
    /// Its name in file names.
    pub(super) id: &'static str,
    /// Its name.
    pub(super) title: &'static str,
    /// Whether surfaces block light.
    pub(super) shadows: bool,
    /// Surfaces at which its paths scatter.
    pub(super) bounces: u32,
    /// Wall seconds, once.
    pub(super) seconds: f64,
    /// The noise of the sum.
    pub(super) radiance_noise: Noise,
    /// The noise of the diffuse part.
    pub(super) diffuse_noise: Noise,
    /// The noise of the specular part.
    pub(super) specular_noise: Noise,
    /// Its pictures, part by part.
    pub(super) pictures: Vec<PartPicture>,
    /// How far shadows move the picture; only for the shadowed reference.
    pub(super) against_unshadowed: Option<Against>,
}

/// A part of a reference as a picture.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PartPicture {
    /// Which part.
    pub(super) part: Part,
    /// The PNG's path.
    pub(super) picture: String,
}

/// A picture against the reference, and the files that show it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Against {
    /// The tone-mapped PNG.
    pub(super) picture: String,
    /// The difference in false colour.
    pub(super) difference_picture: String,
    /// The numbers.
    #[serde(flatten)]
    pub(super) difference: Difference,
    /// Mean FLIP of the tone-mapped pictures, 0 to 1.
    pub(super) flip: f64,
}

/// One method.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MethodRecord {
    /// Unique; its name in file names.
    pub(super) id: &'static str,
    /// Its name.
    pub(super) title: &'static str,
    /// The part of the unshadowed reference that it is compared with.
    pub(super) part: Part,
    /// The diffuse method it was rendered with.
    pub(super) diffuse: String,
    /// The specular method it was rendered with.
    pub(super) specular: String,
    /// What it does.
    #[serde(skip)]
    pub(super) words: &'static str,
    /// Where it was published.
    pub(super) source: &'static str,
    /// Against the reference.
    #[serde(flatten)]
    pub(super) against: Against,
    /// The median wall seconds of its render calls, without building the hierarchy and, where it
    /// was called three times or more, without the first.
    pub(super) seconds: f64,
    /// The fastest and the slowest of them.
    pub(super) seconds_range: [f64; 2],
    /// How many render calls.
    pub(super) repeats: usize,
    /// `seconds` over the exact diffuse method's.
    pub(super) ratio_to_exact: Option<f64>,
    /// `seconds` less the seconds without polygon lights, over the exact diffuse method's; none
    /// where those are not above 0.
    pub(super) lighting_ratio_to_exact: Option<f64>,
}

impl ReferenceRecord {
    /// The noise of one part.
    pub(super) fn noise(&self, part: Part) -> Noise {
        match part {
            Part::Radiance => self.radiance_noise,
            Part::Diffuse => self.diffuse_noise,
            Part::Specular => self.specular_noise,
        }
    }
}
