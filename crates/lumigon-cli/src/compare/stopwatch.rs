//! How long a method takes.

use std::time::Instant;

/// Wall seconds of repeated calls; the first is a warm-up once there are three.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Stopwatch {
    seconds: Vec<f64>,
}

impl Stopwatch {
    /// At most this many calls,
    pub(super) const REPEATS: usize = 10;
    /// and no more once they took this long together.
    const ENOUGH_SECONDS: f64 = 2.0;

    /// Calls once.
    ///
    /// # Errors
    /// What the call returns.
    pub(super) fn measure<T, E>(&mut self, call: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let start = Instant::now();
        let result = call()?;
        self.seconds.push(start.elapsed().as_secs_f64());
        Ok(result)
    }

    /// Whether another call would make the median better at little cost.
    pub(super) fn wants_more(&self) -> bool {
        self.seconds.len() < Self::REPEATS
            && self.seconds.iter().sum::<f64>() < Self::ENOUGH_SECONDS
    }

    /// The median, or the mean of the middle two; 0 before the first call.
    pub(super) fn seconds(&self) -> f64 {
        let sorted = self.sorted();
        match sorted.len() {
            0 => 0.0,
            n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
        }
    }

    /// The fastest and the slowest; 0 before the first call.
    pub(super) fn range(&self) -> [f64; 2] {
        let sorted = self.sorted();
        [sorted.first(), sorted.last()].map(|end| end.copied().unwrap_or(0.0))
    }

    /// How many calls count.
    pub(super) fn repeats(&self) -> usize {
        self.counted().len()
    }

    fn counted(&self) -> &[f64] {
        match self.seconds.len() {
            0..3 => &self.seconds,
            _ => &self.seconds[1..],
        }
    }

    fn sorted(&self) -> Vec<f64> {
        let mut sorted = self.counted().to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warm_up_does_not_count() {
        let of = |seconds: &[f64]| Stopwatch {
            seconds: seconds.to_vec(),
        };
        assert_eq!(of(&[]).seconds(), 0.0);
        assert_eq!(of(&[0.5, 0.25]).seconds(), 0.375);
        let watch = of(&[9.0, 0.25, 0.75, 0.5]);
        assert_eq!((watch.seconds(), watch.repeats()), (0.5, 3));
        assert_eq!(watch.range(), [0.25, 0.75]);
        assert!(!watch.wants_more() && of(&[0.1; 9]).wants_more());
        assert!(!of(&[0.1; 10]).wants_more());
    }

    #[test]
    fn failed_calls_do_not_count() {
        let mut watch = Stopwatch::default();
        assert_eq!(watch.measure(|| Err::<(), _>("no")), Err("no"));
        assert_eq!(watch.measure(|| Ok::<_, ()>(5)), Ok(5));
        assert_eq!(watch.repeats(), 1);
    }
}
