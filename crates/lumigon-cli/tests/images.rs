//! `lumigon images`, from the command line to the files it leaves.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn images(arguments: &[&str], output: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .args(["images", "--texels", "16", "--picture-side", "8"])
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

fn metrics(report: &Path) -> Value {
    serde_json::from_slice(&fs::read(report.join("metrics.json")).unwrap()).unwrap()
}

#[test]
fn report_is_whole_and_more_taps_are_better() {
    let root = TempDir::new().unwrap();
    let report = root.path().join("report");
    let output = images(&["--lights", "20"], &report);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metrics = metrics(&report);
    let listed: BTreeSet<String> = serde_json::from_value(metrics["files"].clone()).unwrap();
    assert_eq!(files(&report), listed);
    let page = fs::read_to_string(report.join("index.html")).unwrap();
    for file in listed.iter().filter(|file| *file != "index.html") {
        assert!(page.contains(file.as_str()), "{file} is not in the page");
    }
    // 3 counted kinds of textures at 20 places of 8 classes.
    let all = &metrics["tables"][0]["rows"][0];
    assert_eq!(all["samples"], 20 * 8 * 3);
    let rms: Vec<f64> = serde_json::from_value(all["rms"].clone()).unwrap();
    // Lookup, 1 x 1, 2 x 2, 3 x 3, 4 x 4.
    assert!(rms[2] < 0.6 * rms[0] && rms[4] < 0.4 * rms[0], "{rms:?}");
    let errors = fs::read_to_string(report.join("errors.csv")).unwrap();
    assert_eq!(errors.lines().count(), 1 + 20 * 8 * 4);

    // The same seed gives the same numbers, and replaces the report.
    let again = images(&["--lights", "20"], &report);
    assert!(again.status.success());
    assert_eq!(
        fs::read_to_string(report.join("errors.csv")).unwrap(),
        errors
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let root = TempDir::new().unwrap();
    let occupied = root.path().join("occupied");
    fs::create_dir(&occupied).unwrap();
    fs::write(occupied.join("thesis.txt"), "years").unwrap();
    let output = images(&[], &occupied);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("no earlier report"), "{message}");
    for arguments in [["--lights", "0"], ["--picture-side", "1"], ["--seed", "x"]] {
        let output = images(&arguments, &root.path().join("none"));
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
    let odd = Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .args(["images", "--texels", "100", "-o", "none"])
        .output()
        .unwrap();
    assert_eq!(odd.status.code(), Some(2));
    assert!(!root.path().join("none").exists());
}
