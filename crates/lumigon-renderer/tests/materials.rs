//! Every layer of a material: closed forms against the path tracer, and what a white furnace shows.

use glam::{Vec3, Vec4};
use lumigon::{
    Ltc, LtcLobes, LtcTable, PolygonLight, PreparedLtc, Sides, SpecularMethod, ggx_cosine,
    irradiance, ltc_form_factor,
};
use lumigon_renderer::{
    Camera, CpuRenderer, EmissivePolygon, Material, PunctualKind, PunctualLight,
    ReferenceRendering, ReferenceSettings, RenderSettings, Rendering, Scene, Watch,
};

/// Five spheres, all of this material, under the file's own square light.
fn spheres(material: &Material) -> Scene {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/check/spheres.glb"
    );
    let mut scene = Scene::load(path).unwrap();
    for of_scene in scene.materials.iter_mut().filter(|m| !m.is_emissive()) {
        *of_scene = material.clone();
    }
    scene
}

/// One material for each layer, and one of all.
fn layers() -> Vec<(&'static str, Material)> {
    let base = Material {
        base_color: Vec4::new(0.7, 0.4, 0.2, 1.0),
        metallic: 0.0,
        perceptual_roughness: 0.5,
        ..Material::default()
    };
    let specular = Material {
        specular: 0.8,
        specular_color: Vec3::new(0.5, 1.0, 9.0),
        ior: 2.0,
        ..base.clone()
    };
    let anisotropic = Material {
        metallic: 1.0,
        anisotropy_strength: 0.7,
        anisotropy_rotation: 0.4,
        ..base.clone()
    };
    let rough = Material {
        diffuse_roughness: 1.0,
        ..base.clone()
    };
    let sheen = Material {
        sheen_color: Vec3::new(0.9, 0.5, 0.3),
        sheen_perceptual_roughness: 0.5,
        ..base.clone()
    };
    let clearcoat = Material {
        metallic: 1.0,
        clearcoat: 0.9,
        clearcoat_perceptual_roughness: 0.3,
        ..base.clone()
    };
    let all = Material {
        metallic: 0.4,
        anisotropy_strength: 0.5,
        diffuse_roughness: 0.5,
        sheen_color: Vec3::new(0.2, 0.4, 0.3),
        sheen_perceptual_roughness: 0.7,
        clearcoat: 0.6,
        clearcoat_perceptual_roughness: 0.2,
        ..specular.clone()
    };
    vec![
        ("base", base),
        ("specular and ior", specular),
        ("anisotropy", anisotropic),
        ("diffuse roughness", rough),
        ("sheen", sheen),
        ("clearcoat", clearcoat),
        ("all", all),
    ]
}

fn settings() -> RenderSettings {
    RenderSettings {
        width: 96,
        height: 60,
        samples: 1,
        ..RenderSettings::default()
    }
}

fn rendered(scene: &Scene) -> Rendering {
    rendered_with(scene, LtcLobes::One)
}

fn rendered_with(scene: &Scene, lobes: LtcLobes) -> Rendering {
    let renderer = CpuRenderer::new(scene);
    assert!(renderer.warnings().is_empty());
    let settings = RenderSettings {
        specular: SpecularMethod::Ltc { lobes },
        ..settings()
    };
    let camera = &scene.cameras[0];
    renderer.render(camera, &settings, Watch::none()).unwrap()
}

fn traced(scene: &Scene, paths: u32) -> ReferenceRendering {
    let RenderSettings {
        width,
        height,
        samples,
        ..
    } = settings();
    let reference = ReferenceSettings {
        width,
        height,
        samples,
        paths,
        bounces: 1,
        shadows: false,
        seed: 3,
        ..ReferenceSettings::default()
    };
    let renderer = CpuRenderer::new(scene);
    let camera = &scene.cameras[0];
    renderer
        .reference(camera, &reference, Watch::none())
        .unwrap()
}

