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
        if self.bar.length() != Some(total) {
            self.bar.set_length(total);
        }
        // Reports of several threads may overtake each other.
        if done > self.bar.position() {
            self.bar.set_position(done);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
