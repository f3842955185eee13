//! Scenes that are loaded, edited, saved and loaded again.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use base64::{Engine, prelude::BASE64_STANDARD};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
use lumigon_renderer::{
    AlphaMode, Camera, CpuRenderer, Filter, GltfSource, ImageFile, Limits, LoadPhase, LoadWatch,
    Material, Mesh, RenderSettings, Sampler, SaveError, Scene, TextureRef, TextureTransform,
    ToneMap, Watch, Wrap, decode_image, srgb8,
};
use serde_json::{Value, json};
use tempfile::TempDir;

type Frames = HashMap<usize, DAffine3>;

fn load(path: &Path) -> (Scene, GltfSource) {
    Scene::load_watched(path, &Limits::default(), LoadWatch::none()).unwrap()
}

fn ours(name: &str) -> (Scene, GltfSource) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/");
    load(Path::new(&format!("{folder}{name}.glb")))
}

fn saved(
    folder: &TempDir,
    name: &str,
    source: &GltfSource,
    original: &Scene,
    edited: &Scene,
    frames: &Frames,
) -> (Scene, GltfSource) {
    let path = folder.path().join(name);
    source.save(original, edited, frames, &path).unwrap();
    check(&path);
    load(&path)
}

/// The JSON of a `.glb` or `.gltf` file, and the first one's binary chunk.
fn parts(path: &Path) -> (Value, Vec<u8>) {
    let bytes = fs::read(path).unwrap();
    if !bytes.starts_with(b"glTF") {
        return (serde_json::from_slice(&bytes).unwrap(), Vec::new());
    }
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(word(8), bytes.len());
    let length = word(12);
    assert_eq!((length % 4, &bytes[16..20]), (0, &b"JSON"[..]));
    let json = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let binary = bytes.get(28 + length..).unwrap_or_default();
    if !binary.is_empty() {
        assert_eq!(word(20 + length), binary.len());
        assert_eq!(
            (binary.len() % 4, &bytes[24 + length..28 + length]),
            (0, &b"BIN\0"[..])
        );
    }
    (json, binary.to_vec())
}

