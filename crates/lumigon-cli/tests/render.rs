//! `lumigon render` and its neighbours as processes: files, exit codes, interruption.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

fn scene(name: &str) -> String {
    format!("{}/../../scenes/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn lumigon() -> Command {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
}

/// Runs the words of `line`, `{scene}` a scene and `{out}` a folder.
fn run(line: &str, folder: &Path) -> Output {
    let words = line.split_whitespace().map(|word| {
        word.replace("{scene}", &scene("cornell.glb"))
            .replace("{out}", folder.to_str().unwrap())
    });
    lumigon().args(words).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into())
        .collect();
    names.sort();
    names
}

/// The R, G and B channels of an EXR, which must be floats.
fn read_exr(path: &Path) -> [Vec<f32>; 3] {
    let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
    ["R", "G", "B"].map(|name| {
        let channels = &image.layer_data.channel_data.list;
        let channel = channels.iter().find(|c| c.name.eq(name)).unwrap();
        match &channel.sample_data {
            exr::prelude::FlatSamples::F32(samples) => samples.clone(),
            _ => panic!("{name} is not float"),
        }
    })
}

#[test]
fn pictures_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let output = run(
        "render {scene} -o {out}/a.exr --size 40x30 --samples 1",
        folder.path(),
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert_eq!(said.lines().count(), 1);
    assert!(said.contains("a.exr: 40x30 in ") && said.contains("polygon lights"));
    let channels = read_exr(&at("a.exr"));
    for channel in &channels {
        assert_eq!(channel.len(), 1200);
        assert!(channel.iter().all(|x| x.is_finite() && *x >= 0.0));
        assert!(channel.iter().sum::<f32>() > 1.0);
    }

    let output = run(
        "render {scene} -o {out}/b.png --size 40x30 --samples 1 --exposure -1 --tonemap none --threads 1",
        folder.path(),
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let png = image::open(at("b.png")).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (40, 30));
    let radiance: Vec<[f32; 3]> = (0..1200)
        .map(|i| [0, 1, 2].map(|c| channels[c][i]))
        .collect();
    let expected = lumigon_renderer::srgb8(&radiance, -1.0, lumigon_renderer::ToneMap::None);
    assert_eq!(png.into_raw(), expected);
    assert_eq!(
        names(folder.path()),
        [Path::new("a.exr"), Path::new("b.png")]
    );
}

#[test]
fn methods_and_the_reference_are_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let radiance = |arguments: &str| {
        let line =
            format!("render {{scene}} -o {{out}}/x.exr --size 24x24 --samples 1 {arguments}");
        let output = run(&line, folder.path());
        assert!(
            output.status.success(),
            "{arguments}: {}",
            text(&output.stderr)
        );
        read_exr(&folder.path().join("x.exr"))
    };
    let exact = radiance("");
    assert_eq!(
        exact,
        radiance("--diffuse exact --occlusion exact --specular ltc")
    );
    let mut seen = vec![exact];
    for arguments in [
        "--diffuse light-vector",
        "--occlusion circle",
        "--diffuse projected-area",
        "--diffuse projected-area --basis centroid",
        "--diffuse projected-area --basis weighted",
        "--diffuse projected-area --basis biased",
        "--diffuse projected-area --basis biased --bias 0.25",
        "--specular none",
        "--specular ltc-2",
        "--reference --spp 2 --no-shadows",
        "--reference --spp 2 --no-shadows --seed 5",
        "--reference --spp 2 --bounces 3",
        "--reference --spp 2 --bounces 3 --indirect",
        "--reference --spp 2 --bounces 3 --no-bounce-shadows",
    ] {
        let picture = radiance(arguments);
        assert!(!seen.contains(&picture), "{arguments}");
        assert_eq!(picture, radiance(&format!("{arguments} --threads 1")));
        seen.push(picture);
    }
}