/// Lights without extent leave the path tracer nothing to chance: only the directional albedos of
/// the layering differ, which one side fits and the other integrates.
#[test]
fn brdfs_and_layering_are_the_path_tracers() {
    for (name, material) in layers() {
        let mut scene = spheres(&material);
        scene.polygon_lights.clear();
        for position in [[-3.0, 2.0, 3.0], [0.5, 4.0, -1.0], [2.0, -1.0, 2.0]] {
            scene.punctual_lights.push(PunctualLight {
                name: String::new(),
                kind: PunctualKind::Point,
                position: position.into(),
                direction: Vec3::NEG_Y,
                color: Vec3::new(30.0, 20.0, 10.0),
                range: None,
            });
        }
        let closed = rendered(&scene);
        let reference = traced(&scene, 2).mean;
        let mut worst = [0.0_f32; 2];
        for (channel, (got, want)) in [
            (&closed.diffuse, &reference.diffuse),
            (&closed.specular, &reference.specular),
        ]
        .into_iter()
        .enumerate()
        {
            assert!(want.iter().any(|x| x[1] > 0.0) || name == "anisotropy" || name == "clearcoat");
            for (got, want) in got.iter().flatten().zip(want.iter().flatten()) {
                // Beside the relative error: the spheres' lights give radiances of about 1.
                let error = (got - want).abs() / (want + 0.02);
                worst[channel] = worst[channel].max(error);
            }
        }
        println!("{name}: {worst:?}");
        assert!(worst[0] < 0.02 && worst[1] < 0.002, "{name}: {worst:?}");
    }
}

/// The closed forms' RMS error over the mean, and the error of the mean, beyond the reference's
/// noise, by channel: diffuse and specular.
fn errors(closed: &Rendering, reference: &ReferenceRendering) -> [[f64; 2]; 2] {
    [
        (
            &closed.diffuse,
            &reference.mean.diffuse,
            &reference.diffuse_error,
        ),
        (
            &closed.specular,
            &reference.mean.specular,
            &reference.specular_error,
        ),
    ]
    .map(|(got, want, error)| {
        let (mut squares, mut deviation, mut sum, mut count) = (0.0, 0.0, 0.0, 0);
        for ((got, want), error) in got.iter().zip(want).zip(error) {
            for channel in 0..3 {
                let [got, want, error] = [got, want, error].map(|x| f64::from(x[channel]));
                if want > 0.0 || got > 0.0 {
                    squares += (got - want).powi(2) - error.powi(2);
                    deviation += got - want;
                    sum += want;
                    count += 1;
                }
            }
        }
        if sum == 0.0 {
            return [0.0; 2];
        }
        let rms = (squares / f64::from(count)).max(0.0).sqrt();
        [rms * f64::from(count) / sum, deviation / sum]
    })
}

#[test]
fn polygons_on_every_layer_are_near_the_path_tracer() {
    for (name, material) in layers() {
        let scene = spheres(&material);
        let [diffuse, specular] = errors(&rendered(&scene), &traced(&scene, 256));
        println!("{name}: diffuse {diffuse:.4?}, specular {specular:.4?}");
        // Plain dielectrics err most: the lobe that has the shape of the reflection with F = 1 is
        // not that of Schlick's part of it, which comes from grazing directions.
        let (diffuse_bounds, specular_bounds) = match name {
            "base" => ([0.01, 0.005], [0.25, 0.1]),
            "specular and ior" => ([0.01, 0.005], [0.06, 0.006]),
            "anisotropy" => ([0.0, 0.0], [0.09, 0.03]),
            "diffuse roughness" => ([0.05, 0.005], [0.25, 0.1]),
            "sheen" => ([0.01, 0.005], [0.14, 0.05]),
            "clearcoat" => ([0.0, 0.0], [0.06, 0.006]),
            _ => ([0.01, 0.01], [0.06, 0.012]),
        };
        for (error, bounds) in [(diffuse, diffuse_bounds), (specular, specular_bounds)] {
            assert!(error[0] <= bounds[0], "{name}: RMS {error:?}");
            assert!(error[1].abs() <= bounds[1], "{name}: mean {error:?}");
        }
    }
}

