//! Virtual lights as something to look at.

use std::sync::Arc;

use earcut::Earcut;
use glam::{Vec2, Vec3, Vec4};
use lumigon_wgpu::Light;

use super::VirtualLights;
use super::virtual_lights::VirtualPoint;
use crate::scene::{AlphaMode, Material, Mesh, PunctualKind, PunctualLight, Scene};

/// What is left of a light's width, so that gaps draw the outlines.
const SHRINKAGE: f32 = 0.96;

/// How far lights are lifted off their surfaces, in diagonals of the scene.
const LIFT: f32 = 5e-4;

/// Area of all points together, in squared diagonals of the scene.
const AREA_OF_POINTS: f32 = 0.05;

/// Radiance of the surfaces, in means of the lights'.
const SURFACES: f32 = 0.2;

/// Linear reflectance of the surfaces.
const GREY: f32 = 0.5;

impl VirtualLights {
    /// The lights as surfaces that show their radiance, a little smaller than they are, over those of
    /// `surroundings` in dark grey: a debug view, to be rendered without specular light.
    ///
    /// Points become squares whose area is their share of the flux; all have the same mean radiance.
    /// Back sides are not there. The scene has no polygon lights; `surroundings` lends its cameras.
    #[must_use]
    pub fn to_scene(&self, surroundings: &Scene) -> Scene {
        let (low, high) = surroundings.bounds().unwrap_or_default();
        // Halved before subtracting: corners of a huge scene are finite, their distance may not be.
        let diagonal = 2.0 * (high * 0.5).distance(low * 0.5);
        let mut view = grey(surroundings);
        let lift = diagonal * LIFT;
        let (mut flux, mut area) = (0.0, 0.0);
        for light in &self.polygons {
            flux += mean(light.radiance.into()) * light.polygon.area();
            area += light.polygon.area();
            add_polygon(&mut view, light, lift);
        }
        let of_points: f32 = self.points.iter().map(|p| mean(p.intensity)).sum();
        if of_points > 0.0 {
            let radiance = of_points / (AREA_OF_POINTS * diagonal * diagonal);
            for point in &self.points {
                add_point(&mut view, point, radiance, lift);
            }
            (flux, area) = (radiance, 1.0);
        }
        let radiance = if area > 0.0 { flux / area } else { 1.0 };
        let irradiance = std::f32::consts::PI * SURFACES * radiance / GREY;
        // From two sides, unequally, so that corners show.
        for (direction, share) in [([-0.4, -0.8, -0.5], 1.0), ([0.6, 0.5, 0.3], 0.5)] {
            view.punctual_lights.push(PunctualLight {
                name: "orientation".to_owned(),
                kind: PunctualKind::Directional,
                position: Vec3::ZERO,
                direction: Vec3::from(direction).normalize(),
                color: Vec3::splat(irradiance * share),
                range: None,
            });
        }
        view
    }
}

fn mean(color: Vec3) -> f32 {
    color.element_sum() / 3.0
}

/// The surfaces alone, grey.
fn grey(scene: &Scene) -> Scene {
    let masked = |material: &Material| matches!(material.alpha_mode, AlphaMode::Mask { .. });
    let materials = scene.materials.iter().map(|material| Material {
        name: material.name.clone(),
        base_color: Vec3::splat(GREY).extend(material.base_color.w),
        // What is cut out stays cut out.
        base_color_texture: material.base_color_texture.filter(|_| masked(material)),
        metallic: 0.0,
        specular: 0.0,
        alpha_mode: material.alpha_mode,
        double_sided: material.double_sided,
        ..Material::default()
    });
    let meshes = scene.meshes.iter().map(|mesh| {
        let mut mesh = Mesh::clone(mesh);
        for color in &mut mesh.colors {
            *color = Vec3::ONE.extend(color.w);
        }
        Arc::new(mesh)
    });
    let textures = match scene.materials.iter().any(masked) {
        true => scene.textures.clone(),
        false => Vec::new(),
    };
    Scene {
        meshes: meshes.collect(),
        materials: materials.collect(),
        textures,
        cameras: scene.cameras.clone(),
        ..Scene::default()
    }
}

