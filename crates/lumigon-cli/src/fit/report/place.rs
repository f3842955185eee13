//! Where in a table something is measured.

use lumigon_fit::BrdfKind;

/// A place by its coordinate along the first axis and the view's angle in radians; `other` gives
/// those along further axes.
pub(super) fn place(
    brdf: BrdfKind,
    first: f64,
    theta: f64,
    mut other: impl FnMut() -> f64,
) -> Vec<f64> {
    let axes = 0..brdf.axes().len();
    axes.map(|axis| match axis {
        0 => first,
        // sqrt(1 - cos), without cancellation.
        _ if axis == brdf.view_axis() => std::f64::consts::SQRT_2 * (0.5 * theta).sin(),
        _ => other(),
    })
    .collect()
}

/// A place of the slice that is shown of a table with more than two axes: their middles.
pub(super) fn in_slice(brdf: BrdfKind, first: f64, theta: f64) -> Vec<f64> {
    place(brdf, first, theta, || 0.5)
}

/// What the first axis is called.
pub(super) fn first_axis(brdf: BrdfKind) -> String {
    name(brdf.axes()[0])
}

/// Which slice it is, as a sentence; nothing where there are two axes.
pub(super) fn slice_words(brdf: BrdfKind) -> String {
    let axes = brdf.axes().iter().enumerate();
    let others: Vec<String> = axes
        .filter(|(axis, _)| *axis > 0 && *axis != brdf.view_axis())
        .map(|(_, meaning)| format!("{} = 0.5", name(meaning)))
        .collect();
    match others.is_empty() {
        true => String::new(),
        false => format!(" Slice at {}.", others.join(", ")),
    }
}

/// An axis' name: its meaning up to the range.
fn name(meaning: &str) -> String {
    let name = meaning.split(',').next().unwrap_or(meaning);
    match name.contains('(') {
        true => name.to_owned(),
        false => name.replace('_', " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_the_view_that_was_asked_for() {
        for brdf in BrdfKind::ALL {
            for theta in [0.0, 1e-3, 0.7, 1.5_f64] {
                let place = in_slice(brdf, 0.4, theta);
                assert_eq!(place.len(), brdf.axes().len());
                let (_, view) = brdf.at(&place);
                assert!((view.z - theta.cos()).abs() < 1e-12, "{view} {theta}");
            }
            assert!(!first_axis(brdf).is_empty());
            assert_eq!(slice_words(brdf).is_empty(), brdf.axes().len() == 2);
        }
        assert_eq!(first_axis(BrdfKind::Ggx), "perceptual roughness");
    }
}
