//! `gallery.glb`: an exhibition room lit by flat emissive shapes alone.
//!
//! A star, a ring with a hole and a letter hang before a wall of glazed bricks, a disk is sunk into the
//! polished floor like a setting sun, and two rows of spheres, metal behind and dielectric in front, go from
//! smooth on the left to rough on the right. Metres, y up; the back wall is at z = -4.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::{facing, looking, turn};
use super::texture::{Bricks, Slabs};
use glam::DVec3;
use serde_json::{Value, json};

const HALF_WIDTH: f64 = 5.2;
const HEIGHT: f64 = 5.0;
const BACK: f64 = -4.0;
const FRONT: f64 = 9.0;

fn object(glb: &mut Glb, name: &str, mesh: &Mesh, material: usize) {
    let geometry = glb.geometry(mesh);
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(Node::new(name).mesh(mesh));
}

fn room(glb: &mut Glb) {
    let length = FRONT - BACK;
    let width = 2.0 * HALF_WIDTH;

    let bricks = Bricks {
        columns: 8,
        rows: 16,
    };
    let colours = glb.texture("bricks, reflectance", &bricks.colours([0.48, 0.465, 0.45]));
    let normals = glb.texture("bricks, normals", &bricks.normals());
    // One texture spans 2.6 m: bricks of 0.32 m by 0.16 m.
    let scale = [width / 2.6, HEIGHT / 2.6];
    let mut normal_texture = glb.tiled(normals, scale);
    normal_texture["scale"] = json!(0.9);
    let base_colour_texture = glb.tiled(colours, scale);
    let wall = glb.material(
        "glazed bricks",
        json!({
            "pbrMetallicRoughness": {
                "baseColorTexture": base_colour_texture,
                "metallicFactor": 0.0,
                "roughnessFactor": 0.42,
            },
            "normalTexture": normal_texture,
        }),
    );
    object(
        glb,
        "brick wall",
        &Mesh::quad_with_tangents(
            [-HALF_WIDTH, 0.0, BACK],
            [width, 0.0, 0.0],
            [0.0, HEIGHT, 0.0],
        ),
        wall,
    );

    let slabs = Slabs { count: 4 };
    let colours = glb.texture("slabs, reflectance", &slabs.colours([0.11, 0.105, 0.11]));
    let polish = glb.texture("slabs, polish", &slabs.polish(0.10, 0.30));
    // Four slabs of 0.8 m to a texture.
    let scale = [width / 3.2, length / 3.2];
    let base_colour_texture = glb.tiled(colours, scale);
    let polish_texture = glb.tiled(polish, scale);
    let floor = glb.material(
        "polished slabs",
        json!({ "pbrMetallicRoughness": {
            "baseColorTexture": base_colour_texture,
            "metallicRoughnessTexture": polish_texture,
        }}),
    );
    object(
        glb,
        "floor",
        &Mesh::quad(
            [-HALF_WIDTH, 0.0, FRONT],
            [width, 0.0, 0.0],
            [0.0, 0.0, -length],
        ),
        floor,
    );

    let plaster = glb.surface("plaster", [0.5, 0.49, 0.5], 0.0, 0.8);
    for (name, corner, u, v) in [
        (
            "left wall",
            [-HALF_WIDTH, 0.0, FRONT],
            [0.0, 0.0, -length],
            [0.0, HEIGHT, 0.0],
        ),
        (
            "right wall",
            [HALF_WIDTH, 0.0, BACK],
            [0.0, 0.0, length],
            [0.0, HEIGHT, 0.0],
        ),
        (
            "ceiling",
            [-HALF_WIDTH, HEIGHT, BACK],
            [width, 0.0, 0.0],
            [0.0, 0.0, length],
        ),
    ] {
        object(glb, name, &Mesh::quad(corner, u, v), plaster);
    }
}

/// A light of this outline.
fn light(
    glb: &mut Glb,
    name: &str,
    outline: &Outline,
    radiance: [f64; 3],
    double_sided: bool,
    place: fn(Node) -> Node,
) {
    let material = glb.emitter(name, radiance, double_sided);
    let geometry = glb.geometry(&Mesh::polygon(outline));
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(place(Node::new(name).mesh(mesh)));
}