/// Adds triangles that show `radiance`.
fn add(
    view: &mut Scene,
    normal: Vec3,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    radiance: Vec3,
) {
    if triangles.is_empty() {
        return;
    }
    let material = view.materials.len();
    view.materials.push(Material {
        name: "virtual light".to_owned(),
        base_color: Vec4::new(radiance.x, radiance.y, radiance.z, 1.0),
        unlit: true,
        ..Material::default()
    });
    let mesh = Mesh {
        name: "virtual light".to_owned(),
        material,
        normals: vec![normal; positions.len()],
        positions,
        triangles,
        ..Mesh::default()
    };
    view.meshes.push(Arc::new(mesh));
}

fn add_point(view: &mut Scene, point: &VirtualPoint, radiance: f32, lift: f32) {
    let area = mean(point.intensity) / radiance;
    let (x, y) = point.normal.any_orthonormal_pair();
    let y = if x.cross(y).dot(point.normal) < 0.0 {
        -y
    } else {
        y
    };
    let center = point.position + point.normal * lift;
    let half = 0.5 * area.sqrt();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(|(a, b)| center + (x * a + y * b) * half);
    let visible = half > 0.0 && corners.iter().all(|corner| corner.is_finite());
    let triangles = if visible {
        vec![[0, 1, 2], [0, 2, 3]]
    } else {
        vec![]
    };
    let color = point.intensity / area;
    add(view, point.normal, corners.to_vec(), triangles, color);
}

fn add_polygon(view: &mut Scene, light: &Light, lift: f32) {
    let polygon = &light.polygon;
    let vector = |v: lumigon::Vec3<f32>| Vec3::new(v.x, v.y, v.z);
    let (normal, center) = (vector(polygon.normal()), vector(polygon.centroid()));
    let (x, y) = normal.any_orthonormal_pair();
    let y = if x.cross(y).dot(normal) < 0.0 { -y } else { y };
    let loops: Vec<Vec<Vec2>> = polygon
        .loops()
        .map(|vertices| {
            let flat = |v| {
                let offset = (vector(v) - center) * SHRINKAGE;
                Vec2::new(offset.dot(x), offset.dot(y))
            };
            vertices.into_iter().map(flat).collect()
        })
        .collect();
    let origin = center + normal * lift;
    let raised = |p: &Vec2| origin + x * p.x + y * p.y;
    let (flat, triangles) = triangulated(&loops);
    let positions = flat.iter().map(raised).collect();
    add(view, normal, positions, triangles, light.radiance.into());
}

/// Vertices, and the triangles that fill counter-clockwise loops less clockwise ones.
fn triangulated(loops: &[Vec<Vec2>]) -> (Vec<Vec2>, Vec<[u32; 3]>) {
    let (outers, holes): (Vec<_>, Vec<_>) = loops
        .iter()
        .filter(|vertices| vertices.len() >= 3)
        .partition(|vertices| area(vertices) > 0.0);
    let mut earcut = Earcut::new();
    let (mut all, mut triangles) = (Vec::new(), Vec::new());
    for &outer in &outers {
        let mut vertices = outer.clone();
        let mut hole_starts: Vec<u32> = Vec::new();
        for hole in &holes {
            // The midpoint of an edge: holes may touch their outline at vertices.
            if outers.len() == 1 || contains(outer, (hole[0] + hole[1]) * 0.5) {
                hole_starts.push(vertices.len() as u32);
                vertices.extend(*hole);
            }
        }
        let mut indices: Vec<u32> = Vec::new();
        let points = vertices.iter().map(Vec2::to_array);
        earcut.earcut(points, &hole_starts, &mut indices);
        let first = all.len() as u32;
        let corners = indices.chunks_exact(3);
        triangles.extend(corners.map(|t| [t[0] + first, t[1] + first, t[2] + first]));
        all.extend(vertices);
    }
    // Whichever way round they came.
    for t in &mut triangles {
        let [a, b, c] = t.map(|i| all[i as usize]);
        if (b - a).perp_dot(c - a) < 0.0 {
            t.swap(1, 2);
        }
    }
    (all, triangles)
}

