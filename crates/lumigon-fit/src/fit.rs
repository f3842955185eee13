use std::{
    cell::RefCell,
    path::PathBuf,
    sync::{
        Mutex, MutexGuard, OnceLock, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use rayon::prelude::*;

use crate::{
    checkpoint::Checkpoint,
    coordinates::Coordinates,
    grid::Grid,
    layout::Layout,
    least_squares::least_squares,
    ltc::Ltc,
    node::Node,
    objective::{Objective, Parts, Residuals},
    settings::Settings,
    table::Table,
};

/// Sums of squared residuals that differ by this are alike: a change of texel must gain more.
const NO_DIFFERENCE: f64 = 1e-8;

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
    #[error("texel {texel:?} has no finite fit; try more directions or another seed")]
    NotFinite {
        /// Position along each axis.
        texel: Vec<usize>,
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

/// A texel's lobes as a fit moves them.
pub(crate) type Lobes = Vec<Coordinates>;

/// A node ready to be fitted, without its lobe's directions.
struct Problem {
    node: Node,
    residuals: Box<dyn Residuals>,
}

impl Problem {
    fn new(settings: &Settings, objective: &dyn Objective, place: &[f64]) -> Self {
        let (node, lobe) = Node::new(settings.brdf, place, settings.directions);
        let residuals = objective.prepare(&node, &lobe);
        Self { node, residuals }
    }

    fn ltcs(&self, settings: &Settings, lobes: &[Coordinates]) -> Vec<Ltc> {
        let mut ltcs: Vec<Ltc> = lobes.iter().map(|c| c.to_ltc(&self.node.limit)).collect();
        if settings.cosine {
            ltcs.push(Ltc::cosine());
        }
        ltcs
    }

    /// Fits from a start; `pull` draws the coordinates to a target with a weight.
    fn fit(
        &self,
        settings: &Settings,
        start: &[Coordinates],
        pull: Option<(&[Coordinates], f64)>,
    ) -> (Lobes, f64) {
        let free = settings.parametrisation.free(settings.brdf.is_isotropic());
        let place = |params: &[f64]| {
            let mut lobes = start.to_vec();
            for (lobe, params) in lobes.iter_mut().zip(params.chunks(free.len())) {
                for (&i, &p) in free.iter().zip(params) {
                    lobe.0[i] = p;
                }
                settings.parametrisation.constrain(lobe, &self.node);
            }
            lobes
        };
        let parts = RefCell::new(Parts::default());
        let residuals_at = |params: &[f64]| {
            let lobes = place(params);
            let mut residuals = Vec::new();
            self.evaluate(settings, &lobes, &mut parts.borrow_mut(), &mut residuals);
            if let Some((target, weight)) = pull {
                for (lobe, target) in lobes.iter().zip(target) {
                    for &i in free {
                        residuals.push(weight * (lobe.0[i] - target.0[i]));
                    }
                }
            }
            residuals
        };
        let params: Vec<f64> = start
            .iter()
            .flat_map(|lobe| free.iter().map(|&i| lobe.0[i]))
            .collect();
        let (params, cost) = least_squares(&params, &residuals_at);
        (place(&params), cost)
    }

    fn evaluate(
        &self,
        settings: &Settings,
        lobes: &[Coordinates],
        parts: &mut Parts,
        residuals: &mut Vec<f64>,
    ) {
        let ltcs = self.ltcs(settings, lobes);
        let parts = parts.of(self.residuals.as_ref(), &ltcs);
        self.residuals.evaluate(&ltcs, &parts, residuals);
    }

    /// A first fit, near the texel's before it where there is one.
    fn march(&self, settings: &Settings, previous: Option<&Lobes>) -> Lobes {
        match previous {
            Some(start) => {
                self.fit(settings, start, Some((start, settings.smoothing)))
                    .0
            }
            None => self.first(settings),
        }
    }

    /// Without a neighbour to start from: one lobe from the limit; two from that one, the best of
    /// many ways to split it.
    fn first(&self, settings: &Settings) -> Lobes {
        let limit = Coordinates::limit(&self.node.limit, self.node.albedo);
        let one = self.fit(settings, &[limit], None);
        if settings.lobes == 1 {
            return one.0;
        }
        let split = |narrower: f64, wider: f64, turned: f64, share: f64| {
            let (mut a, mut b) = (one.0[0], one.0[0]);
            for i in [0, 2] {
                a.0[i] -= narrower;
                b.0[i] += wider;
            }
            a.0[5] -= turned;
            b.0[5] += turned;
            a.0[7] += share.ln();
            b.0[7] += (1.0 - share).ln();
            self.fit(settings, &[a, b], None)
        };
        let mut best = (one.0.clone(), f64::INFINITY);
        for (narrower, wider) in [(0.3, 0.6), (0.2, 0.0)] {
            for turned in [-0.5, 0.0, 0.5] {
                for share in [0.3, 0.7] {
                    let found = split(narrower, wider, turned, share);
                    if found.1 < best.1 {
                        best = found;
                    }
                }
            }
        }
        best.0
    }

    /// One step of a sweep: starts at the texel's own coordinates and at its neighbours' line.
    fn improve(
        &self,
        settings: &Settings,
        grid: &Grid,
        all: &[Lobes],
        index: usize,
        smoothing: f64,
    ) -> Lobes {
        let own = &all[index];
        let pairs = grid.neighbours(index, all, &self.node.limit);
        // Along each axis with both neighbours, their mean makes the table straight.
        let straight: Vec<Lobes> = pairs
            .iter()
            .filter_map(|[low, high]| Some((low.as_ref()?, high.as_ref()?)))
            .map(|(low, high)| combined([0.5, 0.5], low, high))
            .chain(
                grid.beyond(index, all)
                    .map(|[near, far]| combined([2.0, -1.0], near, far)),
            )
            .collect();
        let pull = (!straight.is_empty() && smoothing > 0.0).then(|| {
            let mean = |lobe: usize, i: usize| {
                let sum: f64 = straight.iter().map(|lobes| lobes[lobe].0[i]).sum();
                sum / straight.len() as f64
            };
            (0..own.len())
                .map(|lobe| Coordinates(std::array::from_fn(|i| mean(lobe, i))))
                .collect::<Lobes>()
        });

        // From its own coordinates, and from the neighbours' line.
        let target = pull.as_deref().map(|target| (target, smoothing));
        let mut best = self.fit(settings, own, target);
        if let Some(start) = &pull {
            let (lobes, cost) = self.fit(settings, start, target);
            // Two basins of about the same cost, taken in turns by neighbouring texels, would be
            // far worse between the texels than either: the pull decides.
            if cost + NO_DIFFERENCE < best.1 {
                best = (lobes, cost);
            }
        }
        best.0
    }

    fn texel(&self, settings: &Settings, lobes: &[Coordinates]) -> Vec<f32> {
        let mut ltcs = self.ltcs(settings, lobes);
        let parts = Parts::default().of(self.residuals.as_ref(), &ltcs);
        self.residuals.complete(&mut ltcs, &parts);
        // At most 1 in all at every texel, so that no lookup makes energy: shares and amplitudes
        // both interpolate to at most 1. The second weight is at most 1 itself.
        let total: f64 = ltcs.iter().map(|ltc| ltc.amplitude).sum();
        let second: f64 = ltcs.iter().map(|ltc| ltc.secondary).sum();
        let bound = |sum: f64, most: f64| if sum > most { most / sum } else { 1.0 };
        for ltc in &mut ltcs {
            ltc.amplitude *= bound(total, 1.0);
            ltc.secondary *= bound(second, total.min(1.0));
        }
        Layout::new(settings).pack(&self.node.limit, &ltcs)
    }
}

/// Weighted sum of two texels' coordinates.
fn combined(weights: [f64; 2], a: &Lobes, b: &Lobes) -> Lobes {
    let sum = |(a, b): (&Coordinates, &Coordinates)| {
        Coordinates(std::array::from_fn(|i| {
            weights[0] * a.0[i] + weights[1] * b.0[i]
        }))
    };
    a.iter().zip(b).map(sum).collect()
}

/// A fit that can be watched, stopped, saved and resumed.
pub struct Fit {
    settings: Settings,
    grid: Grid,
    progress: Mutex<Checkpoint>,
}

impl Fit {
    /// A fit from the start.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: &Settings) -> Result<Self, FitError> {
        settings.validate().map_err(FitError::Settings)?;
        let grid = Grid::new(settings);
        Ok(Self {
            progress: Mutex::new(Checkpoint::new(settings, grid.count())),
            settings: settings.clone(),
            grid,
        })
    }

    /// Goes on where a checkpoint of the same settings left off, to the same result.
    ///
    /// # Errors
    /// Settings out of range; a checkpoint of other settings, or one that is damaged.
    pub fn resume(settings: &Settings, checkpoint: Checkpoint) -> Result<Self, FitError> {
        let fit = Self::new(settings)?;
        checkpoint
            .check(settings, fit.grid.count())
            .map_err(FitError::Settings)?;
        *fit.lock() = checkpoint;
        Ok(fit)
    }

    /// What is done so far; from any thread, while the fit runs.
    pub fn checkpoint(&self) -> Checkpoint {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Checkpoint> {
        // Every change under the lock is a single assignment: a panic elsewhere leaves it whole.
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs to the end. `progress(done, total)` is called from many threads as texels finish;
    /// setting `cancel` ends the fit soon. The result depends on the settings alone.
    ///
    /// # Errors
    /// Cancellation, a texel without a finite fit.
    pub fn run(
        &self,
        progress: &(dyn Fn(usize, usize) + Sync),
        cancel: &AtomicBool,
    ) -> Result<Table, FitError> {
        let (settings, grid) = (&self.settings, &self.grid);
        let objective = settings.objective();
        let count = grid.count();
        let problems: Vec<OnceLock<Problem>> = (0..count).map(|_| OnceLock::new()).collect();
        let problem = |index: usize| {
            problems[index]
                .get_or_init(|| Problem::new(settings, objective.as_ref(), &grid.place(index)))
        };
        let total = count * (1 + 2 * settings.sweeps as usize);
        let done = AtomicUsize::new(self.lock().done());
        let finish = |index: usize, lobes: &Lobes| {
            self.lock().set(index, lobes);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        };
        let go_on = || match cancel.load(Ordering::Relaxed) {
            true => Err(FitError::Cancelled),
            false => Ok(()),
        };

        // The march: every texel starts where the one before it ended.
        let step = |index: usize, previous: Option<&Lobes>| {
            if let Some(known) = self.lock().get(index) {
                return Ok(known);
            }
            go_on()?;
            let lobes = problem(index).march(settings, previous);
            finish(index, &lobes);
            Ok(lobes)
        };
        if self.lock().pass() == 0 {
            // All go out from one texel: lobes may share their work in several ways, and from
            // everywhere at once the ways would meet in seams. Along one axis after the other,
            // every line on its own, from where it crosses the line before.
            for lines in grid.lines_from_seed() {
                lines.into_par_iter().try_for_each(|[up, down]| {
                    for way in [up, down] {
                        let mut previous: Option<Lobes> = None;
                        for index in way {
                            previous = Some(step(index, previous.as_ref())?);
                        }
                    }
                    Ok::<_, FitError>(())
                })?;
            }
            self.lock().next_pass();
        }

        // Sweeps, each in two passes over the squares of a chess board: every texel reads the
        // previous pass only, so that their order doesn't matter, and no two neighbours move at
        // once, which would let them swing around each other.
        while self.lock().pass() <= 2 * settings.sweeps as usize {
            let before = self.lock().previous();
            let pass = self.lock().pass();
            let smoothing = settings.smoothing_in(pass.div_ceil(2));
            (0..count).into_par_iter().try_for_each(|index| {
                if self.lock().get(index).is_some() {
                    return Ok(());
                }
                go_on()?;
                if grid.position(index).iter().sum::<usize>() % 2 == pass % 2 {
                    finish(index, &before[index]);
                } else {
                    let lobes = problem(index).improve(settings, grid, &before, index, smoothing);
                    finish(index, &lobes);
                }
                Ok(())
            })?;
            self.lock().next_pass();
        }

        let all = self.lock().previous();
        let texels: Vec<f32> = (0..count)
            .into_par_iter()
            .flat_map_iter(|index| problem(index).texel(settings, &all[index]))
            .collect();
        if let Some(bad) = texels.iter().position(|x| !x.is_finite()) {
            return Err(FitError::NotFinite {
                texel: grid.position(bad / (texels.len() / count)),
            });
        }
        Ok(Table {
            settings: settings.clone(),
            texels,
        })
    }
}

/// Fits a table: [`Fit::run`] without a checkpoint.
///
/// # Errors
/// Settings out of range, cancellation, a texel without a finite fit.
pub fn fit(
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) + Sync),
    cancel: &AtomicBool,
) -> Result<Table, FitError> {
    Fit::new(settings)?.run(progress, cancel)
}

/// Fits single texels again, given by their position along each axis, from the table's own
/// neighbourhood: one more step of a sweep, which hardly moves a finished table. Returns texels in
/// the table's format.
///
/// # Errors
/// Settings out of range, a texel outside the table.
pub fn refit(table: &Table, texels: &[Vec<usize>]) -> Result<Vec<Vec<f32>>, FitError> {
    let settings = table.settings();
    settings.validate().map_err(FitError::Settings)?;
    let grid = Grid::new(settings);
    let objective = settings.objective();
    let layout = table.layout();
    let channels = table.channel_count();
    texels
        .par_iter()
        .map(|position| {
            let index = grid.index(position).ok_or_else(|| {
                FitError::Settings(format!("texel {position:?} is outside the table"))
            })?;
            let mut all = vec![Lobes::new(); grid.count()];
            for near in grid.around(index) {
                let (brdf, view) = settings.brdf.at(&grid.place(near));
                let limit = brdf.limit(view);
                let numbers: Vec<f64> = table.texels()[channels * near..][..channels]
                    .iter()
                    .map(|&x| f64::from(x))
                    .collect();
                all[near] = layout.unpack(&limit, &numbers)[..settings.lobes as usize]
                    .iter()
                    .map(|ltc| Coordinates::from_ltc(ltc, &limit))
                    .collect();
            }
            let problem = Problem::new(settings, objective.as_ref(), &grid.place(index));
            let smoothing = settings.smoothing_in(settings.sweeps as usize);
            let lobes = problem.improve(settings, &grid, &all, index, smoothing);
            Ok(problem.texel(settings, &lobes))
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
        let texel_fits = 9 * (1 + 2 * settings.sweeps as usize);
        assert_eq!(calls.load(Ordering::Relaxed), texel_fits);
        assert_eq!(last.load(Ordering::Relaxed), texel_fits);
        let cancelled = fit(&settings, &|_, _| (), &AtomicBool::new(true));
        assert!(matches!(cancelled, Err(FitError::Cancelled)));
    }

    /// Stopped anywhere, saved as text and resumed, a fit ends where it would have anyway.
    #[test]
    fn resumes_to_the_same_bits() {
        let settings = Settings {
            size: 4,
            lobes: 2,
            cosine: false,
            directions: 300,
            samples: 16,
            sweeps: 1,
            ..Settings::default()
        };
        let whole = on_threads(2, &settings);
        for stop_after in [1, 7, 16, 17, 40] {
            let first = Fit::new(&settings).unwrap();
            let cancel = AtomicBool::new(false);
            let stop = |done: usize, _| {
                if done >= stop_after {
                    cancel.store(true, Ordering::Relaxed);
                }
            };
            assert!(matches!(
                first.run(&stop, &cancel),
                Err(FitError::Cancelled)
            ));
            let text = serde_json::to_string(&first.checkpoint()).unwrap();
            let checkpoint: Checkpoint = serde_json::from_str(&text).unwrap();
            let other = Settings {
                seed: 9,
                ..settings.clone()
            };
            assert!(Fit::resume(&other, checkpoint.clone()).is_err());
            let resumed = Fit::resume(&settings, checkpoint).unwrap();
            let table = resumed.run(&|_, _| (), &AtomicBool::new(false)).unwrap();
            assert_eq!(table, whole);
        }
        let damaged = r#"{"settings":"","pass":0,"previous":[],"current":[]}"#;
        let damaged: Checkpoint = serde_json::from_str(damaged).unwrap();
        assert!(Fit::resume(&settings, damaged).is_err());
    }
}
