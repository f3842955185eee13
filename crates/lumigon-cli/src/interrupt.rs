//! Ctrl-C, as a flag that long work watches.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::Failure;

/// Ctrl-C and requests to terminate: they end the process with exit code 130 until somebody
/// [watches](Self::watch), and set a flag from then on.
pub(crate) struct Interrupt {
    state: Arc<State>,
}

#[derive(Default)]
struct State {
    watched: AtomicBool,
    interrupted: AtomicBool,
}

impl Interrupt {
    /// To be called once, before anything is written.
    pub(crate) fn catch() -> Result<Self, Failure> {
        let state = Arc::new(State::default());
        let handler = Arc::clone(&state);
        ctrlc::set_handler(move || {
            handler.interrupted.store(true, Ordering::SeqCst);
            if !handler.watched.load(Ordering::SeqCst) {
                std::process::exit(i32::from(Failure::Interrupted.report_code()));
            }
        })?;
        Ok(Self { state })
    }

    /// One that no Ctrl-C reaches, for tests: the process has but one that it does.
    #[cfg(test)]
    pub(crate) fn never() -> Self {
        Self {
            state: Arc::default(),
        }
    }

    /// Whoever calls this promises to look at the flag often.
    pub(crate) fn watch(&self) {
        self.state.watched.store(true, Ordering::SeqCst);
    }

    /// Nobody looks any more: Ctrl-C ends the process again.
    pub(crate) fn unwatch(&self) {
        self.state.watched.store(false, Ordering::SeqCst);
    }

    /// Set once Ctrl-C was pressed.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.state.interrupted
    }

    /// An error once Ctrl-C was pressed.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        match self.flag().load(Ordering::SeqCst) {
            true => Err(Failure::Interrupted),
            false => Ok(()),
        }
    }
}
