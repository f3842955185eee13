//! What was measured, as `metrics.json` holds it.

use serde::Serialize;

use super::machine::Machine;
use super::method::Part;
use super::metrics::{Difference, Noise, ZScores};

/// The whole of `metrics.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// Marks the file as this command's.
    pub generator: &'static str,
    /// The version of lumigon.
    pub version: &'static str,
    /// What was rendered.
    pub scene: SceneRecord,
    /// How it was rendered.
    pub settings: SettingsRecord,
    /// What it was rendered on.
    pub machine: Machine,
    /// Wall seconds of rendering the same picture without polygon lights: rays, materials, and
    /// punctual lights, which all methods share.
    pub seconds_without_polygon_lights: f64,
    /// The path-traced pictures, without shadows and with them.
    pub references: [ReferenceRecord; 2],
    /// Every method in the order of the report.
    pub methods: Vec<MethodRecord>,
    /// The exact diffuse method against the noise of the unshadowed reference.
    pub exact_diffuse_z_scores: ZScores,
    /// Every file of the report, relative to its folder.
    pub files: Vec<String>,
}

/// What was rendered.
#[derive(Clone, Debug, Serialize)]
pub struct SceneRecord {
    /// The file, as it was named.
    pub path: String,
    /// Triangles of all meshes.
    pub triangles: usize,
    /// Flat emissive faces.
    pub polygon_lights: usize,
    /// Point, spot and directional lights.
    pub punctual_lights: usize,
    /// What the file asks for and is not done.
    pub warnings: Vec<String>,
}

/// How it was rendered.
#[derive(Clone, Debug, Serialize)]
pub struct SettingsRecord {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The camera's name.
    pub camera: String,
    /// Camera rays a pixel.
    pub samples: u32,
    /// Light paths a pixel of the references.
    pub spp: u32,
    /// Surfaces at which the shadowed reference's paths scatter.
    pub bounces: u32,
    /// Seed of the references.
    pub seed: u64,
    /// Stops of exposure in the PNG pictures.
    pub exposure: f32,
    /// The tone curve of the PNG pictures.
    pub tonemap: String,
    /// The biased projection's bias, in scene units.
    pub bias: f64,
    /// FLIP's viewing distance, in pixels per degree.
    pub pixels_per_degree: f32,
}

/// One path-traced picture.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceRecord {
    /// Its name in file names.
    pub id: &'static str,
    /// Its name.
    pub title: &'static str,
    /// Whether surfaces block light.
    pub shadows: bool,
    /// Surfaces at which its paths scatter.
    pub bounces: u32,
    /// Wall seconds, once.
    pub seconds: f64,
    /// The noise of the sum.
    pub radiance_noise: Noise,
    /// The noise of the diffuse part.
    pub diffuse_noise: Noise,
    /// The noise of the specular part.
    pub specular_noise: Noise,
    /// Its pictures, part by part.
    pub pictures: Vec<PartPicture>,
    /// How far shadows move the picture; only for the shadowed reference.
    pub against_unshadowed: Option<Against>,
}

/// A part of a reference as a picture.
#[derive(Clone, Debug, Serialize)]
pub struct PartPicture {
    /// Which part.
    pub part: Part,
    /// The PNG's path.
    pub picture: String,
}

/// A picture against the reference, and the files that show it.
#[derive(Clone, Debug, Serialize)]
pub struct Against {
    /// The tone-mapped PNG.
    pub picture: String,
    /// The difference in false colour.
    pub difference_picture: String,
    /// The numbers.
    #[serde(flatten)]
    pub difference: Difference,
    /// Mean FLIP of the tone-mapped pictures, 0 to 1.
    pub flip: f64,
}

/// One method.
#[derive(Clone, Debug, Serialize)]
pub struct MethodRecord {
    /// Unique; its name in file names.
    pub id: &'static str,
    /// Its name.
    pub title: &'static str,
    /// The part of the unshadowed reference that it is compared with.
    pub part: Part,
    /// The diffuse method it was rendered with.
    pub diffuse: String,
    /// The specular method it was rendered with.
    pub specular: String,
    /// What it does.
    #[serde(skip)]
    pub words: &'static str,
    /// Where it was published.
    pub source: &'static str,
    /// Against the reference.
    #[serde(flatten)]
    pub against: Against,
    /// The median wall seconds of its render calls, without building the hierarchy.
    pub seconds: f64,
    /// The fastest and the slowest of them.
    pub seconds_range: [f64; 2],
    /// How many render calls.
    pub repeats: usize,
    /// `seconds` over the exact diffuse method's.
    pub ratio_to_exact: f64,
    /// `seconds` less the seconds without polygon lights, over the exact diffuse method's; none
    /// where those are not above 0.
    pub lighting_ratio_to_exact: Option<f64>,
}

impl ReferenceRecord {
    /// The noise of one part.
    pub fn noise(&self, part: Part) -> Noise {
        match part {
            Part::Radiance => self.radiance_noise,
            Part::Diffuse => self.diffuse_noise,
            Part::Specular => self.specular_noise,
        }
    }
}
