//! Indirect light of the path tracer, against an integral over all surfaces that casts no rays at them.

use glam::{DVec3, Vec3};
use lumigon::{PolygonLight, Sides, irradiance};
use lumigon_renderer::{
    Camera, CpuRenderer, Pixels, ReferenceRendering, ReferenceSettings, RenderSettings, Scene,
    Watch,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::FRAC_1_PI;

const SIZE: u32 = 12;

fn load(name: &str) -> Scene {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    Scene::load(format!("{folder}/{name}")).unwrap()
}

/// A triangle's corners, front normal and reflectance.
struct Triangle {
    corners: [DVec3; 3],
    normal: DVec3,
    reflectance: DVec3,
}

fn triangles(scene: &Scene) -> Vec<Triangle> {
    let of_mesh = |mesh: &lumigon_renderer::Mesh| -> Vec<Triangle> {
        let color = scene.materials[mesh.material].base_color;
        (0..mesh.triangles.len())
            .map(|k| {
                let [a, b, c] = mesh.corners(k).map(Vec3::as_dvec3);
                Triangle {
                    corners: [a, b, c],
                    normal: (b - a).cross(c - a).normalize(),
                    reflectance: color.truncate().as_dvec3(),
                }
            })
            .collect()
    };
    scene.meshes.iter().flat_map(|mesh| of_mesh(mesh)).collect()
}

/// What a pixel's middle sees: the nearest triangle that faces the camera.
fn seen<'a>(
    triangles: &'a [Triangle],
    camera: &Camera,
    [x, y]: [u32; 2],
    [width, height]: [u32; 2],
) -> Option<(DVec3, &'a Triangle)> {
    let (u, v) = (
        (x as f32 + 0.5) / width as f32,
        (y as f32 + 0.5) / height as f32,
    );
    let (origin, direction) = camera.ray(u, v, width as f32 / height as f32);
    let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
    let hits = triangles.iter().filter_map(|triangle| {
        let cosine = -direction.dot(triangle.normal);
        let distance = (origin - triangle.corners[0]).dot(triangle.normal) / cosine;
        let point = origin + distance * direction;
        let inside = (0..3).all(|k| {
            let [a, b] = [k, (k + 1) % 3].map(|k| triangle.corners[k]);
            (b - a).cross(point - a).dot(triangle.normal) >= 0.0
        });
        (cosine > 0.0 && distance > 0.0 && inside).then_some((distance, point, triangle))
    });
    let (_, point, triangle) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((point, triangle))
}

/// A piece of a surface: its middle, normal, area, and the radiance that it sends everywhere.
struct Piece {
    position: DVec3,
    normal: DVec3,
    area: f64,
    radiance: DVec3,
}

