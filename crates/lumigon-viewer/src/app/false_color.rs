//! Numbers as colours, with their scales.

use egui::Color32;

/// What colours mean.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scale {
    /// What is shown.
    pub(crate) title: &'static str,
    /// Places from 0 to 1, and what stands there.
    pub(crate) ticks: Vec<(f32, String)>,
    gradient: Gradient,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Gradient {
    /// Blue, white, red.
    Signed,
    /// Dark to bright.
    Heat,
}

impl Scale {
    pub(crate) fn color(&self, place: f32) -> Color32 {
        let place = f64::from(place).clamp(0.0, 1.0);
        let color = match self.gradient {
            Gradient::Signed => colorous::RED_BLUE.eval_continuous(1.0 - place),
            Gradient::Heat => colorous::INFERNO.eval_continuous(place),
        };
        Color32::from_rgb(color.r, color.g, color.b)
    }
}

/// Luminance of linear Rec. 709.
fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The next of 1, 2, 5, 10, ... times a power of ten.
fn round_up(value: f32) -> f32 {
    let power = 10.0_f32.powf(value.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let found = steps.into_iter().map(|step| step * power);
    found
        .into_iter()
        .find(|&step| step >= value * 0.999_99)
        .unwrap_or(value)
}

/// A picture's luminance less the truth's. The scale ends at half of the luminance that 95 % of the
/// truth's lit pixels stay below; its square root chooses the colour, so that small errors show too.
pub(crate) fn error(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> (Vec<Color32>, Scale) {
    let lit = reference.iter().map(|&p| luminance(p));
    let mut lit: Vec<f32> = lit.filter(|y| y.is_finite() && *y > 0.0).collect();
    let limit = if lit.is_empty() {
        1.0
    } else {
        let index = (lit.len() - 1) * 95 / 100;
        let (_, &mut bright, _) = lit.select_nth_unstable_by(index, f32::total_cmp);
        round_up(0.5 * bright)
    };
    let ticks = [-1.0, -0.25, 0.0, 0.25, 1.0_f32].map(|share| {
        let place = 0.5 + 0.5 * share.abs().sqrt().copysign(share);
        (place, format!("{:+}", share * limit))
    });
    let scale = Scale {
        title: "luminance less the reference's",
        ticks: ticks.to_vec(),
        gradient: Gradient::Signed,
    };
    let color = |(&p, &r): (&[f32; 3], &[f32; 3])| {
        let difference = luminance(p) - luminance(r);
        if difference.is_nan() {
            return Color32::from_rgb(255, 0, 255);
        }
        let share = (difference.abs() / limit).min(1.0).sqrt();
        scale.color(0.5 + 0.5 * share.copysign(difference))
    };
    let colors = picture.iter().zip(reference).map(color).collect();
    (colors, scale)
}

/// Standard errors relative to the truth, from 0.1 % to 100 %.
pub(crate) fn noise(errors: &[[f32; 3]], reference: &[[f32; 3]]) -> (Vec<Color32>, Scale) {
    let scale = Scale {
        title: "standard error over luminance",
        ticks: [
            (0.0, "0.1 %"),
            (1.0 / 3.0, "1 %"),
            (2.0 / 3.0, "10 %"),
            (1.0, "100 %"),
        ]
        .map(|(place, text)| (place, text.to_owned()))
        .to_vec(),
        gradient: Gradient::Heat,
    };
    let color = |(&e, &r): (&[f32; 3], &[f32; 3])| {
        let relative = luminance(e) / luminance(r);
        // Black stays black: there is nothing to be off.
        let place = if relative > 0.0 {
            (relative.log10() + 3.0) / 3.0
        } else {
            0.0
        };
        scale.color(place)
    };
    let colors = errors.iter().zip(reference).map(color).collect();
    (colors, scale)
}

/// How many lights a pixel computes.
pub(crate) fn light_counts(counts: &[u32]) -> (Vec<Color32>, Scale) {
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let tick = |share: f32| (share, format!("{:.0}", share * most as f32));
    let shares: &[f32] = if most < 4 {
        &[0.0, 1.0]
    } else {
        &[0.0, 0.5, 1.0]
    };
    let scale = Scale {
        title: "lights per pixel",
        ticks: shares.iter().copied().map(tick).collect(),
        gradient: Gradient::Heat,
    };
    let color = |&count: &u32| scale.color(count as f32 / most as f32);
    (counts.iter().map(color).collect(), scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_their_sides() {
        let reference = vec![[1.0; 3]; 100];
        let mut picture = reference.clone();
        picture[0] = [2.0; 3];
        picture[1] = [0.5; 3];
        picture[2] = [f32::NAN; 3];
        let (colors, scale) = error(&picture, &reference);
        assert!(colors[0].r() > colors[0].b() + 50);
        assert!(colors[1].b() > colors[1].r() + 20);
        assert_eq!(colors[2], Color32::from_rgb(255, 0, 255));
        assert_eq!(colors[3], scale.color(0.5));
        assert_eq!(scale.ticks[4].1, "+0.5");
        // Nothing lit, nothing there.
        assert_eq!(error(&[], &[]).0, []);
        assert_eq!(error(&[[0.0; 3]], &[[0.0; 3]]).0.len(), 1);
    }

    #[test]
    fn counts_reach_from_end_to_end() {
        let (colors, scale) = light_counts(&[0, 2, 4]);
        assert_eq!(
            colors,
            [scale.color(0.0), scale.color(0.5), scale.color(1.0)]
        );
        assert_eq!(scale.ticks[2].1, "4");
    }
}
