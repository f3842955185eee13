//! Files built here, sound and broken.

use std::io::Cursor;

use glam::{DVec3, Vec2, Vec3};
use serde_json::{Value, json};

use super::*;
use crate::scene::{AlphaMode, Camera, Projection, PunctualKind, TextureTransform};

/// A document under construction; attributes go to the end of its only buffer.
struct Document {
    json: Value,
    binary: Vec<u8>,
}

impl Document {
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": []}],
            "accessors": [],
            "bufferViews": [],
        });
        let binary = Vec::new();
        Self { json, binary }
    }

    fn list(&mut self, key: &str) -> &mut Vec<Value> {
        self.json[key].as_array_mut().unwrap()
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()});
        self.list("bufferViews").push(view);
        self.list("bufferViews").len() - 1
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        });
        self.list("accessors").push(accessor);
        self.list("accessors").len() - 1
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len() / width, &bytes)
    }

    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor("SCALAR", 5123, values.len(), &bytes)
    }

    fn primitive(&mut self, primitive: Value) {
        self.json["meshes"][0]["primitives"]
            .as_array_mut()
            .unwrap()
            .push(primitive);
    }

    /// The unit square in the plane z = 0, facing +Z, with texture coordinates as glTF has them.
    fn square() -> Self {
        let mut document = Self::new();
        let position = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
        let uv = document.floats("VEC2", &[0., 1., 1., 1., 1., 0., 0., 0.]);
        let indices = document.indices(&[0, 1, 2, 0, 2, 3]);
        document.primitive(json!({
            "attributes": {"POSITION": position, "TEXCOORD_0": uv}, "indices": indices,
        }));
        document
    }

    fn with_material(mut self, material: &Value) -> Self {
        self.json["materials"] = json!([material]);
        self.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        self
    }

    /// Adds `textures[0]` showing this PNG.
    fn with_texture(mut self, png: &[u8]) -> Self {
        let view = self.view(png);
        self.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
        self.json["textures"] = json!([{"source": 0}]);
        self
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        let mut text = serde_json::to_vec(&json).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        let word = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
        glb.extend(word(28 + text.len() + binary.len()));
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
            glb.extend(word(chunk.len()));
            glb.extend(kind);
            glb.extend(chunk);
        }
        glb
    }

    fn gltf(&self) -> Vec<u8> {
        use base64::{Engine, prelude::BASE64_STANDARD};
        let data = BASE64_STANDARD.encode(&self.binary);
        self.gltf_at(&format!("data:application/octet-stream;base64,{data}"))
    }

    fn gltf_at(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len(), "uri": uri}]);
        serde_json::to_vec(&json).unwrap()
    }

    fn scene(&self) -> Scene {
        let scene = Scene::from_slice(&self.glb(), None, "test.glb").unwrap();
        assert_eq!(
            scene,
            Scene::from_slice(&self.gltf(), None, "test.gltf").unwrap()
        );
        scene
    }

    fn error(&self) -> SceneError {
        Scene::from_slice(&self.glb(), None, "test.glb").unwrap_err()
    }
}

fn png(width: u32, height: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let image = ::image::RgbaImage::from_raw(width, height, texels.as_flattened().to_vec());
    let mut bytes = Cursor::new(Vec::new());
    let image = image.unwrap();
    image
        .write_to(&mut bytes, ::image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

fn face_normals(scene: &Scene) -> Vec<Vec3> {
    let mesh = &scene.meshes[0];
    let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
    corners
        .map(|[a, b, c]| (b - a).cross(c - a).normalize())
        .collect()
}

#[test]
fn plain_square_has_flat_normals_and_glb_equals_gltf() {
    let scene = Document::square().scene();
    assert_eq!(scene.meshes.len(), 1);
    let mesh = &scene.meshes[0];
    assert_eq!(
        (
            mesh.name.as_str(),
            mesh.triangles.len(),
            mesh.positions.len()
        ),
        ("meshes[0]", 2, 6)
    );
    assert!(mesh.normals.iter().all(|&n| n == Vec3::Z));
    assert_eq!(mesh.texcoords[0].len(), 6);
    assert!(scene.polygon_lights.is_empty() && scene.warnings.is_empty());
    assert_eq!(scene.materials[0].name, "default");
}

#[test]
fn hierarchy_mirrors_and_stretches() {
    let mut document = Document::square().with_material(&json!({"emissiveFactor": [1, 1, 1]}));
    let normal = document.floats("VEC3", &[[0.6, 0., 0.8]; 4].concat());
    document.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normal);
    document.json["nodes"] = json!([
        {"name": "parent", "children": [1], "translation": [0, 0, 5], "scale": [-2, 1, 4]},
        {"name": "child", "mesh": 0, "rotation": [0, 0, 0, 2]},
    ]);
    let scene = document.scene();
    // x is mirrored, z is not: the square still faces +Z, and so does its light.
    assert!(face_normals(&scene).iter().all(|&n| n == Vec3::Z));
    let expected = Vec3::new(0.6 / -2.0, 0.0, 0.8 / 4.0).normalize();
    assert!(
        scene.meshes[0]
            .normals
            .iter()
            .all(|n| n.distance(expected) < 1e-6)
    );
    assert_eq!(scene.meshes[0].positions[2], Vec3::new(-2.0, 1.0, 5.0));
    assert_eq!(scene.meshes[0].name, "child");
    let light = &scene.polygon_lights[0];
    assert_eq!(
        (light.area_vector(), light.vertex_count()),
        ([0.0, 0.0, 2.0], 4)
    );
    assert_eq!(light.triangles, [0, 1]);
}

#[test]
fn tangents_follow_mirrors() {
    let mut document = Document::square();
    let normal = document.floats("VEC3", &[[0., 0., 1.]; 4].concat());
    let tangent = document.floats("VEC4", &[[1., 0., 0., 1.]; 4].concat());
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normal);
    attributes["TANGENT"] = json!(tangent);
    document.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let tangent = document.scene().meshes[0].tangents[0];
    // The bitangent, w (n × t), must still point along +Y as the texture does.
    assert_eq!(Vec3::Z.cross(tangent.truncate()) * tangent.w, Vec3::Y);
}

