//! `lumigon compare`, from the command line to the files it leaves.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn square() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/check/square.glb")
}

fn compare(scene: &Path, output: &Path, size: &str, spp: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .arg("compare")
        .arg(scene)
        .arg("-o")
        .arg(output)
        .args(["--size", size, "--spp", spp])
        .output()
        .unwrap()
}

fn succeed(output: &Output) {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
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

/// The values of all attributes of this name.
fn attributes<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let begin = format!("{name}=\"");
    html.match_indices(&begin)
        .map(|(at, _)| html[at + begin.len()..].split('"').next().unwrap())
        .collect()
}

#[test]
fn report_is_whole_and_its_numbers_hold() {
    let root = TempDir::new().unwrap();
    let report = root.path().join("report");
    succeed(&compare(&square(), &report, "96x60", "64"));
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    let metrics: Value =
        serde_json::from_slice(&fs::read(report.join("metrics.json")).unwrap()).unwrap();

    let z = &metrics["exact_diffuse_z_scores"];
    assert!((0.85..1.15).contains(&number(&z["rms"])), "{z}");
    assert!(number(&z["mean"]).abs() < 0.1, "{z}");
    assert!((0.95..1.05).contains(&number(&z["pooled_rms"])), "{z}");
    assert!(number(&z["pooled_mean"]).abs() < 3.0, "{z}");
    assert_eq!(number(&z["greatest_difference_without_error"]), 0.0);
    assert!(number(&z["count"]) > 5000.0);

    let methods = metrics["methods"].as_array().unwrap();
    let method = |id: &str| methods.iter().find(|m| m["id"] == id).unwrap();
    assert_eq!(methods.len(), 19);
    for method in methods {
        assert!(number(&method["rmse"]) > 0.0, "{method}");
        assert!((0.0..=1.0).contains(&number(&method["flip"])), "{method}");
        assert!(number(&method["seconds"]) > 0.0, "{method}");
        let [fastest, slowest] = [0, 1].map(|end| number(&method["seconds_range"][end]));
        assert!(fastest <= slowest && number(&method["repeats"]) >= 1.0);
        for picture in ["picture", "difference_picture"] {
            let path = report.join(method[picture].as_str().unwrap());
            let decoded = image::open(&path).unwrap();
            assert_eq!((decoded.width(), decoded.height()), (96, 60));
            assert!(path.with_extension("exr").exists());
        }
    }
    // Without a cosine the projected area is far off here; exact is not.
    let relative = |id: &str| number(&method(id)["relative_rmse"]);
    assert!(relative("projected-area-optimal") > 5.0 * relative("exact"));
    assert_eq!(number(&method("exact")["ratio_to_exact"]), 1.0);
    let noise = number(&metrics["references"][0]["diffuse_noise"]["rms_standard_error"]);
    let rmse = number(&method("exact")["rmse"]);
    assert!(noise > 0.0 && rmse < 1.1 * noise);

    let listed: BTreeSet<String> = serde_json::from_value(metrics["files"].clone()).unwrap();
    assert_eq!(listed, files(&report));

    let html = fs::read_to_string(report.join("index.html")).unwrap();
    assert!(!html.contains("http:") && !html.contains("https:"));
    let names = [
        "src",
        "href",
        "data-picture",
        "data-difference",
        "data-reference",
    ];
    let links: Vec<_> = names
        .iter()
        .flat_map(|name| attributes(&html, name))
        .collect();
    assert!(links.len() > 100);
    let ids: BTreeSet<_> = attributes(&html, "id").into_iter().collect();
    for link in links {
        match link.strip_prefix('#') {
            Some(id) => assert!(ids.contains(id), "{link}"),
            None => assert!(listed.contains(link), "{link}"),
        }
    }

    // Another run takes the report's place.
    succeed(&compare(&square(), &report, "8x5", "2"));
    let sheet = image::open(report.join("pictures/exact.png")).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (8, 5));
}

#[test]
#[cfg(unix)]
fn names_are_text_not_markup() {
    let root = TempDir::new().unwrap();
    let scene = root.path().join("<script>alert(1)<\u{2044}script>&\"'.glb");
    fs::copy(square(), &scene).unwrap();
    let report = root.path().join("report");
    succeed(&compare(&scene, &report, "8x5", "2"));
    let html = fs::read_to_string(report.join("index.html")).unwrap();
    assert!(!html.contains("<script>alert") && html.contains("alert(1)"));
}

#[test]
fn nothing_is_written_over() {
    let root = TempDir::new().unwrap();
    let folder = root.path().join("thesis");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("chapter-1.txt"), "years of work").unwrap();
    let output = compare(&square(), &folder, "8x5", "2");
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        error.contains("thesis") && error.contains("no earlier report"),
        "{error}"
    );
    assert_eq!(files(root.path()).len(), 1);

    let missing = compare(Path::new("no.glb"), &root.path().join("new"), "8x5", "2");
    assert_eq!(missing.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("no.glb"));
    assert_eq!(files(root.path()).len(), 1);
}

#[test]
fn bounce_light_has_its_sections() {
    let root = TempDir::new().unwrap();
    let report = root.path().join("report");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.glb");
    let output = Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .arg("compare")
        .arg(&scene)
        .arg("-o")
        .arg(&report)
        .args(["--size", "16x16", "--samples", "1", "--spp", "256"])
        .args(["--bounce", "--cube-size", "16", "--virtual-lights", "100"])
        .output()
        .unwrap();
    succeed(&output);
    let metrics: Value =
        serde_json::from_slice(&fs::read(report.join("metrics.json")).unwrap()).unwrap();
    let groups = metrics["bounce"]["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 3);
    for group in groups {
        for method in group["methods"].as_array().unwrap() {
            let lights = number(&method["virtual_lights"]);
            assert!((1.0..=100.0).contains(&lights), "{method}");
            assert!(number(&method["relative_flux_error"]) < 1e-4, "{method}");
            assert!(number(&method["gather_seconds"]) > 0.0, "{method}");
            let path = report.join(method["picture"].as_str().unwrap());
            assert_eq!(image::open(&path).unwrap().width(), 16);
        }
    }
    let rmse = |group: usize, id: &str| {
        let methods = groups[group]["methods"].as_array().unwrap();
        let method = methods.iter().find(|m| m["id"] == id).unwrap();
        number(&method["relative_rmse_beyond_noise"])
    };
    // Most of what is lit is seen; without rays light leaks.
    assert!(rmse(1, "bounce-polygon-traced") < 0.35);
    assert!(rmse(2, "bounce-polygon-shadowed") < rmse(2, "bounce-polygon-leaking"));
    let listed: BTreeSet<String> = serde_json::from_value(metrics["files"].clone()).unwrap();
    assert_eq!(listed, files(&report));
    let html = fs::read_to_string(report.join("index.html")).unwrap();
    let sources = attributes(&html, "src");
    assert!(sources.iter().all(|file| report.join(file).exists()));
    assert!(html.contains("Time to make them"));

    let refused = Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .arg("compare")
        .arg(&scene)
        .args(["-o", "none", "--cube-size", "16"])
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(2));
}
