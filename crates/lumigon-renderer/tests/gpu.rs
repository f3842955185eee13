//! The GPU backend's pictures are the CPU's.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};

use glam::{Affine3A, Vec2, Vec3, Vec4};
use lumigon::{
    DiffuseMethod, DistanceFieldSettings, DistanceFieldSmoothness, ImageMethod, InclusionRule,
    LocalOcclusion, LtcLobes, ProjectionBasis, SpecularMethod,
};
use lumigon_renderer::{
    AlphaMode, Camera, CpuRenderer, EmissivePolygon, Filter, Gpu, GpuPreference, GpuRenderer,
    ImageColors, ImageFile, Limits, Material, Mesh, Pixels, Projection, PunctualKind,
    PunctualLight, RenderError, RenderSettings, Rendering, Sampler, Scene, Texture, TextureRef,
    ToneMap, Watch, Wrap, srgb8,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

static GPU: LazyLock<Gpu> = LazyLock::new(|| {
    Gpu::new(GpuPreference::Any).unwrap_or_else(|fault| panic!("these tests need a GPU: {fault}"))
});

fn scene_files() -> Vec<PathBuf> {
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

fn load(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::load(folder.join(name)).unwrap()
}

fn distances(resolution: u32, smoothness: DistanceFieldSmoothness) -> SpecularMethod {
    let field = DistanceFieldSettings::new(resolution, 2.0, false).unwrap();
    SpecularMethod::ReflectedDistanceField { field, smoothness }
}

fn small(samples: u32) -> RenderSettings {
    RenderSettings {
        width: 96,
        height: 64,
        samples,
        ..RenderSettings::default()
    }
}

fn camera(scene: &Scene) -> Camera {
    let first = scene.cameras.first().cloned();
    first.unwrap_or_else(|| Camera::framing(scene))
}

fn gpu_picture(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Rendering {
    let renderer = GpuRenderer::new(&GPU, scene).unwrap();
    renderer.render(camera, settings, Watch::none()).unwrap()
}

fn cpu_picture(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Rendering {
    let renderer = CpuRenderer::new(scene);
    renderer.render(camera, settings, Watch::none()).unwrap()
}

/// Asserts that two pictures are the same but for so many pixels, which edges cross: there, rays and
/// rasters may see different triangles.
fn assert_same(name: &str, cpu: &Rendering, gpu: &Rendering, on_edges: usize) {
    assert_eq!((cpu.width, cpu.height), (gpu.width, gpu.height), "{name}");
    for (part, cpu, gpu) in [
        ("emitted", &cpu.emitted, &gpu.emitted),
        ("diffuse", &cpu.diffuse, &gpu.diffuse),
        ("specular", &cpu.specular, &gpu.specular),
        ("radiance", &cpu.radiance(), &gpu.radiance()),
    ] {
        let (bytes, error) = difference(cpu, gpu, on_edges);
        assert!(
            bytes <= 1 && error <= 1e-4,
            "{name}, {part}: bytes differ by {bytes}, radiance by {error:e}"
        );
    }
}

/// The greatest difference of any byte and the relative root mean square of the differences in
/// radiance, of all pixels but the `on_edges` worst ones.
fn difference(cpu: &Pixels, gpu: &Pixels, on_edges: usize) -> (u8, f64) {
    let bytes = [cpu, gpu].map(|pixels| srgb8(pixels, 0.0, ToneMap::None));
    let mut pixels: Vec<(f64, u8)> = (0..cpu.len())
        .map(|i| {
            let squares = (0..3).map(|c| f64::from(cpu[i][c] - gpu[i][c]).powi(2));
            let of_bytes = (3 * i..3 * i + 3).map(|i| bytes[0][i].abs_diff(bytes[1][i]));
            (squares.sum(), of_bytes.max().unwrap())
        })
        .collect();
    pixels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let rest = pixels.get(on_edges..).unwrap_or_default();
    let squared: f64 = rest.iter().map(|pixel| pixel.0).sum();
    let scale: f64 = cpu.iter().flatten().map(|&x| f64::from(x).powi(2)).sum();
    let worst = rest.iter().map(|pixel| pixel.1).max().unwrap_or(0);
    (worst, (squared / scale.max(1e-30)).sqrt())
}

fn lit(picture: &Rendering) -> usize {
    let radiance = picture.radiance();
    radiance.iter().filter(|pixel| **pixel != [0.0; 3]).count()
}

#[test]
fn every_scene_looks_as_on_the_cpu() {
    for path in scene_files() {
        let scene = Scene::load(&path).unwrap();
        let camera = camera(&scene);
        let cpu = cpu_picture(&scene, &camera, &small(2));
        let gpu = gpu_picture(&scene, &camera, &small(2));
        // Direct light is seen through the doorway alone in two-rooms.glb.
        assert!(lit(&cpu) > 96 * 64 / 10, "{}", path.display());
        assert_same(&path.display().to_string(), &cpu, &gpu, 12);
    }
}

#[test]
fn every_method_looks_as_on_the_cpu() {
    let scene = load("cornell.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let cpu = CpuRenderer::new(&scene);
    let (exact, circle) = (LocalOcclusion::Exact, LocalOcclusion::Circle);
    let projected = |basis, occlusion| DiffuseMethod::ProjectedArea { basis, occlusion };
    let diffuse = [
        DiffuseMethod::Exact { occlusion: circle },
        DiffuseMethod::LightVector { occlusion: exact },
        DiffuseMethod::LightVector { occlusion: circle },
        projected(ProjectionBasis::Centroid, exact),
        projected(ProjectionBasis::Weighted, exact),
        projected(ProjectionBasis::Biased { bias: 0.3 }, exact),
        projected(ProjectionBasis::Optimal, circle),
    ]
    .map(|diffuse| (diffuse, SpecularMethod::None));
    let specular = [
        SpecularMethod::Ltc {
            lobes: LtcLobes::Two,
        },
        SpecularMethod::ReflectedInclusion(InclusionRule::CrossingNumber),
        SpecularMethod::ReflectedInclusion(InclusionRule::WindingNumber),
        SpecularMethod::LightVector,
        distances(64, DistanceFieldSmoothness::default()),
        distances(16, DistanceFieldSmoothness::fixed(2.0).unwrap()),
    ]
    .map(|specular| (DiffuseMethod::default(), specular));
    for (diffuse, specular) in diffuse.into_iter().chain(specular) {
        let settings = RenderSettings {
            width: 48,
            height: 32,
            diffuse,
            specular,
            ..small(1)
        };
        let cpu = cpu.render(&camera, &settings, Watch::none()).unwrap();
        let gpu = renderer.render(&camera, &settings, Watch::none()).unwrap();
        assert_same(&format!("{diffuse:?} {specular:?}"), &cpu, &gpu, 6);
    }
}

/// Both backends refuse fields over their budget, and go on with what fits.
#[test]
fn distance_fields_have_a_budget() {
    let scene = load("cornell.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let cpu = CpuRenderer::new(&scene);
    let settings = |resolution, distance_field_budget| RenderSettings {
        specular: distances(resolution, DistanceFieldSmoothness::default()),
        distance_field_budget,
        ..small(1)
    };
    for (resolution, budget, fits) in [(64, 1 << 20, true), (64, 100, false), (32, 1 << 20, true)] {
        let settings = settings(resolution, budget);
        for rendering in [
            cpu.render(&camera, &settings, Watch::none()),
            renderer.render(&camera, &settings, Watch::none()),
        ] {
            match rendering {
                Ok(_) => assert!(fits),
                Err(fault) => {
                    let message = fault.to_string();
                    assert!(!fits && message.contains("budget is 100"), "{message}");
                }
            }
        }
    }
}

/// Every layer has its own way through every method.
#[test]
fn every_layer_looks_as_on_the_cpu_by_every_method() {
    let scene = load("materials.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let cpu = CpuRenderer::new(&scene);
    let occlusion = LocalOcclusion::Exact;
    for (diffuse, specular) in [
        (
            DiffuseMethod::default(),
            SpecularMethod::Ltc {
                lobes: LtcLobes::Two,
            },
        ),
        (
            DiffuseMethod::LightVector { occlusion },
            SpecularMethod::LightVector,
        ),
        (
            DiffuseMethod::ProjectedArea {
                basis: ProjectionBasis::Optimal,
                occlusion,
            },
            SpecularMethod::ReflectedInclusion(InclusionRule::CrossingNumber),
        ),
        (
            DiffuseMethod::default(),
            distances(64, DistanceFieldSmoothness::default()),
        ),
    ] {
        let settings = RenderSettings {
            diffuse,
            specular,
            ..small(1)
        };
        let cpu = cpu.render(&camera, &settings, Watch::none()).unwrap();
        let gpu = renderer.render(&camera, &settings, Watch::none()).unwrap();
        assert_same(&format!("{diffuse:?} {specular:?}"), &cpu, &gpu, 12);
    }
}

#[test]
fn lights_without_extent_shine_as_on_the_cpu() {
    let mut glossy = plain(Vec3::new(0.8, 0.5, 0.2));
    glossy.perceptual_roughness = 0.4;
    let (mut scene, camera) = squares(vec![glossy]);
    let spot = PunctualKind::Spot {
        inner_cone_angle: 0.3,
        outer_cone_angle: 0.6,
    };
    let sun = scene.punctual_lights[0].clone();
    for (kind, range) in [
        (PunctualKind::Point, None),
        (PunctualKind::Point, Some(0.9)),
        (spot, Some(3.0)),
        (spot, None),
    ] {
        scene.punctual_lights.push(PunctualLight {
            kind,
            range,
            position: Vec3::new(0.4, 0.7, -0.3),
            ..sun.clone()
        });
    }
    let cpu = cpu_picture(&scene, &camera, &small(2));
    let gpu = gpu_picture(&scene, &camera, &small(2));
    assert!(lit(&cpu) > 500);
    assert_same("lights without extent", &cpu, &gpu, 3);
}

#[test]
fn lights_that_add_little_may_be_left_out_and_no_others() {
    let scene = load("quads-98.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let render = |light_bound| {
        let settings = RenderSettings {
            light_bound,
            ..small(1)
        };
        renderer.render(&camera, &settings, Watch::none()).unwrap()
    };
    let all = render(0.0).radiance();
    let bound = 1e-4;
    let fewer = render(bound).radiance();
    let count = scene.polygon_lights.len() as f32;
    let mut missing = 0;
    for (all, fewer) in all.iter().zip(&fewer) {
        for (all, fewer) in all.iter().zip(fewer) {
            let lost = all - fewer;
            assert!(lost >= -1e-5 * all && lost <= bound * count, "{lost}");
            missing += usize::from(lost > 1e-6);
        }
    }
    assert!(missing > 0);
}

/// More lights than a software driver's shader may go through, smooth and rough surfaces under them.
#[test]
fn thousands_of_lights() {
    let rough = plain(Vec3::splat(0.6));
    let smooth = Material {
        metallic: 1.0,
        perceptual_roughness: 0.1,
        ..plain(Vec3::splat(0.9))
    };
    let (mut scene, camera) = squares(vec![rough, smooth]);
    scene.punctual_lights.clear();
    let corner = |x: f64, z: f64| [x, 1.5, z];
    scene.polygon_lights = (0..8_100)
        .map(|i| {
            let (x, z) = (f64::from(i % 90 - 45), f64::from(i / 90 - 45));
            EmissivePolygon {
                name: String::new(),
                loops: vec![vec![
                    corner(x, z),
                    corner(x + 0.2, z),
                    corner(x + 0.2, z + 0.2),
                    corner(x, z + 0.2),
                ]],
                radiance: Vec3::new(3.0, 2.0, 1.0),
                image: None,
                two_sided: false,
                mesh: 0,
                triangles: Vec::new(),
            }
        })
        .collect();
    let settings = |light_bound| RenderSettings {
        width: 24,
        height: 16,
        samples: 1,
        light_bound,
        ..RenderSettings::default()
    };
    let cpu = cpu_picture(&scene, &camera, &settings(0.0));
    assert!(lit(&cpu) > 50);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let render = |light_bound| {
        let picture = renderer.render(&camera, &settings(light_bound), Watch::none());
        picture.unwrap()
    };
    assert_same("thousands of lights", &cpu, &render(0.0), 3);
    assert_same(
        "thousands of lights, hardly any left out",
        &cpu,
        &render(1e-12),
        3,
    );
    // What is left out of so many is far less than so many bounds.
    let (all, fewer) = (cpu.radiance(), render(1e-4).radiance());
    let (mut lost, mut most) = (0.0_f32, 0.0_f32);
    for (all, fewer) in all.iter().flatten().zip(fewer.iter().flatten()) {
        assert!(all - fewer >= -1e-4 * all, "{all} {fewer}");
        lost = lost.max(all - fewer);
        most = most.max(*all);
    }
    assert!(lost > 1e-4 && lost < 0.1 * most, "{lost} of {most}");
}

/// Red, green and blue blocks, some much brighter than others.
fn blocks(size: [u32; 2]) -> ImageFile {
    let mut random = Pcg64Mcg::seed_from_u64(12);
    let texels = (0..size[0] * size[1]).map(|_| {
        let brightness = if random.random::<f32>() < 0.1 {
            30.0
        } else {
            1.0
        };
        random.random::<[f32; 3]>().map(|x| x * brightness)
    });
    ImageFile::from_linear("blocks", size, &texels.collect::<Vec<_>>()).unwrap()
}

/// A scene of ours with blocks on all its lights.
fn with_images(name: &str) -> Scene {
    let mut scene = load(name);
    let names: std::collections::BTreeSet<_> = scene
        .polygon_lights
        .iter()
        .map(|l| l.name.clone())
        .collect();
    for name in names {
        scene
            .replace_light_image(&name, &blocks([16, 8]), &Limits::default())
            .unwrap();
    }
    assert!(
        scene
            .polygon_lights
            .iter()
            .any(|light| light.image.is_some())
    );
    scene
}

const fn taps(taps: u32) -> ImageMethod {
    ImageMethod::Quadrature { taps }
}

#[test]
fn images_on_lights_look_as_on_the_cpu_by_every_method() {
    let scene = with_images("cornell.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let cpu = CpuRenderer::new(&scene);
    let (exact, circle) = (LocalOcclusion::Exact, LocalOcclusion::Circle);
    let projected = |basis, occlusion| DiffuseMethod::ProjectedArea { basis, occlusion };
    let (ltc, plain) = (SpecularMethod::default(), DiffuseMethod::default());
    let two = SpecularMethod::Ltc {
        lobes: LtcLobes::Two,
    };
    for (diffuse, specular, image_method) in [
        (plain, ltc, taps(1)),
        (plain, ltc, taps(2)),
        (plain, two, taps(3)),
        (plain, ltc, ImageMethod::Lookup),
        (
            DiffuseMethod::Exact { occlusion: circle },
            SpecularMethod::None,
            taps(4),
        ),
        (
            DiffuseMethod::LightVector { occlusion: exact },
            SpecularMethod::LightVector,
            taps(2),
        ),
        (
            DiffuseMethod::LightVector { occlusion: circle },
            SpecularMethod::None,
            ImageMethod::Lookup,
        ),
        (
            projected(ProjectionBasis::Biased { bias: 0.3 }, exact),
            SpecularMethod::ReflectedInclusion(InclusionRule::CrossingNumber),
            taps(2),
        ),
        (
            projected(ProjectionBasis::Optimal, circle),
            SpecularMethod::None,
            taps(2),
        ),
    ] {
        let settings = RenderSettings {
            width: 48,
            height: 32,
            diffuse,
            specular,
            image_method,
            ..small(1)
        };
        let cpu = cpu.render(&camera, &settings, Watch::none()).unwrap();
        let gpu = renderer.render(&camera, &settings, Watch::none()).unwrap();
        let name = format!("{diffuse:?} {specular:?} {image_method:?}");
        assert_same(&name, &cpu, &gpu, 6);
    }
}

#[test]
fn images_on_lights_reach_every_layer_as_on_the_cpu() {
    let scene = with_images("materials.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let cpu = CpuRenderer::new(&scene);
    let occlusion = LocalOcclusion::Exact;
    for (diffuse, specular) in [
        (DiffuseMethod::default(), SpecularMethod::default()),
        (
            DiffuseMethod::LightVector { occlusion },
            SpecularMethod::LightVector,
        ),
        (
            DiffuseMethod::LightVector { occlusion },
            SpecularMethod::ReflectedInclusion(InclusionRule::WindingNumber),
        ),
        (
            DiffuseMethod::default(),
            distances(64, DistanceFieldSmoothness::default()),
        ),
    ] {
        let settings = RenderSettings {
            diffuse,
            specular,
            ..small(1)
        };
        let cpu = cpu.render(&camera, &settings, Watch::none()).unwrap();
        let gpu = renderer.render(&camera, &settings, Watch::none()).unwrap();
        assert_same(&format!("{diffuse:?} {specular:?}"), &cpu, &gpu, 12);
    }
}

#[test]
fn replaced_images_are_shown_as_on_the_cpu() {
    let scene = with_images("cornell.glb");
    let camera = camera(&scene);
    let mut renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let mut cpu = CpuRenderer::new(&scene);
    let light = scene
        .polygon_lights
        .iter()
        .position(|l| l.image.is_some())
        .unwrap();
    let [width, height] = scene.polygon_lights[light].image.unwrap().size;
    let count = (width * height) as usize;
    let mut random = Pcg64Mcg::seed_from_u64(13);
    let bytes: Vec<[u8; 4]> = (0..count).map(|_| random.random()).collect();
    let numbers: Vec<[f32; 3]> = (0..count).map(|_| random.random()).collect();
    for image_method in [taps(2), ImageMethod::Lookup] {
        for colors in [ImageColors::Srgb(&bytes), ImageColors::Linear(&numbers)] {
            renderer.replace_light_image(light, colors).unwrap();
            cpu.replace_light_image(light, &colors.to_linear()).unwrap();
            let settings = RenderSettings {
                width: 48,
                height: 32,
                image_method,
                ..small(1)
            };
            let expected = cpu.render(&camera, &settings, Watch::none()).unwrap();
            let got = renderer.render(&camera, &settings, Watch::none()).unwrap();
            assert!(lit(&expected) > 500);
            assert_same(&format!("replaced, {image_method:?}"), &expected, &got, 6);
        }
    }
    let fault = renderer.replace_light_image(light, ImageColors::Srgb(&bytes[1..]));
    assert!(matches!(fault, Err(RenderError::Picture(_))), "{fault:?}");
    let fault = renderer.replace_light_image(99, ImageColors::Srgb(&bytes));
    assert!(
        matches!(fault, Err(RenderError::NoPicture { light: 99 })),
        "{fault:?}"
    );
}

/// A light's bound holds for the brightest of its colours, also when they are replaced.
#[test]
fn bright_places_of_images_are_not_left_out() {
    let mut scene = with_images("cornell.glb");
    // Hardly anything, but for its image.
    for light in &mut scene.polygon_lights {
        if let Some(image) = &mut light.image {
            image.strength = Vec3::splat(1e-4);
        }
    }
    let camera = camera(&scene);
    let mut renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let light = scene
        .polygon_lights
        .iter()
        .position(|l| l.image.is_some())
        .unwrap();
    let [width, height] = scene.polygon_lights[light].image.unwrap().size;
    let mut colors = vec![[0.0; 3]; (width * height) as usize];
    let middle = (height / 2 * width + width / 2) as usize;
    colors[middle] = [3e6; 3];
    renderer
        .replace_light_image(light, ImageColors::Linear(&colors))
        .unwrap();
    let render = |light_bound| {
        let settings = RenderSettings {
            light_bound,
            ..small(1)
        };
        renderer
            .render(&camera, &settings, Watch::none())
            .unwrap()
            .radiance()
    };
    let (all, fewer) = (render(0.0), render(1e-3));
    let brightest = all.iter().flatten().fold(0.0_f32, |most, &x| most.max(x));
    assert!(brightest > 0.1, "{brightest}");
    let count = scene.polygon_lights.len() as f32;
    for (all, fewer) in all.iter().flatten().zip(fewer.iter().flatten()) {
        assert!(all - fewer <= 1e-3 * count + 1e-5 * all, "{all} {fewer}");
    }
}

/// A square that fills [-1, 1]² at this height, facing up, two triangles.
fn square(height: f32, material: usize) -> Mesh {
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    Mesh {
        material,
        positions: corners.map(|[x, z]| Vec3::new(x, height, z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        texcoords: [corners.map(|c| Vec2::from(c) * 1.7).to_vec(), Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Squares over each other under a sun, seen from above at a slant.
fn squares(materials: Vec<Material>) -> (Scene, Camera) {
    let mut scene = Scene {
        meshes: (0..materials.len())
            .map(|i| Arc::new(square(-(i as f32), i)))
            .collect(),
        materials,
        ..Scene::default()
    };
    let camera = Camera::framing(&scene);
    scene.punctual_lights.push(PunctualLight {
        name: String::new(),
        kind: PunctualKind::Directional,
        position: Vec3::ZERO,
        direction: Vec3::new(0.3, -0.8, -0.2).normalize(),
        color: Vec3::splat(2.0),
        range: None,
    });
    (scene, camera)
}

fn plain(color: Vec3) -> Material {
    Material {
        base_color: color.extend(1.0),
        metallic: 0.0,
        ..Material::default()
    }
}

fn texture(side: u32, wrap: [Wrap; 2], filter: Filter) -> Texture {
    let texels = (0..side * side).map(|i| {
        let at = i.wrapping_mul(2_654_435_761);
        let [r, g, b, _] = at.to_le_bytes();
        // Half of it is holes.
        [
            r,
            g,
            b,
            if (i / side + i % side).is_multiple_of(2) {
                255
            } else {
                10
            },
        ]
    });
    let sampler = Sampler {
        wrap_s: wrap[0],
        wrap_t: wrap[1],
        filter,
    };
    Texture::from_rgba8("", [side; 2], texels.collect(), true, sampler).unwrap()
}

#[test]
fn masks_cut_the_same_holes() {
    for filter in [Filter::Nearest, Filter::Linear] {
        for wrap in [
            [Wrap::Repeat, Wrap::ClampToEdge],
            [Wrap::MirroredRepeat, Wrap::Repeat],
        ] {
            let mut masked = plain(Vec3::ONE);
            masked.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            masked.base_color_texture = Some(TextureRef::default());
            let (mut scene, camera) = squares(vec![masked, plain(Vec3::new(0.9, 0.1, 0.1))]);
            scene.textures.push(texture(4, wrap, filter));
            let cpu = cpu_picture(&scene, &camera, &small(1));
            let gpu = gpu_picture(&scene, &camera, &small(1));
            // The outlines of holes are silhouettes.
            assert_same(&format!("{filter:?} {wrap:?}"), &cpu, &gpu, 20);
        }
    }
}

#[test]
fn backs_are_seen_where_they_are_there() {
    let mut double_sided = plain(Vec3::new(0.1, 0.9, 0.1));
    double_sided.double_sided = true;
    double_sided.emissive = Vec3::splat(0.2);
    let single_sided = plain(Vec3::new(0.9, 0.1, 0.1));
    let (scene, above) = squares(vec![double_sided, single_sided]);
    let mut below = above.clone();
    // The same view, turned upside down about x.
    let turn = Affine3A::from_rotation_x(std::f32::consts::PI);
    below.world_from_camera = turn * above.world_from_camera;
    for (name, camera) in [("above", above), ("below", below)] {
        let cpu = cpu_picture(&scene, &camera, &small(2));
        let gpu = gpu_picture(&scene, &camera, &small(2));
        assert!(lit(&cpu) > 100, "{name}: {}", lit(&cpu));
        assert_same(name, &cpu, &gpu, 3);
    }
}

#[test]
fn vertex_colors_and_parallel_rays() {
    let (mut scene, mut camera) = squares(vec![plain(Vec3::ONE)]);
    Arc::make_mut(&mut scene.meshes[0]).colors = vec![
        Vec4::new(1.0, 0.0, 0.0, 1.0),
        Vec4::new(0.0, 1.0, 0.0, 1.0),
        Vec4::new(0.0, 0.0, 1.0, 1.0),
        Vec4::ONE,
    ];
    for (xmag, ymag) in [(2.0, 1.5), (0.2, 1.0)] {
        camera.projection = Projection::Orthographic { xmag, ymag };
        let cpu = cpu_picture(&scene, &camera, &small(2));
        let gpu = gpu_picture(&scene, &camera, &small(2));
        assert!(lit(&cpu) > 500);
        assert_same("parallel rays", &cpu, &gpu, 3);
    }
}

/// Triangles everywhere around a camera among them, each in a colour of its own.
#[test]
fn the_nearest_triangle_is_seen() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut point =
        move |size: f32| Vec3::from([(); 3].map(|()| size * (random.random::<f32>() - 0.5)));
    let mut scene = Scene::default();
    for i in 0..400_usize {
        let center = point(8.0);
        let size = if i % 10 == 0 { 20.0 } else { 2.0 };
        let mut corners = [(); 3].map(|()| center + point(size));
        if i % 50 == 7 {
            // Without area.
            corners[2] = corners[1];
        }
        scene.meshes.push(Arc::new(Mesh {
            material: i,
            positions: corners.to_vec(),
            normals: vec![Vec3::Y; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }));
        scene.materials.push(Material {
            base_color: (point(1.0) + Vec3::splat(0.5)).extend(1.0),
            unlit: true,
            double_sided: i % 2 == 0,
            ..Material::default()
        });
    }
    let mut camera = Camera::framing(&scene);
    camera.world_from_camera.translation = Vec3::ZERO.into();
    for projection in [
        camera.projection,
        Projection::Perspective {
            yfov: 2.6,
            aspect: None,
        },
        Projection::Orthographic {
            xmag: 3.0,
            ymag: 3.0,
        },
    ] {
        camera.projection = projection;
        let cpu = cpu_picture(&scene, &camera, &small(1));
        let gpu = gpu_picture(&scene, &camera, &small(1));
        assert!(lit(&cpu) > 3000);
        assert_same(&format!("{projection:?}"), &cpu, &gpu, 40);
    }
}

#[test]
fn nothing_is_black() {
    let empty = Scene::default();
    let gpu = gpu_picture(&empty, &Camera::framing(&empty), &small(2));
    assert_eq!((lit(&gpu), gpu.emitted.len()), (0, 96 * 64));

    let (mut dark, camera) = squares(vec![plain(Vec3::ONE)]);
    dark.punctual_lights.clear();
    assert_eq!(lit(&gpu_picture(&dark, &camera, &small(1))), 0);

    let (scene, mut nowhere) = squares(vec![plain(Vec3::ONE)]);
    nowhere.world_from_camera.translation.x = f32::NAN;
    assert_eq!(lit(&gpu_picture(&scene, &nowhere, &small(1))), 0);
}

#[test]
fn far_away_and_huge_worlds() {
    // As far out as single precision leaves a square its shape.
    let (mut scene, mut camera) = squares(vec![plain(Vec3::ONE), plain(Vec3::X)]);
    let far = Vec3::new(8192.0, -16384.0, 4096.0);
    let meshes = scene.meshes.iter_mut().map(Arc::make_mut);
    for position in meshes.flat_map(|m| &mut m.positions) {
        *position += far;
    }
    camera.world_from_camera.translation += glam::Vec3A::from(far);
    let cpu = cpu_picture(&scene, &camera, &small(1));
    let gpu = gpu_picture(&scene, &camera, &small(1));
    assert!(lit(&cpu) > 500);
    assert_same("far away", &cpu, &gpu, 60);

    // What the CPU makes of it is not defined; the GPU has to come to an end.
    for size in [1e15, 1e30, f32::MAX] {
        let (mut scene, _) = squares(vec![plain(Vec3::ONE)]);
        for position in &mut Arc::make_mut(&mut scene.meshes[0]).positions {
            *position *= size;
        }
        let camera = Camera::framing(&scene);
        let gpu = gpu_picture(&scene, &camera, &small(1));
        assert_eq!(gpu.diffuse.len(), 96 * 64);
    }
}

#[test]
fn work_stops_when_asked_and_tells_how_far_it_is() {
    let scene = load("cornell.glb");
    let camera = camera(&scene);
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let cancelled = AtomicBool::new(false);
    let stop = |_, _| cancelled.store(true, Ordering::Relaxed);
    let watch = Watch {
        progress: &stop,
        cancelled: &cancelled,
    };
    let many = RenderSettings {
        samples: 4096,
        ..small(1)
    };
    let stopped = renderer.render(&camera, &many, watch);
    assert_eq!(stopped, Err(RenderError::Cancelled));

    // And can be taken up again.
    let (done, all) = (AtomicU64::new(0), AtomicU64::new(0));
    let progress = |now, total| {
        assert_eq!(now, done.fetch_add(1, Ordering::Relaxed) + 1);
        all.store(total, Ordering::Relaxed);
    };
    let watch = Watch {
        progress: &progress,
        cancelled: &AtomicBool::new(false),
    };
    let first = renderer.render(&camera, &small(20), watch).unwrap();
    assert_eq!(done.load(Ordering::Relaxed), all.load(Ordering::Relaxed));
    assert!(done.load(Ordering::Relaxed) >= 2);
    let again = renderer.render(&camera, &small(20), Watch::none()).unwrap();
    assert!(first == again, "the same picture twice differs");
    if GPU.adapter().has_timestamps {
        let timings = renderer.timings().unwrap();
        assert!(timings.shading > 0.0, "{timings:?}");
    }
}

#[test]
fn lights_move_without_a_new_renderer() {
    let mut scene = load("quads-10.glb");
    let camera = camera(&scene);
    let mut renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    let lights = scene.polygon_lights.clone();
    // Fewer, all that were there and more than that; moved and broken ones among them.
    let mut more = [lights.clone(), lights.clone()].concat();
    for vertex in more[3].loops.iter_mut().flatten() {
        vertex[1] += 0.25;
    }
    more[4].loops[0].truncate(2);
    for list in [lights[..2].to_vec(), Vec::new(), more, lights] {
        renderer.set_lights(&list).unwrap();
        scene.polygon_lights = list;
        let cpu = CpuRenderer::new(&scene);
        let gpu = renderer.render(&camera, &small(1), Watch::none()).unwrap();
        assert_eq!(renderer.warnings(), cpu.warnings());
        let cpu = cpu.render(&camera, &small(1), Watch::none()).unwrap();
        assert_same("moved lights", &cpu, &gpu, 6);
    }
}

#[test]
fn sizes_out_of_range_are_refused() {
    let scene = Scene::default();
    let renderer = GpuRenderer::new(&GPU, &scene).unwrap();
    for (width, height, samples) in [(0, 1, 1), (1, 40_000, 1), (1, 1, 0)] {
        let settings = RenderSettings {
            width,
            height,
            samples,
            ..RenderSettings::default()
        };
        let fault = renderer.render(&Camera::framing(&scene), &settings, Watch::none());
        assert!(matches!(fault, Err(RenderError::OutOfRange { .. })));
    }
}