#[test]
fn strips_and_fans_keep_their_winding() {
    for (mode, points) in [
        (
            5,
            [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0., 0., 2., 0.],
        ),
        (
            6,
            [0., 0., 0., 1., 0., 0., 1., 1., 0., 0.5, 1.5, 0., 0., 1., 0.],
        ),
    ] {
        let mut document = Document::new();
        let position = document.floats("VEC3", &points);
        document.primitive(json!({"attributes": {"POSITION": position}, "mode": mode}));
        let scene = document.scene();
        assert_eq!(face_normals(&scene), [Vec3::Z; 3], "mode {mode}");
    }
    let mut document = Document::square();
    document.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    let scene = document.scene();
    assert!(scene.meshes.is_empty());
    assert_eq!(
        scene.warnings,
        [
            "points and lines are not drawn",
            "the scene has no triangles"
        ]
    );
}

#[test]
fn quantised_attributes_are_decoded() {
    let mut document = Document::new();
    let bytes = [0_u8, 0, 0, 0, 127, 0, 0, 0, 0, 129, 0, 0];
    let position = document.accessor("VEC3", 5120, 3, &bytes);
    document.json["bufferViews"][0]["byteStride"] = json!(4);
    document.json["accessors"][position]["normalized"] = json!(true);
    let uv: Vec<u8> = [0_u16, 65535, 32768, 0, 1, 2]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let uv = document.accessor("VEC2", 5123, 3, &uv);
    document.json["accessors"][uv]["normalized"] = json!(true);
    let uv1: Vec<u8> = [-3_i16, 7, 0, 0, 1, 1]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let uv1 = document.accessor("VEC2", 5122, 3, &uv1);
    let color = document.accessor("VEC3", 5121, 3, &[255, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0]);
    document.json["bufferViews"][color]["byteStride"] = json!(4);
    document.json["accessors"][color]["normalized"] = json!(true);
    document.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    document.primitive(json!({"attributes": {
        "POSITION": position, "TEXCOORD_0": uv, "TEXCOORD_1": uv1, "COLOR_0": color,
    }}));
    let scene = document.scene();
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::NEG_Y]);
    assert_eq!(mesh.texcoords[0][0], Vec2::new(0.0, 1.0));
    assert!((mesh.texcoords[0][1].x - 32768.0 / 65535.0).abs() < 1e-7);
    assert_eq!(mesh.texcoords[1][0], Vec2::new(-3.0, 7.0));
    assert_eq!(mesh.colors[0].to_array(), [1.0, 0.0, 0.2, 1.0]);
}

#[test]
fn sparse_accessors_replace_elements() {
    for with_base in [true, false] {
        let mut document = Document::new();
        let position = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        let indices = document.view(&[1, 2]);
        let values: Vec<u8> = [5_f32, 0., 0., 0., 6., 0.]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let values = document.view(&values);
        let accessor = &mut document.json["accessors"][position];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values},
        });
        if !with_base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        document.primitive(json!({"attributes": {"POSITION": position}}));
        let positions = document.scene().meshes[0].positions.clone();
        assert_eq!(positions, [Vec3::ZERO, Vec3::X * 5.0, Vec3::Y * 6.0]);
        let sparse = |document: &mut Document, key: &str, value: Value| {
            document.json["accessors"][position]["sparse"][key] = value;
            let error = document.error();
            assert_eq!(
                error.place,
                format!("accessors[{position}].sparse"),
                "{error}"
            );
        };
        sparse(&mut document, "count", json!(4));
        sparse(&mut document, "count", json!(3));
        document.binary[36] = 3;
        sparse(&mut document, "count", json!(2));
    }
}

#[test]
fn materials_carry_every_factor_and_texture() {
    let texture = png(2, 1, &[[255, 0, 0, 255], [0, 0, 188, 128]]);
    let transform = json!({"offset": [0.5, 0.25], "rotation": 1.0, "scale": [2, 3], "texCoord": 1});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let document = Document::square()
        .with_texture(&texture)
        .with_material(&json!({
            "name": "paint",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "baseColorTexture": info,
                "metallicFactor": 0.5, "roughnessFactor": 0.25, "metallicRoughnessTexture": info,
            },
            "normalTexture": {"index": 0, "scale": 0.7, "extensions": info["extensions"]},
            "occlusionTexture": {"index": 0, "strength": 0.9},
            "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 0.5, 0.25],
            "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 8},
                "KHR_materials_unlit": {},
            },
        }));
    let scene = document.scene();
    let material = &scene.materials[0];
    assert_eq!(
        (material.metallic, material.perceptual_roughness),
        (0.5, 0.25)
    );
    assert_eq!(material.emissive, Vec3::new(8.0, 4.0, 2.0));
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.3 });
    assert!(material.double_sided && material.unlit);
    assert_eq!(
        (material.normal_scale, material.occlusion_strength),
        (0.7, 0.9)
    );
    let placed = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
    ];
    for reference in placed.map(Option::unwrap) {
        let expected = TextureTransform::new(Vec2::new(0.5, 0.25), 1.0, Vec2::new(2.0, 3.0));
        assert_eq!((reference.texcoord, reference.transform), (1, expected));
    }
    // One image read as sRGB and as data.
    assert_eq!(scene.textures.len(), 2);
    let base = &scene.textures[material.base_color_texture.unwrap().texture];
    let normal = &scene.textures[material.normal_texture.unwrap().texture];
    assert!((base.texel(1, 0).z - 0.5029).abs() < 1e-4);
    assert!((normal.texel(1, 0).z - 188.0 / 255.0).abs() < 1e-6);
}