#[test]
fn bounce_light_is_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let render = |arguments: &str| {
        let line =
            format!("render {{scene}} -o {{out}}/x.exr --size 24x24 --samples 1 {arguments}");
        let output = run(&line, folder.path());
        let errors = text(&output.stderr);
        assert!(output.status.success(), "{arguments}: {errors}");
        let [r, g, b] = read_exr(&folder.path().join("x.exr"));
        let finite = |x: &f32| x.is_finite() && *x >= 0.0;
        assert!(r.iter().chain(&g).chain(&b).all(finite), "{arguments}");
        ([r, g, b].concat(), text(&output.stdout).to_owned())
    };
    let lights = |said: &str| -> [usize; 2] {
        let (before, after) = said.trim_end().split_once(" virtual lights from ").unwrap();
        let count = before.rsplit(' ').next().unwrap();
        [count, after.split(' ').next().unwrap()].map(|number| number.parse().unwrap())
    };
    let sum = |picture: &[f32]| picture.iter().sum::<f32>();
    let (direct, said) = render("--backend cpu");
    assert_eq!(render("--bounce 0 --backend cpu").0, direct);
    assert!(!said.contains("virtual"), "{said}");

    let small = "--bounce 1 --cube-size 8 --virtual-lights 40 --bounce-from scene:1";
    let (both, said) = render(small);
    let [count, texels] = lights(&said);
    assert!(count > 0 && count <= 40, "{said}");
    assert!(texels > 100 && texels <= 6 * 64, "{said}");
    let (bounce, _) = render(&format!("{small} --bounce-only"));
    assert!(sum(&bounce) > 0.05 * sum(&direct), "{}", sum(&bounce));
    for ((both, direct), bounce) in both.iter().zip(&direct).zip(&bounce) {
        assert!((both - direct - bounce).abs() <= 1e-4 * (1.0 + both));
    }

    // Everything makes another picture, and none of them is black.
    let mut seen = vec![bounce];
    for arguments in [
        "--bounce 2 --bounce-from scene:1",
        "--bounce 1 --bounce-from scene:3",
        "--bounce 1 --bounce-from 0.1,0.45,-0.05",
        "--bounce 1 --bounce-from 0.1,0.45,0.1;0.45,0.2,0.1",
        "--bounce 1 --bounce-from scene:1 --virtual point",
        "--bounce 1 --bounce-from scene:1 --virtual point --virtual-clamp 2",
        "--bounce 1 --bounce-from scene:1 --bounce-visibility traced",
        "--bounce 1 --bounce-from scene:1 --bounce-shadows",
        "--bounce 1 --bounce-from scene:1 --no-merge",
        "--bounce 1 --bounce-method rsm",
    ] {
        let line = format!("{arguments} --cube-size 8 --virtual-lights 40 --bounce-only");
        let (picture, _) = render(&line);
        assert!(sum(&picture) > 0.0, "{arguments}");
        assert!(!seen.contains(&picture), "{arguments}");
        seen.push(picture);
    }
    let path = "--bounce 1 --bounce-only --bounce-method path --spp";
    let (traced, said) = render(&format!("{path} 64"));
    assert!(said.contains("64 paths a pixel"), "{said}");
    let ratio = sum(&traced) / sum(&seen[0]);
    assert!((0.6..1.6).contains(&ratio), "{ratio}");
    let (darker, _) = render(&format!(
        "{path} 64 --bounce-visibility traced --bounce-shadows"
    ));
    assert!(sum(&darker) < sum(&traced));

    let (view, said) = render(&format!("{small} --show-virtual-lights"));
    assert!(sum(&view) > 0.0 && view != both && lights(&said)[0] > 0);
    let (view, said) = render(&format!("{small} --virtual point --show-virtual-lights"));
    assert!(sum(&view) > 0.0 && lights(&said)[0] > 0);
}

#[test]
fn bounce_light_of_nothing_is_no_light() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("empty.gltf"), r#"{"asset":{"version":"2.0"}}"#).unwrap();
    let cornell = scene("cornell.glb");
    let empty = at("empty.gltf").into_os_string().into_string().unwrap();
    // Nothing to see; one texel a face; in a wall; out of the scene.
    for (scene, from) in [
        (&empty, "camera"),
        (&empty, "scene:3"),
        (&cornell, "camera"),
        (&cornell, "scene:1"),
        (&cornell, "0,0,0"),
        (&cornell, "1e6,-1e6,3"),
        (&cornell, "1e30,0,0"),
    ] {
        for more in [
            "",
            "--virtual point",
            "--bounce-visibility traced",
            "--no-merge --no-cluster",
            "--show-virtual-lights",
        ] {
            let picture = at("x.exr");
            let output = lumigon()
                .args(["render", scene, "-o", picture.to_str().unwrap()])
                .args(["--size", "8x8", "--samples", "1", "--bounce", "2"])
                .args(["--cube-size", "1", "--bounce-from", from])
                .args(more.split_whitespace())
                .output()
                .unwrap();
            let errors = text(&output.stderr);
            assert!(output.status.success(), "{from} {more}: {errors}");
            let finite = |x: &f32| x.is_finite() && *x >= 0.0;
            let channels = read_exr(&picture);
            assert!(channels.iter().flatten().all(finite), "{from} {more}");
        }
    }
}

