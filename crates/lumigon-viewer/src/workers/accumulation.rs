//! Path-traced pictures of the same view, added up.

use lumigon_renderer::{Pixels, ReferenceRendering};

/// Sums over pictures, each with as much weight as it has paths.
#[derive(Default)]
pub(super) struct Accumulation {
    /// Paths a pixel.
    pub(super) paths: u64,
    pub(super) passes: u32,
    /// Per channel of each pixel the sum of paths times mean, and of squared paths times squared error.
    sums: Vec<[f64; 2]>,
}

/// The mean of all pictures so far.
pub(super) struct Mean {
    /// Radiance.
    pub(super) mean: Pixels,
    /// Its standard error.
    pub(super) error: Pixels,
    /// The mean error over the mean radiance; 0 where all is black.
    pub(super) relative_noise: f64,
}

impl Accumulation {
    /// Adds a picture of `paths` paths a pixel, of noise independent of that of the others. All have one
    /// size.
    pub(super) fn add(&mut self, picture: &ReferenceRendering, paths: u64) {
        let radiance = picture.mean.radiance();
        let means = radiance.as_flattened();
        let errors = picture.radiance_error.as_flattened();
        self.sums.resize(means.len(), [0.0; 2]);
        for ((sum, &mean), &error) in self.sums.iter_mut().zip(means).zip(errors) {
            let weight = paths as f64;
            let weighted = weight * f64::from(error);
            sum[0] += weight * f64::from(mean);
            sum[1] += weighted * weighted;
        }
        self.paths += paths;
        self.passes += 1;
    }

    pub(super) fn mean(&self) -> Mean {
        let inverse = 1.0 / self.paths.max(1) as f64;
        let part = |of: fn(&[f64; 2]) -> f64| -> Pixels {
            let pixels = self.sums.as_chunks::<3>().0.iter();
            pixels
                .map(|channels| channels.each_ref().map(|sum| (of(sum) * inverse) as f32))
                .collect()
        };
        let sum = |of: fn(&[f64; 2]) -> f64| self.sums.iter().map(of).sum::<f64>();
        let mean: fn(&[f64; 2]) -> f64 = |sum| sum[0];
        let error: fn(&[f64; 2]) -> f64 = |sum| sum[1].sqrt();
        let all = sum(mean);
        let relative_noise = match all > 0.0 {
            true => sum(error) / all,
            false => 0.0,
        };
        Mean {
            mean: part(mean),
            error: part(error),
            relative_noise,
        }
    }
}
