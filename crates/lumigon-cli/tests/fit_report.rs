//! `lumigon fit report`, from the command line to the files it leaves.

mod tables;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use lumigon_fit::{BrdfKind, Settings};
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

/// A table fitted on integrals beside a coarse density fit: the report is whole, and its numbers
/// agree with what the table's own manifest says, which other code measured on other lights.
#[test]
fn report_is_whole_and_its_numbers_hold() {
    let root = TempDir::new().unwrap();
    let fine = Settings {
        size: 9,
        directions: 2000,
        samples: 64,
        ..Settings::default()
    };
    let coarse = Settings {
        size: 4,
        ..Settings::published()
    };
    let tables = root.path().join("tables");
    fs::create_dir(&tables).unwrap();
    let [table, baseline] = [fine, coarse].map(|settings| tables::write(&settings, &tables));
    let report = root.path().join("report");
    let paths = [&table, Path::new("--baseline"), &baseline];
    let arguments = ["fit", "report", "--lights", "32"];
    succeed(&lumigon(&arguments, &paths, &report));
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);

    let metrics = metrics(&report);
    let [rough, smooth] = [0, 1].map(|band| &metrics["bands"][band]);
    let stated = number(&metrics["table"]["manifest"]["errors"]["rmse"]);
    let measured = number(&rough["table"]["rmse"]);
    assert!(
        (0.5..2.0).contains(&(measured / stated)),
        "{measured} {stated}"
    );
    let [fitted, density] = ["table", "baseline"].map(|which| number(&rough[which]["rmse"]));
    assert!(fitted > 0.0 && fitted < 0.9 * density, "{fitted} {density}");
    let smooth = number(&smooth["table"]["rmse"]);
    assert!(smooth > 0.0 && smooth < 0.02, "{smooth}");
    assert!(number(&rough["lights"]) > 10_000.0);
    for end in [0, 1] {
        let furnace = number(&rough["table"]["furnace"][end]);
        assert!((0.9..1.1).contains(&furnace), "{furnace}");
    }
    for which in ["table", "baseline"] {
        let bounds = &metrics["second_differences"][which];
        let [rough, smooth] = ["rough", "smooth"].map(|range| number(&bounds[range]));
        assert!(rough > 0.0 && rough < 2.0 && smooth < 2.0, "{bounds}");
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
    let settings = Settings {
        size: 2,
        directions: 200,
        samples: 8,
        ..Settings::published()
    };
    let table = tables::write(&settings, root.path());
    let other = Settings {
        brdf: BrdfKind::Eon,
        ..settings
    };
    let other = tables::write(&other, root.path());
    let report = root.path().join("report");
    let refused = |paths: &[&Path], output: &Path| {
        let output = lumigon(&["fit", "report"], paths, output);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let missing = root.path().join("no.json");
    let with = |baseline| [table.as_path(), Path::new("--baseline"), baseline];
    assert!(refused(&[&missing], &report).contains("no.json"));
    assert!(refused(&with(&missing), &report).contains("no.json"));
    assert!(refused(&with(&other), &report).contains("another BRDF"));
    assert_eq!(files(root.path()).len(), 4);

    let thesis = root.path().join("thesis");
    fs::create_dir(&thesis).unwrap();
    fs::write(thesis.join("chapter-1.txt"), "years of work").unwrap();
    assert!(refused(&[&table], &thesis).contains("no earlier report"));
    assert_eq!(files(root.path()).len(), 5);
}
