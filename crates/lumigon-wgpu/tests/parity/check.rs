//! Functions of a light and a place, over all lights and places.

use lumigon::Sides;

use crate::cases::{Cases, Sight, Subject, cases, double};
use crate::compare::Worst;
use crate::gpu::{Place, evaluate};
use crate::polygons::Vector;
use crate::tolerances::is_comparable;

pub(crate) fn all() -> Cases {
    cases(71, 150, 96)
}

/// What a light gives: dark behind a one-sided light, and otherwise as [`check`].
pub(crate) fn check_light<const N: usize>(
    name: &'static str,
    body: &str,
    range: (f64, f64),
    exact: impl Fn(&Subject, Vector, Vector, &Place) -> [f64; N],
    allowed: impl Fn(&Subject, &Place, &Sight, &[f64; N]) -> Option<f64>,
) {
    check_all(name, body, range, true, exact, allowed);
}

/// A function of `N` numbers at every place: within its range, and what the CPU says where `allowed`
/// says how near.
pub(crate) fn check<const N: usize>(
    name: &'static str,
    body: &str,
    range: (f64, f64),
    exact: impl Fn(&Subject, Vector, Vector, &Place) -> [f64; N],
    allowed: impl Fn(&Subject, &Place, &Sight, &[f64; N]) -> Option<f64>,
) {
    check_all(name, body, range, false, exact, allowed);
}

fn check_all<const N: usize>(
    name: &'static str,
    body: &str,
    range: (f64, f64),
    is_light: bool,
    exact: impl Fn(&Subject, Vector, Vector, &Place) -> [f64; N],
    allowed: impl Fn(&Subject, &Place, &Sight, &[f64; N]) -> Option<f64>,
) {
    let cases = all();
    let values = evaluate(name, body, &cases.lights(), &cases.places);
    let mut worst = Worst::new(name);
    // Rounding may pass a bound that is not clamped to.
    let slack = |x: f64| x.abs() * 2e-5;
    let (least, greatest) = (range.0 - slack(range.0), range.1 + slack(range.1));
    for (place, values) in cases.places.iter().zip(&values) {
        let subject = cases.subject(place);
        let sight = subject.sight(place);
        let got = &values[..N];
        let at = || format!("{place:?} {sight:?} {subject:?}");
        worst.within(got, least as f32, greatest as f32, at);
        let depth = 1e-3 * sight.distance.max(1.0);
        let is_behind = subject.light.sides() == Sides::Front && sight.plane_height < -depth;
        if is_light && is_behind {
            worst.within(got, 0.0, 0.0, at);
        }
        let exact = exact(subject, double(place.point), double(place.normal), place);
        if let Some(allowed) = allowed(subject, place, &sight, &exact) {
            worst.see(got, &exact, allowed, at);
        }
    }
    worst.finish(cases.places.len() / 3);
}

/// A bound that a light may not pass at any place, from the same arguments; `exact` is the light's
/// own.
pub(crate) fn check_bound(
    name: &'static str,
    body: &str,
    exact: impl Fn(&Subject, Vector, Vector, &Place) -> f64,
) {
    let cases = all();
    let values = evaluate(name, body, &cases.lights(), &cases.places);
    let (mut lit, mut tightest) = (0, f64::INFINITY);
    for (place, values) in cases.places.iter().zip(&values) {
        let subject = cases.subject(place);
        let sight = subject.sight(place);
        let exact = exact(subject, double(place.point), double(place.normal), place);
        let bound = f64::from(values[0]);
        // On which side of the plane or the horizon a place is, rounding decides; and a light that a
        // horizon cuts is known to 1e-13.
        let is_seen = is_comparable(&sight) && (sight.height + 1.0).abs() > 1e-6 * sight.distance;
        let exact = exact - 1e-12;
        if is_seen && exact > 0.0 {
            assert!(
                bound >= exact * (1.0 - 1e-5),
                "{name}: {bound} bounds {exact}, at {place:?} {sight:?} {subject:?}"
            );
            lit += 1;
            tightest = tightest.min(bound / exact);
        }
    }
    println!("{name}: {lit} compared, the tightest {tightest:.4} times what is bounded");
    assert!(lit > 1_000, "{name}: only {lit} compared");
}
