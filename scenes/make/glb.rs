//! Writes one scene as a binary glTF 2.0 file.

use super::mesh::Mesh;
use glam::DQuat;
use serde_json::{Map, Value, json};

/// A glTF document under construction: its JSON lists and its one binary buffer.
pub(crate) struct Glb {
    lists: Map<String, Value>,
    roots: Vec<usize>,
    extensions: Vec<&'static str>,
    binary: Vec<u8>,
}

impl Glb {
    pub(crate) fn new() -> Self {
        Self {
            lists: Map::new(),
            roots: Vec::new(),
            extensions: Vec::new(),
            binary: Vec::new(),
        }
    }

    /// Appends `value` to a top-level list such as `meshes` and returns its index.
    fn push(&mut self, list: &str, value: Value) -> usize {
        let Value::Array(items) = self
            .lists
            .entry(list)
            .or_insert_with(|| Value::Array(Vec::new()))
        else {
            unreachable!("only arrays are inserted")
        };
        items.push(value);
        items.len() - 1
    }

    /// Lists an extension that the file uses, once.
    pub(crate) fn require(&mut self, extension: &'static str) {
        if !self.extensions.contains(&extension) {
            self.extensions.push(extension);
        }
    }

    /// Every view starts at a multiple of four bytes, as accessors need.
    fn buffer_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        while !self.binary.len().is_multiple_of(4) {
            self.binary.push(0);
        }
        let mut view = json!({
            "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    fn float_accessor<const N: usize>(&mut self, values: &[[f32; N]], bounds: bool) -> usize {
        const ARRAY_BUFFER: u32 = 34962;
        const FLOAT: u32 = 5126;
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let view = self.buffer_view(&bytes, Some(ARRAY_BUFFER));
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(),
            "type": format!("VEC{N}"),
        });
        if bounds {
            let fold = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
                (0..N)
                    .map(|k| values.iter().map(|v| v[k]).reduce(pick).unwrap_or(0.0))
                    .collect()
            };
            accessor["min"] = json!(fold(f32::min));
            accessor["max"] = json!(fold(f32::max));
        }
        self.push("accessors", accessor)
    }

    fn index_accessor(&mut self, indices: &[u16]) -> usize {
        const ELEMENT_ARRAY_BUFFER: u32 = 34963;
        const UNSIGNED_SHORT: u32 = 5123;
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.buffer_view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": UNSIGNED_SHORT,
                "count": indices.len(), "type": "SCALAR",
            }),
        )
    }

    /// The vertex attributes of `mesh` as one primitive without a material, to be shared by [`Glb::mesh`].
    pub(crate) fn geometry(&mut self, mesh: &Mesh) -> Value {
        let mut attributes = json!({
            "POSITION": self.float_accessor(&mesh.positions, true),
            "NORMAL": self.float_accessor(&mesh.normals, false),
        });
        if !mesh.texcoords.is_empty() {
            attributes["TEXCOORD_0"] = json!(self.float_accessor(&mesh.texcoords, false));
        }
        if !mesh.tangents.is_empty() {
            attributes["TANGENT"] = json!(self.float_accessor(&mesh.tangents, false));
        }
        json!({ "attributes": attributes, "indices": self.index_accessor(&mesh.indices) })
    }

    /// A mesh of one primitive: shared geometry in one material.
    pub(crate) fn mesh(&mut self, name: &str, geometry: &Value, material: usize) -> usize {
        let mut primitive = geometry.clone();
        primitive["material"] = json!(material);
        self.push("meshes", json!({ "name": name, "primitives": [primitive] }))
    }

    /// A material from glTF's own fields; `name` is added.
    pub(crate) fn material(&mut self, name: &str, mut fields: Value) -> usize {
        fields["name"] = json!(name);
        self.push("materials", fields)
    }

    /// A metallic-roughness material of constant colour (linear reflectance, or F0 for a metal).
    pub(crate) fn surface(
        &mut self,
        name: &str,
        [r, g, b]: [f64; 3],
        metallic: f64,
        perceptual_roughness: f64,
    ) -> usize {
        self.material(
            name,
            json!({ "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": metallic,
                "roughnessFactor": perceptual_roughness,
            }}),
        )
    }

    /// A material that reflects nothing but diffuse light: of constant colour (linear reflectance), or of the colours
    /// of a texture as [`Glb::tiled`] refers to it.
    pub(crate) fn matte(&mut self, name: &str, colour: impl Into<Matte>) -> usize {
        const SPECULAR: &str = "KHR_materials_specular";
        self.require(SPECULAR);
        let (key, colour) = match colour.into() {
            Matte::Colour([r, g, b]) => ("baseColorFactor", json!([r, g, b, 1.0])),
            Matte::Texture(reference) => ("baseColorTexture", reference),
        };
        self.material(
            name,
            json!({
                "pbrMetallicRoughness": {
                    key: colour,
                    "metallicFactor": 0.0,
                    "roughnessFactor": 1.0,
                },
                "extensions": { SPECULAR: { "specularFactor": 0.0 } },
            }),
        )
    }

    /// A black material that emits `radiance` from its front, or from both sides.
    ///
    /// glTF bounds the emissive factor by one: the largest component becomes the strength.
    pub(crate) fn emitter(&mut self, name: &str, radiance: [f64; 3], double_sided: bool) -> usize {
        self.require("KHR_materials_emissive_strength");
        let strength = radiance.into_iter().fold(1.0, f64::max);
        let mut fields = json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.0, 0.0, 0.0, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
            "emissiveFactor": radiance.map(|x| x / strength),
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": strength } },
        });
        if double_sided {
            fields["doubleSided"] = json!(true);
        }
        self.material(name, fields)
    }

    /// An embedded PNG, repeated in both directions and trilinearly filtered.
    pub(crate) fn texture(&mut self, name: &str, png: &[u8]) -> usize {
        const REPEAT: u32 = 10497;
        self.wrapped_texture(name, png, REPEAT)
    }

    /// An embedded PNG whose border goes on beyond it, trilinearly filtered.
    fn picture(&mut self, name: &str, png: &[u8]) -> usize {
        const CLAMP_TO_EDGE: u32 = 33071;
        self.wrapped_texture(name, png, CLAMP_TO_EDGE)
    }

    fn wrapped_texture(&mut self, name: &str, png: &[u8], wrap: u32) -> usize {
        const LINEAR: u32 = 9729;
        const LINEAR_MIPMAP_LINEAR: u32 = 9987;
        let sampler = json!({
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR,
            "wrapS": wrap, "wrapT": wrap,
        });
        let samplers = self.lists.get("samplers").and_then(Value::as_array);
        let same = samplers.and_then(|list| list.iter().position(|other| *other == sampler));
        let sampler = same.unwrap_or_else(|| self.push("samplers", sampler));
        let view = self.buffer_view(png, None);
        let image = self.push(
            "images",
            json!({ "name": name, "bufferView": view, "mimeType": "image/png" }),
        );
        self.push("textures", json!({ "sampler": sampler, "source": image }))
    }

    /// A black material that shows a picture in light: white emits `radiance`.
    pub(crate) fn picture_emitter(
        &mut self,
        name: &str,
        png: &[u8],
        radiance: f64,
        double_sided: bool,
    ) -> usize {
        let texture = self.picture(name, png);
        let material = self.emitter(name, [radiance; 3], double_sided);
        self.lists["materials"][material]["emissiveTexture"] = json!({ "index": texture });
        material
    }

    /// A reference to `texture`, repeated `scale` times over the unit square.
    pub(crate) fn tiled(&mut self, texture: usize, scale: [f64; 2]) -> Value {
        self.require("KHR_texture_transform");
        json!({
            "index": texture,
            "extensions": { "KHR_texture_transform": { "scale": scale } },
        })
    }

    /// A perspective camera of vertical field of view `yfov` (radians).
    pub(crate) fn camera(&mut self, aspect: f64, yfov: f64) -> usize {
        self.push(
            "cameras",
            json!({
                "type": "perspective",
                "perspective": { "aspectRatio": aspect, "yfov": yfov, "znear": 0.01, "zfar": 100.0 },
            }),
        )
    }

    /// A node at the root of the scene.
    pub(crate) fn root(&mut self, node: Node) {
        let index = self.push("nodes", Value::Object(node.0));
        self.roots.push(index);
    }

    /// A node at the root that carries `children`.
    pub(crate) fn group(&mut self, node: Node, children: Vec<Node>) {
        let children: Vec<usize> = children
            .into_iter()
            .map(|child| self.push("nodes", Value::Object(child.0)))
            .collect();
        let node = node.with("children", json!(children));
        self.root(node);
    }

    /// The finished file: header, JSON chunk padded with spaces, binary chunk padded with zeros.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        while !self.binary.len().is_multiple_of(4) {
            self.binary.push(0);
        }
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "lumigon scenes/make.rs" },
            "scene": 0,
            "scenes": [{ "nodes": self.roots }],
            "buffers": [{ "byteLength": self.binary.len() }],
        });
        for (name, list) in self.lists {
            root[name] = list;
        }
        if !self.extensions.is_empty() {
            root["extensionsUsed"] = json!(self.extensions);
        }
        let mut text = root.to_string().into_bytes();
        while !text.len().is_multiple_of(4) {
            text.push(b' ');
        }

        let mut file = b"glTF".to_vec();
        let word = |file: &mut Vec<u8>, x: usize| {
            let x = u32::try_from(x).expect("our scenes are far below 4 GiB");
            file.extend_from_slice(&x.to_le_bytes());
        };
        word(&mut file, 2);
        word(&mut file, 12 + 8 + text.len() + 8 + self.binary.len());
        word(&mut file, text.len());
        file.extend_from_slice(b"JSON");
        file.extend_from_slice(&text);
        word(&mut file, self.binary.len());
        file.extend_from_slice(b"BIN\0");
        file.extend_from_slice(&self.binary);
        file
    }
}

