//! Irradiance against independent truth values.

use lumigon::{PolygonLight, Sides, Vec3, irradiance};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    loops: Vec<Vec<[f64; 3]>>,
    point: [f64; 3],
    normal: [f64; 3],
    truth: f64,
}

fn cases() -> Vec<Case> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/truth/lambert.jsonl"
    );
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn every_truth_value_in_both_precisions() {
    let (mut worst64, mut worst32) = (0.0_f64, 0.0_f64);
    let cases = cases();
    assert_eq!(cases.len(), 240);
    for case in &cases {
        let light = PolygonLight::new(&case.loops, Sides::Front).unwrap();
        let e64 = irradiance(&light, case.point.into(), case.normal.into());
        worst64 = worst64.max((e64 - case.truth).abs());
        let light32 = light.cast::<f32>().unwrap();
        let single = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
        let e32 = irradiance(&light32, single(case.point), single(case.normal));
        worst32 = worst32.max((f64::from(e32) - case.truth).abs());
    }
    println!("worst absolute error: f64 {worst64:e}, f32 {worst32:e}");
    assert!(worst64 < 1e-8, "{worst64:e}");
    assert!(worst32 < 1e-5, "{worst32:e}");
}

/// A face-on light, coordinates exact in single precision, from 1 to 1e6 times its size away.
#[test]
fn single_precision_holds_at_any_distance() {
    let shape = [
        [-0.5, -0.5],
        [0.5, -0.5],
        [0.5, 0.25],
        [0.125, 0.5],
        [-0.5, 0.375],
    ];
    let mut worst = 0.0_f64;
    let mut distance = 1.0_f64;
    while distance <= 1e6 {
        let z = f64::from(distance as f32);
        let vertices: Vec<_> = shape.iter().rev().map(|v| [v[0], v[1], z]).collect();
        let light = PolygonLight::new(&[vertices], Sides::Front).unwrap();
        let up = Vec3::new(0.0, 0.0, 1.0);
        let exact = irradiance(&light, Vec3::default(), up);
        let up = Vec3::new(0.0_f32, 0.0, 1.0);
        let got = irradiance(&light.cast().unwrap(), Vec3::default(), up);
        worst = worst.max((f64::from(got) / exact - 1.0).abs());
        distance *= 1.1;
    }
    println!("worst relative error {worst:e}");
    assert!(worst < 2e-6, "{worst:e}");
}
