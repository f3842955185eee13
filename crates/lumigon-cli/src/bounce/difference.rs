//! How far bounce light is from a path-traced one.

use lumigon_renderer::{Pixels, ReferenceRendering};

/// Diffuse light of a path-traced picture.
pub(super) struct Truth {
    pub(super) pixels: Pixels,
    /// Sum of the squared standard errors of all pixels and channels.
    variance: f64,
}

/// Relative to the truth; none where that is black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference {
    /// Root mean square difference over the root mean square of the truth, the truth's own noise taken
    /// out of both.
    pub(super) rmse: Option<f64>,
    /// Difference of the means over the truth's mean.
    pub(super) bias: Option<f64>,
}

impl Truth {
    pub(super) fn new(traced: ReferenceRendering) -> Self {
        let errors = traced.diffuse_error.iter().flatten();
        Self {
            variance: errors.map(|&e| f64::from(e).powi(2)).sum(),
            pixels: traced.mean.diffuse,
        }
    }

    /// Root mean square of the standard errors, over that of the light.
    pub(super) fn noise(&self) -> Option<f64> {
        let squared = self.squared();
        (squared > 0.0).then(|| (self.variance / squared).sqrt())
    }

    /// How far the picture is from this.
    pub(super) fn difference(&self, picture: &[[f32; 3]]) -> Difference {
        let pairs = picture.iter().flatten().zip(self.pixels.iter().flatten());
        let (mut squared, mut sum, mut true_sum) = (0.0, 0.0, 0.0);
        for (&p, &r) in pairs {
            let (p, r) = (f64::from(p), f64::from(r));
            squared += (p - r) * (p - r);
            sum += p;
            true_sum += r;
        }
        let all = self.squared();
        Difference {
            rmse: (all > 0.0).then(|| ((squared - self.variance).max(0.0) / all).sqrt()),
            bias: (true_sum > 0.0).then(|| sum / true_sum - 1.0),
        }
    }

    /// Sum of the squares, without what noise adds to it.
    fn squared(&self) -> f64 {
        let values = self.pixels.iter().flatten();
        values.map(|&r| f64::from(r).powi(2)).sum::<f64>() - self.variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(pixels: &[[f32; 3]], variance: f64) -> Truth {
        Truth {
            pixels: pixels.to_vec(),
            variance,
        }
    }

    #[test]
    fn half_as_bright_is_half_wrong() {
        let truth = truth(&[[2.0, 4.0, 6.0]], 0.0);
        let difference = truth.difference(&[[1.0, 2.0, 3.0]]);
        assert_eq!((difference.rmse, difference.bias), (Some(0.5), Some(-0.5)));
    }

    #[test]
    fn noise_does_not_count() {
        // 1 + noise of ±1: the picture of ones is exactly right.
        let noisy = truth(&[[2.0, 0.0, 2.0], [0.0, 2.0, 0.0]], 6.0);
        assert_eq!(noisy.difference(&[[1.0; 3]; 2]).rmse, Some(0.0));
        assert_eq!(noisy.noise(), Some(1.0));
        assert_eq!(noisy.difference(&[[2.0; 3]; 2]).rmse, Some(1.0));
    }

    #[test]
    fn black_has_no_relative_difference() {
        let black = truth(&[[0.0; 3]], 0.0);
        let difference = black.difference(&[[1.0; 3]]);
        assert_eq!(
            (difference.rmse, difference.bias, black.noise()),
            (None, None, None)
        );
    }
}
