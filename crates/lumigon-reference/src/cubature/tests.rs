use std::f64::consts::PI;

use serde_json::Value;

use super::*;

fn lines(name: &str) -> Vec<Value> {
    let path = format!("{}/../../tests/truth/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn read<T: serde_json::value::Index>(line: &Value, key: T) -> f64 {
    line[key].as_f64().unwrap()
}

fn triple(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| value[i].as_f64().unwrap())
}

fn light(line: &Value) -> Polygon {
    let loops = line["loops"].as_array().unwrap();
    let vertices = |l: &Value| l.as_array().unwrap().iter().map(triple).collect();
    Polygon::new(&loops.iter().map(vertices).collect::<Vec<_>>(), false).unwrap()
}

#[test]
fn irradiance_matches_every_line_of_truth() {
    let lines = lines("lambert.jsonl");
    assert_eq!(lines.len(), 240);
    let mut worst = 0.0_f64;
    for (number, line) in lines.iter().enumerate() {
        let tolerance = Tolerance::default();
        let result = irradiance(&light(line), triple(&line["point"]), triple(&line["normal"]), tolerance).unwrap();
        let error = (result.value - read(line, "truth")).abs();
        assert!(error < 1e-8, "line {}: {result:?}, truth {}", number + 1, line["truth"]);
        worst = worst.max(error);
    }
    println!("worst {worst:e}");
}

#[test]
fn ggx_matches_every_line_of_truth() {
    let lines = lines("ggx.jsonl");
    assert_eq!(lines.len(), 800);
    let mut worst = 0.0_f64;
    for (number, line) in lines.iter().enumerate() {
        let [point, normal, view] = ["point", "normal", "view"].map(|key| triple(&line[key]));
        let alpha = read(line, "perceptual_roughness").powi(2);
        let result = ggx(&light(line), point, normal, view, alpha, Tolerance::default()).unwrap();
        let error = (result.value - read(line, "truth"))
            .abs()
            .max((result.schlick - read(line, "truth_schlick")).abs());
        assert!(error < 1e-6, "line {}: {result:?}, truth {} {}", number + 1, line["truth"], line["truth_schlick"]);
        worst = worst.max(error);
    }
    println!("worst {worst:e}");
}
