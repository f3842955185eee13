//! `screens.glb`: a wall of twelve screens, each with a picture of its own, over a polished floor.
//!
//! Gradients, test cards, chequers, text, noise like photographs, stars of one texel: what is hard for
//! a light that shows a picture. Metres, y up; the screens hang at z = -3.

use std::f64::consts::TAU;

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::rotation::looking;
use super::texture::{Slabs, cell_value, cloud, picture, smoothstep};
use glam::DVec3;
use serde_json::json;

const WIDTH: f64 = 1.28;
const HEIGHT: f64 = 0.72;
const GAP: f64 = 0.1;
const WALL: f64 = -3.0;

/// A fully saturated colour of a hue in turns.
fn hue(turns: f64) -> [f64; 3] {
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|shift| {
        let wave = 0.5 + 0.5 * libm::cos(TAU * (turns - shift));
        wave * wave
    })
}

fn mixed(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] * (1.0 - t) + b[k] * t)
}

fn spectrum(u: f64, v: f64) -> [f64; 3] {
    mixed(hue(u), [v; 3], 0.25 + 0.5 * (v - 0.5).abs())
}

fn test_card(u: f64, v: f64) -> [f64; 3] {
    let bar = ((u * 7.0) as u32).min(6);
    if v > 0.78 {
        return [f64::from((u * 8.0) as u32) / 7.0; 3];
    }
    // White, yellow, cyan, green, magenta, red, blue.
    [
        [1, 1, 1],
        [1, 1, 0],
        [0, 1, 1],
        [0, 1, 0],
        [1, 0, 1],
        [1, 0, 0],
        [0, 0, 1],
    ][bar as usize]
        .map(|c| 0.75 * f64::from(c))
}

fn chequers(u: f64, v: f64) -> [f64; 3] {
    let is_light = ((u * 16.0) as u32 + (v * 9.0) as u32).is_multiple_of(2);
    if is_light {
        [0.95, 0.9, 0.8]
    } else {
        [0.01, 0.02, 0.05]
    }
}

fn text(u: f64, v: f64) -> [f64; 3] {
    let line = (v * 13.0) as u32;
    let within = v * 13.0 - f64::from(line);
    let end = 0.92 - 0.4 * cell_value(3, line, 0) * cell_value(4, line, 1).round();
    let word = (u * 26.0) as u32;
    let is_ink = (0.25..0.7).contains(&within)
        && (0.07..end).contains(&u)
        && cell_value(5, word, line) > 0.22
        && !line.is_multiple_of(13);
    if is_ink {
        [0.02, 0.03, 0.05]
    } else {
        [0.8, 0.82, 0.85]
    }
}

fn mountains(u: f64, v: f64) -> [f64; 3] {
    let ridge = |seed: u64, level: f64, height: f64| level - height * cloud(seed, 3, 5, u, 0.37);
    let sky = mixed([0.12, 0.3, 0.8], [0.9, 0.65, 0.4], v * 1.6);
    let clouds = smoothstep(0.05, 0.6, cloud(40, 4, 5, u, v));
    let mut seen = mixed(sky, [1.0, 0.95, 0.9], clouds);
    for (seed, level, height, colour) in [
        (50, 0.55, 0.35, [0.2, 0.22, 0.32]),
        (60, 0.7, 0.3, [0.06, 0.1, 0.1]),
        (70, 0.85, 0.2, [0.015, 0.035, 0.01]),
    ] {
        let grain = 1.0 + 0.8 * cloud(seed + 7, 16, 3, u, v);
        let is_there = smoothstep(0.0, 0.006, v - ridge(seed, level, height));
        seen = mixed(seen, colour.map(|c| c * grain), is_there);
    }
    seen
}

fn rings(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = ((u - 0.5) * 16.0 / 9.0, v - 0.5);
    [0.5 + 0.5 * libm::cos(60.0 * (x * x + y * y)); 3]
}

fn plasma(u: f64, v: f64) -> [f64; 3] {
    let wave = 1.4 * cloud(80, 3, 4, u, v);
    hue(wave + 0.3 * u).map(|c| 0.9 * c)
}

fn scope(u: f64, v: f64) -> [f64; 3] {
    let wave = 0.5
        + 0.28 * libm::sin(TAU * 2.0 * u) * libm::cos(TAU * 0.7 * u)
        + 0.1 * cloud(85, 12, 2, u, 0.5);
    let beam = 1.0 - smoothstep(0.008, 0.03, (v - wave).abs());
    let grid = |x: f64, n: f64| {
        let x = x * n;
        1.0 - smoothstep(0.0, 0.08, (x - x.round()).abs())
    };
    let lines = 0.06 * grid(u, 10.0).max(grid(v, 6.0));
    [
        0.1 * beam,
        0.01 + lines + 0.95 * beam,
        0.02 + lines + 0.25 * beam,
    ]
}

fn sunset(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = ((u - 0.5) * 16.0 / 9.0, v - 0.55);
    let sun = 1.0 - smoothstep(0.14, 0.15, libm::hypot(x, y));
    if v > 0.62 {
        let glitter =
            smoothstep(-0.1, 0.4, cloud(95, 5, 3, 0.3 * u, 6.0 * v)) * (1.0 - 1.6 * x.abs());
        return mixed([0.03, 0.01, 0.05], [1.0, 0.35, 0.08], glitter.max(0.0));
    }
    mixed(
        mixed([0.1, 0.02, 0.2], [0.95, 0.2, 0.03], v * 1.6),
        [1.0, 0.8, 0.3],
        sun,
    )
}

