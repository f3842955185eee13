//! `lumigon fit export`, from the command line to the files it leaves.

mod tables;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use lumigon_fit::{BrdfKind, Settings};
use tempfile::TempDir;

/// A table of two axes or of four; how well it fits doesn't matter here.
fn table(brdf: BrdfKind, folder: &Path) -> PathBuf {
    let settings = Settings {
        brdf,
        size: 4,
        directions: 200,
        samples: 8,
        ..Settings::published()
    };
    tables::write(&settings, folder)
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
fn tables_in_every_format() {
    let root = TempDir::new().unwrap();
    for (brdf, name, module) in [
        (BrdfKind::Ggx, "ggx-4", "ggx_4"),
        (
            BrdfKind::GgxAnisotropic,
            "ggx-anisotropic-4",
            "ggx_anisotropic_4",
        ),
    ] {
        let table = table(brdf, root.path());
        let folder = root.path().join("made").join(name);
        let formats = "f32,f16,ktx2,dds,exr,rust,json";
        let output = export(&table, &["--format", formats], &folder);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        let mut expected: Vec<String> = [
            "dds",
            "dds.json",
            "exr",
            "f16",
            "f16.json",
            "f32",
            "f32.json",
            "ktx2",
            "table.json",
        ]
        .map(|ending| format!("{name}.{ending}"))
        .into();
        expected.push(format!("{module}.rs"));
        expected.sort();
        assert_eq!(names(&folder), expected);
        assert_eq!(
            String::from_utf8(output.stdout).unwrap().lines().count(),
            10
        );
        let raw = fs::read(folder.join(format!("{name}.f32"))).unwrap();
        assert_eq!(raw, fs::read(table.with_extension("f32")).unwrap());
        let length = || {
            fs::metadata(folder.join(format!("{name}.ktx2")))
                .unwrap()
                .len()
        };
        let full = length();
        let output = export(&table, &["--format", "ktx2", "--half"], &folder);
        assert!(output.status.success());
        // But for the padding before the numbers.
        assert!((full - length()).abs_diff(raw.len() as u64 / 2) < 16);
    }
}

#[test]
fn broken_tables_are_named_and_nothing_written() {
    let root = TempDir::new().unwrap();
    let folder = root.path().join("out");
    let manifest = table(BrdfKind::Ggx, root.path());
    let refused = |table: &Path| {
        let output = export(table, &["--format", "exr"], &folder);
        assert_eq!(output.status.code(), Some(1));
        assert!(!folder.exists(), "nothing is written");
        String::from_utf8(output.stderr).unwrap()
    };
    let missing = refused(&root.path().join("no.json"));
    assert!(missing.contains("no.json"), "{missing}");
    let place = manifest.with_extension("f32");
    let raw = fs::read(&place).unwrap();
    fs::write(&place, &raw[..raw.len() - 4]).unwrap();
    let truncated = refused(&manifest);
    assert!(
        truncated.contains("ggx-4.f32") && truncated.contains("bytes"),
        "{truncated}"
    );
    let mut other = raw.clone();
    other[0] ^= 1;
    fs::write(&place, other).unwrap();
    let changed = refused(&manifest);
    assert!(changed.contains("SHA-256"), "{changed}");
    fs::remove_file(&place).unwrap();
    let alone = refused(&manifest);
    assert!(alone.contains("ggx-4.f32"), "{alone}");
    fs::write(&manifest, "{\"file\":").unwrap();
    let broken = refused(&manifest);
    assert!(broken.contains("ggx-4.json"), "{broken}");

    let output = export(&manifest, &["--format", "bmp"], &folder);
    assert_eq!(output.status.code(), Some(2));
}
