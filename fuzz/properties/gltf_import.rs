//! Whatever the bytes of a glTF file are, importing and rendering it returns.

use lumigon_renderer::{Camera, CpuRenderer, Limits, RenderSettings, Scene, Watch};

/// Small enough that an import which keeps to them takes milliseconds.
const LIMITS: Limits = Limits {
    file_bytes: 1 << 20,
    json_objects: 1 << 12,
    image_side: 256,
    image_bytes: 1 << 20,
    mesh_bytes: 1 << 20,
    node_depth: 64,
    light_image_bytes: 1 << 24,
    light_image_side: 1024,
};

/// Imports `bytes`; an error names the file, a scene keeps what its documentation promises and can
/// be rendered.
pub(super) fn gltf_import(bytes: &[u8]) {
    match Scene::from_slice_within(bytes, None, "fuzzed.glb", &LIMITS) {
        Ok(scene) => {
            keeps_its_promises(&scene);
            renders(&scene);
        }
        Err(error) => {
            assert_eq!(error.path, "fuzzed.glb");
            for part in [&error.place, &error.what, &error.mend] {
                assert!(!part.is_empty(), "{error:?}");
            }
        }
    }
}

fn keeps_its_promises(scene: &Scene) {
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.material < scene.materials.len());
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert_eq!(mesh.normals.len(), vertices);
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
        for optional in [
            mesh.tangents.len(),
            mesh.colors.len(),
            mesh.texcoords[0].len(),
            mesh.texcoords[1].len(),
        ] {
            assert!(optional == 0 || optional == vertices);
        }
        let mut corners = mesh.triangles.iter().flatten();
        assert!(corners.all(|&corner| (corner as usize) < vertices));
    }
    for material in &scene.materials {
        let textures = [
            &material.base_color_texture,
            &material.metallic_roughness_texture,
            &material.normal_texture,
            &material.occlusion_texture,
            &material.emissive_texture,
        ];
        for used in textures.into_iter().flatten() {
            assert!(used.texture < scene.textures.len() && used.texcoord < 2);
        }
        assert!(material.emissive.is_finite() && material.emissive.min_element() >= 0.0);
        for share in [material.metallic, material.perceptual_roughness] {
            assert!((0.0..=1.0).contains(&share));
        }
    }
    for light in &scene.polygon_lights {
        assert!(!light.loops.is_empty());
        assert!(light.loops.iter().all(|vertices| vertices.len() >= 3));
        let mut coordinates = light.loops.iter().flatten().flatten();
        assert!(coordinates.all(|coordinate| coordinate.is_finite()));
        assert!(light.radiance.is_finite() && light.radiance.min_element() >= 0.0);
    }
}

/// Renders a few pixels. Radiance beyond f32 may overflow, but nothing is dark below zero or NaN.
fn renders(scene: &Scene) {
    let renderer = CpuRenderer::new(scene);
    let settings = RenderSettings {
        width: 4,
        height: 3,
        samples: 1,
        ..RenderSettings::default()
    };
    let framing = Camera::framing(scene);
    for camera in scene.cameras.iter().take(2).chain([&framing]) {
        let picture = renderer
            .render(camera, &settings, Watch::none())
            .expect("the settings are in range");
        for (i, pixel) in picture.radiance().into_iter().enumerate() {
            assert!(
                pixel.into_iter().all(|channel| channel >= 0.0),
                "pixel {i}: {pixel:?}"
            );
        }
    }
}
