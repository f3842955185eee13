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
        mut start: Coordinates,
        pull: Option<&Coordinates>,
    ) -> (Coordinates, f64) {
        settings.parametrisation.constrain(&mut start, &self.node);
        let free = settings.parametrisation.free();
        let place = |params: &[f64]| {
            let mut coordinates = start;
            for (&i, &p) in free.iter().zip(params) {
                coordinates.0[i] = p;
            }
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

    /// One step of a sweep: starts at the texel's own and at each neighbour's coordinates.
    fn improve(
        &self,
        settings: &Settings,
        all: &[Coordinates],
        column: usize,
        row: usize,
    ) -> Coordinates {
        let n = settings.size as usize;
        let at = |column: usize, row: usize| all[row * n + column];
        let inner = |i: usize| i > 0 && i + 1 < n;
        let mut starts = vec![at(column, row)];
        let mut mean = [0.0; Coordinates::COUNT];
        let mut axes = 0.0;
        for (is_inner, neighbours) in [
            (
                inner(column),
                [(column.wrapping_sub(1), row), (column + 1, row)],
            ),
            (
                inner(row),
                [(column, row.wrapping_sub(1)), (column, row + 1)],
            ),
        ] {
            let present: Vec<Coordinates> = neighbours
                .iter()
                .filter(|(c, r)| *c < n && *r < n)
                .map(|&(c, r)| at(c, r))
                .collect();
            if is_inner {
                axes += 1.0;
                for (i, m) in mean.iter_mut().enumerate() {
                    *m += 0.5 * (present[0].0[i] + present[1].0[i]);
                }
            }
            starts.extend(present);
        }
        let pull =
            (axes > 0.0 && settings.smoothing > 0.0).then(|| Coordinates(mean.map(|m| m / axes)));
        let mut best = (starts[0], f64::INFINITY);
        for start in starts {
            let (coordinates, cost) = self.fit(settings, start, pull.as_ref());
            // A tie keeps the earlier start, so that equal optima don't flicker.
            if cost < best.1 * (1.0 - 1e-6) {
                best = (coordinates, cost);
            }
        }
        best.0
    }

    fn texel(&self, coordinates: Coordinates) -> [f32; CHANNELS] {
        let ltc = coordinates.to_ltc(&self.node);
        let [a, b, c, d] = ltc.matrix;
        let schlick = self.residuals.schlick(&ltc);
        [a, b, c, d, ltc.amplitude, schlick, 0.0, 0.0].map(|x| x as f32)
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
/// a sweep, which a converged table hardly moves. Returns texels in the table's format.
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
        assert_eq!(on_threads(1, &tiny()), on_threads(2, &tiny()));
        let other = on_threads(2, &Settings { seed: 2, ..tiny() });
        assert_ne!(on_threads(2, &tiny()).texels, other.texels);
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
        assert_eq!(calls.load(Ordering::Relaxed), 27);
        assert_eq!(last.load(Ordering::Relaxed), 27);
        let cancelled = fit(&settings, &|_, _| (), &AtomicBool::new(true));
        assert!(matches!(cancelled, Err(FitError::Cancelled)));
    }
}
