mod indirect;
mod layered;
mod textured;

use std::f64::consts::{FRAC_1_PI, PI};

use super::*;
use crate::{Emitter, Material, Polygon, PunctualLight, Tolerance, irradiance};
use layered::Layered;

/// A rectangle in 3D, reflecting on both sides.
struct Wall {
    corner: DVec3,
    u: DVec3,
    v: DVec3,
}

struct TestScene {
    walls: Vec<Wall>,
    material: Material,
    emitted: [f64; 3],
    emitters: Vec<Emitter>,
    punctual_lights: Vec<PunctualLight>,
}

impl TestScene {
    fn nearest(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<(f64, &Wall)> {
        let hit = |wall: &Wall| {
            let normal = wall.u.cross(wall.v);
            let distance = (wall.corner - origin).dot(normal) / direction.dot(normal);
            let offset = origin + distance * direction - wall.corner;
            let within =
                |edge: DVec3| (0.0..=1.0).contains(&(offset.dot(edge) / edge.length_squared()));
            (distance > 1e-9 && distance < limit - 1e-9 && within(wall.u) && within(wall.v))
                .then_some(distance)
        };
        let hits = self
            .walls
            .iter()
            .filter_map(|wall| Some((hit(wall)?, wall)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Scene for TestScene {
    fn intersect(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<Surface> {
        let (origin, direction) = (DVec3::from(origin), DVec3::from(direction));
        let (distance, wall) = self.nearest(origin, direction, f64::INFINITY)?;
        let normal = wall.u.cross(wall.v).normalize();
        let normal = if normal.dot(direction) > 0.0 {
            -normal
        } else {
            normal
        };
        Some(Surface {
            position: (origin + distance * direction).into(),
            geometric_normal: normal.into(),
            shading_normal: normal.into(),
            material: self.material,
            emitted: self.emitted,
        })
    }

    fn occluded(&self, origin: [f64; 3], direction: [f64; 3], distance: f64) -> bool {
        self.nearest(origin.into(), direction.into(), distance)
            .is_some()
    }

    fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    fn punctual_lights(&self) -> &[PunctualLight] {
        &self.punctual_lights
    }
}

fn rectangle(x: [f64; 2], y: [f64; 2], height: f64) -> Vec<[f64; 3]> {
    vec![
        [x[0], y[0], height],
        [x[0], y[1], height],
        [x[1], y[1], height],
        [x[1], y[0], height],
    ]
}

fn emitter(loops: &[Vec<[f64; 3]>], two_sided: bool, radiance: [f64; 3]) -> Emitter {
    Emitter::new(Polygon::new(loops, two_sided).unwrap(), radiance)
}

/// A floor z = 0 and three lights above it: one concave with a hole, one upright that cuts the horizon, one far away.
fn floor() -> TestScene {
    let concave = vec![
        [-1.0, -1.0, 0.7],
        [-1.0, 1.0, 0.7],
        [1.0, 1.0, 0.7],
        [1.0, 0.6, 0.7],
        [-0.6, 0.6, 0.7],
        [-0.6, -1.0, 0.7],
    ];
    let hole = vec![
        [-0.9, 0.7, 0.7],
        [-0.7, 0.7, 0.7],
        [-0.7, 0.9, 0.7],
        [-0.9, 0.9, 0.7],
    ];
    let upright = vec![
        [1.5, -1.0, -0.5],
        [1.5, -1.0, 0.5],
        [1.5, 1.0, 0.8],
        [1.5, 1.0, -0.5],
    ];
    TestScene {
        walls: vec![Wall {
            corner: DVec3::new(-50.0, -50.0, 0.0),
            u: DVec3::X * 100.0,
            v: DVec3::Y * 100.0,
        }],
        material: Material {
            base_color: [0.8, 0.5, 0.2],
            dielectric_f0: [0.5, 0.2, 0.04],
            alpha: [0.15; 2],
            ..Material::default()
        },
        emitted: [0.0; 3],
        emitters: vec![
            emitter(&[concave, hole], false, [3.0, 2.0, 1.0]),
            emitter(&[upright], true, [1.0, 2.0, 5.0]),
            emitter(
                &[rectangle([-20.0, -15.0], [0.0, 9.0], 15.0)],
                false,
                [1.0, 1.0, 1.0],
            ),
        ],
        punctual_lights: vec![],
    }
}

const DOWNWARDS: [f64; 3] = [0.6, 0.0, -0.8];

/// Parallel rays at 37 degrees from the normal onto [-1, 1]^2 of the floor.
fn camera(size: usize) -> impl Fn(f64, f64) -> Ray + Sync {
    move |x, y| {
        let target = DVec3::new(
            2.0 * x / size as f64 - 1.0,
            1.0 - 2.0 * y / size as f64,
            0.0,
        );
        Ray {
            origin: (target - 10.0 * DVec3::from(DOWNWARDS)).into(),
            direction: DOWNWARDS,
        }
    }
}

fn settings(size: usize, samples: usize) -> Settings<'static> {
    Settings {
        width: size,
        height: size,
        pixel_samples: &[[0.5, 0.5]],
        samples_per_pixel: samples,
        bounces: 1,
        shadows: false,
        direct: true,
        bounce_shadows: true,
        seed: 2,
    }
}

fn run(
    scene: &TestScene,
    camera: &(impl Fn(f64, f64) -> Ray + Sync),
    settings: &Settings<'_>,
) -> Estimate {
    let estimate = render(scene, camera, settings, &|_, _| (), &AtomicBool::new(false)).unwrap();
    assert_eq!(estimate.invalid_samples, 0);
    estimate
}

/// Standardised differences must look like draws from a normal distribution.
fn assert_standard_normal(name: &str, z: &[f64]) {
    let n = z.len() as f64;
    let mean = z.iter().sum::<f64>() / n;
    let rms = (z.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
    println!("{name}: n {n}, mean {mean:.4}, rms {rms:.4}");
    assert!(mean.abs() < 3.0 / n.sqrt(), "{name}: mean z {mean}");
    // Three standard deviations of the root mean square of so many.
    let bound = 3.0 / (2.0 * n).sqrt();
    assert!((rms - 1.0).abs() < bound, "{name}: rms z {rms}");
}

/// A Lambertian material, and nothing else.
fn matte(base_color: [f64; 3]) -> Material {
    Material {
        base_color,
        dielectric_f0: [0.0; 3],
        dielectric_f90: 0.0,
        ..Material::default()
    }
}

/// A material with every lobe, the clearcoat bent away from the surface's normal.
fn stack() -> Material {
    Material {
        base_color: [0.8, 0.5, 0.2],
        metallic: 0.3,
        dielectric_f0: [0.06, 0.04, 0.02],
        dielectric_f90: 0.9,
        alpha: [0.5, 0.15],
        tangent: [0.6, 0.8, 0.0],
        diffuse_roughness: 0.7,
        sheen_color: [0.2, 0.5, 0.4],
        sheen_alpha: 0.2,
        clearcoat: 0.8,
        clearcoat_alpha: 0.1,
        clearcoat_normal: DVec3::new(0.3, 0.1, 0.9).normalize().into(),
    }
}

/// Renders the floor in this material and compares every pixel and channel with cubature.
fn check_direct_light(name: &str, material: Material, size: usize) {
    let scene = TestScene {
        material,
        ..floor()
    };
    let estimate = run(&scene, &camera(size), &settings(size, 1024));
    let layered = Layered::new(material, DOWNWARDS.map(|x| -x));
    let truths: Vec<_> = (0..size * size)
        .into_par_iter()
        .map(|i| {
            let ray = camera(size)((i % size) as f64 + 0.5, (i / size) as f64 + 0.5);
            let point = scene.intersect(ray.origin, ray.direction).unwrap().position;
            let mut truth = [[0.0; 2]; 3];
            for emitter in &scene.emitters {
                let lobes = layered.over(emitter.polygon(), point);
                for (c, truth) in truth.iter_mut().enumerate() {
                    let [diffuse, specular] = layered.reflected(&lobes, c);
                    truth[0] += emitter.radiance()[c] * diffuse;
                    truth[1] += emitter.radiance()[c] * specular;
                }
            }
            truth
        })
        .collect();
    for c in 0..3 {
        let z = |channel: &Channel, truth: fn([f64; 2]) -> f64| -> Vec<f64> {
            let pixels = channel
                .mean
                .iter()
                .zip(&channel.standard_error)
                .zip(&truths);
            pixels
                .map(|((mean, error), t)| (mean[c] - truth(t[c])) / error[c])
                .collect()
        };
        if material.metallic < 1.0 {
            let diffuse = z(&estimate.diffuse, |[diffuse, _]| diffuse);
            assert_standard_normal(&format!("{name}, diffuse"), &diffuse);
        }
        let specular = z(&estimate.specular, |[_, specular]| specular);
        assert_standard_normal(&format!("{name}, specular"), &specular);
        let total = z(&estimate.total, |[diffuse, specular]| diffuse + specular);
        assert_standard_normal(&format!("{name}, total"), &total);
    }
}

#[test]
fn direct_light_agrees_with_cubature() {
    check_direct_light("plain", floor().material, 20);
}

#[test]
fn each_layer_agrees_with_cubature() {
    let plain = floor().material;
    let anisotropic = Material {
        alpha: [0.05, 0.6],
        tangent: [0.8, -0.6, 0.0],
        metallic: 1.0,
        ..plain
    };
    let rough = Material {
        diffuse_roughness: 1.0,
        ..plain
    };
    let sheen = Material {
        sheen_color: [0.3, 0.6, 1.0],
        sheen_alpha: 0.1,
        ..plain
    };
    let clearcoat = Material {
        clearcoat: 1.0,
        clearcoat_alpha: 0.04,
        clearcoat_normal: DVec3::new(-0.5, 0.2, 0.8).normalize().into(),
        ..plain
    };
    check_direct_light("anisotropic", anisotropic, 12);
    check_direct_light("rough diffuse", rough, 12);
    check_direct_light("sheen", sheen, 12);
    check_direct_light("clearcoat", clearcoat, 12);
}

#[test]
fn all_layers_together_agree_with_cubature() {
    check_direct_light("stack", stack(), 14);
}

#[test]
fn shadow_of_a_rectangle_is_a_hole_in_the_light() {
    // A blind half way up hides twice its size of the light, mirrored about the point.
    let blind = [-0.4, 0.4];
    let mut scene = TestScene {
        material: matte([0.8; 3]),
        emitters: vec![emitter(
            &[rectangle([-4.0, 4.0], [-4.0, 4.0], 2.0)],
            false,
            [1.0; 3],
        )],
        ..floor()
    };
    scene.walls.push(Wall {
        corner: DVec3::new(blind[0], blind[0], 1.0),
        u: DVec3::X * (blind[1] - blind[0]),
        v: DVec3::Y * (blind[1] - blind[0]),
    });
    let size = 16;
    // From below the blind.
    let grazing = |x: f64, y: f64| Ray {
        origin: [
            2.0 * x / size as f64 - 1.0,
            2.0 * y / size as f64 - 1.0,
            0.5,
        ],
        direction: [0.0, 0.0, -1.0],
    };
    let shadowed = Settings {
        shadows: true,
        ..settings(size, 512)
    };
    let estimate = run(&scene, &grazing, &shadowed);
    let mut z = vec![];
    for (i, mean) in estimate.diffuse.mean.iter().enumerate() {
        let [x, y, _] = grazing((i % size) as f64 + 0.5, (i / size) as f64 + 0.5).origin;
        let mut hole = rectangle(blind.map(|b| 2.0 * b - x), blind.map(|b| 2.0 * b - y), 2.0);
        hole.reverse();
        let visible =
            Polygon::new(&[rectangle([-4.0, 4.0], [-4.0, 4.0], 2.0), hole], false).unwrap();
        let e = irradiance(&visible, [x, y, 0.0], [0.0, 0.0, 1.0], Tolerance::default()).unwrap();
        z.push(
            (mean[0] - scene.material.base_color[0] * FRAC_1_PI * e.value)
                / estimate.diffuse.standard_error[i][0],
        );
    }
    assert_standard_normal("shadow", &z);
    let unshadowed = run(&scene, &grazing, &settings(size, 512));
    assert!(
        unshadowed
            .diffuse
            .mean
            .iter()
            .zip(&estimate.diffuse.mean)
            .all(|(lit, dark)| lit[0] > dark[0])
    );
}

/// The inside of the cube [-1, 1]^3, all of it glowing.
fn furnace(material: Material) -> TestScene {
    let mut walls = vec![];
    let mut emitters = vec![];
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let corner = |u: f64, v: f64| {
                let mut corner = DVec3::ZERO;
                corner[axis] = side;
                // Mirrored on one side, so that every face emits inwards.
                corner[(axis + 1) % 3] = -side * u;
                corner[(axis + 2) % 3] = v;
                corner
            };
            let corners = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            emitters.push(emitter(
                &[corners.map(Into::into).to_vec()],
                false,
                [1.0; 3],
            ));
            walls.push(Wall {
                corner: corners[0],
                u: corners[1] - corners[0],
                v: corners[3] - corners[0],
            });
        }
    }
    TestScene {
        walls,
        material,
        emitted: [1.0; 3],
        emitters,
        punctual_lights: vec![],
    }
}

/// From the middle of the furnace to points of one wall, up to `tangent` from its own middle.
fn furnace_camera(size: usize, tangent: f64) -> impl Fn(f64, f64) -> Ray + Sync {
    let across = move |x: f64| tangent * (2.0 * x / size as f64 - 1.0);
    move |x, y| Ray {
        origin: [0.0; 3],
        direction: [across(x), across(y), -1.0],
    }
}

#[test]
fn furnace_reflects_its_albedo() {
    let size = 10;
    let plain = |alpha: f64| Material {
        base_color: [0.7, 1.0, 0.2],
        alpha: [alpha; 2],
        ..Material::default()
    };
    let layered = Material {
        base_color: [1.0; 3],
        diffuse_roughness: 1.0,
        sheen_color: [0.3, 1.0, 0.0],
        sheen_alpha: 0.3,
        clearcoat: 1.0,
        clearcoat_alpha: 0.1,
        ..plain(0.3)
    };
    for material in [plain(0.04), plain(1.0), layered] {
        let scene = furnace(material);
        let shadowed = Settings {
            shadows: true,
            ..settings(size, 256)
        };
        let camera = furnace_camera(size, 0.9);
        let estimate = run(&scene, &camera, &shadowed);
        let mut z = [vec![], vec![]];
        for i in 0..size * size {
            let ray = camera((i % size) as f64 + 0.5, (i / size) as f64 + 0.5);
            let cosine = DVec3::from(ray.direction).length_recip();
            let sine = (1.0 - cosine * cosine).sqrt();
            let truth = Layered::new(material, [sine, 0.0, cosine]);
            let weight = truth.factors[3];
            // The walls' own light passes the clearcoat.
            assert!((estimate.emitted[i][1] - (1.0 - weight)).abs() < 1e-9);
            let [diffuse, specular] = truth.reflected(&truth.over_hemisphere(), 1);
            assert!(diffuse + specular <= 1.0 + 1e-5, "{diffuse} {specular}");
            for (z, (channel, truth)) in z
                .iter_mut()
                .zip([(&estimate.diffuse, diffuse), (&estimate.specular, specular)])
            {
                z.push((channel.mean[i][1] - truth) / channel.standard_error[i][1]);
            }
        }
        let [diffuse, specular] = z;
        assert_standard_normal("furnace, diffuse", &diffuse);
        assert_standard_normal("furnace, specular", &specular);
    }
}

#[test]
fn bounces_add_up_to_a_geometric_series() {
    // Materials that reflect the same from any direction, so that every bounce multiplies by that: smooth and rough
    // matte ones, and a mirror under a mirror.
    let rough = Material {
        diffuse_roughness: 1.0,
        ..matte([1.0; 3])
    };
    let mirrors = Material {
        metallic: 1.0,
        alpha: [2e-3; 2],
        clearcoat: 0.7,
        clearcoat_alpha: 2e-3,
        ..Material::default()
    };
    let size = 12;
    let cases: [(Material, [f64; 3]); 3] = [
        (matte([0.2, 0.5, 0.9]), [0.2, 0.5, 0.9]),
        (rough, [1.0; 3]),
        (mirrors, [1.0; 3]),
    ];
    for (material, albedo) in cases {
        // The clearcoat dims the first wall's own light, and all other light meets it from the lit side.
        let scene = furnace(material);
        for bounces in [1, 2, 6] {
            let deep = Settings {
                shadows: true,
                bounces,
                ..settings(size, 128)
            };
            let estimate = run(&scene, &furnace_camera(size, 0.8), &deep);
            for (c, albedo) in albedo.into_iter().enumerate() {
                let series: f64 = (1..=bounces as i32).map(|n| albedo.powi(n)).sum();
                let pixels = (size * size) as f64;
                let reflected = estimate.total.mean.iter().zip(&estimate.emitted);
                let mean = reflected.map(|(t, e)| t[c] - e[c]).sum::<f64>() / pixels;
                let variance: f64 = estimate
                    .total
                    .standard_error
                    .iter()
                    .map(|e| e[c] * e[c])
                    .sum();
                let error = variance.sqrt() / pixels;
                println!(
                    "{bounces} bounces, albedo {albedo}: {mean:.5} +- {error:.5}, series {series:.5}"
                );
                // The mirrors lose about 1e-4 a bounce below the horizon at grazing angles.
                let loss = 3e-4 * f64::from(bounces) * series;
                assert!(
                    (mean - series).abs() < 3.5 * error + loss,
                    "{bounces} {c}: {mean} +- {error}, {series}"
                );
                assert!(error < 0.01 * series);
            }
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = furnace(stack());
    let settings = Settings {
        pixel_samples: &[[0.25, 0.25], [0.75, 0.75]],
        bounces: 4,
        shadows: true,
        ..settings(9, 8)
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run(&scene, &furnace_camera(9, 0.9), &settings))
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert_ne!(
        one,
        run(
            &scene,
            &furnace_camera(9, 0.9),
            &Settings {
                seed: 3,
                ..settings
            }
        )
    );
}

#[test]
fn punctual_lights_are_exact() {
    let mut scene = TestScene {
        material: matte([0.8; 3]),
        ..floor()
    };
    scene.emitters.clear();
    scene.punctual_lights = vec![PunctualLight::Point {
        position: [0.0, 0.0, 2.0],
        intensity: [5.0; 3],
        range: None,
    }];
    let middle = |_: f64, _: f64| Ray {
        origin: [-3.0, 0.0, 4.0],
        direction: [0.6, 0.0, -0.8],
    };
    let estimate = run(
        &scene,
        &middle,
        &Settings {
            shadows: true,
            ..settings(1, 2)
        },
    );
    assert!((estimate.diffuse.mean[0][0] - 0.8 / PI * 5.0 / 4.0).abs() < 1e-12);
    assert_eq!(estimate.total.standard_error[0], [0.0; 3]);
    scene.walls.push(Wall {
        corner: DVec3::new(-0.1, -0.1, 1.5),
        u: DVec3::X * 0.2,
        v: DVec3::Y * 0.2,
    });
    let dark = run(
        &scene,
        &middle,
        &Settings {
            shadows: true,
            ..settings(1, 2)
        },
    );
    assert_eq!(dark.total.mean[0], [0.0; 3]);
    assert_eq!(run(&scene, &middle, &settings(1, 2)), estimate);
}

#[test]
fn stops_and_refuses() {
    let scene = floor();
    let go = |settings: &Settings<'_>, cancel: &AtomicBool| {
        render(
            &scene,
            &camera(8),
            settings,
            &|_, _| cancel.store(true, Ordering::Relaxed),
            cancel,
        )
    };
    let fine = settings(8, 2);
    assert_eq!(
        go(&fine, &AtomicBool::new(true)),
        Err(RenderError::Cancelled)
    );
    assert_eq!(
        go(
            &Settings {
                height: 1000,
                ..fine
            },
            &AtomicBool::new(false)
        ),
        Err(RenderError::Cancelled)
    );
    let refused = |settings: Settings<'_>| go(&settings, &AtomicBool::new(false)).unwrap_err();
    assert!(matches!(
        refused(Settings { width: 0, ..fine }),
        RenderError::Size { .. }
    ));
    assert!(matches!(
        refused(Settings {
            width: usize::MAX,
            ..fine
        }),
        RenderError::Size { .. }
    ));
    assert_eq!(
        refused(Settings {
            pixel_samples: &[],
            ..fine
        }),
        RenderError::PixelSamples
    );
    assert_eq!(
        refused(Settings {
            pixel_samples: &[[0.5, 1.0]],
            ..fine
        }),
        RenderError::PixelSamples
    );
    let odd = refused(Settings {
        samples_per_pixel: 3,
        pixel_samples: &[[0.0; 2], [0.5; 2]],
        ..fine
    });
    assert_eq!(
        odd,
        RenderError::SamplesPerPixel {
            samples_per_pixel: 3,
            count: 2
        }
    );
    assert!(matches!(
        refused(Settings {
            samples_per_pixel: 1,
            ..fine
        }),
        RenderError::SamplesPerPixel { .. }
    ));
    assert_eq!(
        refused(Settings { bounces: 0, ..fine }),
        RenderError::Bounces
    );
}
