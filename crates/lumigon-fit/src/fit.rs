use std::{
    path::PathBuf,
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
};

use rayon::prelude::*;

use crate::{
    coordinates::Coordinates,
    least_squares::least_squares,
    node::Node,
    objective::{Objective, Residuals},
    settings::Settings,
    table::{CHANNELS, Table},
};

/// A sum of squared residuals this small (1 % rms) leaves nothing to gain.
const ACCURATE: f64 = 1e-4;

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// A setting is out of range.
    #[error("fit settings: {0}")]
    Settings(String),
    /// The caller asked to stop.
    #[error("the fit was cancelled")]
    Cancelled,
    /// A texel did not become finite.
    #[error("texel ({column}, {row}) has no finite fit; try more directions or another seed")]
    NotFinite {
        /// Column, along perceptual roughness.
        column: usize,
        /// Row, along the view angle.
        row: usize,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file was read but isn't what it should be.
    #[error("{}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong and what would be right.
        problem: String,
    },
}

/// A node ready to be fitted, without its lobe's directions.
struct Problem {
    node: Node,
    residuals: Box<dyn Residuals>,
}

impl Problem {
    fn new(settings: &Settings, objective: &dyn Objective, column: usize, row: usize) -> Self {
        let last = f64::from(settings.size - 1);
        let (u, v) = (column as f64 / last, row as f64 / last);
        let (node, lobe) = Node::new(settings.brdf, u, 1.0 - v * v, settings.directions);
        let residuals = objective.prepare(&node, &lobe);
        Self { node, residuals }
    }

    /// Fits from a start; `pull` draws the coordinates to a target with a weight.
    fn fit(
        &self,
        settings: &Settings,
        start: Coordinates,
        pull: Option<&Coordinates>,
    ) -> (Coordinates, f64) {
        let free = settings.parametrisation.free();
        let place = |params: &[f64]| {
            let mut coordinates = start;
            for (&i, &p) in free.iter().zip(params) {
                coordinates.0[i] = p;
            }
            settings
                .parametrisation
                .constrain(&mut coordinates, &self.node);
            coordinates
        };
        let residuals_at = |params: &[f64]| {
            let coordinates = place(params);
            let mut residuals = Vec::new();
            self.residuals
                .evaluate(&coordinates.to_ltc(&self.node), &mut residuals);
            if let Some(target) = pull {
                for &i in free {
                    residuals.push(settings.smoothing * (coordinates.0[i] - target.0[i]));
                }
            }
            residuals
        };
        let params: Vec<f64> = free.iter().map(|&i| start.0[i]).collect();
        let (params, cost) = least_squares(&params, &residuals_at);
        (place(&params), cost)
    }

    /// One step of a sweep: starts at the texel's own and at a neighbour's coordinates.
    fn improve(
        &self,
        settings: &Settings,
        all: &[Coordinates],
        column: usize,
        row: usize,
    ) -> Coordinates {
        let n = settings.size as usize;
        let at = |column: usize, row: usize| (column < n && row < n).then(|| all[row * n + column]);
        let own = all[row * n + column];
        let beside = [at(column.wrapping_sub(1), row), at(column + 1, row)];
        let above = at(column, row + 1);
        let below = if row == 0 {
            // The view angle -v beyond normal view is v seen from the other side.
            above.map(Coordinates::mirrored)
        } else {
            at(column, row - 1)
        };

        // Along each axis with both neighbours, their mean makes the table straight.
        let means: Vec<[f64; Coordinates::COUNT]> = [beside, [below, above]]
            .iter()
            .filter_map(|pair| Some((pair[0]?, pair[1]?)))
            .map(|(a, b)| std::array::from_fn(|i| 0.5 * (a.0[i] + b.0[i])))
            .collect();
        let pull = (!means.is_empty() && settings.smoothing > 0.0).then(|| {
            Coordinates(std::array::from_fn(|i| {
                means.iter().map(|m| m[i]).sum::<f64>() / means.len() as f64
            }))
        });

        let mut best = (own, f64::INFINITY);
        // From its own coordinates, and from the neighbour whose fit suits this texel best as it is.
        let as_is = |c: &Coordinates| {
            let mut residuals = Vec::new();
            self.residuals
                .evaluate(&c.to_ltc(&self.node), &mut residuals);
            residuals.iter().map(|r| r * r).sum::<f64>()
        };
        let nearest = [beside[0], beside[1], below, above]
            .into_iter()
            .flatten()
            .min_by(|a, b| as_is(a).total_cmp(&as_is(b)));
        for start in [Some(own), nearest].into_iter().flatten() {
            let (coordinates, cost) = self.fit(settings, start, pull.as_ref());
            // Another basin must be much better: two of about the same cost, taken in turns by
            // neighbouring texels, are far worse between the texels than either.
            if cost + ACCURATE < 0.5 * best.1 {
                best = (coordinates, cost);
            }
        }
        best.0
    }

    fn texel(&self, coordinates: Coordinates) -> [f32; CHANNELS] {
        let ltc = coordinates.to_ltc(&self.node);
        let [a, b, c, d] = ltc.matrix;
        // At most 1 at every texel, so that no lookup makes energy: share and amplitude both
        // interpolate to at most 1. Schlick's weight is at most 1 itself.
        let amplitude = ltc.amplitude.min(1.0);
        let schlick = self.residuals.schlick(&ltc).clamp(0.0, amplitude);
        [a, b, c, d, amplitude, schlick, 0.0, 0.0].map(|x| x as f32)
    }
}