#[test]
fn contradictions_are_refused_before_anything_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, expected) in [
        ("-o {out}/a.jpg", ".png or .exr"),
        ("-o {out}/png", ".png or .exr"),
        ("", "--output"),
        ("-o {out}/a.png --basis optimal", "--diffuse"),
        (
            "-o {out}/a.png --diffuse exact --basis optimal",
            "projected-area",
        ),
        (
            "-o {out}/a.png --diffuse projected-area --basis optimal --bias 1",
            "biased",
        ),
        (
            "-o {out}/a.png --diffuse projected-area --bias 1",
            "--basis",
        ),
        ("-o {out}/a.png --spp 4", "--reference"),
        ("-o {out}/a.png --bounces 4", "--reference"),
        ("-o {out}/a.png --seed 4", "--reference"),
        ("-o {out}/a.png --indirect", "--reference"),
        ("-o {out}/a.png --reference --indirect", "--bounces 2"),
        (
            "-o {out}/a.png --reference --indirect --bounces 1",
            "--bounces 2",
        ),
        (
            "-o {out}/a.png --reference --no-bounce-shadows",
            "--bounces 2",
        ),
        ("-o {out}/a.png --reference --specular ltc", "--reference"),
        ("-o {out}/a.png --bounce 17", "--bounce"),
        ("-o {out}/a.png --bounce-only", "--bounce 1 or more"),
        (
            "-o {out}/a.png --bounce 0 --virtual point",
            "--bounce 1 or more",
        ),
        ("-o {out}/a.png --reference --bounce 1", "--bounces"),
        ("-o {out}/a.png --bounce 1 --spp 9", "path"),
        ("-o {out}/a.png --bounce 1 --seed 9", "path"),
        (
            "-o {out}/a.png --bounce 1 --bounce-method path --cube-size 9",
            "--cube-size is of no use",
        ),
        (
            "-o {out}/a.png --bounce 1 --bounce-method rsm --bounce-from scene",
            "from the lights",
        ),
        (
            "-o {out}/a.png --bounce 1 --virtual-clamp 1",
            "--virtual point",
        ),
        (
            "-o {out}/a.png --bounce 1 --virtual point --virtual-clamp -1",
            "more than 0",
        ),
        (
            "-o {out}/a.png --bounce 1 --no-cluster --virtual-lights 9",
            "--no-cluster",
        ),
        ("-o {out}/a.png --bounce 1 --cube-size 513", "512"),
        (
            "-o {out}/a.png --bounce 1 --virtual-lights 0",
            "--virtual-lights",
        ),
        ("-o {out}/a.png --bounce 1 --bounce-from 1,2", "scene:N"),
        (
            "-o {out}/a.png --bounce 1 --bounce-from -1,2,inf",
            "scene:N",
        ),
        ("-o {out}/a.png --show-virtual-lights", "--bounce 1"),
        (
            "-o {out}/a.png --bounce 1 --bounce-method path --show-virtual-lights",
            "virtual lights",
        ),
        (
            "-o {out}/a.png --bounce 1 --bounce-only --show-virtual-lights",
            "cannot be used with",
        ),
        ("-o {out}/a.png --inclusion winding-number", "--specular"),
        (
            "-o {out}/a.png --specular ltc --inclusion winding-number",
            "reflected",
        ),
        ("-o {out}/a.png --field-phi 2", "--specular"),
        (
            "-o {out}/a.png --specular reflected --smoothness 2",
            "distance-field",
        ),
        (
            "-o {out}/a.png --specular distance-field --field-resolution 100",
            "power of two",
        ),
        (
            "-o {out}/a.png --specular distance-field --field-phi nan",
            "1 to 16",
        ),
        (
            "-o {out}/a.png --specular distance-field --smoothness -1",
            "more than 0",
        ),
        ("-o {out}/a.png --size 0x0", "1440x900"),
        ("-o {out}/a.png --samples 0", "--samples"),
        ("-o {out}/a.png --exposure NaN", "-100"),
        ("-o {out}/a.png --tonemap filmic", "khronos-pbr-neutral"),
        ("-o {out}/a.png --threads 0", "--threads"),
        ("-o {out}/a.png --no-such-option", "--no-such-option"),
    ] {
        let output = run(
            &format!("render no-such-scene.glb {arguments}"),
            folder.path(),
        );
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {message}");
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    assert!(names(folder.path()).is_empty());
}

