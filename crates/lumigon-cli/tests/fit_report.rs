//! `lumigon fit report`, from the command line to the files it leaves.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn lumigon(arguments: &[&str], paths: &[&Path], output: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .args(arguments)
        .args(paths)
        .arg("-o")
        .arg(output)
        .output()
        .unwrap()
}

fn succeed(output: &Output) {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables/ggx-64.json")
}

/// Every file below `folder`, relative to it.
fn files(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
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

fn number(value: &Value) -> f64 {
    let number = value.as_f64();
    number.unwrap_or_else(|| panic!("{value} is no number"))
}

/// The shipped table beside a coarse density fit: the report is whole, and its numbers agree with
/// what the table's own manifest says, which other code measured on other lights.
#[test]
fn report_is_whole_and_its_numbers_hold() {
    let root = TempDir::new().unwrap();
    let coarse = root.path().join("coarse");
    let fit = ["fit", "ggx", "--size", "4", "--objective", "density"];
    succeed(&lumigon(&fit, &[], &coarse));
    let report = root.path().join("report");
    let baseline = coarse.join("ggx-4.json");
    let tables = [&shipped(), Path::new("--baseline"), &baseline];
    let arguments = ["fit", "report", "--lights", "32"];
    succeed(&lumigon(&arguments, &tables, &report));
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);

    let metrics = metrics(&report);
    let [rough, smooth] = [0, 1].map(|band| &metrics["bands"][band]);
    let stated = number(&metrics["table"]["manifest"]["errors"]["rmse"]);
    let measured = number(&rough["table"]["rmse"]);
    assert!(
        (0.4..2.5).contains(&(measured / stated)),
        "{measured} {stated}"
    );
    for band in [rough, smooth] {
        let [table, baseline] = ["table", "baseline"].map(|which| number(&band[which]["rmse"]));
        assert!(table > 0.0 && table < 0.7 * baseline, "{table} {baseline}");
        assert!(number(&band["lights"]) > 500.0);
    }
    for end in [0, 1] {
        let furnace = number(&rough["table"]["furnace"][end]);
        assert!((0.97..1.02).contains(&furnace), "{furnace}");
    }
    for which in ["table", "baseline"] {
        let bounds = &metrics["second_differences"][which];
        let [rough, smooth] = ["rough", "smooth"].map(|range| number(&bounds[range]));
        assert!(rough > 0.0 && rough < smooth && smooth < 2.0, "{bounds}");
    }
    let cells = metrics["cells"]["rmse"][1].as_array().unwrap();
    assert_eq!(cells.len(), 20 * 18);
    assert!(cells.iter().all(|cell| number(cell) < 1.0));

    let listed: BTreeSet<String> = serde_json::from_value(metrics["files"].clone()).unwrap();
    assert_eq!(listed, files(&report));
    let html = fs::read_to_string(report.join("index.html")).unwrap();
    assert!(!html.contains("http:") && !html.contains("https:"));
    let pictures = listed.iter().filter(|file| file.ends_with(".png"));
    for picture in pictures.clone() {
        assert!(html.contains(&format!("=\"{picture}\"")), "{picture}");
        let decoded = image::open(report.join(picture)).unwrap().to_rgb8();
        let colors: BTreeSet<[u8; 3]> = decoded.pixels().map(|pixel| pixel.0).collect();
        assert!(colors.len() > 30, "{picture} is empty");
    }
    assert_eq!(pictures.count(), 18);

    // Without a baseline one is fitted; the same arguments give the same report, in its place.
    let reports = [0, 1].map(|_| {
        let arguments = ["fit", "report", "--lights", "2"];
        succeed(&lumigon(&arguments, &[&baseline], &report));
        self::metrics(&report)
    });
    let made = &reports[0]["baseline"];
    assert_eq!(made["settings"]["objective"], "density");
    assert_eq!(number(&made["settings"]["size"]), 4.0);
    assert!(made["path"].is_null());
    assert_eq!(reports[0], reports[1]);
}

#[test]
fn broken_tables_are_named_and_nothing_written() {
    let root = TempDir::new().unwrap();
    let report = root.path().join("report");
    let refused = |paths: &[&Path], output: &Path| {
        let output = lumigon(&["fit", "report"], paths, output);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let missing = root.path().join("no.json");
    assert!(refused(&[&missing], &report).contains("no.json"));
    let baseline = [&shipped(), Path::new("--baseline"), &missing];
    assert!(refused(&baseline, &report).contains("no.json"));
    assert!(files(root.path()).is_empty());

    let thesis = root.path().join("thesis");
    fs::create_dir(&thesis).unwrap();
    fs::write(thesis.join("chapter-1.txt"), "years of work").unwrap();
    assert!(refused(&[&shipped()], &thesis).contains("no earlier report"));
    assert_eq!(files(root.path()).len(), 1);
}
