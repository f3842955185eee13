//! What `metrics.json` holds.

use serde::Serialize;

use super::cost::CostRow;
use super::errors::ErrorRow;
use super::flicker::FlickerRow;
use crate::compare::machine::Machine;

/// All of a report's numbers.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    pub(super) generator: &'static str,
    pub(super) version: &'static str,
    /// The command that makes it again.
    pub(super) command: String,
    pub(super) machine: Machine,
    pub(super) scenes: Vec<SceneRecord>,
    pub(super) errors: Vec<ErrorRow>,
    pub(super) cost: Vec<CostRow>,
    pub(super) flicker: Vec<FlickerRow>,
    pub(super) warnings: Vec<String>,
    /// Every file of the report, relative to it.
    pub(super) files: Vec<String>,
}

/// What was rendered.
#[derive(Debug, Serialize)]
pub(super) struct SceneRecord {
    pub(super) name: String,
    pub(super) path: String,
    pub(super) triangles: usize,
    pub(super) lights: usize,
    /// The references' noise over their light, in the order nothing, bounce light, all light blocked.
    pub(super) noise: [Option<f64>; 3],
}
