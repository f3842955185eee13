//! `lumigon fit BRDF`, from the command line to the files it leaves.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use lumigon_fit::{BrdfKind, Manifest, Settings, Table};
use tempfile::TempDir;

fn command(arguments: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumigon"));
    command.arg("fit").args(arguments).arg("-o").arg(folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn fit(arguments: &[&str], folder: &Path) -> Output {
    command(arguments, folder).output().unwrap()
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Ctrl-C leaves an unfinished fit, from which the same command makes the very same table.
#[cfg(unix)]
#[test]
fn interrupted_fit_resumes_to_the_same_bytes() {
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    let root = TempDir::new().unwrap();
    let arguments = ["eon", "--size", "5", "--seed", "3"];
    let (whole, stopped) = (root.path().join("whole"), root.path().join("stopped"));
    // What cannot be gone on with is refused, and replaced where that is asked for.
    fs::create_dir(&whole).unwrap();
    fs::write(whole.join("eon-5.unfinished.json"), "{").unwrap();
    let output = fit(&arguments, &whole);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("eon-5.unfinished.json: ") && errors.contains("--fresh"));
    assert_eq!(names(&whole).len(), 1);
    let output = fit(&[&arguments[..], &["--fresh"]].concat(), &whole);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let expected: BTreeSet<_> = ["eon-5.f32", "eon-5.json"].map(str::to_owned).into();
    assert_eq!(names(&whole), expected);

    let unfinished = stopped.join("eon-5.unfinished.json");
    let (mut interruptions, mut wait) = (0, Duration::from_millis(100));
    let last = loop {
        let child = command(&arguments, &stopped).spawn().unwrap();
        // It is there as soon as there is anything to interrupt.
        let start = Instant::now();
        while !unfinished.exists() {
            assert!(start.elapsed() < Duration::from_secs(60));
            sleep(Duration::from_millis(5));
        }
        // Later each time, and then not at all.
        if interruptions < 3 {
            sleep(wait);
            wait *= 2;
            let kill = format!("kill -INT {}", child.id());
            let _ = Command::new("sh").args(["-c", &kill]).output().unwrap();
        }
        let output = child.wait_with_output().unwrap();
        if output.status.success() {
            break output;
        }
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{errors}");
        assert!(errors.contains("lumigon: interrupted"), "{errors}");
        assert!(unfinished.exists(), "{errors}");
        assert!(!stopped.join("eon-5.f32").exists());
        interruptions += 1;
    };
    assert!(interruptions > 0);
    let errors = text(&last.stderr);
    assert!(
        errors.contains("eon-5.unfinished.json: going on"),
        "{errors}"
    );
    assert_eq!(names(&stopped), expected);
    for name in expected {
        let [one, other] = [&whole, &stopped].map(|folder| fs::read(folder.join(&name)).unwrap());
        assert!(one == other, "{name}");
    }

    let manifest = Manifest::read(&whole.join("eon-5.json")).unwrap();
    let remakes = "lumigon fit eon --lobes 1 --size 5 --objective integral --seed 3 -o tables";
    assert_eq!(manifest.command, remakes);
    let settings = Settings {
        size: 5,
        seed: 3,
        ..Settings::of(BrdfKind::Eon, 1)
    };
    assert_eq!(
        Table::read(&whole.join("eon-5.json")).unwrap().settings(),
        &settings
    );
}

#[test]
fn impossible_combinations_are_usage_errors() {
    let root = TempDir::new().unwrap();
    let folder = root.path().join("tables");
    for (arguments, expected) in [
        (&["ggx-anisotropic", "--lobes", "2"][..], "lobes is 2"),
        (&["ggx", "--lobes", "3"], "lobes is 3"),
        (&["ggx", "--size", "1"], "size is 1"),
        (&["ggx-anisotropic", "--size", "65"], "choose 2 to 64"),
        (
            &["phong"],
            "possible values: ggx, ggx-anisotropic, charlie, eon",
        ),
        (
            &["ggx", "--objective", "beauty"],
            "possible values: density, integral",
        ),
        (&[], "<BRDF>"),
    ] {
        let output = fit(arguments, &folder);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
        assert!(errors.contains(expected), "{errors}");
        assert!(!folder.exists());
    }
    let nowhere = root.path().join("file");
    fs::write(&nowhere, "no folder").unwrap();
    let output = fit(&["ggx"], &nowhere);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("file"));
}
