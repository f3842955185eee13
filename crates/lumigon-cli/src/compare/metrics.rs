//! How far one picture is from another, in numbers.

use serde::Serialize;

/// A picture's difference from a reference over all pixels and channels, in double precision.
///
/// Pixels with an infinity or NaN in either picture are left out and counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Difference {
    /// Root of the mean squared difference, in radiance.
    pub(super) rmse: f64,
    /// `rmse` over the reference's mean; none where that mean is 0.
    pub(super) relative_rmse: Option<f64>,
    /// What is left of `rmse` without the reference's own noise:
    /// sqrt(rmse² - mean squared standard error), or 0 where the noise explains all of it.
    pub(super) rmse_beyond_noise: f64,
    /// `rmse_beyond_noise` over the reference's mean.
    pub(super) relative_rmse_beyond_noise: Option<f64>,
    /// Mean difference: above 0 where the picture is too bright.
    pub(super) bias: f64,
    /// `bias` over the reference's mean.
    pub(super) relative_bias: Option<f64>,
    /// The factor on the picture that would bring it closest; none for a black picture.
    pub(super) best_scale: Option<f64>,
    /// `relative_rmse` after that factor: the error of the picture's shape alone.
    pub(super) relative_rmse_at_best_scale: Option<f64>,
    /// Pixels left out.
    pub(super) non_finite_pixels: u64,
}

/// The rms of standard errors, over all pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Noise {
    /// In radiance.
    pub(super) rms_standard_error: f64,
    /// Over the reference's mean; none where that mean is 0.
    pub(super) relative: Option<f64>,
}

/// (picture - reference) / standard error, where the standard error is above 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct ZScores {
    /// How many pixels and channels have one.
    pub(super) count: u64,
    /// Their rms: 1 where nothing but the reference's noise separates the pictures.
    pub(super) rms: Option<f64>,
    /// Their mean: 0 where there is no bias.
    pub(super) mean: Option<f64>,
    /// The fraction beyond ±3: 0.0027 for normally distributed noise.
    pub fraction_beyond_3: Option<f64>,
    /// Rms difference over rms standard error: 1 for noise alone.
    ///
    /// Errors estimated from few paths are too small wherever the estimate itself is too small,
    /// which widens and shifts the z-scores; this ratio and `pooled_mean` stay unbiased.
    pub(super) pooled_rms: Option<f64>,
    /// Mean difference over its own standard error, which is taken as large as it can be: within
    /// ±1 in two of three comparisons without bias.
    pub(super) pooled_mean: Option<f64>,
    /// Pixels and channels whose standard error is 0.
    pub(super) without_error: u64,
    /// The greatest difference among those.
    pub(super) greatest_difference_without_error: f64,
}

/// Means over the finite pixels.
#[derive(Default)]
struct Sums {
    count: f64,
    picture: f64,
    reference: f64,
    squared_difference: f64,
    squared_picture: f64,
    squared_reference: f64,
    product: f64,
    non_finite: u64,
}

impl Difference {
    /// Compares pictures of one size; `noise` is the reference's.
    pub(super) fn new(picture: &[[f32; 3]], reference: &[[f32; 3]], noise: Noise) -> Self {
        let mut sums = Sums::default();
        for (p, r) in picture.iter().zip(reference) {
            if !p.iter().chain(r).all(|value| value.is_finite()) {
                sums.non_finite += 1;
                continue;
            }
            for (&p, &r) in p.iter().zip(r) {
                let (p, r) = (f64::from(p), f64::from(r));
                sums.count += 1.0;
                sums.picture += p;
                sums.reference += r;
                sums.squared_difference += (p - r) * (p - r);
                sums.squared_picture += p * p;
                sums.squared_reference += r * r;
                sums.product += p * r;
            }
        }
        let count = sums.count.max(1.0);
        let mean = sums.reference / count;
        let relative = |value: f64| (mean > 0.0).then(|| value / mean);
        let mean_square = sums.squared_difference / count;
        let rmse = mean_square.sqrt();
        let rmse_beyond_noise = (mean_square - noise.rms_standard_error.powi(2))
            .max(0.0)
            .sqrt();
        let bias = (sums.picture - sums.reference) / count;
        let best_scale = (sums.squared_picture > 0.0).then(|| sums.product / sums.squared_picture);
        let at_best_scale = best_scale.and_then(|scale| {
            let residue = sums.squared_reference - scale * sums.product;
            relative((residue / count).max(0.0).sqrt())
        });
        Self {
            rmse,
            relative_rmse: relative(rmse),
            rmse_beyond_noise,
            relative_rmse_beyond_noise: relative(rmse_beyond_noise),
            bias,
            relative_bias: relative(bias),
            best_scale,
            relative_rmse_at_best_scale: at_best_scale,
            non_finite_pixels: sums.non_finite,
        }
    }
}

impl Noise {
    /// From the means and their standard errors.
    pub(super) fn new(mean: &[[f32; 3]], standard_error: &[[f32; 3]]) -> Self {
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for (m, e) in mean.iter().zip(standard_error) {
            if m.iter().chain(e).all(|value| value.is_finite()) {
                count += 3.0;
                sum += m.iter().copied().map(f64::from).sum::<f64>();
                squares += e.iter().map(|&e| f64::from(e).powi(2)).sum::<f64>();
            }
        }
        let count = f64::max(count, 1.0);
        let rms = f64::sqrt(squares / count);
        Self {
            rms_standard_error: rms,
            relative: (sum > 0.0).then(|| rms / (sum / count)),
        }
    }
}

