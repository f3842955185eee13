//! What happened to the file's own meshes: triangles that are gone, other materials.

use std::collections::{BTreeMap, HashMap, HashSet};

use gltf::json;
use serde_json::{Map, Value, json};

use super::{
    GltfSource, SaveError,
    document::{Document, Vacant},
    material::Materials,
    object,
};
use crate::scene::{Mesh, MeshSource, Scene, import};

/// What becomes of one primitive.
#[derive(Default)]
struct Change {
    /// The triangles that are left, by the file's indices; `None` for all of them.
    left: Option<Vec<[u32; 3]>>,
    /// Another material: the file's index, or glTF's default one.
    material: Option<Option<usize>>,
    /// What the scene calls it.
    name: String,
}

/// Patches the file's meshes and nodes. Returns the indices of those meshes that must be written anew,
/// as they were changed in other ways; their primitives are gone.
pub(super) fn patch(
    source: &GltfSource,
    document: &mut Document<'_>,
    materials: &mut Materials<'_>,
    original: &Scene,
    edited: &Scene,
) -> Result<Vec<usize>, SaveError> {
    if edited.meshes.len() < original.meshes.len() {
        return Err(SaveError::scene(
            "the scene",
            "it has fewer meshes than the file: removed ones must stay as empty ones",
        ));
    }
    let mut root = None;
    let mut anew = Vec::new();
    let mut changes: BTreeMap<(usize, usize), BTreeMap<usize, Change>> = BTreeMap::new();
    for (index, (old, new)) in original.meshes.iter().zip(&edited.meshes).enumerate() {
        let other_material = old.material != new.material || materials.is_replaced(new.material);
        if !other_material && (std::sync::Arc::ptr_eq(old, new) || old == new) {
            continue;
        }
        let part = || format!("mesh \"{}\"", old.name);
        match old.source {
            None => return Err(SaveError::scene(part(), "it is not of the loaded file")),
            Some(MeshSource::AreaLight { node }) => {
                take_area_light(document, node)?;
                if !new.triangles.is_empty() {
                    anew.push(index);
                }
            }
            Some(MeshSource::Primitive {
                node,
                mesh,
                primitive,
                mirrored,
                unshared,
            }) => {
                let change = changes.entry((node, mesh)).or_default();
                let change = change.entry(primitive).or_default();
                change.name.clone_from(&old.name);
                let key = Key { mirrored, unshared };
                let Some(gone) = key.gone(old, new) else {
                    change.left = Some(Vec::new());
                    anew.push(index);
                    continue;
                };
                if other_material {
                    change.material = Some(materials.index(document, new.material)?);
                }
                if !gone.is_empty() {
                    let root = match &root {
                        Some(root) => root,
                        None => root.insert(typed(source)?),
                    };
                    let all = import::file_triangles(root, &source.buffers, mesh, primitive);
                    let all = all.map_err(|fault| SaveError::File {
                        place: fault.place,
                        what: fault.what,
                    })?;
                    change.left = Some(key.left(&all, gone));
                }
            }
        }
    }
    for ((node, mesh), changes) in changes {
        patch_node(document, node, mesh, changes)?;
    }
    Ok(anew)
}

/// The source's JSON as the importer has it.
fn typed(source: &GltfSource) -> Result<json::Root, SaveError> {
    let parsed = <json::Root as serde::Deserialize>::deserialize(&source.json);
    parsed.map_err(|error| SaveError::File {
        place: "JSON".to_owned(),
        what: error.to_string(),
    })
}

/// How a scene's triangle names the file's.
#[derive(Clone, Copy)]
struct Key {
    mirrored: bool,
    unshared: bool,
}

impl Key {
    /// The file's three indices, or three times the index of the file's triangle where that is known.
    fn of(self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        match self {
            Self { unshared: true, .. } => [a / 3; 3],
            Self { mirrored: true, .. } => [a, c, b],
            _ => [a, b, c],
        }
    }

    /// The triangles that `new` lacks, each with how many times; `None` where the two meshes differ in
    /// more than that.
    fn gone(self, old: &Mesh, new: &Mesh) -> Option<HashMap<[u32; 3], usize>> {
        if new.triangles.is_empty() {
            // Whatever became of its vertices.
            return Some(counted(old.triangles.iter().map(|&t| self.of(t))));
        }
        let same = old.positions == new.positions
            && old.normals == new.normals
            && old.tangents == new.tangents
            && old.texcoords == new.texcoords
            && old.colors == new.colors;
        if !same {
            return None;
        }
        let mut gone = counted(old.triangles.iter().copied());
        for triangle in &new.triangles {
            let count = gone.get_mut(triangle).filter(|count| **count > 0)?;
            *count -= 1;
        }
        gone.retain(|_, count| *count > 0);
        Some(
            gone.into_iter()
                .map(|(t, count)| (self.of(t), count))
                .collect(),
        )
    }

    /// The file's triangles without those that are gone.
    fn left(self, all: &[[u32; 3]], mut gone: HashMap<[u32; 3], usize>) -> Vec<[u32; 3]> {
        let mut is_left = |(i, triangle): (usize, &[u32; 3])| {
            let name = if self.unshared {
                [i as u32; 3]
            } else {
                *triangle
            };
            match gone.get_mut(&name).filter(|count| **count > 0) {
                Some(count) => {
                    *count -= 1;
                    false
                }
                None => true,
            }
        };
        let left = all.iter().enumerate().filter(|&pair| is_left(pair));
        left.map(|(_, &triangle)| triangle).collect()
    }
}

