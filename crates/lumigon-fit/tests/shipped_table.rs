//! The table in `tables/` against truth values made by adaptive cubature outside this crate, and
//! against its own manifest.

use std::path::{Path, PathBuf};

use glam::DVec3;
use lumigon_fit::{Ltc, Manifest, Table};
use serde::Deserialize;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

fn manifest_path() -> PathBuf {
    std::env::var_os("LUMIGON_TABLE").map_or_else(|| repository("tables/ggx-64.json"), Into::into)
}

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

/// Sutherland and Hodgman's clip against `plane . v > 0`, then Lambert's edge sum: written apart
/// from the crate's own, so that the two can disagree.
fn clip(polygon: &[DVec3], plane: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &to) in polygon.iter().enumerate() {
        let from = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (d_from, d_to) = (from.dot(plane), to.dot(plane));
        if d_from * d_to < 0.0 {
            kept.push(from.lerp(to, d_from / (d_from - d_to)));
        }
        if d_to >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

fn form_factor(polygon: &[DVec3]) -> f64 {
    let mut sum = 0.0;
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        sum += a.angle_between(b) * b.cross(a).normalize_or_zero().z;
    }
    sum / std::f64::consts::TAU
}

impl Case {
    /// Form factor of the light in cosine space, clipped by both planes.
    fn form_factor(&self, ltc: &Ltc) -> f64 {
        let normal = DVec3::from_array(self.normal).normalize();
        let view = DVec3::from_array(self.view);
        let x = (view - view.dot(normal) * normal).normalize();
        let y = normal.cross(x);
        let shading: Vec<DVec3> = self.loops[0]
            .iter()
            .map(|&v| DVec3::from_array(v) - DVec3::from_array(self.point))
            .map(|v| DVec3::new(v.dot(x), v.dot(y), v.dot(normal)))
            .collect();
        let above = clip(&shading, DVec3::Z);
        let cosine: Vec<DVec3> = above.iter().map(|&v| ltc.shading_to_cosine() * v).collect();
        form_factor(&clip(&cosine, DVec3::Z))
    }

    fn cos_theta(&self) -> f64 {
        DVec3::from_array(self.view).dot(DVec3::from_array(self.normal))
    }
}

fn cases() -> Vec<Case> {
    let path = repository("tests/truth/ggx.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn rmse_on_cubature_truth() {
    let table = Table::read(&manifest_path()).unwrap();
    let cases = cases();
    assert_eq!(cases.len(), 800);
    let (mut sum, mut schlick_sum, mut bias, mut worst) = (0.0, 0.0, 0.0, 0.0_f64);
    for case in &cases {
        let ltc = table.lookup(case.perceptual_roughness, case.cos_theta());
        let form_factor = case.form_factor(&ltc);
        assert!(form_factor > -1e-12, "light facing away");
        let error = ltc.amplitude * form_factor - case.truth;
        sum += error * error;
        bias += error;
        worst = worst.max(error.abs());
        schlick_sum += (ltc.schlick * form_factor - case.truth_schlick).powi(2);
    }
    let count = cases.len() as f64;
    let (rmse, schlick_rmse) = ((sum / count).sqrt(), (schlick_sum / count).sqrt());
    println!(
        "rmse {rmse:.5} bias {:+.5} worst {worst:.4} schlick {schlick_rmse:.5}",
        bias / count
    );
    assert!(rmse < 0.0205, "{rmse}");
}

#[test]
fn manifest_matches() {
    let manifest = Manifest::read(&manifest_path()).unwrap();
    let table = Table::read(&manifest_path()).unwrap();
    assert_eq!(table.size(), 64);
    assert_eq!(&manifest.settings, table.settings());
}
