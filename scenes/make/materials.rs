//! `materials.glb`: every lobe of glTF's material extensions under three polygon lights.
//!
//! Behind: lacquered car paint, a brushed metal disc, velvet. In front: rough clay, plastic with a
//! coloured reflection, and all layers at once. Metres, y up.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::{facing, looking, turn};
use super::texture::Paint;
use glam::DVec3;
use serde_json::{Value, json};

const RADIUS: f64 = 0.5;
const SPACING: f64 = 1.3;
const STEP: f64 = 0.85;

/// A metallic-roughness material with extensions, which are listed as used.
fn layered(
    glb: &mut Glb,
    name: &str,
    [r, g, b]: [f64; 3],
    [metallic, perceptual_roughness]: [f64; 2],
    extensions: &[(&'static str, Value)],
) -> Value {
    for (extension, _) in extensions {
        glb.require(extension);
    }
    let extensions: serde_json::Map<String, Value> = extensions
        .iter()
        .map(|(extension, value)| ((*extension).to_owned(), value.clone()))
        .collect();
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0],
            "metallicFactor": metallic,
            "roughnessFactor": perceptual_roughness,
        },
        "extensions": extensions,
    })
}

/// The materials' fields, from the left, behind and then in front.
fn surfaces(glb: &mut Glb) -> [Value; 6] {
    let flakes = glb.texture("flakes", &Paint::flakes(0.35));
    let waves = glb.texture("waves", &Paint::waves(5.0));
    let flake_texture = glb.tiled(flakes, [6.0, 3.0]);
    let wave_texture = glb.tiled(waves, [4.0, 2.0]);
    let mut paint = layered(
        glb,
        "car paint",
        [0.55, 0.02, 0.03],
        [1.0, 0.5],
        &[(
            "KHR_materials_clearcoat",
            json!({
                "clearcoatFactor": 1.0,
                "clearcoatRoughnessFactor": 0.1,
                "clearcoatNormalTexture": wave_texture,
            }),
        )],
    );
    paint["normalTexture"] = flake_texture;
    // Grooves run around the disc, so reflections stretch outwards: a quarter turn from the tangent.
    let brushed = layered(
        glb,
        "brushed metal",
        [0.9, 0.85, 0.75],
        [1.0, 0.25],
        &[(
            "KHR_materials_anisotropy",
            json!({
                "anisotropyStrength": 0.8,
                "anisotropyRotation": std::f64::consts::FRAC_PI_2,
            }),
        )],
    );
    let velvet = layered(
        glb,
        "velvet",
        [0.12, 0.01, 0.05],
        [0.0, 0.9],
        &[(
            "KHR_materials_sheen",
            json!({ "sheenColorFactor": [0.9, 0.35, 0.6], "sheenRoughnessFactor": 0.5 }),
        )],
    );
    let clay = layered(
        glb,
        "clay",
        [0.62, 0.33, 0.22],
        [0.0, 0.8],
        &[
            (
                "KHR_materials_diffuse_roughness",
                json!({ "diffuseRoughnessFactor": 1.0 }),
            ),
            ("KHR_materials_specular", json!({ "specularFactor": 0.4 })),
        ],
    );
    let plastic = layered(
        glb,
        "plastic",
        [0.03, 0.12, 0.35],
        [0.0, 0.3],
        &[
            ("KHR_materials_ior", json!({ "ior": 1.9 })),
            (
                "KHR_materials_specular",
                json!({ "specularColorFactor": [0.4, 1.0, 0.7] }),
            ),
        ],
    );
    let all = layered(
        glb,
        "all layers",
        [0.7, 0.5, 0.15],
        [0.5, 0.4],
        &[
            (
                "KHR_materials_anisotropy",
                json!({ "anisotropyStrength": 0.6, "anisotropyRotation": 0.6 }),
            ),
            (
                "KHR_materials_sheen",
                json!({ "sheenColorFactor": [0.1, 0.3, 0.5], "sheenRoughnessFactor": 0.6 }),
            ),
            (
                "KHR_materials_clearcoat",
                json!({ "clearcoatFactor": 0.8, "clearcoatRoughnessFactor": 0.2 }),
            ),
            ("KHR_materials_ior", json!({ "ior": 1.7 })),
            (
                "KHR_materials_diffuse_roughness",
                json!({ "diffuseRoughnessFactor": 0.6 }),
            ),
        ],
    );
    [paint, brushed, velvet, clay, plastic, all]
}

