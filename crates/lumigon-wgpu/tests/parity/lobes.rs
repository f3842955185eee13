//! Linearly transformed cosines.

use lumigon::{
    AnisotropicLtc, Ltc, PreparedLtc, irradiance, ltc_form_factor, ltc_form_factor_bound,
};

use crate::cases::{Subject, double};
use crate::check::{check, check_bound, check_light};
use crate::gpu::Place;
use crate::tolerances::{ALBEDO, lobe, lobe_bound, lobe_density, lobe_direction};

fn ltc(place: &Place) -> Ltc<f64> {
    Ltc {
        shading_to_cosine: place.lobe.map(f64::from),
        amplitude: 1.0,
        schlick: 0.0,
    }
}

/// The lobe at a place, about its mirrored view.
///
/// The true one is about unit vectors: where the view is nearly the normal, what f32 leaves of their
/// lengths would turn it.
pub(crate) fn prepared(_: &Subject, place: &Place) -> PreparedLtc<f64> {
    let unit = |v: [f32; 3]| double(v).normalize_or_zero();
    PreparedLtc::new(&ltc(place), unit(place.normal), unit(place.view))
}

/// A lobe that keeps no symmetry; the same numbers as in the shader below.
fn skewed(place: &Place) -> AnisotropicLtc<f64> {
    let [a, b, c, d] = place.lobe.map(f64::from);
    let [e, f, g, h] = [0.2_f32, -0.1, 0.9, 0.3].map(f64::from);
    AnisotropicLtc {
        shading_to_cosine: [[a, e, b], [f, g, h], [c, -e, d]],
        amplitude: 1.0,
        schlick: 0.0,
    }
}

const SKEWED: &str = "
fn skewed(place: Place) -> package::anisotropic_ltc::AnisotropicLtc {
    return package::anisotropic_ltc::AnisotropicLtc(
        vec3f(place.lobe.x, 0.2, place.lobe.y),
        vec3f(-0.1, 0.9, 0.3),
        vec3f(place.lobe.z, -0.2, place.lobe.w),
        1.0,
        0.0
    );
}
";

/// Orientation has to be kept, by more than rounding.
fn is_upright(ltc: &AnisotropicLtc<f64>) -> bool {
    let [a, b, c] = ltc.shading_to_cosine;
    let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    determinant > 1e-3
}

fn prepared_skewed(_: &Subject, place: &Place) -> PreparedLtc<f64> {
    let normal = double(place.normal);
    let (tangent, bitangent) = normal.orthonormal_basis();
    skewed(place).prepare(tangent, bitangent, normal)
}

const PREPARE: &str = "package::ltc::prepare_ltc(place.lobe, place.normal, place.view)";
const PREPARE_SKEWED: &str = "package::anisotropic_ltc::prepare_anisotropic_ltc(
    skewed(place),
    package::vector::tangent_of(place.normal),
    cross(place.normal, package::vector::tangent_of(place.normal)),
    place.normal)";

fn form_factor(prepare: &str) -> String {
    format!(
        "{SKEWED}
        fn evaluate(place: Place) -> array<vec4f, 3> {{
            let lobe = {prepare};
            return one(package::lights::ltc_form_factor_from(place.light, place.point, lobe));
        }}"
    )
}

#[test]
fn ltc_form_factor_is_the_cpu_s() {
    check_light(
        "ltc_form_factor",
        &form_factor(PREPARE),
        (0.0, 1.0),
        |subject, point, _, place| {
            [ltc_form_factor(
                &subject.light,
                point,
                &prepared(subject, place),
            )]
        },
        |subject, place, sight, _| lobe(subject, place, sight, &prepared(subject, place)),
    );
}

#[test]
fn anisotropic_ltc_form_factor_is_the_cpu_s() {
    check_light(
        "ltc_form_factor, anisotropic",
        &form_factor(PREPARE_SKEWED),
        (0.0, 1.0),
        |subject, point, _, place| {
            [ltc_form_factor(
                &subject.light,
                point,
                &prepared_skewed(subject, place),
            )]
        },
        |subject, place, sight, _| {
            is_upright(&skewed(place))
                .then(|| lobe(subject, place, sight, &prepared_skewed(subject, place)))?
        },
    );
}

