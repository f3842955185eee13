//! A thread that works until it is done, or no longer wanted.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lumigon_renderer::{RenderError, Watch};
use rayon::ThreadPoolBuilder;

use super::job::{Job, Update};

/// Work in the background, on all processors but one.
///
/// Dropped, it stops. Neither that nor anything else here waits for the work: its thread has shares of all
/// that it needs, and ends by itself some milliseconds later.
pub(crate) struct Background {
    reporter: Arc<Reporter>,
}

/// What has become of the work.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum BackgroundState {
    /// It goes on.
    #[default]
    Running,
    /// It is done: there will be no further results.
    Finished,
    /// It was told to stop, and has.
    Stopped,
    /// It cannot be done; why, for the user to read.
    Failed(String),
}

impl Background {
    /// Starts. `wake` is called from another thread whenever there is a new result, and when the work ends
    /// without having been stopped.
    #[must_use]
    pub(crate) fn start(job: Job, wake: Box<dyn Fn() + Send + Sync>) -> Self {
        Self::run(move |reporter| job.run(reporter), wake)
    }

    fn run(
        work: impl FnOnce(&Reporter) -> Result<(), RenderError> + Send + 'static,
        wake: Box<dyn Fn() + Send + Sync>,
    ) -> Self {
        let reporter = Arc::new(Reporter {
            wake,
            cancelled: AtomicBool::new(false),
            latest: Mutex::new(None),
            state: Mutex::default(),
            fraction: AtomicU32::new(0),
        });
        let own = Arc::clone(&reporter);
        let thread = std::thread::Builder::new().name("background".to_owned());
        let started = thread.spawn(move || {
            let worked = catch_unwind(AssertUnwindSafe(|| in_pool(work, &own)));
            own.end(match worked {
                Ok(state) => state,
                Err(panic) => BackgroundState::Failed(said(&*panic)),
            });
        });
        if let Err(fault) = started {
            let why = format!("no thread for work in the background: {fault}");
            reporter.end(BackgroundState::Failed(why));
        }
        Self { reporter }
    }

    /// Stops the work; what it has found stays.
    pub(crate) fn stop(&self) {
        self.reporter.cancelled.store(true, Ordering::Relaxed);
    }

    /// The newest result, which may be the one of the last call.
    #[must_use]
    pub(crate) fn latest(&self) -> Option<Arc<Update>> {
        locked(&self.reporter.latest).clone()
    }

    /// How much is done of the pass that goes on, 0 to 1.
    #[must_use]
    pub(crate) fn progress(&self) -> f32 {
        f32::from_bits(self.reporter.fraction.load(Ordering::Relaxed))
    }

    /// What has become of it.
    #[must_use]
    pub(crate) fn state(&self) -> BackgroundState {
        locked(&self.reporter.state).clone()
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        self.stop();
    }
}

/// What the work tells, and is told.
pub(super) struct Reporter {
    wake: Box<dyn Fn() + Send + Sync>,
    cancelled: AtomicBool,
    latest: Mutex<Option<Arc<Update>>>,
    state: Mutex<BackgroundState>,
    /// Bits of a float.
    fraction: AtomicU32,
}

impl Reporter {
    /// Calls `work` with what follows and stops it; `[done, all]` of its parts make up the pass.
    pub(super) fn watched<T>(
        &self,
        [part, parts]: [usize; 2],
        work: impl FnOnce(Watch<'_>) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let progress = |done: u64, total: u64| {
            let within = done as f64 / total.max(1) as f64;
            let fraction = ((part as f64 + within) / parts.max(1) as f64) as f32;
            self.fraction.store(fraction.to_bits(), Ordering::Relaxed);
        };
        work(Watch {
            progress: &progress,
            cancelled: &self.cancelled,
        })
    }

    /// Shows a result of a pass of so many samples or paths.
    pub(super) fn show(&self, update: Update) {
        *locked(&self.latest) = Some(Arc::new(update));
        self.fraction.store(0.0_f32.to_bits(), Ordering::Relaxed);
        self.wake();
    }

    fn end(&self, state: BackgroundState) {
        *locked(&self.state) = state;
        self.wake();
    }

    fn wake(&self) {
        if !self.cancelled.load(Ordering::Relaxed) {
            (self.wake)();
        }
    }
}

/// One processor is left for the window.
fn in_pool(
    work: impl FnOnce(&Reporter) -> Result<(), RenderError> + Send,
    reporter: &Reporter,
) -> BackgroundState {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = ThreadPoolBuilder::new()
        .num_threads(processors.saturating_sub(1).max(1))
        .thread_name(|i| format!("background {i}"))
        .build();
    let worked = match pool {
        Ok(pool) => pool.install(|| work(reporter)),
        Err(fault) => {
            let why = format!("no threads for work in the background: {fault}");
            return BackgroundState::Failed(why);
        }
    };
    match worked {
        Ok(()) => BackgroundState::Finished,
        Err(RenderError::Cancelled) => BackgroundState::Stopped,
        Err(fault) => BackgroundState::Failed(fault.to_string()),
    }
}

/// What a panic has to say.
fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or(panic.downcast_ref::<&str>().copied());
    format!(
        "work in the background has failed, which is a fault of this program: {}",
        text.unwrap_or("it does not say why")
    )
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    /// The state after the work has woken its owner.
    fn ended(
        work: impl FnOnce(&Reporter) -> Result<(), RenderError> + Send + 'static,
    ) -> BackgroundState {
        let (sender, receiver) = channel();
        let wake = move || sender.send(()).unwrap_or_default();
        let background = Background::run(work, Box::new(wake));
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        background.state()
    }

    #[test]
    fn errors_and_panics_are_messages() {
        assert_eq!(ended(|_| Ok(())), BackgroundState::Finished);
        let failed = ended(|_| Err(RenderError::NoPicture { light: 7 }));
        assert!(matches!(failed, BackgroundState::Failed(why) if why.contains("light 7")));
        for parallel in [false, true] {
            let failed = ended(move |_| {
                assert!(parallel, "in the middle");
                rayon::join(|| panic!("in the middle"), || ()).0
            });
            assert!(
                matches!(failed, BackgroundState::Failed(why) if why.contains("in the middle"))
            );
        }
    }

    #[test]
    fn whoever_wants_no_more_is_not_woken() {
        let background = Background::run(
            |reporter| {
                while !reporter.cancelled.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
                Err(RenderError::Cancelled)
            },
            Box::new(|| panic!("it was stopped")),
        );
        assert_eq!(background.state(), BackgroundState::Running);
        background.stop();
        while background.state() == BackgroundState::Running {
            std::thread::yield_now();
        }
        assert_eq!(background.state(), BackgroundState::Stopped);
    }
}
