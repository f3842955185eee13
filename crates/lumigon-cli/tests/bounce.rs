//! `lumigon bounce`, from the command line to the files it leaves.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}"))
}

fn bounce(scenes: &[&Path], arguments: &[&str], output: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .arg("bounce")
        .args(scenes)
        .args(arguments)
        .arg("-o")
        .arg(output)
        .output()
        .unwrap()
}

fn files(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut found = BTreeSet::new();
    for entry in entries.map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.file_type().unwrap().is_dir() {
            let below = files(&entry.path());
            found.extend(below.into_iter().map(|file| format!("{name}/{file}")));
        } else {
            found.insert(name);
        }
    }
    found
}

fn succeed(output: &Output) {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

fn metrics(report: &Path) -> Value {
    serde_json::from_slice(&fs::read(report.join("metrics.json")).unwrap()).unwrap()
}

#[test]
fn report_is_whole_and_its_numbers_hold() {
    let root = TempDir::new().unwrap();
    let report = root.path().join("report");
    let cornell = scene("cornell.glb");
    succeed(&bounce(
        &[&cornell],
        &["--quick", "--spp", "256", "--seed", "3"],
        &report,
    ));
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    let metrics = metrics(&report);
    let listed: BTreeSet<String> = serde_json::from_value(metrics["files"].clone()).unwrap();
    assert_eq!(files(&report), listed);
    let page = fs::read_to_string(report.join("index.html")).unwrap();
    for file in listed.iter().filter(|file| *file != "index.html") {
        assert!(page.contains(file.as_str()), "{file} is not in the page");
    }
    assert!(!page.contains("http:") && !page.contains("https:"));

    let errors = metrics["errors"].as_array().unwrap();
    let lines = fs::read_to_string(report.join("errors.csv")).unwrap();
    assert_eq!(lines.lines().count(), 1 + errors.len());
    for row in errors {
        assert!(
            row["lights"].as_u64() <= row["virtual_lights"].as_u64(),
            "{row}"
        );
        assert!(row["lights"].as_u64() > Some(0), "{row}");
        assert!(row["flux_error"].as_f64().unwrap() < 1e-4, "{row}");
        let rmse: Vec<f64> = serde_json::from_value(row["rmse"].clone()).unwrap();
        assert!(rmse.iter().all(|rmse| (0.0..2.0).contains(rmse)), "{row}");
    }
    let error = |variant: &str, against: usize| {
        let of = |row: &&Value| {
            row["variant"] == variant && row["virtual_lights"] == 64 && row["cube_size"] == 16
        };
        errors.iter().find(of).unwrap()["rmse"][against]
            .as_f64()
            .unwrap()
    };
    // Rays bring the light nearer to the truth than leaking does.
    assert!(error("rsm-shadowed", 2) < error("rsm", 2));

    let cost = metrics["cost"].as_array().unwrap();
    let texels = |row: &Value, way: &str| row[way][1].as_u64().unwrap();
    // One cube map sees as much whatever lights it; ten lights have ten maps.
    assert_eq!(texels(&cost[0], "cube_map"), texels(&cost[1], "cube_map"));
    let ratio = texels(&cost[1], "shadow_maps") as f64 / texels(&cost[0], "shadow_maps") as f64;
    assert!((8.0..12.0).contains(&ratio), "{ratio}");

    let flicker = metrics["flicker"].as_array().unwrap();
    let frame = |moving: &str, title: &str| {
        let of = |row: &&Value| row["moving"] == moving && row["title"] == title;
        flicker.iter().find(of).unwrap()["largest"]
            .as_f64()
            .unwrap()
    };
    assert!(frame("camera", "polygons, camera") > 0.0);
    // Cube maps that stay where they are see the same.
    assert_eq!(frame("camera", "polygons, scene"), 0.0);
    assert!(frame("light", "path traced, mean of all frames") > 0.0);
}

#[test]
fn scenes_without_light_or_surfaces_have_a_report() {
    let root = TempDir::new().unwrap();
    let empty = root.path().join("empty.gltf");
    fs::write(&empty, r#"{"asset":{"version":"2.0"}}"#).unwrap();
    let report = root.path().join("report");
    let sizes = ["--quick", "--size", "8x8", "--spp", "2"];
    succeed(&bounce(&[&empty, &empty], &sizes, &report));
    let metrics = metrics(&report);
    let errors = metrics["errors"].as_array().unwrap();
    assert!(
        errors
            .iter()
            .all(|row| row["rmse"][0].is_null() && row["lights"] == 0)
    );
    assert_ne!(metrics["scenes"][0]["name"], metrics["scenes"][1]["name"]);
    assert!(!metrics["warnings"].as_array().unwrap().is_empty());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let root = TempDir::new().unwrap();
    let none = root.path().join("none");
    let cornell = scene("cornell.glb");
    for arguments in [
        &["--size", "0x5"][..],
        &["--frames", "2"],
        &["--spp", "1"],
        &["--most-traced", "0"],
        &["--backend", "abacus"],
    ] {
        let output = bounce(&[&cornell], arguments, &none);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
    assert_eq!(bounce(&[], &["--quick"], &none).status.code(), Some(2));
    let missing = bounce(&[Path::new("no-such-scene.glb")], &["--quick"], &none);
    assert_eq!(missing.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("no-such-scene.glb"));
    let occupied = root.path().join("occupied");
    fs::create_dir(&occupied).unwrap();
    fs::write(occupied.join("thesis.txt"), "years").unwrap();
    let output = bounce(&[&cornell], &["--quick"], &occupied);
    assert_eq!(output.status.code(), Some(1));
    assert!(!none.exists());
}
