//! An edited scene to glTF, by patching the file it came from: what was not edited stays as it is.
//!
//! Nothing here needs extras: outlines, holes, colours, pictures and both sides are all glTF's own.

mod append;
mod container;
mod document;
mod error;
mod material;
mod removal;
mod texture;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;
use serde_json::{Map, Value};

use super::Scene;
use crate::whole_file::write_whole;
use container::Format;
use document::Document;
pub use error::SaveError;
use material::Materials;

/// A glTF file as it was loaded: its JSON, and the bytes of its buffers and images.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfSource {
    /// Without the URIs of what is in `buffers` and `images`.
    json: Value,
    /// Buffers by the file's index, as long as the file says; `None` where they cannot be read, which
    /// is no fault unless the scene needs them.
    buffers: Vec<Option<Vec<u8>>>,
    /// Images that have a URI, by the file's index, encoded as they are.
    images: Vec<Option<Vec<u8>>>,
}

impl GltfSource {
    pub(super) fn new(
        mut json: Value,
        mut buffers: Vec<Option<Vec<u8>>>,
        mut images: Vec<Option<Vec<u8>>>,
    ) -> Self {
        for (key, list) in [("buffers", &mut buffers), ("images", &mut images)] {
            for (i, bytes) in list.iter_mut().enumerate() {
                let object = json.get_mut(key).and_then(|list| list.get_mut(i));
                match object.and_then(Value::as_object_mut) {
                    Some(object) if bytes.is_some() => drop(object.remove("uri")),
                    Some(_) => {}
                    None => *bytes = None,
                }
            }
        }
        Self {
            json,
            buffers,
            images,
        }
    }

    /// Writes the scene as `edited` has it to a `.glb` or `.gltf` file with everything embedded.
    ///
    /// `original` is what was read with this source. `edited` is a copy of it where: meshes keep their
    /// index; one that lost triangles, or all, stands in its place with its vertices as they were; new
    /// meshes, materials and textures are appended. Everything else of the file (nodes, names, animations,
    /// extras, extensions that are not understood) is written as it was read. A mesh that was changed in
    /// another way is written anew, in world space. `frames` are rigid transforms, world from local, for
    /// the nodes of new meshes by their index; without one a mesh's node stands at the origin.
    ///
    /// A root node that lost all of its mesh, and has no other purpose, is taken by a new mesh of the same
    /// name: a light that was edited stays the node it was. Other new meshes get new nodes.
    ///
    /// Triangles that a mesh lost leave one node: others that show the same glTF mesh keep theirs.
    /// Pictures in floating point, which glTF does not have, become 16-bit PNG, scaled by their brightest
    /// texel; the emissive strength makes up for it.
    ///
    /// The file appears whole or not at all; one that was there before stays until then.
    ///
    /// # Errors
    /// A [`SaveError`]; nothing was written then.
    pub fn save(
        &self,
        original: &Scene,
        edited: &Scene,
        frames: &HashMap<usize, DAffine3>,
        path: &Path,
    ) -> Result<(), SaveError> {
        let format = Format::from_path(path)?;
        if path.is_dir() {
            let path = path.to_owned();
            return Err(SaveError::Folder { path });
        }
        let written = self.patched(original, edited, frames)?.finish(format)?;
        // A link's target is replaced, not the link.
        let target = std::fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
        written.check_length(path)?;
        write_whole(&target, |file| written.write(file)).map_err(|source| SaveError::Io {
            path: path.to_owned(),
            source,
        })
    }

    /// The document with the edits.
    fn patched(
        &self,
        original: &Scene,
        edited: &Scene,
        frames: &HashMap<usize, DAffine3>,
    ) -> Result<Document<'_>, SaveError> {
        let mut document = Document::new(self)?;
        let mut materials = Materials::new(original, edited);
        materials.patch_changed(&mut document)?;
        let anew = removal::patch(self, &mut document, &mut materials, original, edited)?;
        for index in anew
            .into_iter()
            .chain(original.meshes.len()..edited.meshes.len())
        {
            let mesh = &edited.meshes[index];
            append::mesh(&mut document, &mut materials, mesh, frames.get(&index))?;
        }
        Ok(document)
    }
}

/// An object of the document, or an error that names its place.
fn object(
    value: Option<&mut Value>,
    place: impl FnOnce() -> String,
) -> Result<&mut Map<String, Value>, SaveError> {
    value
        .and_then(Value::as_object_mut)
        .ok_or_else(|| SaveError::File {
            place: place(),
            what: "this is not a JSON object".to_owned(),
        })
}
