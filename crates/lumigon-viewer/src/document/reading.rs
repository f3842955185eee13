//! A light of the scene to one that can be held.

use std::sync::Arc;

use glam::{DAffine2, DAffine3, DMat2, DMat3, DVec2, DVec3, Vec3, Vec4};
use lumigon_renderer::{EmissivePolygon, Material, Mesh, Scene, TextureMap, TextureRef};

use super::faces::is_masked;
use super::light::{centroid, plane_frame, quarter_turn, quarters_upright};
use super::surface::{Faces, Fixed, Surface};
use super::{Light, LightPicture, PictureImage};

/// How far texture coordinates may lie from a common map.
const SAME_MAP: f64 = 2.5e-4;

/// The light of a polygon of the scene.
pub(super) fn read(scene: &Scene, polygon: &EmissivePolygon) -> Light {
    let mesh = &scene.meshes[polygon.mesh];
    let material = &scene.materials[mesh.material];
    let world_from_plane = frame(polygon);
    let plane_from_world = world_from_plane.inverse();
    let to_plane = |p: DVec3| plane_from_world.transform_point3(p);
    let flat = |points: &Vec<[f64; 3]>| -> Vec<DVec2> {
        points
            .iter()
            .map(|&p| to_plane(p.into()).truncate())
            .collect()
    };
    let mut light = Light {
        name: polygon.name.clone(),
        world_from_plane,
        loops: polygon.loops.iter().map(flat).collect(),
        radiance: radiance(material, polygon),
        two_sided: polygon.two_sided,
        picture: picture(polygon, &plane_from_world),
        surface: Surface {
            material: Arc::new(material.clone()),
            texcoords_from_plane: [None; 2],
            color: None,
            fixed: None,
        },
    };

    let used = used_vertices(mesh, polygon);
    let mut reason = None;
    for set in 0..2 {
        if !others(material).any(|reference| reference.texcoord == set) {
            continue;
        }
        let Some(texcoords) = texcoords(mesh, set) else {
            continue;
        };
        let samples = used.iter().map(|&i| {
            let place = to_plane(mesh.positions[i as usize].as_dvec3()).truncate();
            (place, texcoords[i as usize].as_dvec2())
        });
        let samples: Vec<_> = samples.collect();
        match affine_map(&samples) {
            Some(map) => light.surface.texcoords_from_plane[set] = Some(map),
            None => reason = Some("its textures do not lie on it in one piece"),
        }
    }
    let colors = || {
        used.iter()
            .filter_map(|&i| mesh.colors.get(i as usize).copied())
    };
    match colors().next() {
        Some(first) if colors().all(|color| color == first) => light.surface.color = Some(first),
        Some(_) => reason = Some("the colours of its vertices differ"),
        None => {}
    }
    if is_masked(material) && reason.is_some() {
        reason = Some("what its alpha mask cuts out lies differently on its triangles");
    }
    if let Some(reason) = reason {
        // They keep their emissive texture, whatever it shows.
        light.radiance = material.emissive;
        light.surface.fixed = Some(Fixed {
            reason,
            faces: Arc::new(kept_faces(mesh, polygon, &light, &used)),
            plane_from_faces: DAffine2::IDENTITY,
        });
    }
    light
}

/// Its textures but the emissive one.
fn others(material: &Material) -> impl Iterator<Item = &TextureRef> {
    [
        &material.base_color_texture,
        &material.metallic_roughness_texture,
        &material.specular_texture,
        &material.specular_color_texture,
        &material.anisotropy_texture,
        &material.diffuse_roughness_texture,
        &material.sheen_color_texture,
        &material.sheen_roughness_texture,
        &material.clearcoat_texture,
        &material.clearcoat_roughness_texture,
        &material.clearcoat_normal_texture,
        &material.normal_texture,
        &material.occlusion_texture,
    ]
    .into_iter()
    .flatten()
}

fn texcoords(mesh: &Mesh, set: usize) -> Option<&[glam::Vec2]> {
    let texcoords = &mesh.texcoords[set];
    (!texcoords.is_empty()).then_some(texcoords.as_slice())
}

/// What a light's picture, or its one colour, is multiplied with.
fn radiance(material: &Material, polygon: &EmissivePolygon) -> Vec3 {
    match &polygon.image {
        Some(image) => image.strength,
        None if material.emissive_texture.is_none() => material.emissive,
        None => polygon.radiance,
    }
}

fn picture(polygon: &EmissivePolygon, plane_from_world: &DAffine3) -> Option<LightPicture> {
    let emission = polygon.image.as_ref()?.emission?;
    Some(LightPicture {
        image: PictureImage::Scene(emission.texture),
        texture_from_plane: texture_from_plane(&emission.map, plane_from_world),
    })
}

fn texture_from_plane(map: &TextureMap, plane_from_world: &DAffine3) -> DAffine2 {
    let world_from_plane = plane_from_world.inverse();
    let [u, v] = map.gradients.map(DVec3::from);
    let along = |axis: DVec3| DVec2::new(u.dot(axis), v.dot(axis));
    let origin = map.uv(world_from_plane.translation.to_array());
    DAffine2 {
        matrix2: DMat2::from_cols(
            along(world_from_plane.matrix3.x_axis),
            along(world_from_plane.matrix3.y_axis),
        ),
        translation: origin.into(),
    }
}

