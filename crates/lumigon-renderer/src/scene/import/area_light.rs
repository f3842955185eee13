//! `EXT_lights_area`, as Khronos pull request 2525 has it.
//!
//! Area lights are "flat surfaces that uniformly emit light from one side", the node's -Z. The text
//! does not say whether the surface is seen; here it is, because its mirror image is: each light
//! becomes a mesh with an emissive black material, one-sided, and lights like any emissive face. The
//! node's rotation orients it and the largest of its scales sizes it. A disk becomes a regular
//! polygon of the same area.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use gltf::json;
use serde_json::Value;

use super::value::{index, number, numbers, object};
use crate::scene::{Material, Mesh, error::Fault};

/// Corners of a disk. At 64 the outline is within 0.09 % of a radius of the circle.
const DISK_CORNERS: u32 = 64;

/// The mesh and material of one node's light, and its positions before rounding.
pub(super) struct AreaLight {
    pub(super) mesh: Mesh,
    pub(super) positions: Vec<DVec3>,
    pub(super) material: Material,
}

/// The light of one node; `reference` is the node's own extension object.
pub(super) fn convert(
    root: &json::Root,
    reference: &Value,
    node_name: &str,
    world_from_local: &DAffine3,
    user: &str,
) -> Result<AreaLight, Fault> {
    let missing = || {
        Fault::new(
            user,
            "there is no such EXT_lights_area light",
            "use an index that exists",
        )
    };
    let reference = object(reference, user)?;
    let light_index = index(reference, "light", user)?.ok_or_else(missing)?;
    let value = root
        .extensions
        .as_ref()
        .and_then(|extensions| extensions.others.get("EXT_lights_area"))
        .and_then(|extension| extension.get("lights"))
        .and_then(|lights| lights.get(light_index))
        .ok_or_else(missing)?;
    let place = format!("extensions.EXT_lights_area.lights[{light_index}]");
    let light = object(value, &place)?;

    let color = Vec3::from(numbers(light, "color", [1.0; 3], &place)?);
    let intensity = number(light, "intensity", 1000.0, &place)?;
    let size = f64::from(number(light, "size", 1.0, &place)?);
    let outline = match light.get("type").and_then(Value::as_str) {
        Some("rect") => {
            let rect = light
                .get("rect")
                .map(|rect| object(rect, &place))
                .transpose()?;
            let aspect = match rect {
                Some(rect) => number(rect, "aspect", 1.0, &format!("{place}.rect"))?,
                None => 1.0,
            };
            let (x, y) = (0.5 * size * f64::from(aspect), 0.5 * size);
            // Counter-clockwise seen from -Z.
            vec![[x, y], [x, -y], [-x, -y], [-x, y]]
        }
        Some("disk") => {
            let step = TAU / f64::from(DISK_CORNERS);
            let radius = 0.5 * size * (step / step.sin()).sqrt();
            (0..DISK_CORNERS)
                .map(|i| (-step * f64::from(i)).sin_cos())
                .map(|(sin, cos)| [radius * cos, radius * sin])
                .collect()
        }
        _ => {
            return Err(Fault::new(
                place + ".type",
                "this is not a type of area light",
                "use rect or disk",
            ));
        }
    };
    if size <= 0.0 || intensity < 0.0 || color.min_element() < 0.0 {
        return Err(Fault::new(
            place,
            "its size, intensity and color are not all positive",
            "use positive numbers",
        ));
    }

    let rotation = rotation(&world_from_local.matrix3);
    let positions: Vec<DVec3> = outline
        .iter()
        .map(|&[x, y]| DVec3::new(x, y, 0.0) * largest_scale(&world_from_local.matrix3))
        .map(|p| rotation * p + world_from_local.translation)
        .collect();
    let name = light
        .get("name")
        .and_then(Value::as_str)
        .unwrap_or(node_name);
    let mesh = Mesh {
        name: name.to_owned(),
        positions: positions.iter().map(|p| p.as_vec3()).collect(),
        normals: vec![(rotation * DVec3::NEG_Z).as_vec3(); positions.len()],
        triangles: (1..positions.len() as u32 - 1)
            .map(|i| [0, i, i + 1])
            .collect(),
        ..Mesh::default()
    };
    let material = Material {
        name: name.to_owned(),
        base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
        metallic: 0.0,
        emissive: color * intensity,
        ..Material::default()
    };
    Ok(AreaLight {
        mesh,
        positions,
        material,
    })
}

fn largest_scale(matrix: &DMat3) -> f64 {
    let scales = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length);
    scales[0].max(scales[1]).max(scales[2])
}

/// The rotation of a node's world matrix: exact without shear, and keeping Z, then Y, with it.
pub(super) fn rotation(matrix: &DMat3) -> DMat3 {
    let z = matrix.z_axis.normalize_or(DVec3::Z);
    let y = (matrix.y_axis - z * z.dot(matrix.y_axis)).normalize_or(z.any_orthonormal_vector());
    DMat3::from_cols(y.cross(z), y, z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn disk_keeps_the_area_of_the_circle() {
        let root: json::Root = serde_json::from_str(
            r#"{"asset": {"version": "2.0"}, "extensions": {"EXT_lights_area": {"lights": [
                {"type": "disk", "size": 3, "intensity": 2, "color": [1, 0.5, 0]}]}}}"#,
        )
        .unwrap();
        let reference = serde_json::json!({"light": 0});
        let place = DAffine3::from_scale(DVec3::new(1.0, -2.0, 0.5));
        let light = convert(&root, &reference, "lamp", &place, "nodes[0]").unwrap();
        let area: DVec3 = light
            .mesh
            .triangles
            .iter()
            .map(|t| t.map(|i| light.positions[i as usize]))
            .map(|[a, b, c]| (b - a).cross(c - a) * 0.5)
            .sum();
        assert!((area - DVec3::NEG_Z * PI * 9.0).length() < 1e-12, "{area}");
        assert_eq!(light.material.emissive, Vec3::new(2.0, 1.0, 0.0));
        assert_eq!(
            (light.mesh.name.as_str(), light.mesh.normals[0]),
            ("lamp", Vec3::NEG_Z)
        );
    }
}