/// GGX alone, metal and dielectric, by one lobe and by two.
#[test]
fn two_lobes_err_less_than_one() {
    for (name, metallic, bounds) in [
        ("metal", 1.0, [0.045, 0.02]),
        ("dielectric", 0.0, [0.3, 0.06]),
    ] {
        let (mut squares, mut count) = ([0.0; 2], 0);
        for perceptual_roughness in [0.25, 0.5, 0.8] {
            let scene = spheres(&Material {
                base_color: Vec4::new(1.0, 0.8, 0.5, 1.0),
                metallic,
                perceptual_roughness,
                ..Material::default()
            });
            let reference = traced(&scene, 512);
            let rms = [LtcLobes::One, LtcLobes::Two].map(|lobes| {
                let [_, [rms, _]] = errors(&rendered_with(&scene, lobes), &reference);
                rms
            });
            println!(
                "{name}, {perceptual_roughness}: one {:.4}, two {:.4}",
                rms[0], rms[1]
            );
            for (sum, rms) in squares.iter_mut().zip(rms) {
                *sum += rms * rms;
            }
            count += 1;
        }
        let [one, two] = squares.map(|sum| (sum / f64::from(count)).sqrt());
        println!("{name}: one {one:.4}, two {two:.4}");
        assert!(
            one < bounds[0] && two < bounds[1],
            "{name}: {one} and {two}"
        );
        assert!(two < 0.6 * one, "{name}: {one} and {two}");
    }
}

/// Directional albedos of GGX by midpoints over the hemisphere: with F = 1, and weighted by
/// Schlick's (1 - h.v)^5.
fn albedos(alpha: f64, cos_view: f64) -> [f64; 2] {
    let normal = lumigon::Vec3::new(0.0, 0.0, 1.0);
    let view = lumigon::Vec3::new((1.0 - cos_view * cos_view).sqrt(), 0.0, cos_view);
    let (rows, columns) = (600, 1200);
    let mut sums = [0.0; 2];
    for row in 0..rows {
        let z = (f64::from(row) + 0.5) / f64::from(rows);
        let sine = (1.0 - z * z).sqrt();
        for column in 0..columns {
            let azimuth = (f64::from(column) + 0.5) / f64::from(columns) * std::f64::consts::TAU;
            let light = lumigon::Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z);
            let value = ggx_cosine(alpha, normal, view, light);
            let half = (view + light).normalize_or_zero();
            sums[0] += value;
            sums[1] += value * (1.0 - half.dot(view)).powi(5);
        }
    }
    sums.map(|sum| sum * std::f64::consts::TAU / f64::from(rows * columns))
}