#[test]
fn ltc_form_factor_bound_is_the_cpu_s() {
    check_light(
        "ltc_form_factor_bound",
        &format!(
            "fn evaluate(place: Place) -> array<vec4f, 3> {{
                let lobe = {PREPARE};
                let light = lights.list[place.light].polygon;
                return one(package::bound::ltc_form_factor_bound(light, place.point, lobe));
            }}"
        ),
        (0.0, 1.0),
        |subject, point, _, place| {
            [ltc_form_factor_bound(
                &subject.light,
                point,
                &prepared(subject, place),
            )]
        },
        |subject, place, sight, exact| {
            lobe_bound(subject, place, sight, &prepared(subject, place), exact[0])
        },
    );
}

/// Of a light; and of a cluster of one light, the sphere about it and its area.
#[test]
fn bounds_hold() {
    let light = "lights.list[place.light].polygon";
    let bound = |call: &str| {
        format!(
            "fn evaluate(place: Place) -> array<vec4f, 3> {{ return one(package::bound::{call}); }}"
        )
    };
    check_bound(
        "irradiance_bound over irradiance",
        &bound(&format!(
            "irradiance_bound({light}, place.point, place.normal)"
        )),
        |subject, point, normal, _| irradiance(&subject.light, point, normal),
    );
    check_bound(
        "ltc_form_factor_bound over ltc_form_factor",
        &bound(&format!(
            "ltc_form_factor_bound({light}, place.point, {PREPARE})"
        )),
        |subject, point, _, place| {
            ltc_form_factor(&subject.light, point, &prepared(subject, place))
        },
    );
    let body = |call: &str| {
        format!(
            "fn evaluate(place: Place) -> array<vec4f, 3> {{
                let light = lights.list[place.light].polygon;
                let radius = 1.0 / light.inverse_radius;
                let power = 0.5 * light.doubled_area * radius * radius;
                let center = light.center - place.point;
                return one(package::bound::{call});
            }}"
        )
    };
    check_bound(
        "cluster_irradiance_bound",
        &body("cluster_irradiance_bound(center, radius, power, place.normal)"),
        |subject, point, normal, _| irradiance(&subject.light, point, normal),
    );
    check_bound(
        "cluster_ltc_bound",
        &body(&format!(
            "cluster_ltc_bound(center, radius, power, {PREPARE})"
        )),
        |subject, point, _, place| {
            ltc_form_factor(&subject.light, point, &prepared(subject, place))
        },
    );
}

#[test]
fn densities_and_shares_are_the_cpu_s() {
    check(
        "ltc_density",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return one(package::ltc::ltc_density(place.lobe, place.towards));
        }",
        (0.0, f64::from(f32::MAX)),
        |_, _, _, place| [ltc(place).density(double(place.towards))],
        |_, place, _, exact| lobe_density(&ltc(place), double(place.towards), exact[0]),
    );
    check(
        "anisotropic_ltc_density",
        &format!(
            "{SKEWED}
            fn evaluate(place: Place) -> array<vec4f, 3> {{
                return one(
                    package::anisotropic_ltc::anisotropic_ltc_density(skewed(place), place.towards)
                );
            }}"
        ),
        // Turned inside out a lobe has a density below 0, and no meaning.
        (-f64::from(f32::MAX), f64::from(f32::MAX)),
        |_, _, _, place| [skewed(place).density(double(place.towards))],
        |_, place, _, exact| {
            let map = skewed(place);
            is_upright(&map).then(|| {
                // Relative to a lobe that is about as wide as this.
                3e-6 * exact[0].max(1.0)
            })
        },
    );
    check(
        "share_above_horizon, isotropic and not",
        &format!(
            "{SKEWED}
            fn evaluate(place: Place) -> array<vec4f, 3> {{
                return three(vec3f(
                    package::ltc::share_above_horizon(place.lobe),
                    package::anisotropic_ltc::anisotropic_share_above_horizon(skewed(place)),
                    0.0
                ));
            }}"
        ),
        (0.0, 1.0),
        |_, _, _, place| {
            [
                ltc(place).share_above_horizon(),
                skewed(place).share_above_horizon(),
            ]
        },
        |_, place, _, _| is_upright(&skewed(place)).then_some(10.0 * ALBEDO),
    );
    check(
        "ltc_cosine_to_shading",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return three(package::ltc::ltc_cosine_to_shading(place.lobe, place.towards));
        }",
        (-1.0, 1.0),
        |_, _, _, place| ltc(place).cosine_to_shading(double(place.towards)).into(),
        |_, place, _, _| lobe_direction(&ltc(place), double(place.towards)),
    );
}
