//! A progress bar for long work, on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on standard error; invisible where that is no terminal. It goes away when dropped.
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    pub(crate) fn new(what: &'static str) -> Self {
        let bar = ProgressBar::no_length().with_message(what);
        let template = "{msg} {wide_bar} {percent}% {elapsed} elapsed, {eta} left";
        bar.set_style(ProgressStyle::with_template(template).expect("the template is valid"));
        Self { bar }
    }

    /// May be called from any thread.
    pub(crate) fn set(&self, done: u64, total: u64) {
        if self.bar.length().is_none() {
            // What was done before the first report took none of this run's time.
            self.bar.set_length(total);
            self.bar.set_position(done);
            self.bar.tick();
            self.bar.reset_eta();
        } else if self.bar.length() != Some(total) {
            self.bar.set_length(total);
        }
        // Work of several parts begins again with each.
        if done == 1 && self.bar.position() > total / 2 {
            self.bar.set_position(done);
        }
        // Reports of several threads may overtake each other.
        if done > self.bar.position() {
            self.bar.set_position(done);
        }
    }

    /// Says something on standard error without tearing the bar.
    pub(crate) fn warn(&self, message: &str) {
        self.bar.suspend(|| eprintln!("warning: {message}"));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn resumed_work_does_not_look_fast() {
        let progress = Progress::new("resumed");
        for done in 900..=910 {
            progress.set(done, 1000);
            std::thread::sleep(Duration::from_millis(20));
        }
        // 90 steps of 20 ms are left; from zero they would seem to be done at once.
        let left = progress.bar.eta();
        assert!(left > Duration::from_secs(1), "{left:?}");
        assert_eq!(progress.bar.position(), 910);
    }
}
