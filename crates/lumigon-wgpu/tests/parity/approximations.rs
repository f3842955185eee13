//! The methods that stand beside the exact ones.

use lumigon::{
    InclusionRule, LocalOcclusion, ProjectionBasis, Pyramid, circle_occlusion, light_direction,
    light_vector, light_vector_above, projected_area, projection_axis, reflected_inclusion,
};

use crate::cases::double;
use crate::check::{check, check_light};
use crate::gpu::streamed;
use crate::tolerances::{
    self, direction, flux, mirrored, near, on_vertices, projection, pyramid_area, pyramid_axis,
};

#[test]
fn light_direction_is_the_cpu_s() {
    let begin = "begin_light_direction(light.polygon, place.point, place.normal)";
    check_light(
        "light_direction, direction",
        &streamed(
            "light_direction",
            "light_direction",
            begin,
            "three(package::light_direction::light_direction(sum).direction)",
        ),
        (-1.0, 1.0),
        |subject, point, normal, _| {
            let occlusion = LocalOcclusion::Exact;
            light_direction(&subject.light, point, normal, occlusion)
                .direction
                .into()
        },
        |subject, place, sight, _| {
            let (point, normal) = (double(place.point), double(place.normal));
            let vector = light_vector_above(&subject.light, point, normal);
            direction(near(sight, 1.0), vector.length())
        },
    );
    check_light(
        "light_direction, solid angle",
        &streamed(
            "light_direction",
            "light_direction",
            begin,
            "one(package::light_direction::light_direction(sum).solid_angle)",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, normal, _| {
            let occlusion = LocalOcclusion::Exact;
            [light_direction(&subject.light, point, normal, occlusion).solid_angle]
        },
        |_, _, sight, _| near(sight, 2.0),
    );
}

#[test]
fn circle_light_direction_is_the_cpu_s() {
    let begin = "begin_circle_light_direction(light.polygon, place.point, place.normal)";
    check_light(
        "circle_light_direction, direction",
        &streamed(
            "light_direction",
            "circle_light_direction",
            begin,
            "three(package::light_direction::circle_light_direction(sum).direction)",
        ),
        (-1.0, 1.0),
        |subject, point, normal, _| {
            let occlusion = LocalOcclusion::Circle;
            light_direction(&subject.light, point, normal, occlusion)
                .direction
                .into()
        },
        |subject, place, sight, _| {
            let length = light_vector(&subject.light, double(place.point)).length();
            direction(flux(sight, false, length), length)
        },
    );
    check_light(
        "circle_light_direction, solid angle",
        &streamed(
            "light_direction",
            "circle_light_direction",
            begin,
            "one(package::light_direction::circle_light_direction(sum).solid_angle)",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, normal, _| {
            let occlusion = LocalOcclusion::Circle;
            [light_direction(&subject.light, point, normal, occlusion).solid_angle]
        },
        |subject, place, sight, _| {
            let (point, normal) = (double(place.point), double(place.normal));
            let angle = lumigon::solid_angle(&subject.light, point);
            let ramp = circle_occlusion(&subject.light, point, normal);
            let (flux, rise) = (flux(sight, false, angle)?, tolerances::ramp(sight)?);
            Some(flux * ramp + angle * rise)
        },
    );
}

#[test]
fn circle_occlusion_is_the_cpu_s() {
    check(
        "circle_occlusion",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            let light = lights.list[place.light].polygon;
            return one(
                package::light_direction::circle_occlusion(light, place.point, place.normal)
            );
        }",
        (0.0, 1.0),
        |subject, point, normal, _| [circle_occlusion(&subject.light, point, normal)],
        |_, _, sight, _| tolerances::ramp(sight),
    );
}

#[test]
fn weighted_axis_is_the_cpu_s() {
    check(
        "weighted_axis",
        &streamed(
            "projected_area",
            "weighted_axis",
            "begin_weighted_axis(light.polygon, place.point)",
            "three(package::projected_area::weighted_axis(sum))",
        ),
        (-1.0, 1.0),
        |subject, point, _, _| {
            projection_axis(&subject.light, point, ProjectionBasis::Weighted).into()
        },
        |subject, place, sight, _| on_vertices(subject, place, sight),
    );
}

#[test]
fn centroid_axis_is_the_cpu_s() {
    check(
        "centroid_axis",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            let light = lights.list[place.light].polygon;
            return three(package::projected_area::centroid_axis(light, place.point));
        }",
        (-1.0, 1.0),
        |subject, point, _, _| {
            projection_axis(&subject.light, point, ProjectionBasis::Centroid).into()
        },
        |subject, place, _, _| {
            let (_, radius) = subject.light.circumscribed_circle();
            let to = (subject.light.centroid() - double(place.point)) * (1.0 / radius);
            tolerances::axis(to.length())
        },
    );
}

const CLIPPED: &str = "begin_projected_area";
const CIRCLE: &str = "begin_circle_projected_area";

fn area_along(axis: &str, begin: &str, bias: &str) -> String {
    streamed(
        "projected_area",
        "projected_area",
        &format!("{begin}(light.polygon, place.point, place.normal, {axis}, {bias})"),
        "one(package::projected_area::projected_area(sum))",
    )
}

fn area_from(basis: &str) -> String {
    format!(
        "fn evaluate(place: Place) -> array<vec4f, 3> {{
            let basis = package::lights::{basis};
            return one(package::lights::projected_area_from(
                place.light, place.point, place.normal, basis, 0.0, false
            ));
        }}"
    )
}