fn stars(u: f64, v: f64) -> [f64; 3] {
    let [x, y] = [(u * 96.0) as u32, (v * 54.0) as u32];
    let star = cell_value(99, x, y);
    let night = 0.015 + 0.05 * smoothstep(0.0, 0.7, cloud(97, 3, 4, u, v));
    if star > 0.985 {
        return [1.0, 0.95, 0.85];
    }
    [0.35 * night, 0.5 * night, 1.5 * night]
}

fn wheel(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = ((u - 0.5) * 16.0 / 9.0, v - 0.5);
    let radius = libm::hypot(x, y) / 0.45;
    let colour = mixed([0.9; 3], hue(libm::atan2(y, x) / TAU), radius.min(1.0));
    mixed(colour, [0.02; 3], smoothstep(0.98, 1.0, radius))
}

fn stripes(u: f64, v: f64) -> [f64; 3] {
    let band = (u * 16.0 / 9.0 + v) * 7.0;
    let colours = [
        [0.95, 0.05, 0.12],
        [1.0, 0.6, 0.02],
        [0.02, 0.5, 0.75],
        [0.9, 0.9, 0.85],
    ];
    colours[band as usize % 4]
}

type Picture = fn(f64, f64) -> [f64; 3];

const PICTURES: [(&str, Picture); 12] = [
    ("mountains", mountains),
    ("test card", test_card),
    ("plasma", plasma),
    ("text", text),
    ("stars", stars),
    ("spectrum", spectrum),
    ("sunset", sunset),
    ("chequers", chequers),
    ("stripes", stripes),
    ("scope", scope),
    ("wheel", wheel),
    ("rings", rings),
];

fn object(glb: &mut Glb, name: &str, mesh: &Mesh, material: usize) {
    let geometry = glb.geometry(mesh);
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(Node::new(name).mesh(mesh));
}

pub(crate) fn screens() -> Vec<u8> {
    let mut glb = Glb::new();
    let slabs = Slabs { count: 4 };
    let colours = glb.texture("slabs, reflectance", &slabs.colours([0.16, 0.16, 0.17]));
    let polish = glb.texture("slabs, polish", &slabs.polish(0.06, 0.2));
    let base_colour_texture = glb.tiled(colours, [3.0, 3.0]);
    let polish_texture = glb.tiled(polish, [3.0, 3.0]);
    let floor = glb.material(
        "polished slabs",
        json!({ "pbrMetallicRoughness": {
            "baseColorTexture": base_colour_texture,
            "metallicRoughnessTexture": polish_texture,
        }}),
    );
    let quad = Mesh::quad([-6.0, 0.0, 6.0], [12.0, 0.0, 0.0], [0.0, 0.0, -12.0]);
    object(&mut glb, "floor", &quad, floor);
    let paint = glb.surface("paint", [0.55, 0.55, 0.57], 0.0, 0.45);
    let wall = WALL - 0.06;
    for (name, corner, u) in [
        ("back wall", [-3.1, 0.0, wall], [6.2, 0.0, 0.0]),
        ("left wall", [-3.1, 0.0, 6.0], [0.0, 0.0, wall - 6.0]),
        ("right wall", [3.1, 0.0, wall], [0.0, 0.0, 6.0 - wall]),
    ] {
        object(
            &mut glb,
            name,
            &Mesh::quad(corner, u, [0.0, 3.6, 0.0]),
            paint,
        );
    }

    let geometry = glb.geometry(&Mesh::quad([0.0; 3], [WIDTH, 0.0, 0.0], [0.0, HEIGHT, 0.0]));
    let left = -2.0 * WIDTH - 1.5 * GAP;
    for (k, (name, colour)) in (0_u32..).zip(PICTURES) {
        let png = picture(192, 108, colour);
        let material = glb.picture_emitter(name, &png, 4.0, false);
        let mesh = glb.mesh(name, &geometry, material);
        let (column, row) = (f64::from(k % 4), f64::from(k / 4));
        let x = left + column * (WIDTH + GAP);
        let y = 0.55 + (2.0 - row) * (HEIGHT + GAP);
        glb.root(Node::new(name).mesh(mesh).translation([x, y, WALL]));
    }

    let geometry = glb.geometry(&Mesh::sphere(96, 48));
    for (name, colour, metallic, perceptual_roughness, place) in [
        ("steel", [0.75, 0.74, 0.72], 1.0, 0.08, [-2.3, 0.42, -1.75]),
        ("bronze", [0.9, 0.62, 0.35], 1.0, 0.3, [-2.45, 0.42, -0.6]),
        ("chalk", [0.8, 0.8, 0.78], 0.0, 0.9, [-2.5, 0.42, 0.55]),
    ] {
        let material = glb.surface(name, colour, metallic, perceptual_roughness);
        let mesh = glb.mesh(name, &geometry, material);
        glb.root(
            Node::new(name)
                .mesh(mesh)
                .translation(place)
                .scale([0.42; 3]),
        );
    }

    let camera = glb.camera(1.6, 52_f64.to_radians());
    let eye = DVec3::new(2.5, 1.45, 2.6);
    glb.root(
        Node::new("hero")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(-1.05, 1.0, -1.9))),
    );
    glb.finish()
}