/// A material with every property of every layer; all textures show `textures[0]`.
fn layered() -> Value {
    let transform = json!({"KHR_texture_transform": {"offset": [0.5, 0.25]}});
    let texture = json!({"index": 0, "extensions": transform});
    json!({"extensions": {
        "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": texture,
            "specularColorFactor": [2, 1, 0.5], "specularColorTexture": texture,
        },
        "KHR_materials_ior": {"ior": 1.8},
        "KHR_materials_anisotropy": {
            "anisotropyStrength": 0.8, "anisotropyRotation": 0.5, "anisotropyTexture": texture,
        },
        "KHR_materials_diffuse_roughness": {
            "diffuseRoughnessFactor": 0.75, "diffuseRoughnessTexture": texture,
        },
        "KHR_materials_sheen": {
            "sheenColorFactor": [0.9, 0.6, 0.3], "sheenColorTexture": texture,
            "sheenRoughnessFactor": 0.4, "sheenRoughnessTexture": texture,
        },
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.7, "clearcoatTexture": texture,
            "clearcoatRoughnessFactor": 0.2, "clearcoatRoughnessTexture": texture,
            "clearcoatNormalTexture": {"index": 0, "scale": 0.6, "extensions": transform},
        },
    }})
}

#[test]
fn layers_carry_every_factor_texture_and_channel() {
    let document = Document::square()
        .with_texture(&png(1, 1, &[[204, 230, 191, 51]]))
        .with_material(&layered());
    let scene = document.scene();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let material = &scene.materials[0];
    let factors = [
        material.specular,
        material.ior,
        material.anisotropy_strength,
        material.anisotropy_rotation,
        material.diffuse_roughness,
        material.sheen_perceptual_roughness,
        material.clearcoat,
        material.clearcoat_perceptual_roughness,
        material.clearcoat_normal_scale,
    ];
    assert_eq!(factors, [0.5, 1.8, 0.8, 0.5, 0.75, 0.4, 0.7, 0.2, 0.6]);
    assert_eq!(material.specular_color, Vec3::new(2.0, 1.0, 0.5));
    assert_eq!(material.sheen_color, Vec3::new(0.9, 0.6, 0.3));
    // One texture read as data and as colour.
    assert_eq!(scene.textures.len(), 2);
    let data = [
        material.specular_texture,
        material.anisotropy_texture,
        material.diffuse_roughness_texture,
        material.sheen_roughness_texture,
        material.clearcoat_texture,
        material.clearcoat_roughness_texture,
        material.clearcoat_normal_texture,
    ];
    let colors = [
        material.specular_color_texture,
        material.sheen_color_texture,
    ];
    let transform = TextureTransform::new(Vec2::new(0.5, 0.25), 0.0, Vec2::ONE);
    for (references, texel) in [(&data[..], 230.0 / 255.0), (&colors[..], 0.7912979)] {
        for reference in references.iter().map(|reference| reference.unwrap()) {
            assert_eq!(reference.transform, transform);
            let green = scene.textures[reference.texture].texel(0, 0).y;
            assert!((green - texel).abs() < 1e-5, "{green}");
        }
    }

    let sample = scene.surface(0, 0, Vec2::new(0.3, 0.2), Vec3::new(0.1, 0.2, -1.0));
    let near = |value: f32, expected: f32| assert!((value - expected).abs() < 1e-6, "{value}");
    let [r, g, b, a] = [204.0, 230.0, 191.0, 51.0].map(|x: f32| x / 255.0);
    near(sample.specular, 0.5 * a);
    near(sample.ior, 1.8);
    near(sample.anisotropy_strength, 0.8 * b);
    near(sample.diffuse_roughness, 0.75 * r);
    near(sample.sheen_perceptual_roughness, 0.4 * a);
    near(sample.clearcoat, 0.7 * r);
    near(sample.clearcoat_perceptual_roughness, 0.2 * g);
    near(sample.specular_color.y, 0.7912979);
    near(sample.sheen_color.y, 0.6 * 0.7912979);
    // The square's texture coordinates run along X, its bitangent along Y.
    let direction = Vec2::from_angle(0.5).rotate(Vec2::new(2.0 * r - 1.0, 2.0 * g - 1.0));
    assert!(sample.tangent.truncate().distance(direction.normalize()) < 1e-6);
    assert_eq!(sample.shading_normal, Vec3::Z);
    let tilted = Vec3::new(0.6 * (2.0 * r - 1.0), 0.6 * (2.0 * g - 1.0), 2.0 * b - 1.0);
    assert!(sample.clearcoat_normal.distance(tilted.normalize()) < 1e-5);
}

