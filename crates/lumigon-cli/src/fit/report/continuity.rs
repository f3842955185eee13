//! How a table's response changes as perceptual roughness and view sweep finely.

use glam::{DVec2, DVec3};
use lumigon_fit::Table;
use rayon::prelude::*;
use serde::Serialize;

use super::light::Quad;
use super::place::in_slice;
use super::response::Lobes;
use super::truth::Truth;
use crate::Failure;
use crate::interrupt::Interrupt;

/// Steps along the first axis, mostly the perceptual roughness, 0 to 1.
pub(super) const WIDTH: usize = 512;
/// Steps of the view angle, 0 to [`LARGEST_ANGLE`].
pub(super) const HEIGHT: usize = 270;
/// In degrees.
pub(super) const LARGEST_ANGLE: f64 = 88.0;
/// Where the sweeps with the BRDF beside them are taken.
pub(super) const SWEEP_DEGREES: f64 = 60.0;
pub(super) const SWEEP_FIRST: f64 = 0.3;
/// Points of the BRDF on a sweep.
const POINTS: usize = 48;

/// Responses to a light that moves with the mirror direction: a square of 1 by 1 at distance 1,
/// one edge of which runs through the mirror direction, the rest above it.
///
/// The edge is where a table shows most: a lobe that turns or widens crosses it.
pub(super) struct Strip {
    /// Row by row from normal view, [`WIDTH`] a row.
    pub(super) responses: Vec<f64>,
    /// The greater of the second differences' absolute values along both axes, likewise; 0 at the
    /// ends.
    pub(super) second_differences: Vec<f64>,
}

/// The greatest second differences `|f(-1) - 2 f(0) + f(1)|`, radiance of the light 1.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Bounds {
    /// From 0.1 on along the first axis.
    pub(super) rough: f64,
    /// Below 0.1, where lobes are narrow and the BRDF itself is steep.
    pub(super) smooth: f64,
}

fn light(view: DVec3) -> Quad {
    let mirror = DVec3::new(-view.x, -view.y, view.z);
    let azimuth = view.truncate().normalize_or(DVec2::X);
    let up = (view.z * azimuth).extend(view.truncate().length());
    let across = DVec3::new(-azimuth.y, azimuth.x, 0.0);
    Quad::new(mirror + 0.5 * up, 0.5 * up, 0.5 * across)
}

fn radians(row: usize) -> f64 {
    (LARGEST_ANGLE * row as f64 / (HEIGHT - 1) as f64).to_radians()
}

fn first(column: usize) -> f64 {
    column as f64 / (WIDTH - 1) as f64
}

fn response(table: &Table, place: &[f64]) -> f64 {
    let (_, view) = table.brdf().at(place);
    Lobes::look_up(table, place).response(&light(view))[0]
}

impl Strip {
    pub(super) fn new(table: &Table, interrupt: &Interrupt) -> Result<Self, Failure> {
        let rows: Result<Vec<Vec<f64>>, Failure> = (0..HEIGHT)
            .into_par_iter()
            .map(|row| {
                interrupt.check()?;
                let at =
                    |column| response(table, &in_slice(table.brdf(), first(column), radians(row)));
                Ok((0..WIDTH).map(at).collect())
            })
            .collect();
        let responses = rows?.concat();
        let second_differences = second_differences(&responses);
        Ok(Self {
            responses,
            second_differences,
        })
    }

    pub(super) fn bounds(&self) -> Bounds {
        let greatest = |rough: bool| {
            let differences = self.second_differences.iter().enumerate();
            differences
                .filter(|(i, _)| (first(i % WIDTH) >= 0.1) == rough)
                .fold(0.0, |greatest: f64, (_, &d)| greatest.max(d))
        };
        Bounds {
            rough: greatest(true),
            smooth: greatest(false),
        }
    }
}

fn second_differences(responses: &[f64]) -> Vec<f64> {
    let along = |i: usize, step: usize| {
        (responses[i - step] - 2.0 * responses[i] + responses[i + step]).abs()
    };
    let height = responses.len() / WIDTH;
    (0..responses.len())
        .map(|i| {
            let (column, row) = (i % WIDTH, i / WIDTH);
            let mut greatest = 0.0_f64;
            if column > 0 && column + 1 < WIDTH {
                greatest = greatest.max(along(i, 1));
            }
            if row > 0 && row + 1 < height {
                greatest = greatest.max(along(i, WIDTH));
            }
            greatest
        })
        .collect()
}

/// The same light along one axis: table and baseline finely, the BRDF at some points.
pub(super) struct Sweep {
    pub(super) truth: Vec<(f64, f64)>,
    pub(super) fitted: [Vec<(f64, f64)>; 2],
}

impl Sweep {
    /// Over the first axis at one view angle.
    pub(super) fn over_first(tables: [&Table; 2], interrupt: &Interrupt) -> Result<Self, Failure> {
        let theta = SWEEP_DEGREES.to_radians();
        Self::new(tables, 1.0, interrupt, &|x| (x, theta))
    }

    /// Over the view angle in degrees at one place of the first axis.
    pub(super) fn over_view(tables: [&Table; 2], interrupt: &Interrupt) -> Result<Self, Failure> {
        let place = |x: f64| (SWEEP_FIRST, x.to_radians());
        Self::new(tables, LARGEST_ANGLE, interrupt, &place)
    }

    fn new(
        tables: [&Table; 2],
        end: f64,
        interrupt: &Interrupt,
        place: &(dyn Fn(f64) -> (f64, f64) + Sync),
    ) -> Result<Self, Failure> {
        let brdf = tables[0].brdf();
        let place = |x: f64| {
            let (first, theta) = place(x);
            in_slice(brdf, first, theta)
        };
        let spread = |i: usize, count: usize| end * i as f64 / (count - 1) as f64;
        let truth: Result<_, Failure> = (0..POINTS)
            .into_par_iter()
            .map(|i| {
                interrupt.check()?;
                let x = spread(i, POINTS);
                let truth = Truth::new(brdf, &place(x), Truth::DIRECTIONS);
                Ok((x, truth.response(&light(truth.view()))[0]))
            })
            .collect();
        let fitted = tables.map(|table| {
            let at = |i: usize| {
                let x = spread(i, WIDTH);
                (x, response(table, &place(x)))
            };
            (0..WIDTH).map(at).collect()
        });
        Ok(Self {
            truth: truth?,
            fitted,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_found_where_it_is_and_a_slope_is_none() {
        let jump = |i: usize| if i % WIDTH >= 300 { 0.25 } else { 0.0 };
        let slope = |i: usize| 0.001 * (i / WIDTH) as f64;
        let responses: Vec<f64> = (0..WIDTH * 5).map(|i| slope(i) + jump(i)).collect();
        let found = second_differences(&responses);
        for (i, difference) in found.iter().enumerate() {
            let expected = if matches!(i % WIDTH, 299 | 300) {
                0.25
            } else {
                0.0
            };
            assert!((difference - expected).abs() < 1e-12, "{i}: {difference}");
        }
    }

    #[test]
    fn the_edge_runs_through_the_mirror_direction() {
        for theta in [0.0, 0.7, 1.5_f64] {
            let view = DVec3::new(0.6 * theta.sin(), 0.8 * theta.sin(), theta.cos());
            let mirror = DVec3::new(-view.x, -view.y, view.z);
            let distances = light(view).edge_planes().map(|plane| plane.dot(mirror));
            let least = distances.into_iter().fold(1.0, f64::min);
            assert!(least.abs() < 1e-12, "{distances:?}");
        }
    }
}
