//! `neon.glb`: a sign of glowing letters before a wall of bricks, over wet ground.
//!
//! The letters are concave polygons, O and P with a hole, and share one picture across the word; the
//! frame around them is a tube with another. They light the wall behind and the ground before them.
//! Metres, y up; the wall is at z = 0.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::looking;
use super::texture::{Bricks, Slabs, picture};
use glam::DVec3;
use serde_json::json;

/// From the wall to the tubes.
const STAND_OFF: f64 = 0.14;
/// Height of the letters.
const LETTER: f64 = 0.8;
/// The sign's middle.
const MIDDLE: [f64; 2] = [0.0, 1.5];

fn object(glb: &mut Glb, name: &str, mesh: &Mesh, material: usize) {
    let geometry = glb.geometry(mesh);
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(Node::new(name).mesh(mesh));
}

/// From one colour of a list to the next as t goes from 0 to 1.
fn ramp(colours: &[[f64; 3]], t: f64) -> [f64; 3] {
    let x = t.clamp(0.0, 1.0) * (colours.len() - 1) as f64;
    let k = (x as usize).min(colours.len() - 2);
    let s = x - k as f64;
    [0, 1, 2].map(|c| colours[k][c] * (1.0 - s) + colours[k + 1][c] * s)
}

fn street(glb: &mut Glb) {
    let bricks = Bricks {
        columns: 8,
        rows: 16,
    };
    let colours = glb.texture("bricks, reflectance", &bricks.colours([0.5, 0.26, 0.19]));
    let normals = glb.texture("bricks, normals", &bricks.normals());
    let scale = [7.0 / 2.2, 3.6 / 2.2];
    let base_colour_texture = glb.tiled(colours, scale);
    let normal_texture = glb.tiled(normals, scale);
    let wall = glb.material(
        "bricks",
        json!({
            "pbrMetallicRoughness": {
                "baseColorTexture": base_colour_texture,
                "metallicFactor": 0.0,
                "roughnessFactor": 0.55,
            },
            "normalTexture": normal_texture,
        }),
    );
    let quad = Mesh::quad_with_tangents([-3.5, 0.0, 0.0], [7.0, 0.0, 0.0], [0.0, 3.6, 0.0]);
    object(glb, "wall", &quad, wall);

    let slabs = Slabs { count: 4 };
    let polish = glb.texture("ground, wetness", &slabs.polish(0.04, 0.3));
    let polish_texture = glb.tiled(polish, [7.0 / 3.0, 2.0]);
    let ground = glb.material(
        "wet ground",
        json!({ "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.1, 0.11, 1.0],
            "metallicRoughnessTexture": polish_texture,
        }}),
    );
    let quad = Mesh::quad([-3.5, 0.0, 6.0], [7.0, 0.0, 0.0], [0.0, 0.0, -6.0]);
    object(glb, "ground", &quad, ground);
}

fn sign(glb: &mut Glb) {
    const STROKE: f64 = 0.105;
    const SPACE: f64 = 0.2;
    let letters = [
        ("letter O", Outline::letter_o(0.74, STROKE), 0.74),
        ("letter P", Outline::letter_p(0.56, STROKE), 0.56),
        ("letter E", Outline::letter_e(0.52, STROKE), 0.52),
        ("letter N", Outline::letter_n(0.66, STROKE), 0.66),
    ];
    let width: f64 = letters.iter().map(|letter| letter.2).sum::<f64>() + 3.0 * SPACE;
    let colours = [
        [1.0, 0.02, 0.32],
        [1.0, 0.05, 0.05],
        [1.0, 0.38, 0.02],
        [0.95, 0.06, 0.75],
        [0.25, 0.12, 1.0],
    ];
    let png = picture(128, 32, |u, v| {
        // Towards the tubes' ends the gas glows weaker.
        let glow = 0.55 + 0.45 * libm::sin(std::f64::consts::PI * (0.12 + 0.76 * v));
        ramp(&colours, u).map(|c| c * glow)
    });
    let material = glb.picture_emitter("letters", &png, 8.0, true);
    let place = |node: Node, x: f64, y: f64, size: f64| {
        node.translation([MIDDLE[0] + x, MIDDLE[1] + y, STAND_OFF])
            .scale([size, size, 1.0])
    };
    let mut x = 0.0;
    for (name, outline, advance) in letters {
        let outline = outline.moved([x, 0.0]);
        // One picture across the word: each letter shows its part.
        let mesh = Mesh::polygon_with_picture(&outline, [0.0, 0.0], [width, 1.0]);
        let geometry = glb.geometry(&mesh);
        let mesh = glb.mesh(name, &geometry, material);
        let node = Node::new(name).mesh(mesh);
        glb.root(place(node, -0.5 * width * LETTER, -0.5 * LETTER, LETTER));
        x += advance + SPACE;
    }

    let (frame_width, frame_height) = (width * LETTER + 0.62, LETTER + 0.6);
    let colours = [[0.02, 0.9, 1.0], [0.03, 0.25, 1.0], [0.02, 1.0, 0.55]];
    let png = picture(64, 32, |u, v| ramp(&colours, 0.75 * u + 0.25 * v));
    let material = glb.picture_emitter("frame", &png, 4.5, true);
    let outline = Outline::round_frame(frame_width, frame_height, 0.34, 0.055);
    let half = [frame_width / 2.0, frame_height / 2.0];
    let mesh = Mesh::polygon_with_picture(&outline, half.map(|x| -x), half);
    let geometry = glb.geometry(&mesh);
    let mesh = glb.mesh("frame", &geometry, material);
    glb.root(place(Node::new("frame").mesh(mesh), 0.0, 0.0, 1.0));
}

pub(crate) fn neon() -> Vec<u8> {
    let mut glb = Glb::new();
    street(&mut glb);
    sign(&mut glb);
    let camera = glb.camera(1.6, 44_f64.to_radians());
    let eye = DVec3::new(-1.5, 0.85, 4.4);
    glb.root(
        Node::new("hero")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(0.1, 0.68, 0.0))),
    );
    glb.finish()
}
