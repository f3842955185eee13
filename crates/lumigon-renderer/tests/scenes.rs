//! The committed scenes are what their script makes, and valid glTF.

#[path = "../../../scenes/make.rs"]
#[allow(dead_code, reason = "its main is for the command line")]
mod make;

use std::path::PathBuf;
use std::sync::LazyLock;

static SCENES: LazyLock<Vec<make::Scene>> = LazyLock::new(make::scenes);

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

#[test]
fn committed_scenes_are_what_the_script_makes() {
    for (name, bytes) in SCENES.iter() {
        let path = folder().join(name);
        let committed = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(
            committed == *bytes,
            "{name} differs from what scenes/make.rs makes: run its command again"
        );
    }
}

/// Every front triangle turns counter-clockwise about its stored normals, so emitters emit where they say.
#[test]
fn scenes_are_valid_and_consistently_oriented() {
    for (name, bytes) in SCENES.iter() {
        let gltf::Gltf { document, blob } =
            gltf::Gltf::from_slice(bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let blob = blob.expect(name);
        for image in document.images() {
            let gltf::image::Source::View { view, .. } = image.source() else {
                panic!("{name}: an image outside the file")
            };
            let png = &blob[view.offset()..view.offset() + view.length()];
            image::load_from_memory(png).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
        assert_eq!(document.cameras().count(), 1, "{name}");
        let mut emitters = 0;
        for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
            let reader = primitive.reader(|_| Some(&blob));
            let vectors = |list: Vec<[f32; 3]>| -> Vec<glam::Vec3> {
                list.into_iter().map(glam::Vec3::from).collect()
            };
            let positions = vectors(reader.read_positions().expect(name).collect());
            let normals = vectors(reader.read_normals().expect(name).collect());
            let indices: Vec<u32> = reader.read_indices().expect(name).into_u32().collect();
            assert_eq!(positions.len(), normals.len(), "{name}");
            for triangle in indices.as_chunks::<3>().0 {
                let [a, b, c] = triangle.map(|k| positions[k as usize]);
                let cross = (b - a).cross(c - a);
                for k in triangle {
                    let cosine = cross.normalize().dot(normals[*k as usize]);
                    assert!(cosine > 0.5, "{name}: {triangle:?} has cosine {cosine}");
                }
            }
            if primitive.material().emissive_factor() != [0.0; 3] {
                emitters += 1;
            }
        }
        assert!(emitters > 0, "{name}");
    }
}
