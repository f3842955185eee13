//! Images with error bars.

use glam::DVec3;

/// An RGB image with the standard error of each value; rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Estimated radiance.
    pub mean: Vec<[f64; 3]>,
    /// Standard error of `mean`, itself estimated from the samples.
    pub standard_error: Vec<[f64; 3]>,
}

/// A rendered image, apart and together.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Radiance of lights and glowing surfaces seen directly; free of noise.
    pub emitted: Vec<[f64; 3]>,
    /// Radiance by way of the first surface's diffuse lobe.
    pub diffuse: Channel,
    /// Radiance by way of the first surface's GGX lobe, sheen and clearcoat.
    pub specular: Channel,
    /// The sum of all three.
    pub total: Channel,
    /// Samples that were NaN or infinite and counted as black: zero unless the scene hands out such numbers.
    pub invalid_samples: usize,
}

/// Mean and variance: of samples while they come in, of a mean afterwards.
#[derive(Clone, Copy, Default)]
pub(crate) struct Moments {
    pub(crate) mean: DVec3,
    pub(crate) variance: DVec3,
}

/// Running sums after Welford 1962, which don't cancel.
#[derive(Clone, Copy, Default)]
pub(crate) struct Welford {
    pub(crate) count: f64,
    pub(crate) mean: DVec3,
    pub(crate) squares: DVec3,
}

impl Welford {
    pub(crate) fn add(&mut self, sample: DVec3) {
        self.count += 1.0;
        let before = sample - self.mean;
        self.mean += before / self.count;
        self.squares += before * (sample - self.mean);
    }

    /// Mean of the samples and the variance of that mean.
    pub(crate) fn moments(&self) -> Moments {
        Moments {
            mean: self.mean,
            variance: self.squares / (self.count * (self.count - 1.0)),
        }
    }
}
