//! glTF 2.0 to [`Scene`].
//!
//! The `gltf` crate supplies the document's types. Its readers trust the document, so everything
//! that follows an index, an offset or a count here is checked first: a hostile file is an error
//! that names its place, never a panic, and never an allocation that its bytes do not justify.

mod accessor;
mod area_light;
mod container;
mod extension;
mod image;
mod material;
mod material_layer;
mod node;
mod primitive;
mod punctual_light;
mod source;
mod value;
mod warning;

#[cfg(test)]
mod tests;

use std::{
    fs,
    path::{Path, PathBuf},
};

use gltf::json;

use super::{GltfSource, Limits, LoadPhase, LoadWatch, Scene, SceneError, error::Fault};
use source::Source;
pub(super) use source::read_file;
use warning::Warnings;

pub(super) fn load(path: &Path, limits: &Limits) -> Result<Scene, SceneError> {
    let file = File::read(path, limits, LoadWatch::none())?;
    from_slice(&file.bytes, Some(&file.folder), &file.name, limits)
}

pub(super) fn load_watched(
    path: &Path,
    limits: &Limits,
    watch: LoadWatch<'_>,
) -> Result<(Scene, GltfSource), SceneError> {
    let file = File::read(path, limits, watch)?;
    from_slice_watched(&file.bytes, Some(&file.folder), &file.name, limits, watch)
}

pub(super) fn from_slice(
    bytes: &[u8],
    base_folder: Option<&Path>,
    name: &str,
    limits: &Limits,
) -> Result<Scene, SceneError> {
    import(bytes, base_folder, limits, LoadWatch::none()).map_err(|fault| fault.in_file(name))
}

pub(super) fn from_slice_watched(
    bytes: &[u8],
    base_folder: Option<&Path>,
    name: &str,
    limits: &Limits,
    watch: LoadWatch<'_>,
) -> Result<(Scene, GltfSource), SceneError> {
    let both = || {
        let scene = import(bytes, base_folder, limits, watch)?;
        watch.begin(LoadPhase::Keeping)?;
        Ok((scene, keep(bytes, base_folder, limits)?))
    };
    both().map_err(|fault: Fault| fault.in_file(name))
}

/// A scene's file and where its neighbours are.
struct File {
    bytes: Vec<u8>,
    folder: PathBuf,
    name: String,
}

impl File {
    fn read(path: &Path, limits: &Limits, watch: LoadWatch<'_>) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let bytes = fs::metadata(path).map_or(0, |metadata| metadata.len());
        let bytes = watch
            .begin(LoadPhase::Reading { bytes })
            .and_then(|()| {
                read_file(path, limits.file_bytes)
                    .map_err(|(what, mend)| Fault::new("file", what, mend))
            })
            .map_err(|fault| fault.in_file(&name))?;
        // A bare file name has the empty path as its parent: the current folder.
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        // Links are followed to the scene itself, and its neighbours are sought where it really is.
        let real = fs::canonicalize(path).ok();
        let folder = real.as_deref().and_then(Path::parent).unwrap_or(folder);
        Ok(Self {
            bytes,
            folder: folder.to_owned(),
            name,
        })
    }
}

fn import(
    bytes: &[u8],
    base_folder: Option<&Path>,
    limits: &Limits,
    watch: LoadWatch<'_>,
) -> Result<Scene, Fault> {
    let container = container::split(bytes)?;
    watch.begin(LoadPhase::Parsing {
        bytes: container.json.len() as u64,
    })?;
    let root = parse(container.json, limits)?;
    let mut warnings = Warnings::default();
    extension::check(&root, &mut warnings)?;
    let source = Source::new(&root, container.binary, base_folder, limits);
    node::import(&root, source, limits, warnings, watch)
}

/// The file as it stands. What the scene does not need may be missing or broken: it stays so.
fn keep(bytes: &[u8], base_folder: Option<&Path>, limits: &Limits) -> Result<GltfSource, Fault> {
    let container = container::split(bytes)?;
    let root = parse(container.json, limits)?;
    let mut source = Source::new(&root, container.binary, base_folder, limits);
    let buffers = (0..root.buffers.len()).map(|i| Some(source.buffer(i, "").ok()?.to_vec()));
    let buffers = buffers.collect();
    let images = root.images.iter();
    let images = images.map(|image| source.uri(image.uri.as_deref()?, "").ok());
    let images = images.collect();
    let json = serde_json::from_slice(container.json)
        .map_err(|error| Fault::new("JSON", error.to_string(), "write valid JSON"))?;
    Ok(GltfSource::new(json, buffers, images))
}

/// The triangles of `meshes[mesh].primitives[primitive]` as the file has them.
pub(super) fn file_triangles(
    root: &json::Root,
    buffers: &[Option<Vec<u8>>],
    mesh: usize,
    primitive: usize,
) -> Result<Vec<[u32; 3]>, Fault> {
    let mut reader = accessor::Reader {
        root,
        source: &mut Source::kept(root, buffers),
        // They passed the limits when the scene was read.
        limit: u64::MAX,
    };
    primitive::file_triangles(&mut reader, mesh, primitive)
}

/// JSON to the document's types, with the path to the first thing that does not fit.
fn parse(text: &[u8], limits: &Limits) -> Result<json::Root, Fault> {
    // An object of two characters becomes a struct of hundreds of bytes.
    let objects = text.iter().filter(|&&c| c == b'{').count();
    if objects > limits.json_objects {
        return Err(Fault::new(
            "JSON",
            format!(
                "{objects} objects pass the limit of {}",
                limits.json_objects
            ),
            "make the scene smaller or raise the limit",
        ));
    }
    let mut deserializer = serde_json::Deserializer::from_slice(text);
    let root: json::Root =
        serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
            let place = error.path().to_string();
            // A key may be the empty string.
            let place = if place == "." || place.is_empty() {
                "JSON".to_owned()
            } else {
                place
            };
            Fault::new(
                place,
                error.into_inner().to_string(),
                "write valid glTF 2.0 JSON there",
            )
        })?;
    deserializer
        .end()
        .map_err(|error| Fault::new("JSON", error.to_string(), "end the file after the JSON"))?;
    let version = root
        .asset
        .min_version
        .as_ref()
        .unwrap_or(&root.asset.version);
    if version.split('.').next() != Some("2") {
        return Err(Fault::new(
            "asset.version",
            format!("glTF {version} is not glTF 2"),
            "convert the scene to glTF 2.0",
        ));
    }
    Ok(root)
}