/// A floor of plain metallic-roughness, its light written out by hand: what is not reflected
/// (by an albedo summed up here) enters, and layers that are not there change nothing.
#[test]
fn plain_materials_are_what_they_say() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/check/square.glb");
    let mut scene = Scene::load(path).unwrap();
    let color = Vec3::new(0.7, 0.4, 0.2);
    let (width, height) = (48_u32, 48_u32);
    let table = LtcTable::ggx();
    for (metallic, perceptual_roughness) in [(0.0, 0.5), (0.3, 0.35), (1.0, 0.6)] {
        for material in scene.materials.iter_mut().filter(|m| !m.is_emissive()) {
            *material = Material {
                base_color: color.extend(1.0),
                metallic,
                perceptual_roughness,
                ..Material::default()
            };
        }
        let renderer = CpuRenderer::new(&scene);
        let settings = RenderSettings {
            width,
            height,
            samples: 1,
            ..RenderSettings::default()
        };
        let camera: &Camera = &scene.cameras[0];
        let picture = renderer.render(camera, &settings, Watch::none()).unwrap();
        let source = &scene.polygon_lights[0];
        let light: PolygonLight<f64> = PolygonLight::new(&source.loops, Sides::Front).unwrap();
        for (x, y) in [(24_u32, 36_u32), (10, 33), (30, 30), (40, 45)] {
            let (u, v) = (
                (x as f32 + 0.5) / width as f32,
                (y as f32 + 0.5) / height as f32,
            );
            let (origin, direction) = camera.ray(u, v, 1.0);
            let point = origin - direction * (origin.y / direction.y);
            assert!(point.abs().max_element() < 4.0, "({x}, {y}) sees the floor");
            let double =
                |v: Vec3| lumigon::Vec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z));
            let normal = lumigon::Vec3::new(0.0, 1.0, 0.0);
            let cosine = -direction.y;

            let [whole, schlick] = albedos(f64::from(perceptual_roughness).powi(2), cosine.into());
            let reflected = 0.04 * (whole - schlick) + schlick;
            let irradiance = irradiance(&light, double(point), normal);
            let lobes = table.lookup(perceptual_roughness, cosine);
            let [lobe] = lobes.lobes;
            let mut in_double = Ltc::cosine(0.0_f64);
            in_double.shading_to_cosine = lobe.shading_to_cosine.map(f64::from);
            let prepared = PreparedLtc::new(&in_double, normal, double(-direction));
            let form_factor = ltc_form_factor(&light, double(point), &prepared);

            let pixel = (y * width + x) as usize;
            for channel in 0..3 {
                let radiance = f64::from(source.radiance[channel]);
                let base = f64::from(color[channel]);
                let share = (1.0 - f64::from(metallic)) * (1.0 - reflected);
                let diffuse = base * share * irradiance * radiance / std::f64::consts::PI;
                let f0 = 0.04 + (base - 0.04) * f64::from(metallic);
                let response = |ltc: &Ltc<f32>| {
                    f0 * f64::from(ltc.amplitude - ltc.schlick) + f64::from(ltc.schlick)
                };
                let specular = radiance
                    * (response(&lobe) * form_factor
                        + response(&lobes.cosine) * irradiance / std::f64::consts::PI);
                let [got_diffuse, got_specular] = [&picture.diffuse, &picture.specular]
                    .map(|part| f64::from(part[pixel][channel]));
                // The table's albedo is fitted.
                assert!(
                    (got_diffuse - diffuse).abs() <= 2e-3 * diffuse,
                    "metallic {metallic}, pixel ({x}, {y}): {got_diffuse} is not {diffuse}"
                );
                assert!(
                    (got_specular - specular).abs() <= 1e-3 * specular,
                    "metallic {metallic}, pixel ({x}, {y}): {got_specular} is not {specular}"
                );
            }
        }
    }
}

/// White walls of radiance 1 all around: no surface shows more than 1.
#[test]
fn furnace_is_not_exceeded() {
    for (name, material) in layers() {
        let white = Material {
            base_color: Vec4::ONE,
            specular_color: Vec3::ONE,
            sheen_color: if material.sheen_color == Vec3::ZERO {
                Vec3::ZERO
            } else {
                Vec3::ONE
            },
            ..material
        };
        let mut scene = spheres(&white);
        scene.polygon_lights = walls();
        let closed = rendered(&scene);
        let (mut least, mut greatest) = (f32::INFINITY, 0.0_f32);
        for (diffuse, specular) in closed.diffuse.iter().zip(&closed.specular) {
            let shown = diffuse[1] + specular[1];
            if shown > 0.0 {
                least = least.min(shown);
                greatest = greatest.max(shown);
            }
        }
        println!("{name}: {least} to {greatest}");
        assert!(greatest < 1.003, "{name}: {greatest}");
        assert!(least > 0.65, "{name}: {least}");
    }
}

/// A cube of inward facing squares.
fn walls() -> Vec<EmissivePolygon> {
    let corner = |axis: usize, side: f64, u: f64, v: f64| {
        let mut p = [0.0; 3];
        p[axis] = side;
        p[(axis + 1) % 3] = u;
        p[(axis + 2) % 3] = v;
        p.map(|x| 50.0 * x)
    };
    (0..6)
        .map(|k| {
            let (axis, side) = (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
            // Counter-clockwise seen from inside.
            let turn = [(-side, -1.0), (-side, 1.0), (side, 1.0), (side, -1.0)];
            EmissivePolygon {
                name: format!("wall {k}"),
                loops: vec![
                    turn.iter()
                        .map(|&(u, v)| corner(axis, side, u, v))
                        .collect(),
                ],
                radiance: Vec3::ONE,
                image: None,
                two_sided: false,
                mesh: 0,
                triangles: Vec::new(),
            }
        })
        .collect()
}
