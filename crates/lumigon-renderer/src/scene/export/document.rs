//! The JSON under change, and the bytes that are added to it.

use std::borrow::Cow;

use serde_json::{Map, Value, json};

use super::{
    GltfSource, SaveError,
    container::{self, Format, Written},
    object,
};

const FLOAT: u32 = 5126;
const U16: u32 = 5123;
const U32: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A copy of a file's JSON under change.
pub(super) struct Document<'a> {
    json: Map<String, Value>,
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    images: Vec<Option<Cow<'a, [u8]>>>,
    /// The buffer that grows.
    growing: usize,
    /// What it grows by, from `start` on.
    added: Vec<u8>,
    start: usize,
    /// Nodes whose mesh is gone.
    pub(super) vacant: Vec<Vacant>,
}

/// A node whose mesh is gone and that stands for nothing else.
pub(super) struct Vacant {
    pub(super) node: usize,
    /// What the scene calls the meshes that were there.
    pub(super) names: Vec<String>,
    /// What the file calls the mesh that was there.
    pub(super) mesh_name: Option<Value>,
}

impl<'a> Document<'a> {
    pub(super) fn new(source: &'a GltfSource) -> Result<Self, SaveError> {
        let mut json = source.json.clone();
        let json = std::mem::take(object(Some(&mut json), || "JSON".to_owned())?);
        let borrowed = |list: &'a [Option<Vec<u8>>]| {
            let borrow = |bytes: &'a Option<Vec<u8>>| bytes.as_deref().map(Cow::Borrowed);
            list.iter().map(borrow).collect::<Vec<_>>()
        };
        let buffers = borrowed(&source.buffers);
        // The first one is the binary chunk of a .glb; one that cannot be read cannot grow.
        let (growing, start) = match buffers.first() {
            None => (0, 0),
            Some(Some(bytes)) => (0, bytes.len().next_multiple_of(4)),
            Some(None) => (buffers.len(), 0),
        };
        Ok(Self {
            json,
            buffers,
            images: borrowed(&source.images),
            growing,
            added: Vec::new(),
            start,
            vacant: Vec::new(),
        })
    }

    pub(super) fn json(&self) -> &Map<String, Value> {
        &self.json
    }

    pub(super) fn json_mut(&mut self) -> &mut Map<String, Value> {
        &mut self.json
    }

    /// `key[index]`, which must be an object.
    pub(super) fn object(
        &mut self,
        key: &str,
        index: usize,
    ) -> Result<&mut Map<String, Value>, SaveError> {
        let value = self.json.get_mut(key).and_then(|list| list.get_mut(index));
        object(value, || format!("{key}[{index}]"))
    }

    /// Appends to a list of the document; returns the index.
    pub(super) fn push(&mut self, key: &str, value: Value) -> Result<usize, SaveError> {
        let list = self.json.entry(key).or_insert_with(|| json!([]));
        let list = list.as_array_mut().ok_or_else(|| SaveError::File {
            place: key.to_owned(),
            what: "this is not a JSON array".to_owned(),
        })?;
        list.push(value);
        Ok(list.len() - 1)
    }

    /// Declares that an extension is used.
    pub(super) fn uses(&mut self, extension: &str) -> Result<(), SaveError> {
        let list = self.json.get("extensionsUsed").and_then(Value::as_array);
        if list.is_none_or(|list| !list.iter().any(|name| name == extension)) {
            self.push("extensionsUsed", json!(extension))?;
        }
        Ok(())
    }

    /// Appends an encoded PNG or JPEG image; returns its index.
    pub(super) fn image(&mut self, name: &str, bytes: Cow<'a, [u8]>) -> Result<usize, SaveError> {
        let mut image = json!({"mimeType": mime_type(&bytes)});
        if !name.is_empty() {
            image["name"] = json!(name);
        }
        let index = self.push("images", image)?;
        self.images.resize(index, None);
        self.images.push(Some(bytes));
        Ok(index)
    }

    /// Appends vertex attributes of `N` floats each; `bounded` ones get their least and greatest.
    pub(super) fn attribute<const N: usize>(
        &mut self,
        values: impl ExactSizeIterator<Item = [f32; N]> + Clone,
        bounded: bool,
    ) -> Result<usize, SaveError> {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let mut accessor = json!({"componentType": FLOAT, "count": values.len(), "type": kind});
        if bounded {
            let bound = |of: fn(f32, f32) -> f32| {
                let bound = values
                    .clone()
                    .reduce(|a, b| std::array::from_fn(|i| of(a[i], b[i])));
                Value::Array(bound.unwrap_or([0.0; N]).map(number).to_vec())
            };
            accessor["min"] = bound(f32::min);
            accessor["max"] = bound(f32::max);
        }
        let bytes: Vec<u8> = values.flatten().flat_map(f32::to_le_bytes).collect();
        accessor["bufferView"] = json!(self.view(&bytes, Some(ARRAY_BUFFER))?);
        self.push("accessors", accessor)
    }

    /// Appends the indices of triangles among so many vertices, as narrow as these allow.
    pub(super) fn indices(
        &mut self,
        triangles: &[[u32; 3]],
        vertices: usize,
    ) -> Result<usize, SaveError> {
        let flat = triangles.as_flattened();
        // The greatest number of each width is not an index: it restarts primitives.
        let (component, bytes) = if vertices <= usize::from(u16::MAX) {
            let narrow = |&i: &u32| (i as u16).to_le_bytes();
            (U16, flat.iter().flat_map(narrow).collect::<Vec<u8>>())
        } else {
            (U32, flat.iter().flat_map(|i| i.to_le_bytes()).collect())
        };
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER))?;
        let accessor = json!({
            "bufferView": view, "componentType": component, "count": flat.len(), "type": "SCALAR",
        });
        self.push("accessors", accessor)
    }

    /// Appends bytes to the growing buffer, aligned to 4, and a view of them.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> Result<usize, SaveError> {
        self.added.resize(self.added.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": self.growing,
            "byteOffset": self.start + self.added.len(),
            "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.added.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    /// Embeds all buffers and images.
    pub(super) fn finish(mut self, format: Format) -> Result<Written<'a>, SaveError> {
        for (index, bytes) in std::mem::take(&mut self.images).into_iter().enumerate() {
            let Some(bytes) = bytes else { continue };
            match format {
                Format::Gltf => {
                    let image = self.object("images", index)?;
                    let kind = image.get("mimeType").and_then(Value::as_str);
                    let kind = kind.unwrap_or_else(|| mime_type(&bytes));
                    let uri = container::data_uri(kind, &[&bytes]);
                    image.insert("uri".to_owned(), Value::String(uri));
                }
                Format::Glb => {
                    let view = self.view(&bytes, None)?;
                    let image = self.object("images", index)?;
                    image.insert("bufferView".to_owned(), json!(view));
                    // With a view it is no longer optional.
                    let kind = image.entry("mimeType");
                    kind.or_insert_with(|| json!(mime_type(&bytes)));
                }
            }
        }
        if !self.added.is_empty() {
            if self.growing == self.buffers.len() {
                self.push("buffers", json!({}))?;
                self.buffers.push(Some(Cow::Borrowed(&[])));
            }
            let length = self.start + self.added.len();
            let buffer = self.object("buffers", self.growing)?;
            buffer.insert("byteLength".to_owned(), json!(length));
        }
        let mut binary = Vec::new();
        for (index, bytes) in std::mem::take(&mut self.buffers).into_iter().enumerate() {
            let Some(bytes) = bytes else { continue };
            let mut parts = vec![bytes];
            if index == self.growing && !self.added.is_empty() {
                let padding = &[0; 4][..self.start - parts[0].len()];
                parts.push(Cow::Borrowed(padding));
                parts.push(Cow::Owned(std::mem::take(&mut self.added)));
            }
            if format == Format::Glb && index == 0 {
                binary = parts;
                continue;
            }
            let parts: Vec<&[u8]> = parts.iter().map(|part| &**part).collect();
            let uri = container::data_uri("application/octet-stream", &parts);
            let buffer = self.object("buffers", index)?;
            buffer.insert("uri".to_owned(), Value::String(uri));
        }
        Ok(Written::new(format, &Value::Object(self.json), binary))
    }
}

/// A number as JSON: the shortest that reads back as this one.
pub(super) fn number(x: f32) -> Value {
    let shortest: f64 = x.to_string().parse().unwrap_or(f64::from(x));
    let same = shortest as f32 == x;
    json!(if same { shortest } else { f64::from(x) })
}

/// Numbers as JSON, as [`number`].
pub(super) fn numbers<const N: usize>(values: [f32; N]) -> Value {
    Value::Array(values.map(number).to_vec())
}

/// What an image's first bytes say it is.
fn mime_type(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [0xff, 0xd8, ..] => "image/jpeg",
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => "image/webp",
        [0xab, b'K', b'T', b'X', b' ', b'2', ..] => "image/ktx2",
        [0x76, 0x2f, 0x31, 0x01, ..] => "image/x-exr",
        [b'#', b'?', ..] => "image/vnd.radiance",
        _ => "application/octet-stream",
    }
}
