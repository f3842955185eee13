//! The shipped table against independent truth values.

use lumigon::{LtcTable, PolygonLight, PreparedLtc, Sides, Vec3, ltc_form_factor};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    loops: Vec<Vec<[f64; 3]>>,
    point: [f64; 3],
    normal: [f64; 3],
    view: [f64; 3],
    perceptual_roughness: f64,
    truth: f64,
    truth_schlick: f64,
}

#[test]
fn table_is_as_good_as_promised() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/truth/ggx.jsonl");
    let text = std::fs::read_to_string(path).unwrap();
    let table = LtcTable::ggx();
    let (mut squares, mut schlick_squares, mut count) = (0.0, 0.0, 0);
    for line in text.lines() {
        let case: Case = serde_json::from_str(line).unwrap();
        let single = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
        let light = PolygonLight::new(&case.loops, Sides::Front)
            .unwrap()
            .cast()
            .unwrap();
        let (normal, view) = (single(case.normal), single(case.view));
        let lobe = table.lookup(case.perceptual_roughness as f32, normal.dot(view));
        let prepared = PreparedLtc::new(&lobe, normal, view);
        let form_factor = ltc_form_factor(&light, single(case.point), &prepared);
        squares += (f64::from(lobe.amplitude * form_factor) - case.truth).powi(2);
        schlick_squares += (f64::from(lobe.schlick * form_factor) - case.truth_schlick).powi(2);
        count += 1;
    }
    assert_eq!(count, 800);
    let rmse = (squares / 800.0).sqrt();
    let schlick_rmse = (schlick_squares / 800.0).sqrt();
    println!("RMSE {rmse:.5}, Schlick-weighted {schlick_rmse:.5}");
    assert!(rmse <= 0.0205, "{rmse}");
    assert!(schlick_rmse <= 0.0205, "{schlick_rmse}");
}