#[test]
fn layers_default_to_none() {
    let extensions = [
        "specular",
        "ior",
        "anisotropy",
        "sheen",
        "clearcoat",
        "diffuse_roughness",
    ];
    let empty = extensions.map(|name| (format!("KHR_materials_{name}"), json!({})));
    let empty = serde_json::Map::from_iter(empty);
    let scene = Document::square()
        .with_material(&json!({"extensions": empty}))
        .scene();
    let expected = crate::scene::Material {
        source: Some(0),
        ..Default::default()
    };
    assert_eq!(scene.materials[0], expected);
}

#[test]
fn layers_refuse_what_is_no_number_and_bound_the_rest() {
    let spoilt = |extension: &str, key: &str, value: Value| {
        let mut material = layered();
        material["extensions"][format!("KHR_materials_{extension}")][key] = value;
        Document::square()
            .with_texture(&png(1, 1, &[[128; 4]]))
            .with_material(&material)
    };
    for (extension, key, value, place) in [
        ("specular", "specularFactor", json!("1"), ""),
        ("specular", "specularColorFactor", json!([1, 1]), ""),
        (
            "specular",
            "specularColorFactor",
            json!([1, 1, 1e39]),
            "[2]",
        ),
        ("specular", "specularColorTexture", json!([]), ""),
        ("specular", "specularTexture", json!({"index": 5}), ""),
        ("ior", "ior", json!(null), ""),
        ("anisotropy", "anisotropyRotation", json!(1e300), ""),
        (
            "anisotropy",
            "anisotropyTexture",
            json!({"texCoord": 0}),
            "",
        ),
        ("diffuse_roughness", "diffuseRoughnessFactor", json!({}), ""),
        ("sheen", "sheenColorFactor", json!(0.5), ""),
        (
            "sheen",
            "sheenRoughnessTexture",
            json!({"index": -1}),
            ".index",
        ),
        (
            "clearcoat",
            "clearcoatNormalTexture",
            json!({"index": 0, "scale": "big"}),
            ".scale",
        ),
        (
            "clearcoat",
            "clearcoatTexture",
            json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": 2}}}),
            ".extensions.KHR_texture_transform.scale",
        ),
    ] {
        let error = spoilt(extension, key, value).error();
        let expected = format!("materials[0].extensions.KHR_materials_{extension}.{key}{place}");
        assert_eq!(error.place, expected, "{error}");
        assert!(!error.mend.is_empty());
    }
    let mut document = Document::square();
    document = document.with_material(&json!({"extensions": {"KHR_materials_sheen": 3}}));
    assert_eq!(
        document.error().place,
        "materials[0].extensions.KHR_materials_sheen"
    );

    let bounded = |extension, key, value| spoilt(extension, key, value).scene();
    let scene = bounded("clearcoat", "clearcoatFactor", json!(7));
    assert_eq!(scene.materials[0].clearcoat, 1.0);
    let scene = bounded("sheen", "sheenColorFactor", json!([-1, 2, 0.5]));
    assert_eq!(scene.materials[0].sheen_color, Vec3::new(0.0, 1.0, 0.5));
    let scene = bounded("ior", "ior", json!(0));
    assert!(scene.materials[0].ior == 0.0 && scene.warnings.is_empty());
    let scene = bounded("ior", "ior", json!(0.5));
    assert_eq!(scene.materials[0].ior, 1.0);
    assert_eq!(scene.warnings.len(), 1);

    let mut unlit = layered();
    unlit["extensions"]["KHR_materials_unlit"] = json!({});
    let scene = Document::square()
        .with_texture(&png(1, 1, &[[128; 4]]))
        .with_material(&unlit)
        .scene();
    assert!(scene.warnings[0].contains("unlit") && scene.warnings[0].contains("sheen"));
}

#[test]
fn anisotropy_finds_a_tangent() {
    let tangent = |document: &Document| {
        let scene = document.scene();
        let sample = scene.surface(0, 0, Vec2::new(0.3, 0.2), Vec3::new(0.1, 0.2, -1.0));
        assert!(sample.tangent.is_normalized());
        assert!(sample.tangent.dot(sample.shading_normal).abs() < 1e-6);
        sample.tangent
    };
    let turned =
        json!({"anisotropyStrength": 1, "anisotropyRotation": std::f32::consts::FRAC_PI_2});
    let mut document = Document::square()
        .with_material(&json!({"extensions": {"KHR_materials_anisotropy": turned}}));
    assert!(tangent(&document).distance(Vec3::Y) < 1e-6);
    // The file's tangents go first.
    let normal = document.floats("VEC3", &[[0., 0., 1.]; 4].concat());
    let along_y = document.floats("VEC4", &[[0., 1., 0., 1.]; 4].concat());
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normal);
    attributes["TANGENT"] = json!(along_y);
    assert!(tangent(&document).distance(Vec3::NEG_X) < 1e-6);
    // Neither tangents nor texture coordinates: any direction, always the same.
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    let attributes = attributes.as_object_mut().unwrap();
    attributes.remove("TANGENT");
    attributes.remove("TEXCOORD_0");
    assert_eq!(tangent(&document), tangent(&document));
}