/// What a validator asks of views and accessors, and that everything is embedded.
fn check(path: &Path) {
    let (json, binary) = parts(path);
    let list = |key: &str| json[key].as_array().cloned().unwrap_or_default();
    let number = |value: &Value, key: &str| value[key].as_u64().unwrap_or(0) as usize;
    for (i, buffer) in list("buffers").iter().enumerate() {
        let length = number(buffer, "byteLength");
        match buffer["uri"].as_str() {
            Some(uri) => {
                let data = uri.split_once(";base64,").unwrap().1;
                assert_eq!(BASE64_STANDARD.decode(data).unwrap().len(), length);
            }
            None => assert!(i == 0 && length <= binary.len() && binary.len() < length + 4),
        }
    }
    for view in list("bufferViews") {
        let end = number(&view, "byteOffset") + number(&view, "byteLength");
        assert!(end <= number(&list("buffers")[number(&view, "buffer")], "byteLength"));
        assert_eq!(number(&view, "byteOffset") % 4, 0);
    }
    for accessor in list("accessors") {
        let view = &list("bufferViews")[number(&accessor, "bufferView")];
        let size = match number(&accessor, "componentType") {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let count = number(&accessor, "count");
        assert!(
            count > 0 && count * size * width <= number(view, "byteLength"),
            "{accessor}"
        );
    }
    for image in list("images") {
        match image["uri"].as_str() {
            Some(uri) => assert!(uri.starts_with("data:image/")),
            None => assert!(image["mimeType"].as_str().unwrap().starts_with("image/")),
        }
    }
}

/// Takes a light out of its mesh into a new mesh at the end, with a material of its own; returns the
/// new mesh's index.
fn take_out(scene: &mut Scene, light: usize) -> usize {
    let light = scene.polygon_lights.remove(light);
    let old = Arc::clone(&scene.meshes[light.mesh]);
    let is_of_light = |t: &usize| light.triangles.contains(&(*t as u32));
    let (of_light, left): (Vec<usize>, Vec<usize>) =
        (0..old.triangles.len()).partition(is_of_light);
    let triangles = |list: Vec<usize>| list.into_iter().map(|t| old.triangles[t]).collect();
    let mut new = Mesh {
        triangles: triangles(of_light),
        source: None,
        ..(*old).clone()
    };
    scene.meshes[light.mesh] = Arc::new(Mesh {
        triangles: triangles(left),
        ..(*old).clone()
    });
    new.material = scene.materials.len();
    scene.materials.push(scene.materials[old.material].clone());
    // The triangles of the others moved up.
    scene
        .polygon_lights
        .retain(|other| other.mesh != light.mesh);
    let (others, _) = scene.lights_of_mesh(light.mesh, &Limits::default());
    scene.polygon_lights.extend(others);
    scene.polygon_lights.sort_by_key(|light| light.mesh);
    add(scene, new)
}

/// Finds a mesh's lights again, after its material was changed.
fn relight(scene: &mut Scene, mesh: usize) {
    let (lights, _) = scene.lights_of_mesh(mesh, &Limits::default());
    scene.polygon_lights.retain(|light| light.mesh != mesh);
    scene.polygon_lights.extend(lights);
    scene.polygon_lights.sort_by_key(|light| light.mesh);
}

fn add(scene: &mut Scene, mesh: Mesh) -> usize {
    scene.meshes.push(Arc::new(mesh));
    let index = scene.meshes.len() - 1;
    let (lights, _) = scene.lights_of_mesh(index, &Limits::default());
    assert!(!lights.is_empty());
    scene.polygon_lights.extend(lights);
    index
}

/// A square frame of side 1 around a hole, with texture coordinates, placed.
fn square_frame(name: &str, material: usize, world_from_plane: &DAffine3) -> Mesh {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let flat: Vec<[f64; 2]> = corners
        .into_iter()
        .chain(corners.map(|[x, y]| [0.4 * x, 0.4 * y]))
        .collect();
    let quad = |a: u32| {
        let b = (a + 1) % 4;
        [[a, b, b + 4], [a, b + 4, a + 4]]
    };
    Mesh {
        name: name.to_owned(),
        material,
        positions: flat
            .iter()
            .map(|&[x, y]| {
                world_from_plane
                    .transform_point3(DVec3::new(x, y, 0.0))
                    .as_vec3()
            })
            .collect(),
        normals: vec![(world_from_plane.matrix3 * DVec3::Z).as_vec3(); 8],
        texcoords: [
            flat.iter()
                .map(|&[x, y]| Vec2::new(x as f32 + 0.5, 0.5 - y as f32))
                .collect(),
            Vec::new(),
        ],
        triangles: (0..4).flat_map(quad).collect(),
        ..Mesh::default()
    }
}

fn frame(translation: DVec3) -> DAffine3 {
    let rotation = DQuat::from_rotation_x(2.1) * DQuat::from_rotation_z(0.4);
    DAffine3::from_rotation_translation(rotation, translation)
}

fn emissive(name: &str, emissive: Vec3) -> Material {
    Material {
        name: name.to_owned(),
        base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
        metallic: 0.0,
        emissive,
        ..Material::default()
    }
}

/// The same polygons, in any order.
fn assert_same_lights(found: &Scene, expected: &Scene) {
    let mut left: Vec<_> = found.polygon_lights.iter().collect();
    assert_eq!(left.len(), expected.polygon_lights.len());
    for b in &expected.polygon_lights {
        let size = b.area().sqrt();
        let counts = |loops: &[Vec<[f64; 3]>]| loops.iter().map(Vec::len).collect::<Vec<_>>();
        let place = left.iter().position(|a| {
            let mut pairs = a.loops.iter().flatten().zip(b.loops.iter().flatten());
            counts(&a.loops) == counts(&b.loops)
                && pairs.all(|(&p, &q)| (DVec3::from(p) - DVec3::from(q)).length() < 1e-5 * size)
        });
        let a = place.unwrap_or_else(|| panic!("no light where {} is: {left:?}", b.name));
        let a = left.remove(a);
        assert_eq!(a.name, b.name);
        assert_eq!(a.two_sided, b.two_sided);
        assert_eq!(a.image.is_some(), b.image.is_some());
        assert!(
            a.radiance
                .abs_diff_eq(b.radiance, 1e-6 * b.radiance.max_element()),
            "{}: {} {}",
            a.name,
            a.radiance,
            b.radiance
        );
    }
}

fn picture(scene: &Scene, camera: &Camera) -> Vec<u8> {
    let settings = RenderSettings {
        width: 64,
        height: 40,
        samples: 1,
        ..RenderSettings::default()
    };
    let rendering = CpuRenderer::new(scene)
        .render(camera, &settings, Watch::none())
        .unwrap();
    srgb8(&rendering.radiance(), 0.0, ToneMap::None)
}

fn assert_same_pictures(found: &Scene, expected: &Scene) {
    let camera = expected.cameras.first().cloned();
    let camera = camera.unwrap_or_else(|| Camera::framing(expected));
    let (a, b) = (picture(found, &camera), picture(expected, &camera));
    let apart = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart <= Some(1), "{apart:?}");
    assert!(b.iter().any(|&c| c > 8), "a black picture says nothing");
}