/// Every triangle in `n`^2 pieces, each with a random point of it, under the scene's only light.
fn pieces(scene: &Scene, triangles: &[Triangle], n: u32) -> Vec<Piece> {
    let [source] = scene.polygon_lights.as_slice() else {
        panic!("one light")
    };
    let light: PolygonLight<f64> = PolygonLight::new(&source.loops, Sides::Front).unwrap();
    let color = source.radiance.as_dvec3();
    let mut random = Pcg64::seed_from_u64(5);
    let mut pieces = vec![];
    for triangle in triangles {
        let [a, b, c] = triangle.corners;
        let [u, v] = [b - a, c - a];
        let area = 0.5 * u.cross(v).length() / f64::from(n * n);
        // Rows of triangles that stand on an edge and of those that hang between them.
        for (i, j, hangs) in (0..n)
            .flat_map(|i| (0..n - i).map(move |j| (i, j)))
            .flat_map(|(i, j)| [(i, j, false), (i, j, true)])
            .filter(|&(i, j, hangs)| !hangs || i + j + 1 < n)
        {
            let (mut s, mut t) = (random.random::<f64>(), random.random::<f64>());
            if (s + t > 1.0) != hangs {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let at = |k: u32, s: f64| (f64::from(k) + s) / f64::from(n);
            let position = a + u * at(i, s) + v * at(j, t);
            let irradiance = irradiance(
                &light,
                position.to_array().into(),
                triangle.normal.to_array().into(),
            );
            pieces.push(Piece {
                position,
                normal: triangle.normal,
                area,
                radiance: triangle.reflectance * color * (irradiance * FRAC_1_PI),
            });
        }
    }
    pieces
}

fn traced(scene: &Scene, settings: ReferenceSettings) -> ReferenceRendering {
    let renderer = CpuRenderer::new(scene);
    renderer
        .reference(&scene.cameras[0], &settings, Watch::none())
        .unwrap()
}

fn sum(pixels: &Pixels) -> f64 {
    pixels.iter().flatten().map(|&x| f64::from(x)).sum()
}

#[test]
fn single_bounce_without_shadows_is_the_integral_over_all_surfaces() {
    let mut scene = load("cornell.glb");
    for material in &mut scene.materials {
        material.specular = 0.0;
    }
    let triangles = triangles(&scene);
    let pieces = pieces(&scene, &triangles, 40);
    let settings = ReferenceSettings {
        width: SIZE,
        height: SIZE,
        samples: 1,
        paths: 1024,
        bounces: 2,
        shadows: false,
        direct: false,
        bounce_shadows: false,
        seed: 1,
    };
    let estimate = traced(&scene, settings);
    let (mut z_squared, mut count) = (0.0, 0);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let Some((point, triangle)) = seen(&triangles, &scene.cameras[0], [x, y], [SIZE, SIZE])
            else {
                continue;
            };
            let mut nearest = f64::INFINITY;
            let arriving: DVec3 = pieces
                .iter()
                .map(|piece| {
                    let offset = piece.position - point;
                    let squared = offset.length_squared();
                    if offset.dot(triangle.normal) > 1e-6 {
                        nearest = nearest.min(squared / piece.area);
                    }
                    let cosines =
                        offset.dot(triangle.normal).max(0.0) * (-offset).dot(piece.normal).max(0.0);
                    piece.radiance * (piece.area * cosines / (squared * squared).max(1e-30))
                })
                .sum();
            // Beside a wall its pieces are too coarse.
            if nearest < 4.0 {
                continue;
            }
            let truth = triangle.reflectance * arriving * FRAC_1_PI;
            let pixel = (y * SIZE + x) as usize;
            for c in 0..3 {
                let (mean, error) = (
                    f64::from(estimate.mean.diffuse[pixel][c]),
                    f64::from(estimate.diffuse_error[pixel][c]),
                );
                // The integral has an error of its own, about a hundredth at this distance.
                let z = (mean - truth[c]) / error.hypot(0.01 * truth[c]).max(1e-9);
                assert!(
                    z.abs() < 5.0,
                    "pixel {x}, {y}, channel {c}: {mean} +- {error}, not {}",
                    truth[c]
                );
                z_squared += z * z;
                count += 1;
            }
        }
    }
    let rms = (z_squared / f64::from(count)).sqrt();
    println!("{count} values, rms z {rms:.3}");
    assert!(count > 300 && (0.5..1.2).contains(&rms), "{count}, {rms}");

    assert_eq!(sum(&estimate.mean.emitted), 0.0);
    let blocked = ReferenceSettings {
        bounce_shadows: true,
        ..settings
    };
    let [all, some] = [&estimate, &traced(&scene, blocked)].map(|e| sum(&e.mean.diffuse));
    // The two blocks hide walls from one another.
    assert!(some < 0.9 * all, "{some} of {all}");
}

#[test]
fn near_room_is_lit_by_indirect_light_alone() {
    let scene = load("two-rooms.glb");
    let [width, height] = [48, 30];
    let triangles = triangles(&scene);
    let settings = RenderSettings {
        width,
        height,
        samples: 1,
        ..RenderSettings::default()
    };
    let direct = CpuRenderer::new(&scene)
        .render(&scene.cameras[0], &settings, Watch::none())
        .unwrap()
        .radiance();
    let indirect = traced(
        &scene,
        ReferenceSettings {
            width,
            height,
            samples: 1,
            bounces: 4,
            direct: false,
            ..ReferenceSettings::default()
        },
    )
    .mean
    .radiance();
    let [mut near, mut far] = [0, 0];
    let mut sums = [0.0; 2];
    for y in 0..height {
        for x in 0..width {
            let seen = seen(&triangles, &scene.cameras[0], [x, y], [width, height]);
            let (point, _) = seen.expect("the rooms are closed");
            let pixel = (y * width + x) as usize;
            let brightest = direct[pixel].into_iter().fold(0.0, f32::max);
            // What stands in the doorway belongs to neither.
            if point.z > 1e-3 {
                assert!(brightest < 1e-6, "pixel {x}, {y} at {point}: {brightest}");
                near += 1;
                sums[1] += f64::from(indirect[pixel][1]);
            } else if point.z < -0.3 {
                far += 1;
                sums[0] += f64::from(direct[pixel][1] + indirect[pixel][1]);
            }
        }
    }
    let [far_mean, near_mean] = [sums[0] / f64::from(far), sums[1] / f64::from(near)];
    println!("{near} pixels of {near_mean:.4}, {far} of {far_mean:.4}");
    assert!(near > 700 && far > 100, "{near}, {far}");
    assert!(near_mean > 0.02 * far_mean && near_mean < far_mean);
}
