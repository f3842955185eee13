//! `room.glb`: a living room that lives from light that its surfaces throw at each other.
//!
//! Its strong light is a ring below the ceiling that shines up alone: all below it sees its light only
//! from the ceiling and the upper walls. An arched window adds evening light, a reading lamp a pool on
//! the sofa. Red rug and sofa, blue cupboard and green boxes stand next to white walls. Everything is
//! diffuse but a vase. Metres, y up; walls face inwards only, 5 m from one to the other.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::{facing, looking};
use super::texture::{cell_value, cloud, picture, smoothstep};
use glam::DVec3;

/// Half the length of a wall.
const HALF: f64 = 2.5;
const HEIGHT: f64 = 2.8;

const WHITE: [f64; 3] = [0.78, 0.76, 0.72];
const RED: [f64; 3] = [0.56, 0.035, 0.03];
const BLUE: [f64; 3] = [0.03, 0.10, 0.45];
const GREEN: [f64; 3] = [0.06, 0.32, 0.08];
const OAK: [f64; 3] = [0.42, 0.25, 0.12];
const CHARCOAL: [f64; 3] = [0.06; 3];

fn object(glb: &mut Glb, name: &str, mesh: &Mesh, material: usize) {
    placed(glb, name, mesh, material, |node| node);
}

fn placed(
    glb: &mut Glb,
    name: &str,
    mesh: &Mesh,
    material: usize,
    place: impl FnOnce(Node) -> Node,
) {
    let geometry = glb.geometry(mesh);
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(place(Node::new(name).mesh(mesh)));
}

/// Reflectance of planks along u, eight across, two to a length; it repeats.
fn planks(u: f64, v: f64) -> [f64; 3] {
    const ROWS: f64 = 8.0;
    let row = (v * ROWS).floor();
    let across = v * ROWS - row;
    let along = 2.0 * u + cell_value(201, row as u32, 0);
    let plank = along.floor();
    let (row, end) = (row as u32, along - plank);
    let seam = (across.min(1.0 - across) / ROWS).min(end.min(1.0 - end) / 2.0);
    let shade = 0.75 + 0.5 * cell_value(202, row, plank as u32 % 2);
    let grain = 1.0 + 0.45 * cloud(210 + u64::from(row), 3, 3, u, 7.0 * v);
    let joint = 0.35 + 0.65 * smoothstep(0.0008, 0.003, seam);
    OAK.map(|c| (c * shade * grain * joint).clamp(0.0, 1.0))
}

/// A painting: a sun over a sea and dunes, in flat colours.
fn painting(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = ((u - 0.66) * 1.5, v - 0.36);
    let wave = 0.012 * libm::sin(40.0 * u + 9.0 * libm::sin(5.0 * u));
    let dune = 0.74 + 0.10 * libm::sin(5.0 * u + 0.4);
    if v > dune {
        [0.75, 0.45, 0.12]
    } else if v > 0.56 + wave {
        [0.02, 0.28, 0.38]
    } else if libm::hypot(x, y) < 0.17 {
        [0.85, 0.16, 0.04]
    } else if v > 0.42 {
        [0.88, 0.62, 0.35]
    } else {
        [0.88, 0.78, 0.58]
    }
}

fn shell(glb: &mut Glb) {
    let wood = glb.texture("planks", &picture(256, 256, planks));
    let reference = glb.tiled(wood, [2.0, 2.5]);
    let floor = glb.matte("planks", reference);
    let white = glb.matte("white", WHITE);
    let side = 2.0 * HALF;
    for (name, corner, u, v, material) in [
        (
            "floor",
            [-HALF, 0.0, HALF],
            [side, 0.0, 0.0],
            [0.0, 0.0, -side],
            floor,
        ),
        (
            "ceiling",
            [-HALF, HEIGHT, -HALF],
            [side, 0.0, 0.0],
            [0.0, 0.0, side],
            white,
        ),
        (
            "back wall",
            [-HALF, 0.0, -HALF],
            [side, 0.0, 0.0],
            [0.0, HEIGHT, 0.0],
            white,
        ),
        (
            "front wall",
            [HALF, 0.0, HALF],
            [-side, 0.0, 0.0],
            [0.0, HEIGHT, 0.0],
            white,
        ),
        (
            "window wall",
            [-HALF, 0.0, HALF],
            [0.0, 0.0, -side],
            [0.0, HEIGHT, 0.0],
            white,
        ),
        (
            "right wall",
            [HALF, 0.0, -HALF],
            [0.0, 0.0, side],
            [0.0, HEIGHT, 0.0],
            white,
        ),
    ] {
        object(glb, name, &Mesh::quad(corner, u, v), material);
    }
}