#[test]
fn a_light_taken_out_and_others_added_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let (original, source) = ours("cornell");
    let mut edited = original.clone();
    let moved = take_out(&mut edited, 0);
    let material = edited.meshes[moved].material;
    edited.materials[material].emissive *= Vec3::new(0.3, 1.1, 0.7);
    relight(&mut edited, moved);

    let image = {
        let texels =
            (0..16_u32).map(|i| [i * 13 % 256, i * 40 % 256, 255 - i * 7, 255].map(|c| c as u8));
        let image = image::RgbaImage::from_raw(4, 4, texels.flatten().collect()).unwrap();
        let mut png = std::io::Cursor::new(Vec::new());
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        png.into_inner()
    };
    let picture = decode_image(&image, "dots.png", &Limits::default()).unwrap();
    let sampler = Sampler {
        wrap_s: Wrap::ClampToEdge,
        wrap_t: Wrap::MirroredRepeat,
        filter: Filter::Nearest,
    };
    edited.textures.push(picture.texture(true, sampler));
    let shown = TextureRef {
        texture: edited.textures.len() - 1,
        texcoord: 0,
        transform: TextureTransform::new(Vec2::new(0.25, 0.5), 0.7, Vec2::new(0.5, -0.75)),
    };
    edited.materials.push(Material {
        emissive_texture: Some(shown),
        double_sided: true,
        alpha_mode: AlphaMode::Mask { cutoff: 0.25 },
        ..emissive("shown", Vec3::new(7.0, 3.0, 0.5))
    });
    edited
        .materials
        .push(emissive("dim", Vec3::new(0.25, 0.5, 0.125)));
    let count = edited.materials.len();
    let first = frame(DVec3::new(0.1, 0.9, 0.2));
    let second = frame(DVec3::new(-0.3, 0.4, -0.1));
    let a = add(&mut edited, square_frame("shown", count - 2, &first));
    add(&mut edited, square_frame("dim", count - 1, &second));
    let frames = Frames::from([(a, first)]);

    for name in ["a.glb", "a.gltf"] {
        let (read, again) = saved(&folder, name, &source, &original, &edited, &frames);
        assert_same_lights(&read, &edited);
        assert_same_pictures(&read, &edited);
        assert_eq!(read.cameras, edited.cameras);
        let find = |name: &str| {
            let mut found = read
                .materials
                .iter()
                .find(|m| m.name == name)
                .unwrap()
                .clone();
            found.source = None;
            found
        };
        let expected = &edited.materials[count - 2];
        let found = find("shown");
        let reference = found.emissive_texture.unwrap();
        let matrix = reference.transform.texture_from_texcoord;
        assert!(matrix.abs_diff_eq(shown.transform.texture_from_texcoord, 1e-6));
        assert_eq!(read.textures[reference.texture].sampler, sampler);
        assert_eq!(
            Material {
                emissive_texture: Some(shown),
                ..found
            },
            *expected
        );
        assert_eq!(find("dim"), edited.materials[count - 1]);

        // What was read and is saved unedited is the same file, whichever of the two kinds.
        let (_, same) = saved(&folder, name, &again, &read, &read, &Frames::new());
        assert_eq!(again, same);
        let first = fs::read(folder.path().join(name)).unwrap();
        saved(&folder, name, &source, &original, &edited, &frames);
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), first);
    }
    // The picture is the file it was.
    let (json, binary) = parts(&folder.path().join("a.glb"));
    let view = json["images"].as_array().unwrap().last().unwrap()["bufferView"].as_u64();
    let view = &json["bufferViews"][view.unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(&binary[start..start + image.len()], &image);
    // The light that was taken out whole is the node it was; the others have new ones.
    let nodes = json["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), node_count(&source_folder("cornell")) + 2);
    // The light with a frame stands in it.
    let node = nodes.iter().find(|node| node["name"] == "shown").unwrap();
    assert_eq!(node["translation"], json!([0.1, 0.9, 0.2]));
}

#[test]
fn scenes_of_ours_come_back_with_every_light_taken_out() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["neon", "stained-glass"] {
        let (original, source) = ours(name);
        let mut edited = original.clone();
        while let Some(light) = edited
            .polygon_lights
            .iter()
            .position(|light| light.mesh < original.meshes.len())
        {
            take_out(&mut edited, light);
        }
        let (read, _) = saved(
            &folder,
            "all.glb",
            &source,
            &original,
            &edited,
            &Frames::new(),
        );
        assert_same_lights(&read, &edited);
        assert_same_pictures(&read, &edited);
    }
}

fn source_folder(name: &str) -> std::path::PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/");
    format!("{folder}{name}.glb").into()
}

