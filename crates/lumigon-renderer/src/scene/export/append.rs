//! New meshes, each with a node of its own.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};
use serde_json::{Map, Value, json};

use super::{
    SaveError,
    document::{Document, Vacant, numbers},
    material::Materials,
    object,
};
use crate::scene::Mesh;

/// Appends a mesh and its node, which stands at the root of the scene that is shown, placed by
/// `world_from_local` where that is rigid; a vacant node of the same name is taken. Meshes without
/// triangles leave nothing.
pub(super) fn mesh(
    document: &mut Document<'_>,
    materials: &mut Materials<'_>,
    mesh: &Mesh,
    world_from_local: Option<&DAffine3>,
) -> Result<(), SaveError> {
    if mesh.triangles.is_empty() {
        return Ok(());
    }
    check(mesh)?;
    let mut node = Map::new();
    let frame = world_from_local.and_then(|frame| rigid(frame, &mut node));
    let frame = frame.unwrap_or(DAffine3::IDENTITY);
    let to_local = frame.inverse();
    let point = |p: &Vec3| to_local.transform_point3(p.as_dvec3()).as_vec3().to_array();
    // A rotation's inverse; rounding must not leave a length other than 1.
    let turn = |n: Vec3| {
        (to_local.matrix3 * n.as_dvec3())
            .normalize_or_zero()
            .as_vec3()
    };

    let mut attributes = Map::new();
    let mut attribute = |name: &str, accessor: usize| {
        attributes.insert(name.to_owned(), json!(accessor));
    };
    let positions = document.attribute(mesh.positions.iter().map(point), true)?;
    attribute("POSITION", positions);
    let normals = mesh.normals.iter().map(|&n| turn(n).to_array());
    attribute("NORMAL", document.attribute(normals, false)?);
    if !mesh.tangents.is_empty() {
        let tangents = mesh.tangents.iter();
        let tangents = tangents.map(|t| turn(t.truncate()).extend(t.w).to_array());
        attribute("TANGENT", document.attribute(tangents, false)?);
    }
    // The second set means nothing without a first, which glTF then demands.
    let sets = mesh.texcoords.iter().rposition(|set| !set.is_empty());
    for (i, set) in mesh
        .texcoords
        .iter()
        .enumerate()
        .take(sets.map_or(0, |last| last + 1))
    {
        let texcoords = if set.is_empty() {
            let none = std::iter::repeat_n([0.0; 2], mesh.positions.len());
            document.attribute(none.collect::<Vec<_>>().into_iter(), false)?
        } else {
            document.attribute(set.iter().map(Vec2::to_array), false)?
        };
        attribute(&format!("TEXCOORD_{i}"), texcoords);
    }
    if !mesh.colors.is_empty() {
        let colors = mesh.colors.iter().map(Vec4::to_array);
        attribute("COLOR_0", document.attribute(colors, false)?);
    }
    let indices = document.indices(&mesh.triangles, mesh.positions.len())?;
    let mut primitive = json!({"attributes": attributes, "indices": indices});
    if let Some(material) = materials.index(document, mesh.material)? {
        primitive["material"] = json!(material);
    }
    let mut json = json!({"primitives": [primitive]});
    // What came off a node goes back there: a light that was edited stays the node it was.
    let is_its = |vacant: &Vacant| vacant.names.contains(&mesh.name);
    if let Some(found) = document.vacant.iter().position(is_its) {
        let vacant = document.vacant.remove(found);
        if let Some(name) = vacant.mesh_name {
            json["name"] = name;
        }
        let index = document.push("meshes", json)?;
        node.insert("mesh".to_owned(), json!(index));
        let old = document.object("nodes", vacant.node)?;
        old.retain(|key, _| {
            !["matrix", "translation", "rotation", "scale"].contains(&key.as_str())
        });
        old.extend(node);
        return Ok(());
    }
    let index = document.push("meshes", json)?;
    node.insert("mesh".to_owned(), json!(index));
    if !mesh.name.is_empty() {
        node.insert("name".to_owned(), json!(mesh.name));
    }
    let node = document.push("nodes", Value::Object(node))?;
    show(document, node)
}

/// Refuses what would not be read again.
fn check(mesh: &Mesh) -> Result<(), SaveError> {
    let refuse = |what: &str| Err(SaveError::scene(format!("mesh \"{}\"", mesh.name), what));
    let count = mesh.positions.len();
    let optional = [
        mesh.tangents.len(),
        mesh.texcoords[0].len(),
        mesh.texcoords[1].len(),
        mesh.colors.len(),
    ];
    if mesh.normals.len() != count || optional.iter().any(|&n| n != 0 && n != count) {
        return refuse("not every attribute has one value for each vertex");
    }
    if mesh
        .triangles
        .as_flattened()
        .iter()
        .any(|&i| i as usize >= count)
    {
        return refuse("a triangle has a corner that is none of its vertices");
    }
    let finite = mesh.positions.iter().all(|p| p.is_finite())
        && mesh.normals.iter().all(|n| n.is_finite())
        && mesh.tangents.iter().all(|t| t.is_finite())
        && mesh.texcoords.iter().flatten().all(|uv| uv.is_finite())
        && mesh.colors.iter().all(|c| c.is_finite());
    if !finite {
        return refuse("a vertex is not finite");
    }
    Ok(())
}

/// Writes a rigid transform to a node as translation and rotation. Returns the transform that these
/// make when they are read, or `None` where it is not rigid.
fn rigid(frame: &DAffine3, node: &mut Map<String, Value>) -> Option<DAffine3> {
    let DAffine3 {
        matrix3,
        translation,
    } = *frame;
    let off = matrix3.transpose() * matrix3 - DMat3::IDENTITY;
    let off = off
        .to_cols_array()
        .iter()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    let is_rigid = frame.is_finite() && off < 1e-6 && matrix3.determinant() > 0.0;
    if !is_rigid || translation.abs().max_element() > f64::from(f32::MAX) {
        return None;
    }
    let rotation = DQuat::from_mat3(&matrix3).normalize().as_quat();
    let translation = translation.as_vec3();
    if translation != Vec3::ZERO {
        node.insert("translation".to_owned(), numbers(translation.to_array()));
    }
    if rotation.to_array() != [0.0, 0.0, 0.0, 1.0] {
        node.insert("rotation".to_owned(), numbers(rotation.to_array()));
    }
    let read = DQuat::from_array(rotation.to_array().map(f64::from)).normalize();
    let translation = DVec3::from(translation.to_array().map(f64::from));
    Some(DAffine3::from_rotation_translation(read, translation))
}

/// Adds a node to the roots of the scene that is shown. A file without scenes shows all nodes.
fn show(document: &mut Document<'_>, node: usize) -> Result<(), SaveError> {
    let json = document.json_mut();
    let index = json.get("scene").and_then(Value::as_u64).unwrap_or(0);
    let Some(scenes) = json.get_mut("scenes").and_then(Value::as_array_mut) else {
        return Ok(());
    };
    if scenes.is_empty() {
        return Ok(());
    }
    let place = || format!("scenes[{index}]");
    let scene = usize::try_from(index).ok().and_then(|i| scenes.get_mut(i));
    let nodes = object(scene, place)?
        .entry("nodes")
        .or_insert_with(|| json!([]));
    let nodes = nodes.as_array_mut().ok_or_else(|| SaveError::File {
        place: place() + ".nodes",
        what: "this is not a JSON array".to_owned(),
    })?;
    nodes.push(json!(node));
    Ok(())
}
