//! Functions of a light and a place.

use lumigon::{
    irradiance, irradiance_bound, light_vector, light_vector_above, solid_angle, solid_angle_above,
};

use crate::check::check_light;
use crate::gpu::streamed;
use crate::polygons::Vector;
use crate::tolerances::{bound, flux, near};

#[test]
fn irradiance_is_the_cpu_s() {
    check_light(
        "irradiance",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return one(package::lights::irradiance_from(place.light, place.point, place.normal));
        }",
        (0.0, std::f64::consts::PI),
        |subject, point, normal, _| [irradiance(&subject.light, point, normal)],
        |_, _, sight, exact| flux(sight, true, exact[0]),
    );
}

#[test]
fn light_vector_is_the_cpu_s() {
    check_light(
        "light_vector",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return three(package::lights::light_vector_from(place.light, place.point));
        }",
        (-std::f64::consts::PI, std::f64::consts::PI),
        |subject, point, _, _| light_vector(&subject.light, point).into(),
        |_, _, sight, exact: &[f64; 3]| flux(sight, false, length(exact)),
    );
}

#[test]
fn light_vector_above_is_the_cpu_s() {
    check_light(
        "light_vector_above",
        &streamed(
            "irradiance",
            "light_vector_above",
            "begin_light_vector_above(light.polygon, place.point, place.normal)",
            "three(package::irradiance::light_vector_above(sum))",
        ),
        (-std::f64::consts::PI, std::f64::consts::PI),
        |subject, point, normal, _| light_vector_above(&subject.light, point, normal).into(),
        // The near form at any distance.
        |_, _, sight, _| near(sight, 1.0),
    );
}

#[test]
fn solid_angle_is_the_cpu_s() {
    check_light(
        "solid_angle",
        &streamed(
            "solid_angle",
            "solid_angle",
            "begin_solid_angle(light.polygon, place.point)",
            "one(package::solid_angle::solid_angle(sum))",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, _, _| [solid_angle(&subject.light, point)],
        |_, _, sight, exact| flux(sight, false, exact[0]),
    );
}

#[test]
fn solid_angle_above_is_the_cpu_s() {
    check_light(
        "solid_angle_above",
        &streamed(
            "solid_angle",
            "solid_angle_above",
            "begin_solid_angle_above(light.polygon, place.point, place.normal)",
            "one(package::solid_angle::solid_angle_above(sum))",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, normal, _| [solid_angle_above(&subject.light, point, normal)],
        |_, _, sight, _| near(sight, 2.0),
    );
}

#[test]
fn irradiance_bound_is_the_cpu_s() {
    check_light(
        "irradiance_bound",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            let light = lights.list[place.light].polygon;
            return one(package::bound::irradiance_bound(light, place.point, place.normal));
        }",
        (0.0, std::f64::consts::PI),
        |subject, point, normal, _| [irradiance_bound(&subject.light, point, normal)],
        |_, _, sight, exact| bound(sight, exact[0]),
    );
}

fn length(v: &[f64; 3]) -> f64 {
    Vector::from(*v).length()
}
