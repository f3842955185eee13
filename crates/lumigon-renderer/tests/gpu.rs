//! The GPU backend's pictures are the CPU's.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use glam::Vec3;
use lumigon_renderer::{
    Camera, CpuRenderer, Gpu, GpuPreference, GpuRenderer, Pixels, RenderSettings, Rendering, Scene,
    Watch,
};

static GPU: LazyLock<Gpu> = LazyLock::new(|| {
    Gpu::new(GpuPreference::Any).unwrap_or_else(|fault| panic!("these tests need a GPU: {fault}"))
});

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let files = std::fs::read_dir(&folder).unwrap();
    let mut scenes: Vec<_> = files
        .map(|file| file.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "glb"))
        .collect();
    scenes.sort();
    assert!(!scenes.is_empty(), "no scenes in {}", folder.display());
    scenes
}

fn settings(width: u32, height: u32, samples: u32) -> RenderSettings {
    RenderSettings {
        width,
        height,
        samples,
        ..RenderSettings::default()
    }
}

/// Materials that reflect diffusely alone.
fn diffuse_alone(scene: &mut Scene) {
    for material in &mut scene.materials {
        material.specular = 0.0;
        material.clearcoat = 0.0;
        material.sheen_color = Vec3::ZERO;
        material.diffuse_roughness = 0.0;
    }
}

fn camera(scene: &Scene) -> Camera {
    let first = scene.cameras.first().cloned();
    first.unwrap_or_else(|| Camera::framing(scene))
}

fn both(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> [Rendering; 2] {
    let cpu = CpuRenderer::new(scene);
    let gpu = GpuRenderer::new(&GPU, scene).unwrap();
    let t = std::time::Instant::now();
    let a = gpu.render(camera, settings, Watch::none()).unwrap();
    let t1 = t.elapsed();
    gpu.render(camera, settings, Watch::none()).unwrap();
    println!("{t1:?} {:?} {:?}", t.elapsed() - t1, gpu.timings());
    [
        cpu.render(camera, settings, Watch::none()).unwrap(),
        a
    ]
}

/// Pixels that differ, and the relative root mean square of the differences of the others.
fn differences(cpu: &Pixels, gpu: &Pixels) -> (usize, f64) {
    assert_eq!(cpu.len(), gpu.len());
    let mut differing = 0;
    let (mut squared, mut scale) = (0.0, 0.0);
    for (c, g) in cpu.iter().zip(gpu) {
        let off = (0..3)
            .map(|i| (c[i] - g[i]).abs() / (1.0 + c[i].abs()))
            .fold(0.0, f32::max);
        assert!(g.iter().all(|x| x.is_finite()));
        if off > 0.5 / 255.0 {
            differing += 1;
            continue;
        }
        for i in 0..3 {
            squared += f64::from(c[i] - g[i]).powi(2);
            scale += f64::from(c[i]).powi(2);
        }
    }
    (differing, (squared / f64::max(scale, 1e-30)).sqrt())
}

#[test]
fn first_picture() {
    for path in scenes() {
        let mut scene = Scene::load(&path).unwrap();
        if std::env::var_os("DIFFUSE").is_some() {
            diffuse_alone(&mut scene);
        }
        let [cpu, gpu] = both(&scene, &camera(&scene), &settings(96, 64, 2));
        for (name, cpu, gpu) in [
            ("emitted", &cpu.emitted, &gpu.emitted),
            ("diffuse", &cpu.diffuse, &gpu.diffuse),
            ("specular", &cpu.specular, &gpu.specular),
        ] {
            let (differing, rmse) = differences(cpu, gpu);
            println!("{} {name}: {differing} {rmse:e}", path.display());

        }
    }
}