/// Fits a table. `progress(done, total)` is called from many threads as texels finish; setting
/// `cancel` ends the fit soon. The result depends on the settings alone.
///
/// # Errors
/// Settings out of range, cancellation, a texel without a finite fit.
pub fn fit(
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) + Sync),
    cancel: &AtomicBool,
) -> Result<Table, FitError> {
    settings.validate().map_err(FitError::Settings)?;
    let n = settings.size as usize;
    let objective = settings.objective();
    let total = n * n * (1 + settings.sweeps as usize);
    let done = AtomicUsize::new(0);
    let advance = || {
        if cancel.load(Ordering::Relaxed) {
            return Err(FitError::Cancelled);
        }
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        Ok(())
    };

    // March: each column on its own, from normal to grazing view.
    let columns = (0..n)
        .into_par_iter()
        .map(|column| {
            let mut marched = Vec::with_capacity(n);
            let mut start = None;
            for row in 0..n {
                let problem = Problem::new(settings, objective.as_ref(), column, row);
                let from = start.unwrap_or_else(|| Coordinates::mirror(&problem.node));
                let (coordinates, _) = problem.fit(settings, from, None);
                start = Some(coordinates);
                marched.push((problem, coordinates));
                advance()?;
            }
            Ok(marched)
        })
        .collect::<Result<Vec<_>, FitError>>()?;
    let mut coordinates = vec![Coordinates([0.0; Coordinates::COUNT]); n * n];
    for (column, marched) in columns.iter().enumerate() {
        for (row, (_, c)) in marched.iter().enumerate() {
            coordinates[row * n + column] = *c;
        }
    }

    // Sweeps: every texel reads the previous sweep only, so that their order doesn't matter.
    for _ in 0..settings.sweeps {
        coordinates = (0..n * n)
            .into_par_iter()
            .map(|i| {
                let (column, row) = (i % n, i / n);
                advance()?;
                Ok(columns[column][row]
                    .0
                    .improve(settings, &coordinates, column, row))
            })
            .collect::<Result<_, FitError>>()?;
    }

    let texels: Vec<f32> = (0..n * n)
        .into_par_iter()
        .flat_map_iter(|i| columns[i % n][i / n].0.texel(coordinates[i]))
        .collect();
    if let Some(bad) = texels.iter().position(|x| !x.is_finite()) {
        let texel = bad / CHANNELS;
        return Err(FitError::NotFinite {
            column: texel % n,
            row: texel / n,
        });
    }
    Ok(Table {
        settings: settings.clone(),
        texels,
    })
}

/// Fits single texels `(column, row)` again, from the table's own neighbourhood: one more step of
/// a sweep, which hardly moves a finished table. Returns texels in the table's format.
///
/// # Errors
/// Settings out of range, a texel outside the table.
pub fn refit(table: &Table, texels: &[(usize, usize)]) -> Result<Vec<[f32; 8]>, FitError> {
    let settings = table.settings();
    settings.validate().map_err(FitError::Settings)?;
    let n = table.size();
    if let Some((column, row)) = texels.iter().find(|(c, r)| *c >= n || *r >= n) {
        return Err(FitError::Settings(format!(
            "texel ({column}, {row}) is outside the table of {n} x {n}"
        )));
    }
    let objective = settings.objective();
    texels
        .par_iter()
        .map(|&(column, row)| {
            let mut all = vec![Coordinates([0.0; Coordinates::COUNT]); n * n];
            for (c, r) in [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)] {
                let (c, r) = (column.wrapping_add_signed(c), row.wrapping_add_signed(r));
                if c < n && r < n {
                    let u = c as f64 / (n - 1) as f64;
                    let v = r as f64 / (n - 1) as f64;
                    let (node, _) = Node::new(settings.brdf, u, 1.0 - v * v, 64);
                    all[r * n + c] = Coordinates::from_ltc(&table.texel(c, r), &node);
                }
            }
            let problem = Problem::new(settings, objective.as_ref(), column, row);
            Ok(problem.texel(problem.improve(settings, &all, column, row)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::ObjectiveKind;

    fn tiny() -> Settings {
        Settings {
            size: 8,
            directions: 1000,
            samples: 48,
            ..Settings::default()
        }
    }

    fn on_threads(threads: usize, settings: &Settings) -> Table {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| fit(settings, &|_, _| (), &AtomicBool::new(false)))
            .unwrap()
    }

    #[test]
    fn same_bits_on_any_number_of_threads() {
        let one = on_threads(1, &tiny());
        assert_eq!(one, on_threads(2, &tiny()));
        let other = on_threads(2, &Settings { seed: 2, ..tiny() });
        assert_ne!(one.texels, other.texels);
    }

    #[test]
    fn both_objectives_are_finite_everywhere() {
        for base in [Settings::published(), Settings::default()] {
            let samples = if base.objective == ObjectiveKind::Density {
                128
            } else {
                32
            };
            let settings = Settings {
                size: 4,
                directions: 500,
                samples,
                ..base
            };
            let table = on_threads(2, &settings);
            assert!(table.texels().iter().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn progress_reaches_the_total_and_cancel_stops() {
        let (calls, last) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let progress = |done: usize, total: usize| {
            calls.fetch_add(1, Ordering::Relaxed);
            last.fetch_max(done, Ordering::Relaxed);
            assert!(done <= total);
        };
        let settings = Settings {
            size: 3,
            directions: 100,
            samples: 8,
            ..Settings::default()
        };
        fit(&settings, &progress, &AtomicBool::new(false)).unwrap();
        let texel_fits = 9 * (1 + settings.sweeps as usize);
        assert_eq!(calls.load(Ordering::Relaxed), texel_fits);
        assert_eq!(last.load(Ordering::Relaxed), texel_fits);
        let cancelled = fit(&settings, &|_, _| (), &AtomicBool::new(true));
        assert!(matches!(cancelled, Err(FitError::Cancelled)));
    }
}
