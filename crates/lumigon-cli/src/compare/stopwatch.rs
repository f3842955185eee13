//! How long a method takes.

use std::time::Instant;

/// Wall seconds of repeated calls.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    sorted: Vec<f64>,
}

/// At most this many calls,
const REPEATS: usize = 9;
/// and no more once they took this long together.
const ENOUGH_SECONDS: f64 = 1.5;

impl Timing {
    /// Calls until it has been called often or long enough, at least once; the last result.
    ///
    /// # Errors
    /// The first that a call returns.
    pub fn of<T, E>(mut call: impl FnMut() -> Result<T, E>) -> Result<(T, Self), E> {
        let mut sorted = Vec::new();
        loop {
            let start = Instant::now();
            let result = call()?;
            sorted.push(start.elapsed().as_secs_f64());
            if sorted.len() >= REPEATS || sorted.iter().sum::<f64>() >= ENOUGH_SECONDS {
                sorted.sort_by(f64::total_cmp);
                return Ok((result, Self { sorted }));
            }
        }
    }

    /// The median; the upper of two.
    pub fn seconds(&self) -> f64 {
        self.sorted[self.sorted.len() / 2]
    }

    /// The fastest and the slowest.
    pub fn range(&self) -> [f64; 2] {
        [self.sorted[0], self.sorted[self.sorted.len() - 1]]
    }

    /// How many calls.
    pub fn repeats(&self) -> usize {
        self.sorted.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_calls_repeat_and_errors_stop() {
        let mut calls = 0;
        let (last, timing) = Timing::of(|| {
            calls += 1;
            Ok::<_, ()>(calls)
        })
        .unwrap();
        assert_eq!((last, timing.repeats()), (REPEATS, REPEATS));
        let [fastest, slowest] = timing.range();
        assert!(fastest <= timing.seconds() && timing.seconds() <= slowest);
        assert_eq!(Timing::of(|| Err::<(), _>("no")), Err("no"));
    }
}