fn node_count(path: &Path) -> usize {
    parts(path).0["nodes"].as_array().unwrap().len()
}

/// Sessions that move a light and save leave one light, at one node.
#[test]
fn session_after_session_leaves_one_node() {
    let folder = tempfile::tempdir().unwrap();
    let path = source_folder("cornell");
    let count = node_count(&path);
    let (mut original, mut source) = load(&path);
    for session in 0..3 {
        let mut edited = original.clone();
        let moved = take_out(&mut edited, 0);
        let place = frame(DVec3::new(0.1 * f64::from(session), 0.5, 0.0));
        let mesh = Mesh {
            source: None,
            ..square_frame(
                &edited.meshes[moved].name,
                edited.meshes[moved].material,
                &place,
            )
        };
        edited.meshes[moved] = Arc::new(mesh);
        relight(&mut edited, moved);
        let frames = Frames::from([(moved, place)]);
        let (read, again) = saved(&folder, "s.glb", &source, &original, &edited, &frames);
        assert_same_lights(&read, &edited);
        assert_eq!(node_count(&folder.path().join("s.glb")), count);
        (original, source) = (read, again);
    }
}

/// A file under construction: one square with normals and texture coordinates as a strip, another
/// without normals, emissive and not.
struct Built {
    json: Value,
    binary: Vec<u8>,
}

impl Built {
    fn new() -> Self {
        let mut built = Self {
            json: json!({
                "asset": {"version": "2.0", "generator": "by hand", "extras": {"of": "asset"}},
                "scene": 0,
                "scenes": [{"nodes": [0, 1], "name": "main"}],
                "accessors": [],
                "bufferViews": [],
                "materials": [
                    {"name": "lamp", "emissiveFactor": [1, 0.5, 0.25], "extras": {"kept": [1, 2]},
                     "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4},
                                    "VENDOR_finish": {"gloss": "satin"}}},
                    {"name": "wall"},
                ],
                "extensionsUsed": ["KHR_materials_emissive_strength", "VENDOR_finish"],
            }),
            binary: Vec::new(),
        };
        // Two squares side by side in the plane z = 0, one strip with a degenerate join between.
        let squares = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [2.0, 0.0, 0.0],
            [3.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [3.0, 1.0, 0.0],
        ];
        let position = built.floats("VEC3", squares.as_flattened());
        let normal = built.floats("VEC3", &[[0.0, 0.0, 1.0]; 8].concat());
        let strip = built.indices(&[0, 1, 2, 3, 3, 4, 4, 5, 6, 7]);
        let list = built.indices(&[0, 1, 2, 2, 1, 3, 4, 4, 5, 4, 5, 6, 6, 5, 7]);
        built.json["meshes"] = json!([
            {"name": "strip", "extras": {"mesh": 1}, "primitives": [
                {"attributes": {"POSITION": position, "NORMAL": normal}, "indices": strip, "mode": 5,
                 "material": 0}]},
            {"primitives": [
                {"attributes": {"POSITION": position}, "indices": list, "material": 0},
                {"attributes": {"POSITION": position}, "indices": list, "mode": 1}]},
        ]);
        built.json["nodes"] = json!([
            {"mesh": 0, "name": "plain", "extras": {"deep": {"er": null}}},
            {"mesh": 1, "name": "mirrored", "translation": [0, 0, 3], "scale": [-1, 1, 1]},
        ]);
        built
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = if kind == "VEC3" { 3 } else { 2 };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len() / width, &bytes)
    }

    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor("SCALAR", 5123, values.len(), &bytes)
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let (offset, length) = (self.binary.len(), bytes.len());
        self.binary.extend_from_slice(bytes);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        let view = views.len() - 1;
        let mut accessor =
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        if kind == "VEC3" {
            accessor["min"] = json!([0, 0, 0]);
            accessor["max"] = json!([3, 1, 0]);
        }
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    /// As a `.gltf` file beside its buffer.
    fn write(&self, folder: &TempDir) -> (Scene, GltfSource) {
        let mut json = self.json.clone();
        json["buffers"] = json!([
            {"byteLength": self.binary.len(), "uri": "a%20b.bin", "name": "geometry"}]);
        fs::write(folder.path().join("a b.bin"), &self.binary).unwrap();
        let path = folder.path().join("built.gltf");
        fs::write(&path, json.to_string()).unwrap();
        load(&path)
    }
}

/// The light of a mesh that spans these x in the world.
fn light_at(scene: &Scene, node: &str, x: [f64; 2]) -> usize {
    let is_it = |light: &lumigon_renderer::EmissivePolygon| {
        let within = |p: &[f64; 3]| x[0] - 1e-6 <= p[0] && p[0] <= x[1] + 1e-6;
        light.name.starts_with(node) && light.loops.iter().flatten().all(within)
    };
    scene.polygon_lights.iter().position(is_it).unwrap()
}