/// A ring that hangs from three wires and shines up from a tray with a white underside.
fn ring_lamp(glb: &mut Glb) {
    const UP: f64 = 2.12;
    const TRAY: f64 = 2.07;
    let centre = [-0.3, -0.3];
    let ring = Outline::ring(0.85, 0.5, 48).moved([centre[0], -centre[1]]);
    let light = glb.emitter("ring", [11.5, 9.6, 7.2], false);
    let enamel = glb.matte("enamel", [0.8; 3]);
    let surface = Mesh::polygon(&ring);
    placed(glb, "ring", &surface, light, |node| {
        node.translation([0.0, UP, 0.0]).rotation(facing(DVec3::Y))
    });
    // Turned over, y runs the other way.
    let below = Outline::ring(0.85, 0.5, 48).moved(centre);
    placed(
        glb,
        "ring, underside",
        &Mesh::polygon(&below),
        enamel,
        |node| {
            node.translation([0.0, TRAY, 0.0])
                .rotation(facing(DVec3::NEG_Y))
        },
    );
    object(glb, "ring, rim", &Mesh::rim(&ring, TRAY, UP), enamel);
    let wires = glb.matte("wire", CHARCOAL);
    for [dx, dz] in [[0.0, -0.86], [-0.74, 0.43], [0.74, 0.43]] {
        let [x, z] = [centre[0] + dx, centre[1] + dz];
        let wire = Outline::rectangle(0.008, 0.008).moved([x, -z]);
        object(glb, "wire", &Mesh::rim(&wire, TRAY, HEIGHT), wires);
    }
}

fn window(glb: &mut Glb) {
    const SILL: f64 = 0.8;
    let light = glb.emitter("window", [1.3, 1.7, 2.5], false);
    let arch = Mesh::polygon(&Outline::lancet(1.0, 0.85));
    // Off the wall, so that no surface coincides with it.
    placed(glb, "window", &arch, light, |node| {
        node.translation([-HALF + 0.004, SILL, 0.35])
            .rotation(facing(DVec3::X))
    });
    let white = glb.matte("sill", [0.8; 3]);
    let sill = Mesh::cuboid(
        [-HALF + 0.002, SILL - 0.05, -0.25],
        [[0.16, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 1.2]],
    );
    object(glb, "sill", &sill, white);
}

fn sofa(glb: &mut Glb) {
    let red = glb.matte("sofa", RED);
    for (name, low, high) in [
        ("sofa, seat", [-1.0, 0.0, -2.2], [1.0, 0.42, -1.45]),
        ("sofa, back", [-1.0, 0.0, -2.4], [1.0, 0.86, -2.2]),
        ("sofa, left arm", [-1.2, 0.0, -2.4], [-1.0, 0.6, -1.45]),
        ("sofa, right arm", [1.0, 0.0, -2.4], [1.2, 0.6, -1.45]),
    ] {
        object(glb, name, &Mesh::standing(low, high), red);
    }
    let cushion = glb.matte("cushion", [0.75, 0.5, 0.1]);
    let mesh = Mesh::standing([0.5, 0.42, -2.19], [0.9, 0.78, -2.04]);
    object(glb, "cushion", &mesh, cushion);
}

/// A lamp beside the sofa whose square shade lets light out below alone.
fn reading_lamp(glb: &mut Glb) {
    let (low, high) = ([0.72, 1.22, -2.0], [1.12, 1.5, -1.6]);
    let shade = glb.matte("shade", [0.7, 0.62, 0.48]);
    object(glb, "lamp, shade", &Mesh::standing(low, high), shade);
    let light = glb.emitter("lamp", [21.0, 16.5, 10.0], false);
    let below = Mesh::quad(low, [0.4, 0.0, 0.0], [0.0, 0.0, 0.4]);
    object(glb, "lamp", &below, light);
    let dark = glb.matte("stand", CHARCOAL);
    let stand = Mesh::standing([1.27, 0.0, -1.82], [1.3, 1.38, -1.79]);
    object(glb, "lamp, stand", &stand, dark);
    let arm = Mesh::cuboid(
        [1.12, 1.35, -1.82],
        [[0.15, 0.0, 0.0], [0.0, 0.03, 0.0], [0.0, 0.0, 0.03]],
    );
    object(glb, "lamp, arm", &arm, dark);
    let foot = Mesh::standing([1.22, 0.0, -1.92], [1.46, 0.025, -1.68]);
    object(glb, "lamp, foot", &foot, dark);
}