fn check_area(
    name: &'static str,
    body: &str,
    basis: impl Fn(f64) -> ProjectionBasis,
    occlusion: LocalOcclusion,
) {
    check(
        name,
        body,
        (0.0, f64::from(f32::MAX)),
        |subject, point, normal, place| {
            let basis = basis(place.bias.into());
            [projected_area(
                &subject.light,
                point,
                normal,
                basis,
                occlusion,
            )]
        },
        |subject, place, sight, exact| {
            let basis = basis(place.bias.into());
            let rise = match occlusion {
                LocalOcclusion::Exact => 0.0,
                LocalOcclusion::Circle => tolerances::ramp(sight)?,
            };
            projection(subject, place, sight, basis, exact[0], rise)
        },
    );
}

#[test]
fn projected_area_is_the_cpu_s() {
    let centroid = "package::projected_area::centroid_axis(light.polygon, place.point)";
    check_area(
        "projected_area",
        &area_along(centroid, CLIPPED, "0.0"),
        |_| ProjectionBasis::Centroid,
        LocalOcclusion::Exact,
    );
    check_area(
        "projected_area, biased",
        &area_along(centroid, CLIPPED, "place.bias"),
        |bias| ProjectionBasis::Biased { bias },
        LocalOcclusion::Exact,
    );
    check_area(
        "projected_area, weighted",
        &area_from("BASIS_WEIGHTED"),
        |_| ProjectionBasis::Weighted,
        LocalOcclusion::Exact,
    );
    check_area(
        "projected_area, optimal",
        &area_from("BASIS_OPTIMAL"),
        |_| ProjectionBasis::Optimal,
        LocalOcclusion::Exact,
    );
    check_area(
        "projected_area, circle",
        &area_along(centroid, CIRCLE, "place.bias"),
        |bias| ProjectionBasis::Biased { bias },
        LocalOcclusion::Circle,
    );
}

/// A search, as its file tells to run it; `result` is of the pyramid it finds.
fn search(result: &str) -> String {
    format!(
        "fn evaluate(place: Place) -> array<vec4f, 3> {{
            let light = lights.list[place.light];
            var search = package::pyramid::begin_pyramid(light.polygon, place.point);
            while package::pyramid::pyramid_wants_pass(search) {{
                search = package::pyramid::begin_pyramid_pass(search);
                for (var i = light.first_record; i < light.end_record; i++) {{
                    let record = light_vertices[i];
                    if record.w != 0.0 {{
                        search = package::pyramid::pyramid_move_to(search, record.xyz);
                    }} else {{
                        search = package::pyramid::pyramid_line_to(search, record.xyz);
                    }}
                }}
                search = package::pyramid::end_pyramid_pass(search);
            }}
            let pyramid = package::pyramid::found_pyramid(search);
            return {result};
        }}"
    )
}

#[test]
fn pyramid_is_the_cpu_s() {
    check(
        "pyramid, axis",
        &search("three(pyramid.axis)"),
        (-1.0, 1.0),
        |subject, point, _, _| Pyramid::new(&subject.light, point).axis.into(),
        |subject, place, sight, _| pyramid_axis(subject, place, sight),
    );
    check(
        "pyramid, moments",
        &search("three(vec3f(pyramid.area, pyramid.moment_trace, pyramid.moment_determinant))"),
        (0.0, f64::from(f32::MAX)),
        |subject, point, _, _| {
            let pyramid = Pyramid::new(&subject.light, point);
            [
                pyramid.area,
                pyramid.moment_trace,
                pyramid.moment_determinant,
            ]
        },
        |subject, place, sight, exact: &[f64; 3]| pyramid_area(subject, place, sight, exact),
    );
    check(
        "pyramid, solid angles",
        &search(
            "three(vec3f(
                package::pyramid::pyramid_solid_angle(pyramid),
                package::pyramid::pyramid_solid_angle_bounds(pyramid)
            ))",
        ),
        (0.0, std::f64::consts::TAU),
        |subject, point, _, _| {
            let pyramid = Pyramid::new(&subject.light, point);
            let (least, greatest) = pyramid.solid_angle_bounds();
            [pyramid.solid_angle(), least, greatest]
        },
        |subject, place, sight, exact: &[f64; 3]| pyramid_area(subject, place, sight, exact),
    );
}

#[test]
fn reflected_inclusion_is_the_cpu_s() {
    for (name, rule, result) in [
        (
            "reflected_inclusion",
            InclusionRule::CrossingNumber,
            "one(package::reflection::reflected_inclusion(sum))",
        ),
        (
            "reflected_inclusion_by_winding",
            InclusionRule::WindingNumber,
            "one(package::reflection::reflected_inclusion_by_winding(sum))",
        ),
    ] {
        check_light(
            name,
            &streamed(
                "reflection",
                "reflected_inclusion",
                "begin_reflected_inclusion(light.polygon, place.point, place.normal, place.view)",
                result,
            ),
            (0.0, 1.0),
            |subject, point, normal, place| {
                let view = double(place.view);
                [reflected_inclusion(
                    &subject.light,
                    point,
                    normal,
                    view,
                    rule,
                )]
            },
            |subject, place, sight, _| mirrored(subject, place, sight),
        );
    }
}