#[test]
fn strips_and_mirrored_meshes_without_normals_lose_their_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let (original, source) = Built::new().write(&folder);
    assert_eq!(original.polygon_lights.len(), 4);
    for (node, x) in [
        ("plain", [0.0, 1.0]),
        ("plain", [2.0, 3.0]),
        ("mirrored", [-1.0, 0.0]),
        ("mirrored", [-3.0, -2.0]),
    ] {
        let mut edited = original.clone();
        let light = light_at(&edited, node, x);
        let new = take_out(&mut edited, light);
        assert_eq!(edited.meshes[new].triangles.len(), 2);
        let (read, _) = saved(
            &folder,
            "b.glb",
            &source,
            &original,
            &edited,
            &Frames::new(),
        );
        assert_same_lights(&read, &edited);
        assert_same_pictures(&read, &edited);
        let (json, _) = parts(&folder.path().join("b.glb"));
        // What is left are the file's own vertices; the degenerate triangle was no one's to take.
        let mesh = usize::from(node == "mirrored");
        let primitive = &json["meshes"][mesh]["primitives"][0];
        assert_eq!(
            primitive["attributes"],
            source_primitive(&folder, mesh)["attributes"]
        );
        assert!(primitive["mode"].is_null());
        let lines = &json["meshes"][1]["primitives"][1];
        assert_eq!(lines["mode"], 1);
    }
}

fn source_primitive(folder: &TempDir, mesh: usize) -> Value {
    let (json, _) = parts(&folder.path().join("built.gltf"));
    json["meshes"][mesh]["primitives"][0].clone()
}

#[test]
fn one_instance_is_edited_and_the_others_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let mut built = Built::new();
    let nodes = built.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"mesh": 0, "name": "other", "translation": [0, 5, 0]}));
    built.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    // A scene that is not shown shows it too.
    let scenes = built.json["scenes"].as_array_mut().unwrap();
    scenes.push(json!({"nodes": [3]}));
    let nodes = built.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"mesh": 0, "name": "elsewhere"}));
    let (original, source) = built.write(&folder);
    let mut edited = original.clone();
    let light = light_at(&edited, "other", [2.0, 3.0]);
    take_out(&mut edited, light);
    let (read, _) = saved(
        &folder,
        "c.glb",
        &source,
        &original,
        &edited,
        &Frames::new(),
    );
    assert_same_lights(&read, &edited);
    let (json, _) = parts(&folder.path().join("c.glb"));
    let mut own = json["meshes"][2].clone();
    assert_eq!(json["nodes"][2]["mesh"], 2);
    assert_eq!(json["meshes"][0], built.json["meshes"][0]);
    own["primitives"] = built.json["meshes"][0]["primitives"].clone();
    assert_eq!(own, built.json["meshes"][0]);

    // All instances, one after the other, wholly.
    let mut edited = original.clone();
    while let Some(light) = edited
        .polygon_lights
        .iter()
        .position(|l| l.name.ends_with("strip"))
    {
        let mesh = edited.polygon_lights[light].mesh;
        if mesh >= original.meshes.len() {
            break;
        }
        take_out(&mut edited, light);
    }
    let (read, _) = saved(
        &folder,
        "c.glb",
        &source,
        &original,
        &edited,
        &Frames::new(),
    );
    assert_same_lights(&read, &edited);
    let (json, _) = parts(&folder.path().join("c.glb"));
    // The node itself is still there, and shows one of its lights.
    assert_eq!(json["nodes"][0]["extras"], json!({"deep": {"er": null}}));
    assert_eq!(json["nodes"][0]["name"], "plain");
    let shown = json["nodes"][0]["mesh"].as_u64().unwrap() as usize;
    assert!(shown >= 2);
    assert_eq!(json["meshes"][shown]["name"], "strip");
    assert_eq!(json["nodes"][3]["mesh"], 0);
}

