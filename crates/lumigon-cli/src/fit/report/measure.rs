//! Errors over perceptual roughness and view angle.

use std::sync::atomic::{AtomicU64, Ordering};

use lumigon_fit::Table;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use rayon::prelude::*;
use serde::Serialize;

use super::light::Quad;
use super::place::place;
use super::response::Lobes;
use super::truth::Truth;
use crate::Failure;
use crate::interrupt::Interrupt;

/// Cells along the first axis, mostly the perceptual roughness, from 0 to 1.
pub(super) const COLUMNS: usize = 20;
/// Cells along the view angle, from 0 to 90 degrees.
pub(super) const ROWS: usize = 18;
/// Random places in a cell.
const NODES: u64 = 2;
/// No table is made for views beyond.
const LARGEST_ANGLE: f64 = 89.0;
/// Below this albedo the furnace counts differences as absolute: a sheen's goes down to 0.
const LEAST_ALBEDO: f64 = 0.01;
/// The furnace counts up to here, in degrees.
const FURNACE_ANGLE: f64 = 85.0;

/// One light: truth and both tables, each with F = 1 and under the second weight.
struct Sample {
    truth: [f64; 2],
    fitted: [[f64; 2]; 2],
}

/// One place: albedos over the true one ([`LEAST_ALBEDO`] at least), shares below the horizon; table and baseline.
struct Place {
    degrees: f64,
    furnace: [f64; 2],
    leaked: [f64; 2],
    samples: Vec<Sample>,
}

/// The table and its baseline, measured on the same lights at the same places.
pub(super) struct Measurement {
    /// Row by row, [`COLUMNS`] a row, from normal to grazing view.
    cells: Vec<Vec<Place>>,
}

/// What a table misses over a range of its first axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Numbers {
    /// Root mean square of table minus truth for lights of radiance 1, F = 1.
    pub(super) rmse: f64,
    /// The same under the BRDF's second weight.
    pub(super) secondary_rmse: f64,
    /// Median of `|table - truth| / truth` over lights of response above 1e-3.
    pub(super) median_relative: f64,
    /// The 95th percentile of that.
    pub(super) percentile_95_relative: f64,
    /// Least and greatest albedo over the true one at view angles to 85 degrees.
    pub(super) furnace: [f64; 2],
    /// Mean share of the lobe below the horizon.
    pub(super) leaked_mean: f64,
    /// Greatest share.
    pub(super) leaked_greatest: f64,
}

/// [`Numbers`] of table and baseline over a range of the first axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Band {
    pub(super) first_axis: [f64; 2],
    pub(super) places: usize,
    pub(super) lights: usize,
    pub(super) table: Numbers,
    pub(super) baseline: Numbers,
}

