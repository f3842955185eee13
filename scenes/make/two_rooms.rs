//! `two-rooms.glb`: light that comes through a doorway.
//!
//! The light hangs on the far side of the wall between the rooms and faces away from it, so nothing in
//! the near room, where the camera is, can see it: every bit of light there has been reflected first, by
//! surfaces most of which the camera cannot see. Everything is diffuse. Metres, y up; walls face inwards only.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::{facing, looking};
use glam::DVec3;

const HEIGHT: f64 = 2.6;
/// The wall between the rooms: from the near room's side to the far one's.
const NEAR: f64 = 0.0;
const FAR: f64 = -0.2;
/// The doorway.
const DOOR: [f64; 2] = [-0.9, 0.8];
const LINTEL: f64 = 2.15;

/// A room's walls.
struct Room {
    x: [f64; 2],
    z: [f64; 2],
}

const NEAR_ROOM: Room = Room {
    x: [-1.6, 1.7],
    z: [NEAR, 2.9],
};
const FAR_ROOM: Room = Room {
    x: [-2.2, 2.4],
    z: [-3.4, FAR],
};

fn object(glb: &mut Glb, name: &str, mesh: &Mesh, material: usize) {
    let geometry = glb.geometry(mesh);
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(Node::new(name).mesh(mesh));
}

/// A wall with the doorway as seen from the room it faces, where `x` runs to the right: one outline with a notch.
fn wall_with_door(x: [f64; 2], door: [f64; 2]) -> Outline {
    Outline {
        loops: vec![vec![
            [x[0], 0.0],
            [door[0], 0.0],
            [door[0], LINTEL],
            [door[1], LINTEL],
            [door[1], 0.0],
            [x[1], 0.0],
            [x[1], HEIGHT],
            [x[0], HEIGHT],
        ]],
    }
}

/// The six sides of a room but the one with the doorway, from the floor on: ceiling, left, right, and its far end
/// towards `end`.
fn sides(glb: &mut Glb, name: &str, room: &Room, end: f64, materials: [usize; 5]) {
    let ([x0, x1], [z0, z1]) = (room.x, room.z);
    let (width, depth) = (x1 - x0, z1 - z0);
    let up = [0.0, HEIGHT, 0.0];
    // What faces -z runs to the left.
    let (corner, along) = if end > 0.0 {
        ([x1, 0.0, z1], [-width, 0.0, 0.0])
    } else {
        ([x0, 0.0, z0], [width, 0.0, 0.0])
    };
    let quads = [
        (
            "floor",
            [x0, 0.0, z1],
            [width, 0.0, 0.0],
            [0.0, 0.0, -depth],
        ),
        (
            "ceiling",
            [x0, HEIGHT, z0],
            [width, 0.0, 0.0],
            [0.0, 0.0, depth],
        ),
        ("left wall", [x0, 0.0, z1], [0.0, 0.0, -depth], up),
        ("right wall", [x1, 0.0, z0], [0.0, 0.0, depth], up),
        ("end wall", corner, along, up),
    ];
    for ((side, corner, u, v), material) in quads.into_iter().zip(materials) {
        let name = format!("{name}, {side}");
        object(glb, &name, &Mesh::quad(corner, u, v), material);
    }
}

/// The wall between the rooms, and the inside of its doorway.
fn partition(glb: &mut Glb, white: usize, threshold: usize) {
    let mirrored = |[a, b]: [f64; 2]| [-b, -a];
    for (name, outline, towards, z) in [
        (
            "partition, near side",
            wall_with_door(NEAR_ROOM.x, DOOR),
            DVec3::Z,
            NEAR,
        ),
        (
            "partition, far side",
            wall_with_door(mirrored(FAR_ROOM.x), mirrored(DOOR)),
            DVec3::NEG_Z,
            FAR,
        ),
    ] {
        let geometry = glb.geometry(&Mesh::polygon(&outline));
        let mesh = glb.mesh(name, &geometry, white);
        let node = Node::new(name).mesh(mesh).translation([0.0, 0.0, z]);
        glb.root(node.rotation(facing(towards)));
    }
    let thickness = NEAR - FAR;
    let [left, right] = DOOR;
    let width = right - left;
    for (name, corner, u, v, material) in [
        (
            "threshold",
            [left, 0.0, NEAR],
            [width, 0.0, 0.0],
            [0.0, 0.0, -thickness],
            threshold,
        ),
        (
            "lintel",
            [left, LINTEL, FAR],
            [width, 0.0, 0.0],
            [0.0, 0.0, thickness],
            white,
        ),
        (
            "left jamb",
            [left, 0.0, NEAR],
            [0.0, 0.0, -thickness],
            [0.0, LINTEL, 0.0],
            white,
        ),
        (
            "right jamb",
            [right, 0.0, FAR],
            [0.0, 0.0, thickness],
            [0.0, LINTEL, 0.0],
            white,
        ),
    ] {
        object(glb, name, &Mesh::quad(corner, u, v), material);
    }
}

pub(crate) fn two_rooms() -> Vec<u8> {
    let mut glb = Glb::new();
    let [white, grey, oak, red, teal, yellow] = [
        ("white", [0.8, 0.79, 0.77]),
        ("stone", [0.6, 0.58, 0.55]),
        ("oak", [0.45, 0.28, 0.14]),
        ("red", [0.62, 0.05, 0.04]),
        ("teal", [0.03, 0.38, 0.42]),
        ("yellow", [0.8, 0.55, 0.08]),
    ]
    .map(|(name, colour)| glb.matte(name, colour));
    sides(
        &mut glb,
        "near room",
        &NEAR_ROOM,
        1.0,
        [grey, white, white, white, white],
    );
    sides(
        &mut glb,
        "far room",
        &FAR_ROOM,
        -1.0,
        [oak, white, yellow, teal, white],
    );
    partition(&mut glb, white, grey);

    // Beside the doorway, off the wall so that no surface coincides with it.
    let light = glb.emitter("light", [34.0, 30.0, 25.0], false);
    let frame = Outline::round_frame(1.2, 1.9, 0.4, 0.28);
    let geometry = glb.geometry(&Mesh::polygon(&frame));
    let mesh = glb.mesh("light", &geometry, light);
    glb.root(
        Node::new("light")
            .mesh(mesh)
            .translation([1.6, 1.35, FAR - 0.004])
            .rotation(facing(DVec3::NEG_Z)),
    );

    for (name, low, high, material) in [
        ("red chest", [0.0, 0.0, -3.1], [0.9, 0.7, -2.5], red),
        ("pedestal", [1.15, 0.0, 0.3], [1.5, 0.85, 0.65], white),
        ("bench", [1.25, 0.0, 1.25], [1.65, 0.45, 2.5], oak),
        ("step", [-0.15, 0.0, 0.95], [0.25, 0.35, 1.35], teal),
    ] {
        object(&mut glb, name, &Mesh::standing(low, high), material);
    }
    let geometry = glb.geometry(&Mesh::sphere(40, 20));
    for (name, material, place, radius) in [
        ("ball", white, [1.325, 1.052, 0.475], 0.2),
        ("ball on the floor", yellow, [0.55, 0.262, 1.5], 0.26),
    ] {
        let mesh = glb.mesh(name, &geometry, material);
        glb.root(
            Node::new(name)
                .mesh(mesh)
                .translation(place)
                .scale([radius; 3]),
        );
    }

    let camera = glb.camera(1.6, 64_f64.to_radians());
    let eye = DVec3::new(-1.4, 1.55, 2.7);
    glb.root(
        Node::new("corner")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(0.75, 0.9, 0.5))),
    );
    glb.finish()
}