fn furniture(glb: &mut Glb) {
    let [red, blue, green, white, oak] = [
        ("rug", RED),
        ("blue", BLUE),
        ("green", GREEN),
        ("white lacquer", WHITE),
        ("oak", OAK),
    ]
    .map(|(name, colour)| glb.matte(name, colour));
    for (name, low, high, material) in [
        ("rug", [-1.5, 0.0, -1.1], [0.9, 0.012, 0.7], red),
        ("cupboard", [-2.45, 0.0, -2.45], [-1.55, 2.0, -1.95], blue),
        ("white box", [-1.35, 0.012, 0.2], [-0.95, 0.38, 0.6], white),
        ("green box", [1.75, 0.0, -2.4], [2.4, 0.62, -1.75], green),
        ("box on top", [1.85, 0.62, -2.3], [2.25, 0.95, -1.9], white),
    ] {
        object(glb, name, &Mesh::standing(low, high), material);
    }
    // Doors, a finger off the cupboard's front.
    for (name, x) in [("left door", -2.44), ("right door", -1.99)] {
        let door = Mesh::cuboid(
            [x, 0.06, -1.95],
            [[0.43, 0.0, 0.0], [0.0, 1.9, 0.0], [0.0, 0.0, 0.02]],
        );
        object(glb, name, &door, blue);
    }

    let (low, high) = ([-0.85, 0.4, -0.55], [0.25, 0.44, 0.15]);
    let edges = [0, 1, 2].map(|k| high[k] - low[k]);
    let top = Mesh::cuboid(
        low,
        [
            [edges[0], 0.0, 0.0],
            [0.0, edges[1], 0.0],
            [0.0, 0.0, edges[2]],
        ],
    );
    object(glb, "table", &top, oak);
    for x in [low[0] + 0.03, high[0] - 0.08] {
        for z in [low[2] + 0.03, high[2] - 0.08] {
            let leg = Outline::rectangle(0.05, 0.05).moved([x + 0.025, -z - 0.025]);
            object(glb, "table leg", &Mesh::rim(&leg, 0.012, 0.4), oak);
        }
    }
    let cream = glb.matte("cream", [0.8, 0.77, 0.7]);
    let vase = glb.surface("vase", [0.02, 0.22, 0.2], 0.0, 0.35);
    let geometry = glb.geometry(&Mesh::sphere(40, 20));
    for (name, material, place, scale) in [
        ("ball", cream, [0.62, 0.262, -0.35], [0.25; 3]),
        ("vase", vase, [-0.55, 0.62, -0.25], [0.12, 0.18, 0.12]),
    ] {
        let mesh = glb.mesh(name, &geometry, material);
        glb.root(Node::new(name).mesh(mesh).translation(place).scale(scale));
    }
    let books = [
        ("book", [0.5, 0.08, 0.06], 0.44, 0.0),
        ("book", [0.7, 0.66, 0.55], 0.47, 0.02),
        ("book", [0.05, 0.2, 0.3], 0.505, -0.015),
    ];
    for (name, colour, y, shift) in books {
        let material = glb.matte(name, colour);
        let mesh = Mesh::standing([-0.25 + shift, y, -0.3], [0.02 + shift, y + 0.03, 0.08]);
        object(glb, name, &mesh, material);
    }
}

fn picture_on_the_wall(glb: &mut Glb) {
    let dark = glb.matte("frame", CHARCOAL);
    let (x, y, z) = (-0.65, 1.35, -HALF + 0.002);
    let frame = Mesh::cuboid(
        [x, y, z],
        [[1.2, 0.0, 0.0], [0.0, 0.82, 0.0], [0.0, 0.0, 0.025]],
    );
    object(glb, "frame", &frame, dark);
    let texture = glb.texture("painting", &picture(192, 128, painting));
    let reference = glb.tiled(texture, [1.0, 1.0]);
    let canvas = glb.matte("painting", reference);
    let mesh = Mesh::quad(
        [x + 0.03, y + 0.03, z + 0.03],
        [1.14, 0.0, 0.0],
        [0.0, 0.76, 0.0],
    );
    object(glb, "painting", &mesh, canvas);
}

pub(crate) fn room() -> Vec<u8> {
    let mut glb = Glb::new();
    shell(&mut glb);
    ring_lamp(&mut glb);
    window(&mut glb);
    sofa(&mut glb);
    reading_lamp(&mut glb);
    furniture(&mut glb);
    picture_on_the_wall(&mut glb);
    let camera = glb.camera(1.6, 56_f64.to_radians());
    let eye = DVec3::new(2.3, 1.6, 2.35);
    glb.root(
        Node::new("corner")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(-0.75, 1.0, -1.3))),
    );
    glb.finish()
}