#[test]
fn what_was_not_edited_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut built = Built::new();
    built.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 0, "output": 0, "extras": 1.5e300}]}]);
    built.json["extensions"] =
        json!({"VENDOR_world": {"sky": [0.1, 1e-300, -0.0, 18446744073709551615_u64]}});
    built.json["extras"] = json!({"ünï": "\u{0}\"\\", "empty": {}});
    built.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    built.json["samplers"] = json!([{"wrapS": 33071, "name": "unused"}]);
    built.json["images"] = json!([
        {"uri": "dot.png", "name": "dot"},
        {"uri": "no-such-file.png"},
        {"uri": "https://example.com/far.png"}]);
    built.json["textures"] = json!([{"source": 0, "sampler": 0}, {"source": 1}]);
    built.json["materials"][1]["pbrMetallicRoughness"] = json!({"baseColorTexture": {"index": 0}});
    built.json["meshes"][1]["primitives"][0]["material"] = json!(1);
    let mut png = std::io::Cursor::new(Vec::new());
    let dot = image::RgbImage::from_pixel(1, 1, image::Rgb([200, 100, 50]));
    dot.write_to(&mut png, image::ImageFormat::Png).unwrap();
    fs::write(folder.path().join("dot.png"), png.get_ref()).unwrap();
    let (original, source) = built.write(&folder);

    let mut edited = original.clone();
    let light = light_at(&edited, "plain", [0.0, 1.0]);
    let new = take_out(&mut edited, light);
    let material = edited.meshes[new].material;
    edited.materials[material].emissive = Vec3::new(9.0, 3.0, 1.0);
    relight(&mut edited, new);
    // Elsewhere, where the files beside the first one are not.
    let elsewhere = tempfile::tempdir().unwrap();
    for name in ["d.glb", "d.gltf"] {
        let path = elsewhere.path().join(name);
        source
            .save(&original, &edited, &Frames::new(), &path)
            .unwrap();
        let (read, _) = load(&path);
        assert_same_lights(&read, &edited);
        assert_same_pictures(&read, &edited);
        let (json, _) = parts(&path);
        for (key, value) in built.json.as_object().unwrap() {
            match key.as_str() {
                "accessors" | "bufferViews" | "materials" | "meshes" => {
                    let kept = value.as_array().unwrap();
                    let found = json[key].as_array().unwrap();
                    // The first mesh lost triangles.
                    let from = usize::from(key == "meshes");
                    assert_eq!(found[from..kept.len()], kept[from..], "{key}");
                }
                "nodes" => assert_eq!(
                    json[key].as_array().unwrap()[..2],
                    value.as_array().unwrap()[..]
                ),
                "scenes" => assert_eq!(json[key], json!([{"nodes": [0, 1, 2], "name": "main"}])),
                "images" => {
                    assert_eq!(json[key][0]["name"], "dot");
                    assert_eq!(
                        json[key].as_array().unwrap()[1..],
                        value.as_array().unwrap()[1..]
                    );
                }
                _ => assert_eq!(&json[key], value, "{key}"),
            }
        }
        assert_eq!(json["buffers"][0]["name"], "geometry");
        // The light's own material keeps what was not understood.
        let own = json["materials"].as_array().unwrap().last().unwrap();
        let expected = json!({
            "name": "lamp", "extras": {"kept": [1, 2]},
            "emissiveFactor": [1.0, 1.0_f64 / 3.0, 1.0_f64 / 9.0],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 9.0},
                           "VENDOR_finish": {"gloss": "satin"}}});
        assert_eq!(own["extensions"], expected["extensions"]);
        assert_eq!(own["extras"], expected["extras"]);
        for i in 0..3 {
            let factor = own["emissiveFactor"][i].as_f64().unwrap();
            assert!((factor - expected["emissiveFactor"][i].as_f64().unwrap()).abs() < 1e-7);
        }
    }
}

#[test]
fn area_lights_become_meshes_when_they_are_edited() {
    let folder = tempfile::tempdir().unwrap();
    let mut built = Built::new();
    let lights = json!([{"type": "rect", "size": 2, "rect": {"aspect": 0.5}, "intensity": 3}]);
    built.json["extensions"] = json!({"EXT_lights_area": {"lights": lights}});
    built.json["nodes"][0]["extensions"] = json!({"EXT_lights_area": {"light": 0}});
    let (original, source) = built.write(&folder);
    let light = original
        .polygon_lights
        .iter()
        .position(|light| light.area() > 1.5);
    let mut edited = original.clone();
    let new = take_out(&mut edited, light.unwrap());
    let material = edited.meshes[new].material;
    edited.materials[material].emissive = Vec3::new(0.5, 3.0, 2.0);
    relight(&mut edited, new);
    let (read, _) = saved(
        &folder,
        "area.glb",
        &source,
        &original,
        &edited,
        &Frames::new(),
    );
    assert_same_lights(&read, &edited);
    assert_same_pictures(&read, &edited);
    let (json, _) = parts(&folder.path().join("area.glb"));
    assert_eq!(json["nodes"][0], Built::new().json["nodes"][0]);
}