impl Measurement {
    /// `lights` random lights a cell.
    pub(super) fn new(
        tables: [&Table; 2],
        lights: u32,
        seed: u64,
        progress: &(dyn Fn(u64, u64) + Sync),
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let done = AtomicU64::new(0);
        let total = COLUMNS * ROWS;
        let measure = |cell: usize| {
            interrupt.check()?;
            let (column, row) = (cell % COLUMNS, cell / COLUMNS);
            let places = (0..NODES).map(|node| {
                let stream = seed.wrapping_mul(total as u64 * NODES) + cell as u64 * NODES + node;
                let mut rng = Pcg32::seed_from_u64(stream);
                let first = (column as f64 + rng.random::<f64>()) / COLUMNS as f64;
                let degrees = (row as f64 + rng.random::<f64>()) * 90.0 / ROWS as f64;
                let count = u64::from(lights).div_ceil(NODES);
                measure_place(tables, first, degrees.min(LARGEST_ANGLE), count, &mut rng)
            });
            let places = places.collect();
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total as u64);
            Ok(places)
        };
        let cells: Result<_, Failure> = (0..total).into_par_iter().map(measure).collect();
        Ok(Self { cells: cells? })
    }

    /// RMSE of each cell for table (0) or baseline (1); with F = 1 (0) or weighted (1).
    pub(super) fn rmse(&self, which: usize, weight: usize) -> Vec<f64> {
        self.each(|places| {
            let samples = places.iter().flat_map(|place| &place.samples);
            rms(samples.map(|s| s.fitted[which][weight] - s.truth[weight]))
        })
    }

    /// Mean albedo of each cell over the true one.
    pub(super) fn furnace(&self, which: usize) -> Vec<f64> {
        self.each(|places| mean(places.iter().map(|place| place.furnace[which])))
    }

    /// Mean share below the horizon of each cell.
    pub(super) fn leaked(&self, which: usize) -> Vec<f64> {
        self.each(|places| mean(places.iter().map(|place| place.leaked[which])))
    }

    fn each(&self, number: impl Fn(&[Place]) -> f64) -> Vec<f64> {
        self.cells.iter().map(|places| number(places)).collect()
    }

    /// The numbers over a range of columns.
    pub(super) fn band(&self, columns: std::ops::Range<usize>) -> Band {
        let edge = |column: usize| column as f64 / COLUMNS as f64;
        let cells = self.cells.iter().enumerate();
        let places: Vec<&Place> = cells
            .filter(|(cell, _)| columns.contains(&(cell % COLUMNS)))
            .flat_map(|(_, places)| places)
            .collect();
        Band {
            first_axis: [edge(columns.start), edge(columns.end)],
            places: places.len(),
            lights: places.iter().map(|place| place.samples.len()).sum(),
            table: Numbers::new(&places, 0),
            baseline: Numbers::new(&places, 1),
        }
    }
}

fn measure_place(
    tables: [&Table; 2],
    first: f64,
    degrees: f64,
    lights: u64,
    rng: &mut Pcg32,
) -> Place {
    let brdf = tables[0].brdf();
    let place = place(brdf, first, degrees.to_radians(), || rng.random());
    let truth = Truth::new(brdf, &place, Truth::DIRECTIONS);
    let lobes = tables.map(|table| Lobes::look_up(table, &place));
    let samples = (0..lights).map(|_| {
        let light = Quad::random(rng, &truth);
        Sample {
            truth: truth.response(&light),
            fitted: lobes.each_ref().map(|lobes| lobes.response(&light)),
        }
    });
    Place {
        degrees,
        samples: samples.collect(),
        furnace: lobes.each_ref().map(|lobes| {
            let albedo = truth.albedo()[0];
            1.0 + (lobes.albedo()[0] - albedo) / albedo.max(LEAST_ALBEDO)
        }),
        leaked: lobes.each_ref().map(Lobes::leaked),
    }
}

impl Numbers {
    fn new(places: &[&Place], which: usize) -> Self {
        let samples = || places.iter().flat_map(|place| &place.samples);
        let error =
            |weight: usize| rms(samples().map(|s| s.fitted[which][weight] - s.truth[weight]));
        let mut relative: Vec<f64> = samples()
            .filter(|s| s.truth[0] > 1e-3)
            .map(|s| (s.fitted[which][0] - s.truth[0]).abs() / s.truth[0])
            .collect();
        relative.sort_by(f64::total_cmp);
        let percentile = |percent: usize| {
            let last = relative.len().saturating_sub(1);
            relative.get(last * percent / 100).copied().unwrap_or(0.0)
        };
        let furnace = places
            .iter()
            .filter(|place| place.degrees <= FURNACE_ANGLE)
            .map(|place| place.furnace[which]);
        let leaked = places.iter().map(|place| place.leaked[which]);
        Self {
            rmse: error(0),
            secondary_rmse: error(1),
            median_relative: percentile(50),
            percentile_95_relative: percentile(95),
            furnace: furnace.fold([f64::INFINITY, 0.0], |[least, greatest], ratio| {
                [least.min(ratio), greatest.max(ratio)]
            }),
            leaked_mean: mean(leaked.clone()),
            leaked_greatest: leaked.fold(0.0, f64::max),
        }
    }
}

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

fn rms(numbers: impl Iterator<Item = f64>) -> f64 {
    mean(numbers.map(|x| x * x)).sqrt()
}
