//! Reflection models themselves, for light from one direction.

use lumigon::{
    Vec3, charlie_cosine, eon_albedo, eon_cosine, eon_multiple_albedo, eon_multiple_cosine,
    eon_single_albedo, eon_single_cosine, ggx_anisotropic_cosine, ggx_cosine, schlick,
};

use crate::cases::double;
use crate::check::check;
use crate::gpu::Place;
use crate::polygons::Vector;
use crate::tolerances::{ALBEDO, cloth, diffuse, facets};

/// A function of the model's arguments, as one number.
fn body(call: &str) -> String {
    format!("fn evaluate(place: Place) -> array<vec4f, 3> {{ return {call}; }}")
}

const POSITIVE: (f64, f64) = (0.0, f32::MAX as f64);

/// Normal, view and light, of unit length: a half vector's sine would be what f32 leaves of it.
fn towards(place: &Place) -> [Vector; 3] {
    [place.normal, place.view, place.towards].map(|v| double(v).normalize_or_zero())
}

#[test]
fn ggx_cosine_is_the_cpu_s() {
    check(
        "ggx_cosine",
        &body(
            "one(package::ggx::ggx_cosine(place.alpha, place.normal, place.view, place.towards))",
        ),
        POSITIVE,
        |_, _, _, place| {
            let [normal, view, light] = towards(place);
            [ggx_cosine(place.alpha.into(), normal, view, light)]
        },
        |_, place, _, exact| facets(place, place.alpha, exact[0]),
    );
}

#[test]
fn ggx_anisotropic_cosine_is_the_cpu_s() {
    check(
        "ggx_anisotropic_cosine",
        &body(
            "one(package::ggx::ggx_anisotropic_cosine(
                vec2f(place.alpha, place.cosine),
                package::vector::tangent_of(place.normal),
                cross(place.normal, package::vector::tangent_of(place.normal)),
                place.normal, place.view, place.towards))",
        ),
        POSITIVE,
        |_, _, _, place| {
            let [normal, view, light] = towards(place);
            let (tangent, bitangent) = normal.orthonormal_basis();
            let alpha = [place.alpha.into(), place.cosine.into()];
            [ggx_anisotropic_cosine(
                alpha, tangent, bitangent, normal, view, light,
            )]
        },
        |_, place, _, exact| facets(place, place.alpha.min(place.cosine), exact[0]),
    );
}

#[test]
fn schlick_is_the_cpu_s() {
    check(
        "schlick",
        &body("three(package::ggx::schlick(abs(place.normal), place.cosine))"),
        (0.0, 1.0),
        |_, _, normal, place| {
            let f0: [f64; 3] = normal.into();
            f0.map(|f0| schlick(f0.abs(), place.cosine.into()))
        },
        |_, _, _, _| Some(ALBEDO),
    );
}

#[test]
fn charlie_cosine_is_the_cpu_s() {
    check(
        "charlie_cosine",
        &body(
            "one(package::charlie::charlie_cosine(
                place.alpha, place.normal, place.view, place.towards))",
        ),
        POSITIVE,
        |_, _, _, place| {
            let [normal, view, light] = towards(place);
            [charlie_cosine(place.alpha.into(), normal, view, light)]
        },
        |_, place, _, exact| cloth(place, exact[0]),
    );
}

#[test]
fn eon_is_the_cpu_s() {
    check(
        "eon_cosine",
        &body(
            "three(package::eon::eon_cosine(
                place.lobe.xyz, place.alpha, place.normal, place.view, place.towards))",
        ),
        POSITIVE,
        |_, _, _, place| {
            let [normal, view, light] = towards(place);
            let [x, y, z, _] = place.lobe.map(f64::from);
            [x, y, z].map(|rho| eon_cosine(rho, place.alpha.into(), normal, view, light))
        },
        |_, place, _, exact: &[f64; 3]| diffuse(place, Vec3::from(*exact).length()),
    );
    check(
        "eon_single_cosine, eon_multiple_cosine",
        &body(
            "three(vec3f(
                package::eon::eon_single_cosine(
                    place.alpha, place.normal, place.view, place.towards),
                package::eon::eon_multiple_cosine(
                    place.alpha, place.normal, place.view, place.towards),
                0.0))",
        ),
        POSITIVE,
        |_, _, _, place| {
            let [normal, view, light] = towards(place);
            let r = place.alpha.into();
            [
                eon_single_cosine(r, normal, view, light),
                eon_multiple_cosine(r, normal, view, light),
            ]
        },
        |_, place, _, exact| diffuse(place, exact[0] + exact[1]),
    );
    check(
        "eon_albedo, eon_multiple_albedo, eon_single_albedo",
        &body(
            "array<vec4f, 3>(
                vec4f(
                    package::eon::eon_albedo(place.lobe.xyz, place.alpha, place.cosine),
                    package::eon::eon_single_albedo(place.alpha, place.cosine)),
                vec4f(package::eon::eon_multiple_albedo(place.lobe.xyz, place.alpha), 0.0),
                vec4f(0.0))",
        ),
        (0.0, 1.0),
        |_, _, _, place| {
            let (r, cosine) = (f64::from(place.alpha), f64::from(place.cosine));
            let [x, y, z, _] = place.lobe.map(f64::from);
            let [a, b, c] = [x, y, z].map(|rho| eon_albedo(rho, r, cosine));
            let [e, f, g] = [x, y, z].map(|rho| eon_multiple_albedo(rho, r));
            [a, b, c, eon_single_albedo(r, cosine), e, f, g]
        },
        |_, _, _, _| Some(3.0 * ALBEDO),
    );
}