/// The example of the extension's own text: the lower left quadrant, turned clockwise.
#[test]
fn texture_transform_is_the_extensions() {
    let transform = TextureTransform::new(
        Vec2::new(0.0, 1.0),
        std::f32::consts::FRAC_PI_2,
        Vec2::splat(0.5),
    );
    for (uv, expected) in [
        ((0., 0.), (0., 1.)),
        ((1., 0.), (0., 0.5)),
        ((0., 1.), (0.5, 1.)),
        ((1., 1.), (0.5, 0.5)),
    ] {
        assert!(
            transform
                .apply(Vec2::from(uv))
                .distance(Vec2::from(expected))
                < 1e-6,
            "{uv:?}"
        );
    }
}

#[test]
fn emissive_texture_gives_its_mean() {
    let texture = png(
        2,
        2,
        &[
            [255, 255, 255, 255],
            [0, 0, 0, 255],
            [0, 0, 0, 255],
            [255, 0, 0, 255],
        ],
    );
    let document = Document::square()
        .with_texture(&texture)
        .with_material(&json!({
            "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}},
        }));
    let scene = document.scene();
    assert_eq!(scene.polygon_lights.len(), 1);
    let error = scene.polygon_lights[0].radiance - Vec3::new(2.0, 1.0, 1.0);
    assert!(error.abs().max_element() < 1e-6);
    let sample = scene.surface(0, 0, Vec2::new(0.5, 0.25), Vec3::NEG_Z);
    assert!(sample.emissive.x > 0.0 && sample.front && sample.opacity == 1.0);
    let behind = scene.surface(0, 0, Vec2::new(0.5, 0.25), Vec3::Z);
    assert_eq!(
        (behind.emissive, behind.opacity, behind.front),
        (Vec3::ZERO, 0.0, false)
    );
    assert_eq!(behind.geometric_normal, Vec3::NEG_Z);
}

#[test]
fn normal_texture_tilts_the_normal() {
    // Red half as far to the right, green as far up the image.
    let texture = png(1, 1, &[[204, 230, 230, 255]]);
    let tilted = |document: &Document| {
        let scene = document.scene();
        scene
            .surface(0, 0, Vec2::new(0.3, 0.3), Vec3::new(0.1, 0.0, -1.0))
            .shading_normal
    };
    let mut document = Document::square()
        .with_texture(&texture)
        .with_material(&json!({
            "normalTexture": {"index": 0},
        }));
    let expected = Vec3::new(204. / 127.5 - 1., 230. / 127.5 - 1., 230. / 127.5 - 1.).normalize();
    assert!(tilted(&document).distance(expected) < 1e-5);
    let normal = document.floats("VEC3", &[[0., 0., 1.]; 4].concat());
    let tangent = document.floats("VEC4", &[[1., 0., 0., 1.]; 4].concat());
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normal);
    attributes["TANGENT"] = json!(tangent);
    assert!(tilted(&document).distance(expected) < 1e-5);
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_do() {
    let mut document = Document::square();
    let turn = [
        0.0,
        std::f32::consts::FRAC_1_SQRT_2,
        0.0,
        std::f32::consts::FRAC_1_SQRT_2,
    ];
    document.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 1.5}},
        {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}},
    ]);
    document.json["extensions"] = json!({
        "KHR_lights_punctual": {"lights": [
            {"type": "point", "color": [1, 0.5, 0], "intensity": 20, "range": 7},
            {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
            {"type": "directional"},
        ]},
        "EXT_lights_area": {"lights": [
            {"type": "rect", "size": 2, "rect": {"aspect": 3}, "intensity": 5, "color": [1, 0, 0]},
        ]},
    });
    let lit = |extension: &str, light: u32| json!({"rotation": turn, "translation": [1, 2, 3], "extensions": {extension: {"light": light}}});
    let mut area = lit("EXT_lights_area", 0);
    area["scale"] = json!([1, -4, 2]);
    area["name"] = json!("panel");
    document.json["nodes"] = json!([
        {"children": [1, 2, 3, 4, 5, 6]},
        {"camera": 0, "rotation": turn, "translation": [1, 2, 3], "scale": [9, 9, 9]},
        {"camera": 1},
        lit("KHR_lights_punctual", 0), lit("KHR_lights_punctual", 1), lit("KHR_lights_punctual", 2),
        area,
    ]);
    let scene = document.scene();
    let perspective = Projection::Perspective {
        yfov: 0.5,
        aspect: Some(1.5),
    };
    assert_eq!(scene.cameras[0].projection, perspective);
    let (origin, direction) = scene.cameras[0].ray(0.5, 0.5, 1.5);
    assert_eq!(origin, Vec3::new(1.0, 2.0, 3.0));
    assert!(direction.distance(Vec3::NEG_X) < 1e-6);
    assert_eq!(
        scene.cameras[1].projection,
        Projection::Orthographic {
            xmag: 2.0,
            ymag: 1.0
        }
    );
    let kinds: Vec<PunctualKind> = scene
        .punctual_lights
        .iter()
        .map(|light| light.kind)
        .collect();
    let spot = PunctualKind::Spot {
        inner_cone_angle: 0.1,
        outer_cone_angle: 0.2,
    };
    assert_eq!(
        kinds,
        [PunctualKind::Point, spot, PunctualKind::Directional]
    );
    let point = &scene.punctual_lights[0];
    assert_eq!(
        (point.color, point.range),
        (Vec3::new(20.0, 10.0, 0.0), Some(7.0))
    );
    assert!(point.direction.distance(Vec3::NEG_X) < 1e-6);
    // 4 times 2 high, 3 times that wide, facing -X, and seen there.
    let panel = &scene.polygon_lights[0];
    assert_eq!(
        (panel.name.as_str(), panel.radiance),
        ("panel", Vec3::X * 5.0)
    );
    assert!((DVec3::from(panel.area_vector()) - DVec3::NEG_X * 192.0).length() < 1e-4);
    assert_eq!(panel.vertex_count(), 4);
    let mesh = &scene.meshes[panel.mesh];
    assert_eq!(
        (mesh.name.as_str(), panel.triangles.len()),
        ("panel", mesh.triangles.len())
    );
    assert!(Camera::framing(&scene).ray(0.5, 0.5, 1.0).1.is_normalized());
}

