//! Differences as colours.

use image::{Rgb, RgbImage};

/// A scale of signed differences of luminance: blue where too dark, white where right, red where
/// too bright. The square root of the difference chooses the colour, so that small differences
/// show beside large ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FalseColor {
    /// The difference at either end of the scale; above 0.
    pub(crate) limit: f64,
}

impl FalseColor {
    /// A scale fit for differences from `reference`: its end is half of the luminance that 95 % of
    /// the lit pixels stay below, rounded up to 1, 2 or 5 times a power of ten.
    pub(crate) fn for_reference(reference: &[[f32; 3]]) -> Self {
        let mut lit: Vec<f64> = reference
            .iter()
            .map(|&p| luminance(p))
            .filter(|y| y.is_finite() && *y > 0.0)
            .collect();
        if lit.is_empty() {
            return Self { limit: 1.0 };
        }
        let index = (lit.len() - 1) * 95 / 100;
        let (_, &mut bright, _) = lit.select_nth_unstable_by(index, f64::total_cmp);
        Self {
            limit: round_up(0.5 * bright),
        }
    }

    /// The colour of one difference of luminance.
    pub(crate) fn color(self, difference: f64) -> Rgb<u8> {
        if difference.is_nan() {
            return Rgb([255, 0, 255]);
        }
        let share = (difference.abs() / self.limit).min(1.0).sqrt();
        let place = 0.5 - 0.5 * share.copysign(difference);
        let color = colorous::RED_BLUE.eval_continuous(place);
        Rgb([color.r, color.g, color.b])
    }

    /// The picture of `picture - reference`; magenta where that is not a number.
    pub(crate) fn image(
        self,
        (width, height): (u32, u32),
        picture: &[[f32; 3]],
        reference: &[[f32; 3]],
    ) -> RgbImage {
        let mut image = RgbImage::new(width, height);
        let pairs = picture.iter().zip(reference);
        for (pixel, (&p, &r)) in image.pixels_mut().zip(pairs) {
            *pixel = self.color(luminance(p) - luminance(r));
        }
        image
    }

    /// The differences that a legend names, as (place from 0 to 1, difference).
    pub(crate) fn ticks(self) -> [(f64, f64); 5] {
        [-1.0, -0.25, 0.0, 0.25, 1.0].map(|share: f64| {
            let place = 0.5 + 0.5 * share.abs().sqrt().copysign(share);
            (place, share * self.limit)
        })
    }

    /// The difference at a place from 0 to 1 along the scale.
    pub(crate) fn difference_at(self, place: f64) -> f64 {
        let signed_root = 2.0 * place - 1.0;
        self.limit * signed_root * signed_root.abs()
    }
}

/// Relative luminance of linear sRGB (Rec. 709).
fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// The next of 1, 2, 5, 10... times a power of ten. `value` must be above 0.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|step| step * power >= value * (1.0 - 1e-9));
    let rounded = step.unwrap_or(10.0) * power;
    if rounded.is_normal() { rounded } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle_have_their_colors() {
        let scale = FalseColor { limit: 2.0 };
        let [red, _, blue] = scale.color(5.0).0;
        assert!(red > blue);
        let [red, _, blue] = scale.color(-5.0).0;
        assert!(blue > red);
        assert!(scale.color(0.0).0.iter().all(|&c| c > 230));
        assert_eq!(scale.color(0.0), scale.color(-0.0));
        assert_eq!(scale.color(2.0), scale.color(f64::INFINITY));
        assert_eq!(scale.color(f64::NAN), Rgb([255, 0, 255]));
    }

    #[test]
    fn ticks_lie_where_the_legend_draws_them() {
        let scale = FalseColor { limit: 0.5 };
        for (place, difference) in scale.ticks() {
            assert!((scale.difference_at(place) - difference).abs() < 1e-12);
        }
    }

    #[test]
    fn limit_is_a_round_number_above_half_of_the_bright() {
        let reference: Vec<[f32; 3]> = (0..100).map(|i| [i as f32 * 0.01; 3]).collect();
        assert_eq!(FalseColor::for_reference(&reference).limit, 0.5);
        assert_eq!(FalseColor::for_reference(&[]).limit, 1.0);
        assert_eq!(FalseColor::for_reference(&[[f32::NAN; 3]]).limit, 1.0);
        let tiny = FalseColor::for_reference(&[[1e-45; 3]]).limit;
        assert!(tiny > 0.0 && tiny.is_finite());
        for (value, rounded) in [(0.1, 0.1), (0.11, 0.2), (3.0, 5.0), (7.0, 10.0)] {
            assert!((round_up(value) / rounded - 1.0).abs() < 1e-12);
        }
    }
}