fn counted(triangles: impl Iterator<Item = [u32; 3]>) -> HashMap<[u32; 3], usize> {
    let mut counts = HashMap::new();
    triangles.for_each(|t| *counts.entry(t).or_default() += 1);
    counts
}

/// Changes what one node shows of its mesh; other nodes that show the same mesh do not see it.
fn patch_node(
    document: &mut Document<'_>,
    node: usize,
    mesh: usize,
    changes: BTreeMap<usize, Change>,
) -> Result<(), SaveError> {
    let place = format!("meshes[{mesh}].primitives");
    let names = changes.values().map(|change| change.name.clone()).collect();
    let mut copy = document.object("meshes", mesh)?.clone();
    let primitives = copy.get_mut("primitives").and_then(Value::as_array_mut);
    let primitives = primitives.ok_or_else(|| SaveError::File {
        place: place.clone(),
        what: "this is not a JSON array".to_owned(),
    })?;
    let mut empty = HashSet::new();
    for (index, change) in changes {
        let primitive = object(primitives.get_mut(index), || format!("{place}[{index}]"))?;
        if let Some(left) = &change.left {
            // What is left without area was never seen.
            if left.iter().all(|&[a, b, c]| a == b || b == c || c == a) {
                empty.insert(index);
                continue;
            }
            let largest = left.as_flattened().iter().max().copied().unwrap_or(0);
            let indices = document.indices(left, largest as usize + 1)?;
            primitive.insert("indices".to_owned(), json!(indices));
            primitive.remove("mode");
            // A compressed copy would still have them all.
            if let Some(extensions) = primitive.get_mut("extensions") {
                let extensions =
                    object(Some(extensions), || format!("{place}[{index}].extensions"))?;
                extensions.remove("KHR_draco_mesh_compression");
                if extensions.is_empty() {
                    primitive.remove("extensions");
                }
            }
        }
        match change.material {
            Some(Some(material)) => drop(primitive.insert("material".to_owned(), json!(material))),
            Some(None) => drop(primitive.remove("material")),
            None => {}
        }
    }
    let mut index = 0;
    primitives.retain(|_| {
        index += 1;
        !empty.contains(&(index - 1))
    });
    if primitives.is_empty() {
        let object = document.object("nodes", node)?;
        // These mean nothing without a mesh, and glTF forbids them.
        for key in ["mesh", "skin", "weights"] {
            object.remove(key);
        }
        if is_vacant(document.json(), node) {
            document.vacant.push(Vacant {
                node,
                names,
                mesh_name: copy.remove("name"),
            });
        }
        return Ok(());
    }
    let nodes = document.json().get("nodes").and_then(Value::as_array);
    let shows = |node: &&Value| node.get("mesh").and_then(Value::as_u64) == Some(mesh as u64);
    let shown = nodes.map_or(0, |nodes| nodes.iter().filter(shows).count());
    if shown > 1 {
        let own = document.push("meshes", Value::Object(copy))?;
        let node = document.object("nodes", node)?;
        node.insert("mesh".to_owned(), json!(own));
    } else {
        *document.object("meshes", mesh)? = copy;
    }
    Ok(())
}

/// Whether another mesh may take a node over, and place it: it is a root, has nothing but a name and a
/// place, and neither an animation nor a skin moves it or is moved by it.
fn is_vacant(json: &Map<String, Value>, node: usize) -> bool {
    let list =
        |value: Option<&'_ Value>| value.and_then(Value::as_array).cloned().unwrap_or_default();
    let is_node = |value: &Value| value.as_u64() == Some(node as u64);
    let nodes = json.get("nodes").and_then(Value::as_array);
    let bare = [
        "name",
        "extras",
        "matrix",
        "translation",
        "rotation",
        "scale",
    ];
    let is_bare = nodes
        .and_then(|nodes| nodes.get(node)?.as_object())
        .is_some_and(|node| node.keys().all(|key| bare.contains(&key.as_str())));
    let is_child = |parent: &Value| list(parent.get("children")).iter().any(is_node);
    let is_moved = |animation: &Value| {
        let channels = list(animation.get("channels"));
        let target = |channel: &Value| channel.get("target")?.get("node").map(is_node);
        channels.iter().any(|channel| target(channel) == Some(true))
    };
    let is_bone = |skin: &Value| {
        list(skin.get("joints")).iter().any(is_node) || skin.get("skeleton").is_some_and(is_node)
    };
    is_bare
        && !nodes.is_some_and(|nodes| nodes.iter().any(is_child))
        && !list(json.get("animations")).iter().any(is_moved)
        && !list(json.get("skins")).iter().any(is_bone)
}

/// Takes the area light from a node.
fn take_area_light(document: &mut Document<'_>, node: usize) -> Result<(), SaveError> {
    let place = || format!("nodes[{node}].extensions");
    let node = document.object("nodes", node)?;
    let extensions = object(node.get_mut("extensions"), place)?;
    extensions.remove("EXT_lights_area");
    if extensions.is_empty() {
        node.remove("extensions");
    }
    Ok(())
}
