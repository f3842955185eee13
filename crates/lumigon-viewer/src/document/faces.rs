//! A light to the mesh and the material that show it.

use std::sync::Arc;

use earcut::Earcut;
use glam::{DAffine2, DAffine3, DVec2, DVec3, Mat3, Vec2, Vec3, Vec4};
use lumigon_renderer::{AlphaMode, Material, Mesh, TextureRef, TextureTransform};

use super::Light;
use super::light::signed_area;
use super::outline::contains;

/// How far two maps to texture coordinates may differ over a light and be one.
const SAME_MAP: f64 = 1e-6;

/// The mesh of a light, of material `material`, and that material. `texture` is its picture's index in
/// the scene.
///
/// Without loops that enclose area the mesh has no triangles.
pub(super) fn faces(light: &Light, material: usize, texture: Option<usize>) -> (Mesh, Material) {
    let surface = &light.surface;
    let mut made = Material::clone(&surface.material);
    made.emissive = light.radiance;
    made.double_sided = light.two_sided;
    let mut maps = surface.texcoords_from_plane;
    match (&light.picture, texture) {
        (Some(picture), Some(texture)) => {
            let (set, transform) = place(light, picture.texture_from_plane, &mut maps);
            made.emissive_texture = Some(TextureRef {
                texture,
                texcoord: set,
                transform,
            });
        }
        // Fixed faces show the texture that they came with.
        _ if surface.fixed.is_some() => {}
        _ => made.emissive_texture = None,
    }
    let mut mesh = match &surface.fixed {
        Some(fixed) => {
            let mut mesh = fixed_mesh(light, fixed);
            let points: Vec<DVec2> = fixed
                .faces
                .positions
                .iter()
                .map(|p| fixed.plane_from_faces.transform_point2(p.truncate()))
                .collect();
            give_texcoords(&mut mesh, &points, &maps);
            mesh
        }
        None => cut(light, &maps),
    };
    mesh.name.clone_from(&light.name);
    mesh.material = material;
    drop_flat(&mut mesh);
    (mesh, made)
}

/// Which set of texture coordinates shows the picture, and how; a set that has no map yet is given one.
fn place(
    light: &Light,
    texture_from_plane: DAffine2,
    maps: &mut [Option<DAffine2>; 2],
) -> (usize, TextureTransform) {
    let before = light.surface.material.emissive_texture;
    if let Some(reference) = before
        && let Some(map) = maps[reference.texcoord]
    {
        let own = affine(&reference.transform) * map;
        let points = light.loops.iter().flatten();
        let same = |&p: &DVec2| {
            let (a, b) = (
                own.transform_point2(p),
                texture_from_plane.transform_point2(p),
            );
            a.distance(b) <= SAME_MAP * (1.0 + b.length())
        };
        if points.clone().all(same) {
            return (reference.texcoord, reference.transform);
        }
    }
    let is_empty = |set: usize| {
        let fixed = light.surface.fixed.as_ref();
        fixed.is_none_or(|fixed| fixed.faces.texcoords[set].is_empty())
    };
    let mut free = (0..2).filter(|&set| maps[set].is_none());
    // Where both are in use, the other textures of fixed faces lose their place.
    if let Some(free) = free.clone().find(|&set| is_empty(set)).or(free.next()) {
        maps[free] = Some(texture_from_plane);
        return (free, TextureTransform::default());
    }
    // Other textures use both sets: the transform makes the difference.
    let map = maps[0].unwrap_or(DAffine2::IDENTITY);
    let inverse = map.inverse();
    let inverse = if inverse.is_finite() {
        inverse
    } else {
        DAffine2::IDENTITY
    };
    let m = texture_from_plane * inverse;
    let column = |v: DVec2, w: f32| v.as_vec2().extend(w);
    let transform = TextureTransform {
        texture_from_texcoord: Mat3::from_cols(
            column(m.matrix2.x_axis, 0.0),
            column(m.matrix2.y_axis, 0.0),
            column(m.translation, 1.0),
        ),
    };
    (0, transform)
}

/// A texture transform in double precision.
pub(super) fn affine(transform: &TextureTransform) -> DAffine2 {
    let [x, y, t] = [0, 1, 2].map(|i| transform.texture_from_texcoord.col(i).truncate().as_dvec2());
    DAffine2::from_cols(x, y, t)
}

fn give_texcoords(mesh: &mut Mesh, points: &[DVec2], maps: &[Option<DAffine2>; 2]) {
    for (texcoords, map) in mesh.texcoords.iter_mut().zip(maps) {
        if let Some(map) = map {
            let apply = |&p: &DVec2| map.transform_point2(p).as_vec2();
            *texcoords = points.iter().map(apply).collect();
        }
    }
    // Sets are numbered without gaps.
    if mesh.texcoords[0].is_empty() && !mesh.texcoords[1].is_empty() {
        mesh.texcoords[0] = vec![Vec2::ZERO; points.len()];
    }
}

