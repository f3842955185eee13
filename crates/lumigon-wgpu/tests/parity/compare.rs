//! What differs, how much of it is allowed, and where it is worst.

/// The worst of a function's errors.
pub(crate) struct Worst {
    name: &'static str,
    compared: usize,
    /// Error over what is allowed.
    ratio: f64,
    error: f64,
    at: String,
    /// Values out of their range, whatever the place.
    faults: usize,
    fault: String,
}

impl Worst {
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            name,
            compared: 0,
            ratio: 0.0,
            error: 0.0,
            at: String::new(),
            faults: 0,
            fault: String::new(),
        }
    }

    /// Every value is finite and in its range.
    pub(crate) fn within(
        &mut self,
        values: &[f32],
        least: f32,
        greatest: f32,
        at: impl FnOnce() -> String,
    ) {
        // Also a NaN is not in a range.
        let good = |x: &f32| x.is_finite() && (least..=greatest).contains(x);
        if !values.iter().all(good) {
            self.faults += 1;
            if self.faults == 1 {
                self.fault = format!("{values:?} not in {least} to {greatest} at {}", at());
            }
        }
    }

    /// A value against the true one: as vectors, by the length of what differs.
    pub(crate) fn see(
        &mut self,
        got: &[f32],
        want: &[f64],
        allowed: f64,
        at: impl FnOnce() -> String,
    ) {
        self.compared += 1;
        let squared: f64 = got
            .iter()
            .zip(want)
            .map(|(got, want)| (f64::from(*got) - want).powi(2))
            .sum();
        let error = squared.sqrt();
        let ratio = if error == 0.0 { 0.0 } else { error / allowed };
        // A NaN is worse than anything.
        if (ratio.is_nan() || ratio > self.ratio) && !self.ratio.is_nan() {
            self.ratio = ratio;
            self.error = error;
            self.at = format!("{got:?}, not {want:?}, at {}", at());
        }
    }

    /// Prints the worst, and fails where it is too much or where too few were compared.
    pub(crate) fn finish(self, least_compared: usize) {
        let Self {
            name,
            compared,
            ratio,
            error,
            at,
            ..
        } = self;
        println!("{name}: {compared} compared, worst {ratio:.3} of what is allowed: {error:.2e}");
        assert!(
            self.faults == 0,
            "{name}: {} faults, the first: {}",
            self.faults,
            self.fault
        );
        assert!(ratio <= 1.0, "{name}: {ratio} of what is allowed: {at}");
        assert!(
            compared >= least_compared,
            "{name}: only {compared} compared"
        );
    }
}