fn lights(glb: &mut Glb) {
    light(
        glb,
        "star",
        &Outline::star(5, 0.85, 0.38),
        [4.8, 2.4, 0.5],
        true,
        |node| {
            node.translation([-1.75, 2.85, BACK + 0.3])
                .rotation(turn(DVec3::Z, 9.0))
        },
    );
    light(
        glb,
        "letter",
        &Outline::letter_r(),
        [4.6, 0.38, 1.8],
        true,
        |node| {
            node.translation([1.15, 1.85, BACK + 0.3])
                .scale([1.7, 1.7, 1.0])
        },
    );
    light(
        glb,
        "ring",
        &Outline::ring(1.15, 0.9, 64),
        [0.16, 2.5, 2.9],
        true,
        |node| {
            node.translation([3.75, 1.17, -2.3])
                .rotation(facing(DVec3::new(-0.75, 0.0, 1.0)))
        },
    );
    light(
        glb,
        "sun",
        &Outline::disk(1.0, 64),
        [5.0, 1.2, 0.16],
        true,
        |node| {
            node.translation([-3.95, 0.15, -2.6])
                .rotation(facing(DVec3::new(0.35, 0.0, 1.0)))
        },
    );

    // The two panels are one mesh; the right one is its mirror image.
    let material = glb.emitter("panel", [1.7, 1.65, 1.6], false);
    let geometry = glb.geometry(&Mesh::polygon(&Outline::rectangle(1.0, 1.0)));
    let panel = glb.mesh("panel", &geometry, material);
    for (name, side) in [("left panel", 1.0), ("right panel", -1.0)] {
        let child = Node::new(&format!("{name}, placed"))
            .mesh(panel)
            .translation([-2.6, 4.4, 2.6])
            .rotation(facing(DVec3::new(0.2, -1.0, -0.2)))
            .scale([3.6, 2.4, 1.0]);
        glb.group(Node::new(name).scale([side, 1.0, 1.0]), vec![child]);
    }
    for (name, side, radiance) in [
        ("left side panel", 1.0, [3.4, 1.7, 0.75]),
        ("right side panel", -1.0, [0.75, 1.9, 2.9]),
    ] {
        let material = glb.emitter(name, radiance, false);
        let side_panel = glb.mesh(name, &geometry, material);
        let child = Node::new(&format!("{name}, placed"))
            .mesh(side_panel)
            .translation([-5.0, 2.0, 3.4])
            .rotation(facing(DVec3::new(1.0, 0.0, -0.1)))
            .scale([3.4, 3.2, 1.0]);
        glb.group(Node::new(name).scale([side, 1.0, 1.0]), vec![child]);
    }
    light(
        glb,
        "front panel",
        &Outline::rectangle(8.0, 3.0),
        [0.45, 0.45, 0.48],
        false,
        |node| {
            node.translation([0.0, 2.8, 8.8])
                .rotation(facing(DVec3::NEG_Z))
        },
    );
}

fn spheres(glb: &mut Glb) {
    const COUNT: u32 = 5;
    const RADIUS: f64 = 0.36;
    const SPACING: f64 = 0.92;
    let stone = glb.surface("plinth", [0.05, 0.05, 0.055], 0.0, 0.5);
    let half = SPACING * f64::from(COUNT) / 2.0;
    for (name, z, height) in [("upper step", -0.5, 0.55), ("lower step", 0.4, 0.14)] {
        object(
            glb,
            name,
            &Mesh::cuboid(
                [-half, 0.0, z - 0.45],
                [[2.0 * half, 0.0, 0.0], [0.0, height, 0.0], [0.0, 0.0, 0.9]],
            ),
            stone,
        );
    }
    let geometry: Value = glb.geometry(&Mesh::sphere(96, 48));
    for k in 0..COUNT {
        let perceptual_roughness = 0.1 + 0.9 * f64::from(k) / f64::from(COUNT - 1);
        let x = SPACING * (f64::from(k) - f64::from(COUNT - 1) / 2.0);
        for (kind, colour, metallic, y, z) in [
            ("metal", [1.0, 0.78, 0.45], 1.0, 0.55, -0.5),
            ("dielectric", [0.8, 0.78, 0.75], 0.0, 0.14, 0.4),
        ] {
            let name = format!("{kind} {k}");
            let material = glb.surface(&name, colour, metallic, perceptual_roughness);
            let mesh = glb.mesh(&name, &geometry, material);
            glb.root(
                Node::new(&name)
                    .mesh(mesh)
                    .translation([x, y + RADIUS, z])
                    .scale([RADIUS; 3]),
            );
        }
    }
}

pub(crate) fn gallery() -> Vec<u8> {
    let mut glb = Glb::new();
    room(&mut glb);
    lights(&mut glb);
    spheres(&mut glb);
    let camera = glb.camera(1.6, 38_f64.to_radians());
    let eye = DVec3::new(0.0, 1.9, 7.6);
    glb.root(
        Node::new("hero")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(0.0, 1.2, 0.0))),
    );
    glb.finish()
}
