//! The shader's polynomial coefficients are those of the crate `lumigon`.

use lumigon_shaders::MODULES;

/// By number of a texel, by power of y, by power of x.
const GGX: [[[f32; 7]; 7]; 8] = include!("../../../tables/ggx-polynomial-6.rs");

/// Coefficients stand in the shader by power of y, then of x, both falling: four numbers of a texel
/// at once, first those of the matrix, then the amplitudes.
#[test]
fn shader_has_the_numbers_of_the_table() {
    let (_, text) = MODULES
        .iter()
        .find(|(name, _)| *name == "ggx_polynomial")
        .unwrap();
    let mut numbers = Vec::new();
    for line in text.lines() {
        let coefficients = line
            .strip_prefix("    row = row * x + vec4f(")
            .or_else(|| line.strip_prefix("    row = vec4f("))
            .or_else(|| line.strip_prefix("    var row = vec4f("));
        if let Some(list) = coefficients.and_then(|rest| rest.strip_suffix(");")) {
            numbers.extend(list.split(", ").map(|x| x.parse::<f32>().unwrap()));
        }
    }
    let table = [0, 4].into_iter().flat_map(|first| {
        let powers = (0..7).rev().flat_map(|j| (0..7).rev().map(move |i| (j, i)));
        powers.flat_map(move |(j, i)| (first..first + 4).map(move |n| GGX[n][j][i]))
    });
    let table: Vec<f32> = table.collect();
    assert_eq!(
        numbers, table,
        "write the coefficients of tables/ggx-polynomial-6.rs into shaders/ggx_polynomial.wesl"
    );
}