#[test]
fn what_is_not_done_is_reported_once_or_refused() {
    let mut document = Document::square().with_material(&json!({"alphaMode": "BLEND"}));
    document.json["extensionsUsed"] =
        json!(["KHR_materials_transmission", "KHR_materials_clearcoat"]);
    document.json["animations"] = json!([{"channels": [], "samplers": []}]);
    document.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "children": [1]}, {"mesh": 0, "skin": 0},
    ]);
    document.json["meshes"][0]["primitives"][0]["targets"] = json!([{}]);
    assert_eq!(
        document.scene().warnings,
        [
            "KHR_materials_transmission is not supported and is ignored",
            "animations are not played: the scene is drawn as it stands",
            "skins are not applied: meshes are drawn in their bind pose",
            "morph targets are not applied",
            "alphaMode BLEND is drawn opaque",
        ]
    );
    document.json["extensionsRequired"] =
        json!(["KHR_texture_transform", "KHR_draco_mesh_compression"]);
    let error = document.error();
    assert_eq!(error.place, "extensionsRequired[1]");
    assert!(
        error.to_string().contains("test.glb") && error.what.contains("KHR_draco_mesh_compression")
    );
}

#[test]
fn default_scene_is_drawn() {
    let mut document = Document::square();
    document.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [7, 0, 0]}]);
    document.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    document.json["scene"] = json!(1);
    let scene = document.scene();
    assert_eq!(
        (scene.meshes.len(), scene.meshes[0].positions[0].x),
        (1, 7.0)
    );
    document.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(document.scene().meshes[0].positions[0].x, 0.0);
    document.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(document.scene().meshes.len(), 2);
}

