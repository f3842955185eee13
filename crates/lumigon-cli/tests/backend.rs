//! `--backend` and `lumigon gpu` as processes: the same picture from each, and what happens where
//! there is no GPU.

use std::path::Path;
use std::process::{Command, Output};

const MEND: &str = "these tests need a Vulkan driver, such as Debian's mesa-vulkan-drivers";

fn scene(name: &str) -> String {
    format!("{}/../../scenes/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn command(line: &str, folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumigon"));
    command.args(line.split_whitespace().map(|word| {
        word.replace("{cornell}", &scene("cornell.glb"))
            .replace("{gallery}", &scene("gallery.glb"))
            .replace("{out}", folder.to_str().unwrap())
    }));
    command
}

fn run(line: &str, folder: &Path) -> Output {
    command(line, folder).output().unwrap()
}

/// On a machine whose Vulkan finds no driver.
fn run_without_gpu(line: &str, folder: &Path) -> Output {
    command(line, folder)
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn read_png(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}

/// Pixels that differ by more than 1/255 although the four around them do not differ among
/// themselves: silhouettes are where they do.
fn differing_off_silhouettes(a: &image::RgbImage, b: &image::RgbImage) -> Vec<(u32, u32)> {
    assert_eq!(a.dimensions(), b.dimensions());
    let (width, height) = a.dimensions();
    let apart =
        |p: &image::Rgb<u8>, q: &image::Rgb<u8>| (0..3).map(|c| p[c].abs_diff(q[c])).max().unwrap();
    let mut differing = Vec::new();
    for (x, y, pixel) in a.enumerate_pixels() {
        let around = [
            (x.saturating_sub(1), y),
            ((x + 1).min(width - 1), y),
            (x, y.saturating_sub(1)),
            (x, (y + 1).min(height - 1)),
        ];
        let on_silhouette = around
            .iter()
            .any(|&(x, y)| apart(pixel, a.get_pixel(x, y)) > 16);
        if !on_silhouette && apart(pixel, b.get_pixel(x, y)) > 1 {
            differing.push((x, y));
        }
    }
    differing
}

#[test]
fn every_backend_renders_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["cornell", "gallery"] {
        let render = |backend: &str| {
            let line = format!(
                "render {{{scene}}} -o {{out}}/{backend}.png --size 96x60 --samples 2 --backend {backend}"
            );
            let output = run(&line, folder.path());
            assert!(output.status.success(), "{MEND}: {}", text(&output.stderr));
            let said = text(&output.stdout).to_owned();
            (
                read_png(&folder.path().join(format!("{backend}.png"))),
                said,
            )
        };
        let (cpu, said) = render("cpu");
        assert!(said.contains(" on the CPU, "), "{said}");
        let (gpu, said) = render("gpu");
        assert!(said.contains(" on the GPU "), "{said}");
        assert_eq!(differing_off_silhouettes(&cpu, &gpu), [], "{scene}");
        let (auto, said) = render("auto");
        let no_gpu = " on the CPU (there is no hardware GPU), ";
        let chose = said.contains(" on the GPU ") || said.contains(no_gpu);
        assert!(chose, "{said}");
        assert_eq!(differing_off_silhouettes(&cpu, &auto), [], "{scene}");
    }
}

/// The light bound leaves out what is too dim to matter, and 0 nothing.
#[test]
fn light_bounds_are_bounds() {
    let folder = tempfile::tempdir().unwrap();
    let render = |arguments: &str| {
        let line = format!(
            "render {{cornell}} -o {{out}}/x.exr --size 48x36 --samples 1 --backend gpu {arguments}"
        );
        let output = run(&line, folder.path());
        assert!(output.status.success(), "{MEND}: {}", text(&output.stderr));
        let image = exr::prelude::read_first_rgba_layer_from_file(
            folder.path().join("x.exr"),
            |size, _| vec![[0.0_f32; 3]; size.area()],
            |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| {
                pixels[at.y() * 48 + at.x()] = [r, g, b];
            },
        );
        image.unwrap().layer_data.channel_data.pixels
    };
    let exact = render("");
    assert_eq!(exact, render("--light-bound 0"));
    let sum = |picture: &[[f32; 3]]| picture.iter().flatten().sum::<f32>();
    let dark = render("--light-bound 1e30");
    assert!(sum(&dark) < 0.9 * sum(&exact), "no light adds 1e30");
    let bound = 1e-3;
    let bounded = render(&format!("--light-bound {bound}"));
    for (a, b) in exact.iter().flatten().zip(bounded.iter().flatten()) {
        // One light, and its diffuse and specular light apart.
        assert!((a - b).abs() <= 2.0 * bound, "{a} {b}");
    }
}