/// The outline, cut into triangles whose fronts are towards +z.
fn cut(light: &Light, maps: &[Option<DAffine2>; 2]) -> Mesh {
    let points: Vec<DVec2> = light.loops.iter().flatten().copied().collect();
    let normal = light.normal().as_vec3();
    let color = light.surface.color;
    let mut mesh = Mesh {
        positions: points
            .iter()
            .map(|&p| light.to_world(p).as_vec3())
            .collect(),
        normals: vec![normal; points.len()],
        colors: color.map_or_else(Vec::new, |color| vec![color; points.len()]),
        triangles: triangulate(&light.loops),
        ..Mesh::default()
    };
    give_texcoords(&mut mesh, &points, maps);
    mesh
}

/// Triangles of the points of all loops, one loop after the other, counter-clockwise: each outer loop
/// less the holes in it.
pub(super) fn triangulate(loops: &[Vec<DVec2>]) -> Vec<[u32; 3]> {
    let mut starts = Vec::with_capacity(loops.len());
    let mut count = 0_u32;
    for points in loops {
        starts.push(count);
        count += points.len() as u32;
    }
    let areas: Vec<f64> = loops.iter().map(|points| signed_area(points)).collect();
    let outers: Vec<usize> = (0..loops.len()).filter(|&i| areas[i] > 0.0).collect();
    let mut holes: Vec<Vec<usize>> = vec![Vec::new(); loops.len()];
    for hole in (0..loops.len()).filter(|&i| areas[i] < 0.0) {
        let owner = match outers[..] {
            [only] => Some(only),
            _ => {
                // Touching loops share vertices, not the middles of edges.
                let inside = (loops[hole][0] + loops[hole][1]) * 0.5;
                let around = outers
                    .iter()
                    .filter(|&&outer| contains(&loops[outer], inside));
                around
                    .copied()
                    .min_by(|&a, &b| areas[a].total_cmp(&areas[b]))
            }
        };
        if let Some(owner) = owner {
            holes[owner].push(hole);
        }
    }

    let mut earcut = Earcut::new();
    let mut triangles = Vec::new();
    let mut cut: Vec<u32> = Vec::new();
    for outer in outers {
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut sources: Vec<u32> = Vec::new();
        let mut hole_starts: Vec<u32> = Vec::new();
        for &i in std::iter::once(&outer).chain(&holes[outer]) {
            if i != outer {
                hole_starts.push(points.len() as u32);
            }
            points.extend(loops[i].iter().map(DVec2::to_array));
            sources.extend((0..loops[i].len() as u32).map(|k| starts[i] + k));
        }
        earcut.earcut_slice(&points, &hole_starts, &mut cut);
        triangles.extend(cut.as_chunks::<3>().0.iter().filter_map(|t| {
            let [a, b, c] = t.map(|k| DVec2::from(points[k as usize]));
            let doubled = (b - a).perp_dot(c - a);
            let [i, j, k] = t.map(|k| sources[k as usize]);
            if doubled > 0.0 {
                Some([i, j, k])
            } else {
                (doubled < 0.0).then_some([i, k, j])
            }
        }));
    }
    triangles
}

fn fixed_mesh(light: &Light, fixed: &super::surface::Fixed) -> Mesh {
    let faces = &fixed.faces;
    let scale = fixed.plane_from_faces.matrix2;
    let plane_from_faces = DAffine3::from_mat3_translation(
        glam::DMat3::from_mat2(scale),
        fixed.plane_from_faces.translation.extend(0.0),
    );
    let world_from_faces = light.world_from_plane * plane_from_faces;
    let turn = world_from_faces.matrix3;
    let normals_turn = turn.inverse().transpose();
    let direction = |v: Vec3, by: glam::DMat3| {
        (by * v.as_dvec3())
            .try_normalize()
            .unwrap_or(light.normal())
            .as_vec3()
    };
    let position = |&p: &DVec3| world_from_faces.transform_point3(p).as_vec3();
    let tangent = |t: &Vec4| direction(t.truncate(), turn).extend(t.w);
    Mesh {
        positions: faces.positions.iter().map(position).collect(),
        normals: faces
            .normals
            .iter()
            .map(|&n| direction(n, normals_turn))
            .collect(),
        tangents: faces.tangents.iter().map(tangent).collect(),
        texcoords: faces.texcoords.clone(),
        colors: faces.colors.clone(),
        triangles: faces.triangles.clone(),
        ..Mesh::default()
    }
}

/// Takes off triangles that have no area in single precision.
fn drop_flat(mesh: &mut Mesh) {
    let positions = &mesh.positions;
    mesh.triangles.retain(|t| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        (b - a).cross(c - a) != Vec3::ZERO
    });
}

/// Whether its alpha mode asks for the base colour's alpha.
pub(super) fn is_masked(material: &Material) -> bool {
    matches!(material.alpha_mode, AlphaMode::Mask { .. })
}

/// An empty mesh in the place of one that has gone: other meshes keep their indices.
pub(super) fn nothing(mesh: &Mesh) -> Arc<Mesh> {
    Arc::new(Mesh {
        name: mesh.name.clone(),
        material: mesh.material,
        ..Mesh::default()
    })
}
