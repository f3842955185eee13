//! Functions of a light and a place.

use lumigon::{
    Sides, irradiance, light_vector, light_vector_above, solid_angle, solid_angle_above,
};

use crate::cases::{Cases, Sight, Subject, cases, double};
use crate::compare::Worst;
use crate::gpu::{Place, evaluate, streamed};
use crate::polygons::Vector;
use crate::tolerances::flux;

fn all() -> Cases {
    cases(71, 150, 96)
}

/// A function of `N` numbers at every place: within its range, dark behind a one-sided light, and
/// what the CPU says where `allowed` says how near.
fn check<const N: usize>(
    name: &'static str,
    body: &str,
    range: (f64, f64),
    exact: impl Fn(&Subject, Vector, Vector, &Place) -> [f64; N],
    allowed: impl Fn(&Sight, &[f64; N]) -> Option<f64>,
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
        let is_behind = subject.light.sides() == Sides::Front && sight.plane_height < -1e-3;
        if is_behind && sight.plane_height.abs() > 1e-3 * sight.distance {
            worst.within(got, 0.0, 0.0, at);
        }
        let exact = exact(subject, double(place.point), double(place.normal), place);
        if let Some(allowed) = allowed(&sight, &exact) {
            worst.see(got, &exact, allowed, at);
        }
    }
    worst.finish(cases.places.len() / 3);
}

#[test]
fn irradiance_is_the_cpu_s() {
    check(
        "irradiance",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return one(package::lights::irradiance_from(place.light, place.point, place.normal));
        }",
        (0.0, std::f64::consts::PI),
        |subject, point, normal, _| [irradiance(&subject.light, point, normal)],
        |sight, exact| flux(sight, true, exact[0]),
    );
}

#[test]
fn light_vector_is_the_cpu_s() {
    check(
        "light_vector",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return three(package::lights::light_vector_from(place.light, place.point));
        }",
        (-std::f64::consts::PI, std::f64::consts::PI),
        |subject, point, _, _| light_vector(&subject.light, point).into(),
        |sight, exact: &[f64; 3]| flux(sight, false, length(exact)),
    );
}

#[test]
fn light_vector_above_is_the_cpu_s() {
    check(
        "light_vector_above",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return three(
                package::lights::light_vector_above_from(place.light, place.point, place.normal)
            );
        }",
        (-std::f64::consts::PI, std::f64::consts::PI),
        |subject, point, normal, _| light_vector_above(&subject.light, point, normal).into(),
        // The near form at any distance.
        |sight, exact: &[f64; 3]| {
            flux(
                &Sight {
                    lowest: -1.0,
                    ..*sight
                },
                true,
                length(exact),
            )
        },
    );
}

#[test]
fn solid_angle_is_the_cpu_s() {
    check(
        "solid_angle",
        &streamed(
            "solid_angle",
            "solid_angle",
            "begin_solid_angle(light.polygon, place.point)",
            "one(package::solid_angle::solid_angle(sum))",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, _, _| [solid_angle(&subject.light, point)],
        |sight, exact| flux(sight, false, exact[0]),
    );
}

#[test]
fn solid_angle_above_is_the_cpu_s() {
    check(
        "solid_angle_above",
        &streamed(
            "solid_angle",
            "solid_angle_above",
            "begin_solid_angle_above(light.polygon, place.point, place.normal)",
            "one(package::solid_angle::solid_angle_above(sum))",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, normal, _| [solid_angle_above(&subject.light, point, normal)],
        |sight, exact| {
            flux(
                &Sight {
                    lowest: -1.0,
                    ..*sight
                },
                true,
                exact[0],
            )
        },
    );
}

fn length(v: &[f64; 3]) -> f64 {
    Vector::from(*v).length()
}