/// Its plane: origin at the centroid, one axis along the longest edge, y as near to up as that leaves.
fn frame(polygon: &EmissivePolygon) -> DAffine3 {
    let origin = polygon.loops.iter().flatten().next();
    let origin = origin.map_or(DVec3::ZERO, |&p| DVec3::from(p));
    let upright = plane_frame(origin, DVec3::from(polygon.area_vector()));
    let from_world = upright.inverse();
    let flat = |points: &Vec<[f64; 3]>| -> Vec<DVec2> {
        let flat = |&p: &[f64; 3]| from_world.transform_point3(p.into()).truncate();
        points.iter().map(flat).collect()
    };
    let loops: Vec<Vec<DVec2>> = polygon.loops.iter().map(flat).collect();
    let center = centroid(&loops);
    let longest = loops.first().and_then(|outer| {
        let edges = outer.iter().zip(outer.iter().cycle().skip(1));
        // The first of those that differ by rounding alone.
        edges
            .map(|(&a, &b)| b - a)
            .fold(None, |best: Option<DVec2>, edge| match best {
                Some(best) if edge.length() <= best.length() * (1.0 + 1e-5) => Some(best),
                _ => Some(edge),
            })
    });
    let x = longest.and_then(DVec2::try_normalize).unwrap_or(DVec2::X);
    let turned = upright.matrix3 * DMat3::from_mat2(DMat2::from_cols(x, x.perp()));
    let quarters = quarters_upright(turned);
    DAffine3 {
        matrix3: super::light::orthonormal(turned * DMat3::from_mat2(quarter_turn(quarters))),
        translation: upright.transform_point3(center.extend(0.0)),
    }
}

fn used_vertices(mesh: &Mesh, polygon: &EmissivePolygon) -> Vec<u32> {
    let corners = polygon
        .triangles
        .iter()
        .flat_map(|&t| mesh.triangles[t as usize]);
    let mut used: Vec<u32> = corners.collect();
    used.sort_unstable();
    used.dedup();
    used
}

/// The affine map that all samples are on; `None` where there is none.
fn affine_map(samples: &[(DVec2, DVec2)]) -> Option<DAffine2> {
    let &(origin, at_origin) = samples.first()?;
    // Three samples that span the most: the farthest from the first, and from the line to it.
    let along = samples.iter().max_by(|a, b| {
        a.0.distance_squared(origin)
            .total_cmp(&b.0.distance_squared(origin))
    })?;
    let x = along.0 - origin;
    let across = samples.iter().max_by(|a, b| {
        let height = |p: DVec2| x.perp_dot(p - origin).abs();
        height(a.0).total_cmp(&height(b.0))
    })?;
    let place = DMat2::from_cols(x, across.0 - origin);
    let change = DMat2::from_cols(along.1 - at_origin, across.1 - at_origin);
    let matrix2 = change * place.inverse();
    let map = DAffine2 {
        matrix2,
        translation: at_origin - matrix2 * origin,
    };
    let tolerance = |uv: DVec2| SAME_MAP + 4.0 * f64::from(f32::EPSILON) * uv.abs().max_element();
    let fits = |&(p, uv): &(DVec2, DVec2)| map.transform_point2(p).distance(uv) <= tolerance(uv);
    (map.is_finite() && samples.iter().all(fits)).then_some(map)
}

/// The polygon's triangles in the light's frame.
fn kept_faces(mesh: &Mesh, polygon: &EmissivePolygon, light: &Light, used: &[u32]) -> Faces {
    let plane_from_world = light.world_from_plane.inverse();
    let turn = plane_from_world.matrix3;
    let direction = |v: Vec3| (turn * v.as_dvec3()).as_vec3();
    let pick = |i: &u32| *i as usize;
    let tangent = |t: Vec4| direction(t.truncate()).extend(t.w);
    let texcoords = |set: usize| -> Vec<glam::Vec2> {
        texcoords(mesh, set).map_or_else(Vec::new, |list| {
            used.iter().map(|i| list[pick(i)]).collect()
        })
    };
    let renamed = |i: u32| used.partition_point(|&k| k < i) as u32;
    let of_used = |i: &u32| plane_from_world.transform_point3(mesh.positions[pick(i)].as_dvec3());
    Faces {
        loops: light.loops.clone(),
        positions: used.iter().map(of_used).collect(),
        normals: used
            .iter()
            .map(|i| direction(mesh.normals[pick(i)]))
            .collect(),
        tangents: used
            .iter()
            .filter_map(|i| mesh.tangents.get(pick(i)).map(|&t| tangent(t)))
            .collect(),
        texcoords: [texcoords(0), texcoords(1)],
        colors: used
            .iter()
            .filter_map(|i| mesh.colors.get(pick(i)).copied())
            .collect(),
        triangles: polygon
            .triangles
            .iter()
            .map(|&t| mesh.triangles[t as usize].map(renamed))
            .collect(),
    }
}
