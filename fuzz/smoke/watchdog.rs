//! Ends the test when an input takes too long: a hang would say nothing.

use std::process;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Inputs take milliseconds; this leaves room for a busy machine.
const LONGEST: Duration = Duration::from_secs(20);

struct Attempt {
    label: String,
    input: Vec<u8>,
    started: Instant,
}

/// Watches one attempt at a time from its own thread.
pub(super) struct Watchdog {
    current: Arc<Mutex<Option<Attempt>>>,
}

impl Watchdog {
    pub(super) fn start(name: &str) -> Self {
        let current = Arc::new(Mutex::new(None::<Attempt>));
        let (watched, name) = (Arc::clone(&current), name.to_owned());
        thread::spawn(move || {
            loop {
                thread::sleep(Duration::from_secs(1));
                let attempt = watched.lock().expect("nothing panics while it holds this");
                if let Some(attempt) = attempt.as_ref()
                    && attempt.started.elapsed() > LONGEST
                {
                    let path = super::save(&name, &attempt.input);
                    let label = &attempt.label;
                    eprintln!(
                        "{name}, {label}: no end after {LONGEST:?}; saved as {}",
                        path.display()
                    );
                    process::exit(1);
                }
            }
        });
        Self { current }
    }

    pub(super) fn enter(&self, label: &str, input: &[u8]) {
        self.set(Some(Attempt {
            label: label.to_owned(),
            input: input.to_owned(),
            started: Instant::now(),
        }));
    }

    pub(super) fn leave(&self) {
        self.set(None);
    }

    fn set(&self, attempt: Option<Attempt>) {
        *self
            .current
            .lock()
            .expect("nothing panics while it holds this") = attempt;
    }
}
