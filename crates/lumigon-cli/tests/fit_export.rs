//! `lumigon fit export`, from the command line to the files it leaves.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

fn table() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables/ggx-64.json")
}

fn export(table: &Path, arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .args(["fit", "export"])
        .arg(table)
        .args(arguments)
        .arg("-o")
        .arg(folder)
        .output()
        .unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn the_shipped_table_in_every_format() {
    let root = TempDir::new().unwrap();
    let folder = root.path().join("made/here");
    let formats = "f32,f16,ktx2,dds,exr,rust,json";
    let output = export(&table(), &["--format", formats], &folder);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let expected = [
        "ggx-64.dds",
        "ggx-64.dds.json",
        "ggx-64.exr",
        "ggx-64.f16",
        "ggx-64.f16.json",
        "ggx-64.f32",
        "ggx-64.f32.json",
        "ggx-64.ktx2",
        "ggx-64.table.json",
        "ggx_64.rs",
    ];
    assert_eq!(names(&folder), expected);
    assert_eq!(
        String::from_utf8(output.stdout).unwrap().lines().count(),
        10
    );
    let raw = fs::read(folder.join("ggx-64.f32")).unwrap();
    assert_eq!(raw, fs::read(table().with_extension("f32")).unwrap());
    let full = fs::metadata(folder.join("ggx-64.ktx2")).unwrap().len();
    let output = export(&table(), &["--format", "ktx2", "--half"], &folder);
    assert!(output.status.success());
    let half = fs::metadata(folder.join("ggx-64.ktx2")).unwrap().len();
    // But for the padding before the numbers.
    assert!((full - half).abs_diff(raw.len() as u64 / 2) < 16);
}

#[test]
fn broken_tables_are_named_and_nothing_written() {
    let root = TempDir::new().unwrap();
    let folder = root.path().join("out");
    let refused = |table: &Path| {
        let output = export(table, &["--format", "exr"], &folder);
        assert_eq!(output.status.code(), Some(1));
        assert!(!folder.exists(), "nothing is written");
        String::from_utf8(output.stderr).unwrap()
    };
    let missing = refused(&root.path().join("no.json"));
    assert!(missing.contains("no.json"), "{missing}");
    let manifest = root.path().join("ggx-64.json");
    fs::copy(table(), &manifest).unwrap();
    let alone = refused(&manifest);
    assert!(alone.contains("ggx-64.f32"), "{alone}");
    let raw = fs::read(table().with_extension("f32")).unwrap();
    let place = manifest.with_extension("f32");
    fs::write(&place, &raw[..raw.len() - 4]).unwrap();
    let truncated = refused(&manifest);
    assert!(truncated.contains("bytes"), "{truncated}");
    let mut other = raw.clone();
    other[0] ^= 1;
    fs::write(&place, other).unwrap();
    let changed = refused(&manifest);
    assert!(changed.contains("SHA-256"), "{changed}");
    fs::write(&manifest, "{\"file\":").unwrap();
    let broken = refused(&manifest);
    assert!(broken.contains("ggx-64.json"), "{broken}");

    let output = export(&table(), &["--format", "bmp"], &folder);
    assert_eq!(output.status.code(), Some(2));
}