#[test]
fn without_a_gpu_the_cpu_renders_or_nothing_does() {
    let folder = tempfile::tempdir().unwrap();
    let line = "render {cornell} -o {out}/x.png --size 24x18 --samples 1 --backend";
    let output = run_without_gpu(&format!("{line} gpu"), folder.path());
    assert_eq!(output.status.code(), Some(1));
    let fault = text(&output.stderr);
    assert!(fault.contains("there is no GPU"), "{fault}");
    assert!(fault.contains("mesa-vulkan-drivers"), "{fault}");
    assert!(!folder.path().join("x.png").exists());

    for line in [format!("{line} auto"), line.replace(" --backend", "")] {
        let output = run_without_gpu(&line, folder.path());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let said = text(&output.stdout);
        let no_gpu = " on the CPU (there is no hardware GPU), ";
        assert!(said.contains(no_gpu), "{said}");
        assert_eq!(said.lines().count(), 1);
        assert!(!text(&output.stderr).contains("warning"), "{line}");
        std::fs::remove_file(folder.path().join("x.png")).unwrap();
    }

    for line in ["bench --backend gpu", "gpu check {cornell}"] {
        let output = run_without_gpu(line, folder.path());
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(text(&output.stderr).contains("there is no GPU"), "{line}");
    }
}

#[test]
fn contradictions_and_unknown_backends_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, fault) in [
        ("--backend tpu", "[possible values: auto, cpu, gpu]"),
        ("--backend gpu --reference", "--reference runs on the CPU"),
        ("--light-bound -1", "not negative"),
        ("--light-bound nan", "not negative"),
        ("--light-bound 0.1 --reference", "cannot be used with"),
    ] {
        let line = format!("render {{cornell}} -o {{out}}/x.png --size 8x8 {arguments}");
        let output = run(&line, folder.path());
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        let said = text(&output.stderr);
        assert!(said.contains(fault), "{arguments}: {said}");
        assert!(!folder.path().join("x.png").exists());
    }
    for line in [
        "bench --backend gpu --only kernels",
        "bench --markdown {out}/x.md",
    ] {
        let output = run(line, folder.path());
        assert_eq!(output.status.code(), Some(2), "{line}");
    }
}

#[test]
fn gpus_are_listed_or_said_to_be_missing() {
    let folder = tempfile::tempdir().unwrap();
    let output = run("gpu info", folder.path());
    assert!(output.status.success());
    let said = text(&output.stdout);
    assert!(said.contains("  0: "), "{MEND}: {said}");
    let backends = |said: &str| {
        let lines = said.lines().filter_map(|l| l.strip_prefix("--backend "));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let [auto, gpu] = &backends(said)[..] else {
        panic!("{said}");
    };
    assert!(
        auto.starts_with("auto: ") && gpu.starts_with("gpu: "),
        "{said}"
    );
    assert!(!gpu.contains("nothing"), "{said}");

    let output = run("gpu info --json", folder.path());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let name = report["gpus"][0]["name"].as_str().unwrap();
    assert!(said.contains(name));
    assert_eq!(report["gpu"]["gpu"], name);

    let output = run_without_gpu("gpu info", folder.path());
    assert!(output.status.success());
    let said = text(&output.stdout);
    assert!(said.starts_with("no GPUs\n"), "{said}");
    assert!(said.contains("mesa-vulkan-drivers"), "{said}");
    let [auto, gpu] = &backends(said)[..] else {
        panic!("{said}");
    };
    assert!(auto.starts_with("auto: the CPU, for "), "{said}");
    assert!(gpu.starts_with("gpu: nothing, for "), "{said}");
}

#[test]
fn the_gpu_is_checked_against_the_cpu() {
    let folder = tempfile::tempdir().unwrap();
    let line = "gpu check {cornell} {gallery} --size 96x60 --json {out}/check.json";
    let output = run(line, folder.path());
    assert!(output.status.success(), "{MEND}: {}", text(&output.stderr));
    let bytes = std::fs::read(folder.path().join("check.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    let scenes = report["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), 2);
    for scene in scenes {
        assert_eq!(scene["same"], true);
        for difference in [scene, &scene["bounce_light"]] {
            assert!(difference["greatest_byte"].as_u64().unwrap() <= 1);
            assert!(difference["relative_rmse"].as_f64().unwrap() <= 1e-4);
        }
    }
    let output = run("gpu check {out}/nothing.glb", folder.path());
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("nothing.glb"));
}