fn stage(glb: &mut Glb) {
    let grey = glb.surface("stage", [0.18, 0.18, 0.19], 0.0, 0.55);
    let pieces = [
        (
            "floor",
            Mesh::quad([-6.0, 0.0, 6.0], [12.0, 0.0, 0.0], [0.0, 0.0, -9.0]),
        ),
        (
            "wall",
            Mesh::quad([-6.0, 0.0, -3.0], [12.0, 0.0, 0.0], [0.0, 7.0, 0.0]),
        ),
        (
            "step",
            Mesh::cuboid(
                [-2.1, 0.0, -1.3],
                [[4.2, 0.0, 0.0], [0.0, STEP, 0.0], [0.0, 0.0, 1.2]],
            ),
        ),
    ];
    for (name, mesh) in &pieces {
        let geometry = glb.geometry(mesh);
        let mesh = glb.mesh(name, &geometry, grey);
        glb.root(Node::new(name).mesh(mesh));
    }
}

fn lights(glb: &mut Glb) {
    for (name, outline, radiance, position, direction) in [
        (
            "softbox",
            Outline::rectangle(3.2, 1.6),
            [5.5, 5.3, 5.0],
            [0.6, 4.2, 1.8],
            [-0.1, -1.0, -0.5],
        ),
        (
            "star",
            Outline::star(5, 1.0, 0.45),
            [14.0, 7.5, 2.5],
            [-3.6, 2.0, 1.6],
            [1.0, -0.2, -0.45],
        ),
        (
            "ring",
            Outline::ring(0.9, 0.55, 48),
            [2.5, 6.5, 11.0],
            [3.6, 2.2, 0.8],
            [-1.0, -0.3, -0.2],
        ),
    ] {
        let material = glb.emitter(name, radiance, false);
        let geometry = glb.geometry(&Mesh::polygon(&outline));
        let mesh = glb.mesh(name, &geometry, material);
        glb.root(
            Node::new(name)
                .mesh(mesh)
                .translation(position)
                .rotation(facing(direction.into())),
        );
    }
}

pub(crate) fn materials() -> Vec<u8> {
    let mut glb = Glb::new();
    stage(&mut glb);
    lights(&mut glb);
    let sphere = glb.geometry(&Mesh::sphere_with_tangents(72, 36));
    let disc = glb.geometry(&Mesh::brushed_disc(96));
    for (k, fields) in surfaces(&mut glb).into_iter().enumerate() {
        let name = fields["name"].as_str().unwrap_or_default().to_owned();
        let material = glb.material(&name, fields);
        let (column, behind) = (k % 3, k < 3);
        let (ground, z) = if behind { (STEP, -0.7) } else { (0.0, 0.55) };
        let x = SPACING * (column as f64 - 1.0);
        let is_disc = name == "brushed metal";
        let mesh = glb.mesh(&name, if is_disc { &disc } else { &sphere }, material);
        let rotation = if is_disc {
            facing(DVec3::new(0.0, 0.1, 1.0))
        } else {
            turn(DVec3::Y, 20.0)
        };
        glb.root(
            Node::new(&name)
                .mesh(mesh)
                .translation([x, ground + RADIUS, z])
                .rotation(rotation)
                .scale([RADIUS; 3]),
        );
    }
    let camera = glb.camera(1.6, 30_f64.to_radians());
    let eye = DVec3::new(0.0, 2.3, 6.2);
    glb.root(
        Node::new("camera")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(0.0, 0.72, 0.0))),
    );
    glb.finish()
}