#[test]
fn the_opened_file_itself_can_be_saved_over() {
    let folder = tempfile::tempdir().unwrap();
    let (original, source) = Built::new().write(&folder);
    let mut edited = original.clone();
    take_out(&mut edited, 0);
    // Twice: the source is still the file as it was loaded.
    for _ in 0..2 {
        let (read, _) = saved(
            &folder,
            "built.gltf",
            &source,
            &original,
            &edited,
            &Frames::new(),
        );
        assert_same_lights(&read, &edited);
    }
    #[cfg(unix)]
    {
        let link = folder.path().join("link.gltf");
        std::os::unix::fs::symlink(folder.path().join("built.gltf"), &link).unwrap();
        source
            .save(&original, &original, &Frames::new(), &link)
            .unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(
            load(&folder.path().join("built.gltf"))
                .0
                .polygon_lights
                .len(),
            4
        );
    }
}

#[test]
fn materials_and_vertices_that_were_changed_come_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let (original, source) = Built::new().write(&folder);
    let mut edited = original.clone();
    let lamp = edited.meshes[0].material;
    edited.materials[lamp].perceptual_roughness = 0.25;
    edited.materials[lamp].clearcoat = 0.5;
    edited.materials[lamp].emissive = Vec3::new(0.5, 0.25, 0.125);
    let mesh = Arc::make_mut(&mut edited.meshes[1]);
    mesh.positions
        .iter_mut()
        .for_each(|p| *p += Vec3::new(0.0, 0.5, 0.0));
    edited.polygon_lights.clear();
    for mesh in 0..2 {
        let (lights, _) = edited.lights_of_mesh(mesh, &Limits::default());
        edited.polygon_lights.extend(lights);
    }
    let (read, _) = saved(
        &folder,
        "e.glb",
        &source,
        &original,
        &edited,
        &Frames::new(),
    );
    assert_same_lights(&read, &edited);
    assert_eq!(read.materials[lamp], edited.materials[lamp]);
    let (json, _) = parts(&folder.path().join("e.glb"));
    assert_eq!(json["materials"].as_array().unwrap().len(), 2);
    assert_eq!(
        json["materials"][0]["extensions"]["VENDOR_finish"],
        json!({"gloss": "satin"})
    );
    assert!(
        json["extensionsUsed"]
            .as_array()
            .unwrap()
            .contains(&json!("KHR_materials_clearcoat"))
    );
}

#[test]
fn pictures_in_floating_point_keep_their_range() {
    let folder = tempfile::tempdir().unwrap();
    let (original, source) = Built::new().write(&folder);
    let mut edited = original.clone();
    let texels: Vec<[f32; 3]> = (0..64)
        .map(|i| {
            [
                0.01 * i as f32,
                40.0 / (1 + i) as f32,
                (i as f32 * 0.3).sin().abs(),
            ]
        })
        .collect();
    let image = ImageFile::from_linear("bright", [8, 8], &texels).unwrap();
    edited
        .textures
        .push(image.texture(true, Sampler::default()));
    edited.materials.push(Material {
        emissive_texture: Some(TextureRef {
            texture: edited.textures.len() - 1,
            ..TextureRef::default()
        }),
        ..emissive("bright", Vec3::new(0.5, 2.0, 1.0))
    });
    let place = frame(DVec3::new(1.0, 1.0, 1.0));
    let mesh = square_frame("bright", edited.materials.len() - 1, &place);
    let index = add(&mut edited, mesh);
    let (read, _) = saved(
        &folder,
        "f.glb",
        &source,
        &original,
        &edited,
        &Frames::from([(index, place)]),
    );
    assert_same_pictures(&read, &edited);
    let (found, expected) = (read.polygon_lights.last(), edited.polygon_lights.last());
    let (found, expected) = (found.unwrap().radiance, expected.unwrap().radiance);
    println!("{found} {expected}");
    assert!(found.abs_diff_eq(expected, 1e-5 * expected.max_element()));
    let (json, _) = parts(&folder.path().join("f.glb"));
    let material = json["materials"].as_array().unwrap().last().unwrap();
    assert_eq!(
        material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"],
        80.0
    );
}