impl ZScores {
    /// Compares pictures of one size.
    pub(super) fn new(
        picture: &[[f32; 3]],
        reference: &[[f32; 3]],
        standard_error: &[[f32; 3]],
    ) -> Self {
        let (mut count, mut sum, mut squares, mut beyond) = (0_u64, 0.0, 0.0, 0_u64);
        let (mut difference_sum, mut square_difference, mut variance) = (0.0, 0.0, 0.0);
        let mut variance_of_sum = 0.0;
        let (mut without_error, mut greatest) = (0, 0.0_f64);
        for ((p, r), e) in picture.iter().zip(reference).zip(standard_error) {
            let mut pixel_error = 0.0;
            for ((&p, &r), &e) in p.iter().zip(r).zip(e) {
                let difference = f64::from(p) - f64::from(r);
                let error = f64::from(e);
                if !difference.is_finite() || !error.is_finite() {
                    continue;
                }
                if error > 0.0 {
                    let z = difference / error;
                    count += 1;
                    sum += z;
                    squares += z * z;
                    beyond += u64::from(z.abs() > 3.0);
                    difference_sum += difference;
                    square_difference += difference * difference;
                    variance += error * error;
                    pixel_error += error;
                } else {
                    without_error += 1;
                    greatest = greatest.max(difference.abs());
                }
            }
            // A pixel's channels share their paths, so their errors add up; pixels share none.
            variance_of_sum += pixel_error * pixel_error;
        }
        let over_count = |value: f64| (count > 0).then(|| value / count as f64);
        Self {
            count,
            rms: over_count(squares).map(f64::sqrt),
            mean: over_count(sum),
            fraction_beyond_3: over_count(beyond as f64),
            pooled_rms: (variance > 0.0).then(|| f64::sqrt(square_difference / variance)),
            pooled_mean: (variance_of_sum > 0.0)
                .then(|| difference_sum / f64::sqrt(variance_of_sum)),
            without_error,
            greatest_difference_without_error: greatest,
        }
    }

    /// Whether the reference's noise explains the differences: a pooled rms of at most 1.15, a
    /// pooled mean within ±4, and no difference where the reference knows no error. None where no
    /// pixel has an error to judge by.
    pub(super) fn is_noise(&self) -> Option<bool> {
        let (rms, mean) = (self.pooled_rms?, self.pooled_mean?);
        Some(rms <= 1.15 && mean.abs() <= 4.0 && self.greatest_difference_without_error < 1e-4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: Noise = Noise {
        rms_standard_error: 0.0,
        relative: None,
    };

    #[test]
    fn twice_as_bright_is_wrong_by_its_scale_alone() {
        let reference = [[1.0, 2.0, 3.0], [4.0, 0.0, 2.0]];
        let picture = reference.map(|p| p.map(|v| 2.0 * v));
        let d = Difference::new(&picture, &reference, QUIET);
        assert!((d.rmse - (34.0_f64 / 6.0).sqrt()).abs() < 1e-12);
        assert!((d.bias - 2.0).abs() < 1e-12);
        assert!((d.relative_bias.unwrap() - 1.0).abs() < 1e-12);
        assert!((d.best_scale.unwrap() - 0.5).abs() < 1e-12);
        assert!(d.relative_rmse_at_best_scale.unwrap() < 1e-7);
    }

    #[test]
    fn noise_explains_its_own_share() {
        let noise = Noise {
            rms_standard_error: 3.0,
            relative: None,
        };
        let d = Difference::new(&[[5.0; 3]], &[[0.0; 3]], noise);
        assert_eq!((d.rmse, d.rmse_beyond_noise), (5.0, 4.0));
        let d = Difference::new(&[[2.0; 3]], &[[0.0; 3]], noise);
        assert_eq!(d.rmse_beyond_noise, 0.0);
    }

    #[test]
    fn black_and_broken_pictures_have_no_relative_numbers() {
        let d = Difference::new(&[[0.0; 3]], &[[0.0; 3]], QUIET);
        assert_eq!((d.rmse, d.relative_rmse, d.best_scale), (0.0, None, None));
        let picture = [[f32::NAN, 1.0, 1.0], [2.0; 3]];
        let d = Difference::new(&picture, &[[1.0; 3], [1.0; 3]], QUIET);
        assert_eq!((d.rmse, d.non_finite_pixels), (1.0, 1));
        let d = Difference::new(&[], &[], QUIET);
        assert_eq!((d.rmse, d.bias), (0.0, 0.0));
    }

    #[test]
    fn z_scores_leave_out_what_has_no_error() {
        let z = ZScores::new(&[[1.0, 5.0, 0.25]], &[[0.0, 1.0, 0.0]], &[[1.0, 1.0, 0.0]]);
        assert_eq!((z.count, z.without_error), (2, 1));
        assert!((z.rms.unwrap() - 8.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!((z.mean, z.fraction_beyond_3), (Some(2.5), Some(0.5)));
        assert_eq!(z.greatest_difference_without_error, 0.25);
        assert!((z.pooled_rms.unwrap() - 8.5_f64.sqrt()).abs() < 1e-12);
        assert!((z.pooled_mean.unwrap() - 2.5).abs() < 1e-12);
        assert_eq!(z.is_noise(), Some(false));
        let none = ZScores::new(&[], &[], &[]);
        assert_eq!((none.rms, none.is_noise()), (None, None));
    }

    #[test]
    fn noise_is_the_rms_of_standard_errors() {
        let n = Noise::new(&[[2.0; 3], [4.0; 3]], &[[0.3; 3], [0.4; 3]]);
        let rms = f64::sqrt((0.09 + 0.16) / 2.0);
        assert!((n.rms_standard_error - rms).abs() < 1e-8);
        assert!((n.relative.unwrap() - rms / 3.0).abs() < 1e-8);
    }
}