#[test]
fn failures_name_the_file_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("old.png"), "old").unwrap();
    std::fs::write(folder.path().join("bad.glb"), "glTF, but not really").unwrap();
    for (line, expected) in [
        (
            "render no-such-scene.glb -o {out}/a.png",
            "no-such-scene.glb",
        ),
        ("render {out}/bad.glb -o {out}/old.png", "bad.glb"),
        ("render {scene} -o {out}/missing/a.png", "missing/a.png"),
        ("render {scene} -o {out}/old.png/a.png", "old.png/a.png"),
        (
            "render {scene} -o {out}/a.png --camera nobody",
            "\"nobody\"",
        ),
        ("scene info {out}/bad.glb", "bad.glb"),
        ("man {out}/old.png", "old.png"),
    ] {
        let output = run(line, folder.path());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains(expected), "{line}: {message}");
    }
    assert_eq!(
        names(folder.path()),
        [Path::new("bad.glb"), Path::new("old.png")]
    );
    let old = std::fs::read(folder.path().join("old.png")).unwrap();
    assert_eq!(old, b"old");
}

/// A limit on the size of files stands for a full disk: the write fails halfway.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_picture() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["old.png", "old.exr"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "old").unwrap();
        let output = Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 8; exec \"$@\"", "sh"])
            .arg(env!("CARGO_BIN_EXE_lumigon"))
            .args(["render", &scene("cornell.glb"), "--size", "200x200"])
            .args(["--samples", "1", "-o", path.to_str().unwrap()])
            .output()
            .unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(name), "{message}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(names(folder.path()).len(), 2);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    let gallery = scene("gallery.glb");
    let render = ["render", &gallery, "-o", picture.to_str().unwrap()];
    let render = [
        render.as_slice(),
        &["--size", "8000x8000", "--samples", "16"],
    ]
    .concat();
    let reference = [render.as_slice(), &["--reference", "--spp", "100000"]].concat();
    for arguments in [render, reference] {
        let mut child = lumigon().args(&arguments).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        assert!(child.try_wait().unwrap().is_none(), "not long enough");
        let start = Instant::now();
        let killed = Command::new("sh")
            .args(["-c", &format!("kill -INT {}", child.id())])
            .status()
            .unwrap();
        assert!(killed.success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert!(start.elapsed() < Duration::from_secs(20));
        assert!(names(folder.path()).is_empty());
    }
}

#[test]
fn scene_info_lists_the_lights() {
    let folder = tempfile::tempdir().unwrap();
    let output = run("scene info {scene} --json", folder.path());
    assert!(output.status.success());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let lights = report["polygon_lights"].as_array().unwrap();
    assert!(!lights.is_empty());
    for light in lights {
        assert!(light["area"].as_f64().unwrap() > 0.0);
        assert!(light["vertices"].as_u64().unwrap() >= 3);
        assert!(light["radiance"][0].as_f64().unwrap() >= 0.0);
    }
    assert!(report["triangles"].as_u64().unwrap() > 10);
    let output = run("scene info {scene}", folder.path());
    let listed = format!("{} polygon lights", lights.len());
    assert!(text(&output.stdout).contains(&listed));
}

#[test]
fn completions_and_manual_pages() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = run(&format!("completions {shell}"), folder.path());
        assert!(
            text(&output.stdout).contains("khronos-pbr-neutral"),
            "{shell}"
        );
    }
    assert!(text(&run("man", folder.path()).stdout).contains(".TH lumigon 1"));
    assert!(run("man {out}/man1", folder.path()).status.success());
    let pages = names(&folder.path().join("man1"));
    for page in ["lumigon.1", "lumigon-render.1", "lumigon-eval.1"] {
        assert!(pages.contains(&PathBuf::from(page)), "{pages:?}");
    }
}

/// Every subcommand has an example.
#[test]
fn help_has_examples() {
    for subcommand in [
        "render",
        "eval",
        "scene info",
        "fit ggx",
        "completions",
        "man",
    ] {
        let output = run(&format!("{subcommand} --help"), Path::new("."));
        let help = text(&output.stdout);
        assert!(help.contains(&format!("  lumigon {subcommand}")), "{help}");
    }
}