#[test]
fn bare_and_hostile_sources_are_saved_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let from = |json: &Value| {
        let text = json.to_string();
        let limits = Limits::default();
        Scene::from_slice_watched(text.as_bytes(), None, "bare", &limits, LoadWatch::none())
            .unwrap()
    };
    let asset = json!({"version": "2.0"});
    for bare in [
        json!({"asset": asset}),
        json!({"asset": asset, "scenes": []}),
        json!({"asset": asset, "scenes": [{"nodes": []}], "nodes": [{}]}),
        json!({"asset": asset, "buffers": [{"byteLength": 9}]}),
        json!({"asset": asset, "buffers": [{"byteLength": 9, "uri": "far.bin"}], "bufferViews": []}),
        json!({"asset": asset, "buffers": [{"byteLength": 3, "uri": "data:,abc"}]}),
    ] {
        let (original, source) = from(&bare);
        let mut edited = original.clone();
        edited.materials.push(emissive("one", Vec3::ONE));
        let mesh = square_frame("one", edited.materials.len() - 1, &DAffine3::IDENTITY);
        add(&mut edited, mesh);
        for name in ["g.glb", "g.gltf"] {
            let path = folder.path().join(name);
            source
                .save(&original, &edited, &Frames::new(), &path)
                .unwrap();
            let (read, _) = load(&path);
            assert_same_lights(&read, &edited);
        }
        // Nothing in it at all.
        source
            .save(
                &original,
                &original,
                &Frames::new(),
                &folder.path().join("h.glb"),
            )
            .unwrap();
        load(&folder.path().join("h.glb"));
    }

    let (original, source) = Built::new().write(&folder);
    let path = folder.path().join("never.glb");
    let refused = |edited: &Scene, text: &str| {
        let error = source
            .save(&original, edited, &Frames::new(), &path)
            .unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
        assert!(!path.exists());
    };
    let mut fewer = original.clone();
    fewer.meshes.pop();
    refused(&fewer, "removed ones must stay as empty ones");
    let with = |material: Material, mesh: &dyn Fn(&mut Mesh)| {
        let mut edited = original.clone();
        edited.materials.push(material);
        let index = edited.materials.len() - 1;
        let mut new = square_frame("new", index, &DAffine3::IDENTITY);
        mesh(&mut new);
        edited.meshes.push(Arc::new(new));
        edited
    };
    let plain = || emissive("plain", Vec3::ONE);
    refused(
        &with(plain(), &|m| m.positions[3].x = f32::NAN),
        "a vertex is not finite",
    );
    refused(
        &with(plain(), &|m| m.triangles[2][1] = 8),
        "none of its vertices",
    );
    refused(
        &with(plain(), &|m| m.normals.truncate(3)),
        "one value for each vertex",
    );
    refused(&with(plain(), &|m| m.material = 77), "has no material 77");
    refused(
        &with(emissive("x", Vec3::INFINITY), &|_| ()),
        "material \"x\": its radiance",
    );
    let texture = |texture, transform| Material {
        emissive_texture: Some(TextureRef {
            texture,
            texcoord: 0,
            transform,
        }),
        ..plain()
    };
    refused(
        &with(texture(9, TextureTransform::default()), &|_| ()),
        "has no texture 9",
    );
    let mut sheared = TextureTransform::default();
    sheared.texture_from_texcoord.y_axis.x = 0.5;
    refused(&with(texture(0, sheared), &|_| ()), "sheared");

    let save = |path: &Path| {
        source
            .save(&original, &original, &Frames::new(), path)
            .unwrap_err()
    };
    assert!(matches!(
        save(&folder.path().join("a.obj")),
        SaveError::Format { .. }
    ));
    assert!(matches!(
        save(&folder.path().join("no/a.glb")),
        SaveError::Io { .. }
    ));
    fs::create_dir(folder.path().join("d.glb")).unwrap();
    assert!(matches!(
        save(&folder.path().join("d.glb")),
        SaveError::Folder { .. }
    ));
    let left = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    assert!(
        left.into_iter()
            .all(|name| !name.to_string_lossy().starts_with(".lumigon"))
    );
}

#[test]
fn reading_is_followed_and_stopped() {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicBool, Ordering};
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/screens.glb");
    let seen = Mutex::new(Vec::new());
    let cancelled = AtomicBool::new(false);
    let note = |phase| seen.lock().unwrap().push(phase);
    let watch = LoadWatch {
        progress: &note,
        cancelled: &cancelled,
    };
    Scene::load_watched(path, &Limits::default(), watch).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(matches!(seen[0], LoadPhase::Reading { bytes } if bytes > 1000));
    assert!(matches!(seen[1], LoadPhase::Parsing { .. }));
    assert_eq!(seen.last(), Some(&LoadPhase::Keeping));
    assert!(
        seen.iter()
            .any(|p| matches!(p, LoadPhase::Image { number: 2, .. }))
    );
    assert!(
        seen.iter()
            .any(|p| matches!(p, LoadPhase::Lights { triangles: 1.. }))
    );

    let stop = |phase| {
        if matches!(phase, LoadPhase::Lights { .. }) {
            assert!(!cancelled.swap(true, Ordering::Relaxed), "it went on");
        }
    };
    let watch = LoadWatch {
        progress: &stop,
        cancelled: &cancelled,
    };
    let error = Scene::load_watched(path, &Limits::default(), watch).unwrap_err();
    assert!(error.to_string().contains("stopped"), "{error}");
}
