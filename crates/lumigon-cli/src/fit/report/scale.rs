//! From numbers to colours.

use colorous::Gradient;
use plotters::style::RGBColor;

/// A colour scale with a name and ticks, shared by pictures that stand side by side.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    /// What the numbers are.
    pub(super) label: &'static str,
    kind: Kind,
    gradient: Gradient,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Powers of ten, inclusive.
    Logarithmic {
        low: i32,
        high: i32,
    },
    Linear {
        low: f64,
        high: f64,
    },
}

impl Scale {
    /// Decades that hold the numbers, at most `decades` of them below the greatest.
    pub(super) fn logarithmic<'a>(
        label: &'static str,
        numbers: impl Iterator<Item = &'a f64>,
        decades: i32,
    ) -> Self {
        let positive = numbers.copied().filter(|x| *x > 0.0 && x.is_finite());
        let [least, greatest] = positive.fold([f64::INFINITY, 0.0], |[low, high], x| {
            [low.min(x), high.max(x)]
        });
        let (low, high) = if greatest > 0.0 {
            let high = greatest.log10().ceil() as i32;
            let low = least.log10().floor() as i32;
            (low.max(high - decades).min(high - 1), high)
        } else {
            (-1, 0)
        };
        Self {
            label,
            kind: Kind::Logarithmic { low, high },
            gradient: colorous::INFERNO,
        }
    }

    /// From `low` to `high`.
    pub(super) fn linear(label: &'static str, low: f64, high: f64) -> Self {
        Self {
            label,
            kind: Kind::Linear { low, high },
            gradient: colorous::INFERNO,
        }
    }

    /// From 0 to the next of 1, 2 and 5 times a power of ten that holds the numbers.
    pub(super) fn from_zero<'a>(
        label: &'static str,
        numbers: impl Iterator<Item = &'a f64>,
    ) -> Self {
        let numbers = numbers.copied().filter(|x| x.is_finite());
        let greatest = numbers.fold(0.0, f64::max);
        let high = if greatest > 0.0 {
            let power = 10.0_f64.powf(greatest.log10().floor());
            let steps = [1.0, 2.0, 5.0].map(|step| step * power);
            let step = steps.into_iter().find(|step| *step >= greatest);
            step.unwrap_or(10.0 * power)
        } else {
            1.0
        };
        Self::linear(label, 0.0, high)
    }

    /// About 1, as far to both sides as the numbers go or 0.2.
    pub(super) fn about_one<'a>(
        label: &'static str,
        numbers: impl Iterator<Item = &'a f64>,
    ) -> Self {
        let deviation = numbers.fold(0.0, |most: f64, x| most.max((x - 1.0).abs()));
        let steps = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2];
        let limit = steps.into_iter().find(|step| *step >= deviation);
        let limit = limit.unwrap_or(0.2);
        Self {
            label,
            kind: Kind::Linear {
                low: 1.0 - limit,
                high: 1.0 + limit,
            },
            gradient: colorous::RED_BLUE,
        }
    }

    /// Where on the scale a number is, 0 to 1.
    fn place(&self, number: f64) -> f64 {
        let place = match self.kind {
            Kind::Logarithmic { low, high } => {
                (number.max(0.0).log10() - f64::from(low)) / f64::from(high - low)
            }
            Kind::Linear { low, high } => (number - low) / (high - low),
        };
        place.clamp(0.0, 1.0)
    }

    /// Magenta where it isn't a number.
    pub(super) fn color(&self, number: f64) -> RGBColor {
        if number.is_nan() {
            return RGBColor(255, 0, 255);
        }
        self.color_at(self.place(number))
    }

    /// The colour at a place from 0 to 1.
    pub(super) fn color_at(&self, place: f64) -> RGBColor {
        let color = self.gradient.eval_continuous(place);
        RGBColor(color.r, color.g, color.b)
    }

    /// Places and texts of the numbers that a colour bar names.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        match self.kind {
            Kind::Logarithmic { low, high } => (low..=high)
                .map(|power| {
                    let text = match power {
                        -3..=3 => format!("{}", 10.0_f64.powi(power)),
                        _ => format!("1e{power}"),
                    };
                    (f64::from(power - low) / f64::from(high - low), text)
                })
                .collect(),
            Kind::Linear { low, high } => (0..=4)
                .map(|i| {
                    let place = f64::from(i) / 4.0;
                    let number = low + place * (high - low);
                    // As many digits as tell the ticks apart.
                    let digits = (1.0 - ((high - low) / 4.0).log10().floor()).clamp(0.0, 9.0);
                    (place, format!("{number:.*}", digits as usize))
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_places() {
        let scale = Scale::logarithmic("", [0.0, 0.002, 0.03, f64::NAN].iter(), 4);
        assert_eq!(scale.place(0.001), 0.0);
        assert!((scale.place(0.01) - 0.5).abs() < 1e-12);
        assert_eq!(scale.place(7.0), 1.0);
        assert_eq!(scale.place(0.0), 0.0);
        let texts: Vec<String> = scale.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(texts, ["0.001", "0.01", "0.1"]);
        assert_eq!(scale.color(f64::NAN), RGBColor(255, 0, 255));
        let nothing = Scale::logarithmic("", [0.0].iter(), 4);
        assert_eq!(nothing.ticks().len(), 2);

        for (greatest, high) in [
            (0.023, 0.05),
            (0.1, 0.1),
            (0.7, 1.0),
            (3.0, 5.0),
            (0.0, 1.0),
        ] {
            let scale = Scale::from_zero("", [0.0, greatest, f64::NAN].iter());
            assert!((scale.place(high / 2.0) - 0.5).abs() < 1e-9, "{greatest}");
        }

        let scale = Scale::about_one("", [0.97, 1.01].iter());
        let texts: Vec<String> = scale.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(texts, ["0.950", "0.975", "1.000", "1.025", "1.050"]);
        let grey = scale.color(1.0);
        assert!(grey.0 > 230 && grey.1 > 230 && grey.2 > 230, "{grey:?}");
    }
}
