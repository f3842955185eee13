//! Fitted tables, looked up in textures, and the polynomials.

use lumigon::{AnisotropicLtcTable, LtcSum, LtcTable, ggx_polynomial};

use crate::check::check;
use crate::gpu::Place;
use crate::tolerances::TABLE;

const SUM: &str = "
fn sum(found: package::ltc_table::LtcSum) -> array<vec4f, 3> {
    return array<vec4f, 3>(
        found.lobe.shading_to_cosine,
        vec4f(found.lobe.amplitude, found.lobe.schlick, found.cosine_amplitude, found.cosine_schlick),
        vec4f(
            package::ltc_table::ltc_sum_albedo(found),
            package::ltc_table::ltc_sum_schlick_albedo(found),
            0.0,
            0.0
        )
    );
}
";

/// From all of the axes, and from a little beyond their ends.
fn arguments(place: &Place) -> [f32; 2] {
    [1.2 * place.alpha - 0.1, 1.2 * place.cosine - 0.1]
}

const ARGUMENTS: &str = "1.2 * place.alpha - 0.1, 1.2 * place.cosine - 0.1";

fn check_sum(name: &'static str, call: &str, cpu: impl Fn(f32, f32) -> LtcSum<1>) {
    check(
        name,
        &format!(
            "{SUM}
            fn evaluate(place: Place) -> array<vec4f, 3> {{
                return sum({call}({ARGUMENTS}));
            }}"
        ),
        (-100.0, 100.0),
        |_, _, _, place| {
            let [column, cosine] = arguments(place);
            let sum = cpu(column, cosine);
            let [lobe] = sum.lobes;
            let [a, b, c, d] = lobe.shading_to_cosine;
            let numbers = [
                lobe.amplitude,
                lobe.schlick,
                sum.cosine.amplitude,
                sum.cosine.schlick,
            ];
            let [e, f, g, h] = numbers;
            [a, b, c, d, e, f, g, h, sum.albedo(), sum.schlick_albedo()].map(f64::from)
        },
        |_, _, _, _| Some(TABLE),
    );
}

#[test]
fn tables_of_one_lobe_are_the_cpu_s() {
    let table = LtcTable::ggx();
    check_sum("lookup_ggx", "package::tables::lookup_ggx", |r, c| {
        table.lookup(r, c)
    });
    let table = LtcTable::charlie();
    check_sum(
        "lookup_charlie",
        "package::tables::lookup_charlie",
        |r, c| table.lookup(r, c),
    );
    let table = LtcTable::eon();
    check_sum("lookup_eon", "package::tables::lookup_eon", |r, c| {
        table.lookup(r, c)
    });
    check_sum(
        "ggx_polynomial",
        "package::ggx_polynomial::ggx_polynomial",
        ggx_polynomial,
    );
}

#[test]
fn table_of_two_lobes_is_the_cpu_s() {
    let table = LtcTable::ggx_2();
    check(
        "lookup_ggx_two",
        &format!(
            "fn evaluate(place: Place) -> array<vec4f, 3> {{
                let found = package::tables::lookup_ggx_two({ARGUMENTS});
                return array<vec4f, 3>(
                    found.first.shading_to_cosine,
                    found.second.shading_to_cosine,
                    vec4f(
                        found.first.amplitude + found.second.schlick,
                        found.second.amplitude + found.first.schlick,
                        package::ltc_table::ltc_pair_albedo(found),
                        package::ltc_table::ltc_pair_schlick_albedo(found)
                    )
                );
            }}"
        ),
        (-100.0, 100.0),
        |_, _, _, place| {
            let [column, cosine] = arguments(place);
            let sum = table.lookup(column, cosine);
            let [first, second] = sum.lobes;
            let mut numbers = [0.0; 12];
            numbers[..4].copy_from_slice(&first.shading_to_cosine);
            numbers[4..8].copy_from_slice(&second.shading_to_cosine);
            numbers[8] = first.amplitude + second.schlick;
            numbers[9] = second.amplitude + first.schlick;
            numbers[10] = sum.albedo();
            numbers[11] = sum.schlick_albedo();
            numbers.map(f64::from)
        },
        |_, _, _, _| Some(TABLE),
    );
}

#[test]
fn anisotropic_table_is_the_cpu_s() {
    let table = AnisotropicLtcTable::ggx();
    check(
        "lookup_ggx_anisotropic",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            let alpha = vec2f(place.alpha, place.cosine);
            let found = package::tables::lookup_ggx_anisotropic(alpha, place.towards);
            return array<vec4f, 3>(
                vec4f(found.row_x, found.amplitude),
                vec4f(found.row_y, found.schlick),
                vec4f(found.row_z, 0.0)
            );
        }",
        (-100.0, 100.0),
        |_, _, _, place| {
            let found = table.lookup([place.alpha, place.cosine], place.towards.into());
            let [x, y, z] = found.shading_to_cosine;
            let numbers = [
                x[0],
                x[1],
                x[2],
                found.amplitude,
                y[0],
                y[1],
                y[2],
                found.schlick,
                z[0],
                z[1],
                z[2],
            ];
            numbers.map(f64::from)
        },
        |_, _, _, _| Some(TABLE),
    );
}