#[test]
fn broken_documents_name_their_place() {
    type Break = fn(&mut Document);
    let cases: [(&str, Break); 25] = [
        ("nodes[0]", |d| d.json["nodes"][0]["mesh"] = json!(3)),
        ("scenes[0].nodes[0]", |d| d.json["nodes"] = json!([])),
        ("nodes[0].children[0]", |d| {
            d.json["nodes"] = json!([{"children": [0]}]);
        }),
        ("nodes[1].children[0]", |d| {
            d.json["nodes"] = json!([{"children": [1]}, {"children": [0]}]);
        }),
        ("nodes[0].scale[0]", |d| {
            d.json["nodes"] = json!([{"scale": [1e39, 1, 1]}]);
        }),
        ("meshes[0].primitives[0].attributes.POSITION", |d| {
            d.json["nodes"] = json!([{"mesh": 0, "scale": [1e20, 1, 1]}]);
        }),
        ("nodes[0].matrix", |d| {
            d.json["nodes"] = json!([{"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]);
        }),
        ("scene", |d| d.json["scene"] = json!(1)),
        ("accessors[0]", |d| {
            d.json["accessors"][0]["count"] = json!(5);
        }),
        ("accessors[0]", |d| {
            d.json["accessors"][0]["count"] = json!(u64::MAX);
        }),
        ("accessors[0]", |d| {
            d.json["accessors"][0]["byteOffset"] = json!(u64::MAX);
        }),
        ("accessors[0]", |d| {
            d.json["accessors"][0]["type"] = json!("VEC2");
        }),
        ("accessors[0].componentType", |d| {
            d.json["accessors"][0]["componentType"] = json!(1);
        }),
        ("accessors[0]", |d| {
            d.json["bufferViews"][0]["byteStride"] = json!(4);
        }),
        ("accessors[2]", |d| {
            d.json["accessors"][2]["componentType"] = json!(5126);
        }),
        ("bufferViews[0]", |d| {
            d.json["bufferViews"][0]["byteLength"] = json!(u64::MAX);
        }),
        ("bufferViews[0]", |d| {
            d.json["bufferViews"][0]["byteOffset"] = json!(1_000_000);
        }),
        ("bufferViews[0]", |d| {
            d.json["bufferViews"][0]["buffer"] = json!(1);
        }),
        ("meshes[0].primitives[0].indices", |d| {
            let at = d.binary.len() - 2;
            d.binary[at] = 4;
        }),
        ("meshes[0].primitives[0].mode", |d| {
            d.json["meshes"][0]["primitives"][0]["mode"] = json!(7);
        }),
        ("meshes[0].primitives[0].attributes.POSITION", |d| {
            d.binary[..4].copy_from_slice(&f32::NAN.to_le_bytes());
        }),
        ("meshes[0].primitives[0].attributes.TEXCOORD_0", |d| {
            d.json["accessors"][1]["count"] = json!(3);
        }),
        ("meshes[0].primitives[0]", |d| {
            d.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        }),
        ("asset.version", |d| {
            d.json["asset"]["version"] = json!("1.0");
        }),
        ("nodes[0].mesh", |d| d.json["nodes"][0]["mesh"] = json!(-1)),
    ];
    for (i, (place, spoil)) in cases.into_iter().enumerate() {
        let mut document = Document::square();
        spoil(&mut document);
        let error = document.error();
        assert_eq!(error.place, place, "case {i}: {error}");
        assert!(error.to_string().starts_with("test.glb: ") && !error.mend.is_empty());
    }
}

#[test]
fn small_files_cannot_ask_for_much() {
    // Elements without bytes.
    let mut document = Document::square();
    let accessor = document.json["accessors"][0].as_object_mut().unwrap();
    accessor.remove("bufferView");
    accessor["count"] = json!(100_000_000);
    assert_eq!(document.error().place, "accessors[0]");
    // Many instances.
    let mut document = Document::square();
    document.json["nodes"] = Value::Array(vec![json!({"mesh": 0}); 1000]);
    document.json.as_object_mut().unwrap().remove("scene");
    document.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(document.scene().meshes.len(), 1000);
    let limits = Limits {
        mesh_bytes: 100_000,
        ..Limits::default()
    };
    let error = Scene::from_slice_within(&document.glb(), None, "", &limits).unwrap_err();
    assert_eq!(error.place, "meshes[0].primitives[0]");
    // A chain of nodes.
    let count = 100_000;
    let chain = (0..count).map(|i| {
        if i + 1 < count {
            json!({"children": [i + 1]})
        } else {
            json!({})
        }
    });
    document.json["nodes"] = chain.collect();
    assert_eq!(document.error().place, "nodes[1024]");
    // Brackets without end.
    let deep = format!("{{\"asset\": {}", "[".repeat(100_000));
    assert!(Scene::from_slice(deep.as_bytes(), None, "").is_err());
    let limits = Limits {
        json_objects: 10,
        ..Limits::default()
    };
    assert!(Scene::from_slice_within(&Document::square().glb(), None, "", &limits).is_err());
}

#[test]
fn emissive_images_may_be_brighter_than_white() {
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x00\x84\x00\x80\x80\x81";
    let document = Document::square()
        .with_texture(hdr)
        .with_material(&json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}));
    let scene = document.scene();
    let texel = |x| scene.textures[0].texel(x, 0).to_array();
    assert_eq!((texel(0), texel(1)), ([8., 4., 0., 1.], [0., 1., 1., 1.]));
    let light = &scene.polygon_lights[0];
    assert!((light.radiance - Vec3::new(4.0, 2.5, 0.5)).length() < 1e-5);
    assert_eq!(light.image.unwrap().size, [2, 1]);
}

#[test]
fn pictures_of_lights_keep_to_their_budget() {
    let texels: Vec<_> = (0..64).map(|i| [i; 4]).collect();
    let mut document = Document::square()
        .with_texture(&png(8, 8, &texels))
        .with_material(&json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}));
    document.json["nodes"] = json!([{"mesh": 0, "name": "left"}, {"mesh": 0, "name": "right"}]);
    document.json["scenes"] = json!([{"nodes": [0, 1]}]);
    // 64 + 16 + 4 + 1 cells of 16 bytes, twice.
    let within = |light_image_bytes, light_image_side| {
        let limits = Limits {
            light_image_bytes,
            light_image_side,
            ..Limits::default()
        };
        Scene::from_slice_within(&document.glb(), None, "two.glb", &limits)
    };
    assert!(within(2720, 4096).is_ok());
    let message = within(2719, 4096).unwrap_err().to_string();
    for part in [
        "two.glb",
        "\"right\"",
        "8 × 8",
        "1360 bytes",
        "1359 of 2719",
    ] {
        assert!(message.contains(part), "{message}");
    }
    let scene = within(2719, 4).unwrap();
    assert_eq!(scene.polygon_lights[1].image.unwrap().size, [4, 4]);
    assert_eq!(scene.warnings.len(), 2);
    let warning = "light \"left\" shows 8 × 8 texels, its picture 4 × 4";
    assert!(
        scene.warnings[0].starts_with(warning),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn images_are_bounded_before_they_are_decoded() {
    let emissive = json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}});
    let mut huge = png(1, 1, &[[0; 4]]);
    // The header's width and height, and its checksum, as a decoder would read them.
    huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let checksum = crc32(&huge[12..29]);
    huge[29..33].copy_from_slice(&checksum.to_be_bytes());
    let error = Document::square()
        .with_texture(&huge)
        .with_material(&emissive)
        .error();
    assert_eq!(error.place, "images[0]");
    let sound = Document::square()
        .with_texture(&png(8, 8, &[[9; 4]; 64]))
        .with_material(&emissive);
    assert_eq!(sound.scene().textures[0].width, 8);
    for limits in [
        Limits {
            image_bytes: 255,
            ..Limits::default()
        },
        Limits {
            image_side: 7,
            ..Limits::default()
        },
    ] {
        let error = Scene::from_slice_within(&sound.glb(), None, "", &limits).unwrap_err();
        assert_eq!(error.place, "images[0]");
    }
    let text = Document::square()
        .with_texture(b"GIF89a")
        .with_material(&emissive);
    assert_eq!(text.error().place, "images[0]");
}

/// CRC-32 as PNG has it, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    };
    !bytes.iter().fold(!0, step)
}

