//! The table in `tables/` against truth values made by adaptive cubature outside this crate, and
//! against its own manifest.

use std::path::{Path, PathBuf};

use glam::DVec3;
use lumigon_fit::{Ltc, Manifest, Settings, Table, refit};
use serde::Deserialize;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

fn manifest_path() -> PathBuf {
    repository("tables/ggx-64.json")
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

/// `Table::read` checks length, hash and finiteness.
#[test]
fn manifest_matches() {
    let manifest = Manifest::read(&manifest_path()).unwrap();
    let table = Table::read(&manifest_path()).unwrap();
    assert_eq!(table.size(), 64);
    assert_eq!(&manifest.settings, table.settings());
    assert_eq!(
        manifest.settings,
        Settings::default(),
        "the shipped table is the default fit"
    );
}

/// The fit still makes this table.
#[test]
fn texels_refit_to_themselves() {
    let table = Table::read(&manifest_path()).unwrap();
    let places = [(0, 0), (9, 20), (25, 55), (40, 33), (63, 5), (50, 62)];
    for ((column, row), texel) in places.into_iter().zip(refit(&table, &places).unwrap()) {
        let shipped = &table.texels()[8 * (row * 64 + column)..][..8];
        for (i, (again, shipped)) in texel.iter().zip(shipped).enumerate() {
            println!(
                "({column}, {row})[{i}]: {again} {shipped} {:.1e}",
                again - shipped
            );
        }
        for (i, (again, shipped)) in texel.iter().zip(shipped).enumerate() {
            assert!(
                (again - shipped).abs() < 5e-4 + 1e-3 * shipped.abs(),
                "({column}, {row})[{i}]: {again} now, {shipped} shipped"
            );
        }
    }
}

/// Bilinear lookup supposes that the table is smooth: second differences along both axes. The last
/// rows before 90 degrees bend most.
#[test]
fn smooth_between_texels() {
    let table = Table::read(&manifest_path()).unwrap();
    let at = |c: usize, r: usize, i: usize| f64::from(table.texels()[8 * (r * 64 + c) + i]);
    let (mut worst, mut worst_inside) = (0.0_f64, 0.0_f64);
    for i in 0..6 {
        for r in 0..64 {
            for c in 0..64 {
                let here = at(c, r, i);
                let mut bend = 0.0_f64;
                if (1..63).contains(&c) {
                    bend = bend.max((at(c - 1, r, i) - 2.0 * here + at(c + 1, r, i)).abs());
                }
                if (1..63).contains(&r) {
                    bend = bend.max((at(c, r - 1, i) - 2.0 * here + at(c, r + 1, i)).abs());
                }
                worst = worst.max(bend);
                if r < 58 {
                    worst_inside = worst_inside.max(bend);
                }
            }
        }
    }
    println!("second differences: {worst:.4}, below row 58 {worst_inside:.4}");
    assert!(
        worst < 0.08 && worst_inside < 0.02,
        "{worst} {worst_inside}"
    );
}

/// A white surface in a white furnace reflects what the BRDF itself does; a lookup is finite and
/// positive anywhere.
#[test]
fn furnace_and_finiteness() {
    let table = Table::read(&manifest_path()).unwrap();
    let report = table.errors([0.1, 1.0], 99, 200, 8);
    println!("{report:?}");
    assert!(
        report.furnace[0] > 0.98 && report.furnace[1] < 1.01,
        "{:?}",
        report.furnace
    );
    let dielectric = report.dielectric_furnace;
    assert!(
        dielectric[0] > 0.95 && dielectric[1] < 1.02,
        "{dielectric:?}"
    );
    let mut whitest = 0.0_f64;
    for i in 0..=1000 {
        for j in 0..=100 {
            let ltc = table.lookup(f64::from(i) / 1000.0, f64::from(j) / 100.0);
            let determinant = ltc.shading_to_cosine().determinant();
            assert!(determinant > 0.0, "{i} {j}: {ltc:?}");
            // No energy is made, anywhere: amplitudes are at most 1, and so is the share.
            let share = ltc.share_above_horizon();
            let (white, schlick) = (ltc.amplitude * share, ltc.schlick * share);
            whitest = whitest.max(white);
            assert!(
                white > 0.0 && white < 1.0 + 1e-6,
                "{i} {j}: {white} {ltc:?}"
            );
            assert!(
                (0.0..=white).contains(&schlick),
                "{i} {j}: {schlick} {ltc:?}"
            );
        }
    }
    println!("largest albedo {whitest:.6}");
}
