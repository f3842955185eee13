//! What `metrics.json` holds.

use lumigon_fit::{Manifest, Settings, Table};
use serde::Serialize;

use super::continuity::Bounds;
use super::measure::Band;

/// All of a report's numbers.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    pub(super) generator: &'static str,
    pub(super) version: &'static str,
    pub(super) table: TableRecord,
    pub(super) baseline: TableRecord,
    /// Seed of the lights.
    pub(super) seed: u64,
    /// Random lights a cell.
    pub(super) lights: u32,
    /// Numbers over ranges of perceptual roughness.
    pub(super) bands: Vec<Band>,
    pub(super) second_differences: SecondDifferences,
    pub(super) cells: Cells,
    /// Every file of the report, relative to it.
    pub(super) files: Vec<String>,
}

/// One table.
#[derive(Debug, Serialize)]
pub(super) struct TableRecord {
    /// What the report calls it.
    pub(super) name: String,
    /// Its manifest's path; none where it was fitted for the report.
    pub(super) path: Option<String>,
    pub(super) settings: Settings,
    /// What its manifest says; none where it was fitted for the report.
    pub(super) manifest: Option<Manifest>,
}

/// Of the response to the light of the continuity figure.
#[derive(Debug, Serialize)]
pub(super) struct SecondDifferences {
    pub(super) table: Bounds,
    pub(super) baseline: Bounds,
}

/// Cell by cell, from perceptual roughness 0 and normal view, columns fastest; table and baseline.
#[derive(Debug, Serialize)]
pub(super) struct Cells {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) rmse: [Vec<f64>; 2],
    pub(super) secondary_rmse: [Vec<f64>; 2],
    pub(super) furnace: [Vec<f64>; 2],
    pub(super) leaked: [Vec<f64>; 2],
}

impl TableRecord {
    pub(super) fn new(table: &Table, name: &str, read: Option<(String, Manifest)>) -> Self {
        let (path, manifest) = read.unzip();
        Self {
            name: name.to_owned(),
            path,
            settings: table.settings().clone(),
            manifest,
        }
    }
}