fn area(vertices: &[Vec2]) -> f32 {
    let following = vertices.iter().cycle().skip(1);
    let pairs = vertices.iter().zip(following);
    0.5 * pairs.map(|(a, b)| a.perp_dot(*b)).sum::<f32>()
}

/// Whether a point lies in a loop, by the crossing number.
fn contains(vertices: &[Vec2], point: Vec2) -> bool {
    let following = vertices.iter().cycle().skip(1);
    let crosses = |(a, b): &(&Vec2, &Vec2)| {
        (a.y > point.y) != (b.y > point.y)
            && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    vertices.iter().zip(following).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumigon::{PolygonLight, Sides};

    fn surroundings() -> Scene {
        Scene {
            meshes: vec![Arc::new(Mesh {
                positions: vec![Vec3::ZERO, Vec3::X * 10.0, Vec3::Y * 10.0],
                normals: vec![Vec3::Z; 3],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            })],
            materials: vec![Material::default()],
            ..Scene::default()
        }
    }

    fn area_of(mesh: &Mesh) -> f32 {
        let cross = |k| {
            let [a, b, c] = mesh.corners(k);
            (b - a).cross(c - a) * 0.5
        };
        (0..mesh.triangles.len()).map(cross).sum::<Vec3>().z
    }

    #[test]
    fn a_frame_shows_its_area_and_radiance() {
        let square = |half: f64| -> Vec<[f64; 3]> {
            vec![
                [-half, -half, 0.0],
                [half, -half, 0.0],
                [half, half, 0.0],
                [-half, half, 0.0],
            ]
        };
        let mut hole = square(1.0);
        hole.reverse();
        let polygon = PolygonLight::new(&[square(2.0), hole], Sides::Front).unwrap();
        let lights = VirtualLights {
            polygons: vec![Light {
                polygon: polygon.cast().unwrap(),
                radiance: [3.0, 2.0, 1.0],
                image: None,
            }],
            ..VirtualLights::default()
        };
        let view = lights.to_scene(&surroundings());
        assert_eq!((view.meshes.len(), view.materials.len()), (2, 2));
        let shown = area_of(&view.meshes[1]);
        assert!(
            (shown / (12.0 * SHRINKAGE * SHRINKAGE) - 1.0).abs() < 1e-5,
            "{shown}"
        );
        let material = &view.materials[view.meshes[1].material];
        assert!(material.unlit && material.base_color == Vec4::new(3.0, 2.0, 1.0, 1.0));
    }

    #[test]
    fn points_are_as_large_as_their_flux() {
        let point = |z: f32, intensity: f32| VirtualPoint {
            position: Vec3::new(1.0, 1.0, z),
            normal: Vec3::Z,
            intensity: Vec3::splat(intensity),
            least_distance: 0.1,
        };
        let lights = VirtualLights {
            points: vec![point(0.0, 1.0), point(1.0, 4.0), point(2.0, 0.0)],
            ..VirtualLights::default()
        };
        let view = lights.to_scene(&surroundings());
        assert_eq!(view.meshes.len(), 3, "the dark one does not show");
        let [small, large] = [1, 2].map(|mesh| area_of(&view.meshes[mesh]));
        assert!(small > 0.0 && (large / small - 4.0).abs() < 1e-4);
        assert!((small + large) / (200.0 * AREA_OF_POINTS) < 1.001);
        let colors = [1, 2].map(|mesh| view.materials[view.meshes[mesh].material].base_color);
        assert!((colors[0] - colors[1]).abs().max_element() < 1e-4 * colors[0].x);
    }

    #[test]
    fn nothing_shows_nothing() {
        let view = VirtualLights::default().to_scene(&Scene::default());
        assert!(view.meshes.is_empty() && view.polygon_lights.is_empty());
    }
}