#[test]
fn files_outside_the_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("scene");
    fs::create_dir_all(inside.join("data")).unwrap();
    let document = Document::square();
    fs::write(inside.join("data/my buffer.bin"), &document.binary).unwrap();
    fs::write(folder.path().join("secret.bin"), &document.binary).unwrap();
    let load = |uri: &str| Scene::from_slice(&document.gltf_at(uri), Some(&inside), "scene.gltf");
    assert!(load("data/my%20buffer.bin").is_ok());
    assert!(load("./data/my buffer.bin").is_ok());
    let absolute = folder.path().join("secret.bin").display().to_string();
    for uri in [
        "../secret.bin",
        "data/../../secret.bin",
        "%2e%2e/secret.bin",
        "..%2fsecret.bin",
        "..\\secret.bin",
        absolute.as_str(),
        &format!("file://{absolute}"),
        "http://example.com/secret.bin",
        "HTTPS://example.com/secret.bin",
        "//example.com/secret.bin",
        "c:/secret.bin",
        "c%3A/secret.bin",
        "data/my%20buffer.bin%00",
        "data/%ff.bin",
        "",
        "data",
        "data/missing.bin",
        "data:;base64,####",
        "data:nothing",
    ] {
        let error = load(uri).unwrap_err();
        assert_eq!(error.place, "buffers[0].uri", "{uri}: {error}");
    }
    let no_folder = Scene::from_slice(
        &document.gltf_at("data/my%20buffer.bin"),
        None,
        "scene.gltf",
    );
    assert_eq!(no_folder.unwrap_err().place, "buffers[0].uri");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("secret.bin"), inside.join("link.bin"))
            .unwrap();
        assert!(load("link.bin").unwrap_err().what.contains("link"));
    }
    let path = inside.join("scene.gltf");
    fs::write(&path, document.gltf_at("data/my%20buffer.bin")).unwrap();
    assert_eq!(Scene::load(&path).unwrap().meshes.len(), 1);
    let missing = Scene::load(inside.join("none.gltf")).unwrap_err();
    assert!(missing.path.ends_with("none.gltf"), "{missing}");
    assert!(Scene::load(&inside).is_err());
}

/// A scene with a bit of everything.
fn rich() -> Document {
    let texture = png(
        2,
        2,
        &[
            [255, 255, 255, 255],
            [9, 80, 3, 255],
            [0, 0, 90, 255],
            [255, 0, 0, 99],
        ],
    );
    let mut document = Document::square().with_texture(&texture).with_material(&json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}, "alphaMode": "MASK",
        "extensions": layered()["extensions"],
    }));
    let indices = document.view(&[1]);
    let values = document.view(&[0; 12]);
    document.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values},
    });
    document.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
    ]);
    document.json["samplers"] = json!([{"wrapS": 33071, "magFilter": 9728}]);
    document.json["textures"][0]["sampler"] = json!(0);
    document.json["extensions"] = json!({
        "KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]},
        "EXT_lights_area": {"lights": [{"type": "disk", "size": 2}]},
    });
    document.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2], "scale": [1, 2, 3]},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"EXT_lights_area": {"light": 0}}, "rotation": [0.5, 0.5, 0.5, 0.5]},
    ]);
    document
}

/// Whatever a file's bytes are, reading it returns; a scene that comes of it can be asked.
fn survive(bytes: &[u8]) {
    let limits = Limits {
        image_bytes: 1 << 22,
        mesh_bytes: 1 << 24,
        ..Limits::default()
    };
    if let Ok(scene) = Scene::from_slice_within(bytes, None, "mutant", &limits) {
        for (m, mesh) in scene.meshes.iter().enumerate() {
            for t in 0..mesh.triangles.len().min(100) {
                let sample = scene.surface(m, t, Vec2::splat(0.3), Vec3::new(0.1, -0.2, -1.0));
                assert!(sample.shading_normal.is_finite() && sample.base_color.is_finite());
                assert!(sample.clearcoat_normal.is_finite() && sample.tangent.is_finite());
                assert!(sample.specular_color.is_finite() && sample.sheen_color.is_finite());
            }
        }
        for light in &scene.polygon_lights {
            if let Some(image) = &light.image {
                let cells = image.cells(&scene.textures, [4, 2]);
                assert!(
                    cells
                        .as_flattened()
                        .iter()
                        .all(|x| *x >= 0.0 && x.is_finite())
                );
                let frame = [image.corner, image.edge_u, image.edge_v];
                assert!(frame.as_flattened().iter().all(|x| x.is_finite()));
            }
            assert!(
                light.area().is_finite() && light.radiance.is_finite(),
                "{light:?}"
            );
            assert!(
                light
                    .loops
                    .iter()
                    .flatten()
                    .flatten()
                    .all(|x| x.is_finite())
            );
        }
        assert!(Camera::framing(&scene).ray(0.1, 0.9, 1.5).1.is_finite());
    }
}

#[test]
fn truncated_files_never_panic() {
    for bytes in [rich().glb(), rich().gltf()] {
        assert!(Scene::from_slice(&bytes, None, "").is_ok());
        for length in 0..bytes.len() {
            survive(&bytes[..length]);
        }
    }
}

#[test]
fn flipped_bits_never_panic() {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        // Xorshift, Marsaglia 2003.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for original in [rich().glb(), rich().gltf()] {
        for _ in 0..3000 {
            let mut bytes = original.clone();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                match random(3) {
                    0 => bytes[at] ^= 1 << random(8),
                    1 => bytes[at] = b"0123456789-.eE[]{},:\""[random(21)],
                    _ => bytes[at] = [0, 0xff, 0x7f, 0x80][random(4)],
                }
            }
            survive(&bytes);
        }
    }
}
