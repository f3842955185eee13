//! Where the time of a picture went.

use std::sync::PoisonError;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use super::CpuRenderer;

/// How long the processors worked on a picture: time of all threads together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuTimings {
    /// Milliseconds of finding what each pixel sees, and what that is made of.
    pub rays: f64,
    /// Milliseconds of the light of the scene's own lights.
    pub lights: f64,
    /// Milliseconds of the light of virtual lights.
    pub virtual_lights: f64,
}

/// Nanoseconds of all threads, while they work.
#[derive(Default)]
pub(super) struct Spent {
    rays: AtomicU64,
    lights: AtomicU64,
    virtual_lights: AtomicU64,
}

impl Spent {
    pub(super) fn on_rays(&self, start: Instant) {
        add(&self.rays, start);
    }

    /// The time now.
    pub(super) fn on_lights(&self, start: Instant) -> Instant {
        add(&self.lights, start)
    }

    pub(super) fn on_virtual_lights(&self, start: Instant) {
        add(&self.virtual_lights, start);
    }
}

fn add(to: &AtomicU64, start: Instant) -> Instant {
    let now = Instant::now();
    to.fetch_add((now - start).as_nanos() as u64, Ordering::Relaxed);
    now
}

impl CpuRenderer<'_> {
    /// How long the last picture took that [`CpuRenderer::render`] or
    /// [`CpuRenderer::render_with_bounce`] has finished; none before the first.
    #[must_use]
    pub fn timings(&self) -> Option<CpuTimings> {
        *self.timings.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn keep_timings(&self, spent: &Spent) {
        let milliseconds = |time: &AtomicU64| time.load(Ordering::Relaxed) as f64 * 1e-6;
        let timings = CpuTimings {
            rays: milliseconds(&spent.rays),
            lights: milliseconds(&spent.lights),
            virtual_lights: milliseconds(&spent.virtual_lights),
        };
        *self.timings.lock().unwrap_or_else(PoisonError::into_inner) = Some(timings);
    }
}
