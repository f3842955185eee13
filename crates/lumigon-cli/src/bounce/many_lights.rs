//! A room with as many lights as wanted.

use std::sync::Arc;

use glam::Vec3;
use lumigon_renderer::{EmissivePolygon, Material, Mesh, Scene};

const HALF: f32 = 4.0;
const HEIGHT: f32 = 3.0;
/// Of all lights together, in watts a channel.
const FLUX: f32 = 400.0;

/// A furnished room under `count` square lights of equal size, on a grid below the ceiling; they have
/// the same flux together, however many they are.
pub(super) fn room(count: usize) -> Scene {
    let mut scene = Scene::default();
    let colors = [
        [0.75, 0.73, 0.7],
        [0.6, 0.08, 0.06],
        [0.08, 0.2, 0.5],
        [0.3, 0.2, 0.1],
    ];
    for color in colors {
        scene.materials.push(Material {
            base_color: Vec3::from(color).extend(1.0),
            metallic: 0.0,
            specular: 0.0,
            ..Material::default()
        });
    }
    let (low, high) = (Vec3::new(-HALF, 0.0, -HALF), Vec3::new(HALF, HEIGHT, HALF));
    for (face, quad) in faces(low, high).into_iter().enumerate() {
        // Red to the left, blue to the right, seen from inside.
        let material = [1, 2, 3, 0, 0, 0][face];
        let [a, b, c, d] = quad;
        add(&mut scene, "room", [d, c, b, a], material);
    }
    for (low, high, material) in [
        ([-3.0, 0.0, -3.0], [-1.8, 1.9, -2.4], 0),
        ([0.5, 0.0, -1.0], [2.3, 0.75, 0.2], 3),
        ([2.8, 0.0, 1.5], [3.9, 1.0, 3.2], 1),
    ] {
        for quad in faces(low.into(), high.into()) {
            add(&mut scene, "box", quad, material);
        }
    }
    add_lights(&mut scene, count);
    scene
}

fn add_lights(scene: &mut Scene, count: usize) {
    let columns = (count as f32).sqrt().ceil().max(1.0);
    let rows = (count as f32 / columns).ceil().max(1.0);
    let spacing = 2.0 * HALF / columns.max(rows);
    let half = (0.2 * spacing).min(0.4);
    let area = 4.0 * half * half;
    let radiance = Vec3::splat(FLUX / (std::f32::consts::PI * area * count.max(1) as f32));
    let material = scene.materials.len();
    scene.materials.push(Material {
        emissive: radiance,
        base_color: Vec3::ZERO.extend(1.0),
        metallic: 0.0,
        specular: 0.0,
        ..Material::default()
    });
    for light in 0..count {
        let (column, row) = (light as f32 % columns, (light as f32 / columns).floor());
        let place = |index: f32, of: f32| HALF * (2.0 * (index + 0.5) / of - 1.0);
        let center = Vec3::new(place(column, columns), HEIGHT - 0.1, place(row, rows));
        // Counter-clockwise seen from below.
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let corners = corners.map(|[x, z]| center + Vec3::new(x * half, 0.0, z * half));
        let mesh = scene.meshes.len();
        add(scene, "light", corners, material);
        scene.polygon_lights.push(EmissivePolygon {
            name: format!("light {light}"),
            loops: vec![corners.map(|v| v.as_dvec3().to_array()).to_vec()],
            radiance,
            image: None,
            two_sided: false,
            mesh,
            triangles: vec![0, 1],
        });
    }
}

/// The faces of a box, counter-clockwise seen from outside: -x, +x, -y, +y, -z, +z.
fn faces(low: Vec3, high: Vec3) -> [[Vec3; 4]; 6] {
    let v = |x: bool, y: bool, z: bool| {
        let pick = |up: bool, axis: usize| if up { high[axis] } else { low[axis] };
        Vec3::new(pick(x, 0), pick(y, 1), pick(z, 2))
    };
    let (o, i) = (false, true);
    [
        [v(o, o, o), v(o, o, i), v(o, i, i), v(o, i, o)],
        [v(i, o, o), v(i, i, o), v(i, i, i), v(i, o, i)],
        [v(o, o, o), v(i, o, o), v(i, o, i), v(o, o, i)],
        [v(o, i, o), v(o, i, i), v(i, i, i), v(i, i, o)],
        [v(o, o, o), v(o, i, o), v(i, i, o), v(i, o, o)],
        [v(o, o, i), v(i, o, i), v(i, i, i), v(o, i, i)],
    ]
}

fn add(scene: &mut Scene, name: &str, corners: [Vec3; 4], material: usize) {
    let [a, b, _, d] = corners;
    let normal = (b - a).cross(d - a).normalize_or(Vec3::Y);
    scene.meshes.push(Arc::new(Mesh {
        name: name.to_owned(),
        material,
        positions: corners.to_vec(),
        normals: vec![normal; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumigon_renderer::CpuRenderer;

    #[test]
    fn lights_face_down_and_share_the_flux() {
        for count in [0, 1, 3, 10, 1000] {
            let scene = room(count);
            assert_eq!(scene.polygon_lights.len(), count);
            assert!(CpuRenderer::new(&scene).warnings().is_empty());
            let flux: f64 = scene
                .polygon_lights
                .iter()
                .map(|light| {
                    let [x, y, z] = light.area_vector();
                    assert!(
                        y < 0.0 && x.abs() < 1e-6 && z.abs() < 1e-6,
                        "{:?}",
                        [x, y, z]
                    );
                    light.area() * f64::from(light.radiance.x) * std::f64::consts::PI
                })
                .sum();
            let expected = if count == 0 { 0.0 } else { f64::from(FLUX) };
            assert!((flux - expected).abs() < 1e-2, "{count}: {flux}");
        }
    }

    #[test]
    fn walls_face_inwards_and_boxes_outwards() {
        let scene = room(0);
        let middle = Vec3::new(0.0, 0.5 * HEIGHT, 0.0);
        for mesh in scene.meshes.iter().filter(|mesh| mesh.name == "room") {
            let [a, ..] = mesh.corners(0);
            assert!(
                mesh.normals[0].dot(middle - a) > 0.0,
                "{:?}",
                mesh.normals[0]
            );
        }
        let boxes: Vec<_> = scene
            .meshes
            .iter()
            .filter(|mesh| mesh.name == "box")
            .collect();
        for faces in boxes.chunks(6) {
            let all = || faces.iter().flat_map(|mesh| &mesh.positions);
            let center = all().sum::<Vec3>() / 24.0;
            for mesh in faces {
                assert!(mesh.normals[0].dot(mesh.positions[0] - center) > 0.0);
            }
        }
    }
}