/// What colours [`Glb::matte`].
pub(crate) enum Matte {
    Colour([f64; 3]),
    Texture(Value),
}

impl From<[f64; 3]> for Matte {
    fn from(colour: [f64; 3]) -> Self {
        Self::Colour(colour)
    }
}

impl From<Value> for Matte {
    fn from(reference: Value) -> Self {
        Self::Texture(reference)
    }
}

/// A node's name, content and transform.
pub(crate) struct Node(Map<String, Value>);

impl Node {
    pub(crate) fn new(name: &str) -> Self {
        Self(Map::new()).with("name", json!(name))
    }

    fn with(mut self, key: &str, value: Value) -> Self {
        self.0.insert(key.to_owned(), value);
        self
    }

    pub(crate) fn mesh(self, mesh: usize) -> Self {
        self.with("mesh", json!(mesh))
    }

    pub(crate) fn camera(self, camera: usize) -> Self {
        self.with("camera", json!(camera))
    }

    pub(crate) fn translation(self, translation: [f64; 3]) -> Self {
        self.with("translation", json!(translation))
    }

    pub(crate) fn rotation(self, rotation: DQuat) -> Self {
        self.with("rotation", json!(rotation.to_array()))
    }

    pub(crate) fn scale(self, scale: [f64; 3]) -> Self {
        self.with("scale", json!(scale))
    }
}
