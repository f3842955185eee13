//! `stained-glass.glb`: three lancet windows light a chapel.
//!
//! Each window is one polygon that shows a picture: panes in lead, colours as saturated as glass has
//! them. They fall on worn slabs, on the rough wall across and on two stone balls. Metres, y up; two
//! windows are in the left wall, one in the wall at z = -4.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::{facing, looking};
use super::texture::{Bricks, Slabs, cell_value, cloud, picture, smoothstep};
use glam::{DVec2, DVec3};
use serde_json::json;

const HALF_WIDTH: f64 = 2.1;
const HEIGHT: f64 = 4.6;
const BACK: f64 = -4.0;
const FRONT: f64 = 5.0;

const RUBY: [f64; 3] = [0.80, 0.012, 0.02];
const COBALT: [f64; 3] = [0.012, 0.07, 0.85];
const AZURE: [f64; 3] = [0.02, 0.30, 0.75];
const AMBER: [f64; 3] = [1.0, 0.50, 0.02];
const EMERALD: [f64; 3] = [0.015, 0.42, 0.07];
const VIOLET: [f64; 3] = [0.30, 0.02, 0.48];
const CREAM: [f64; 3] = [0.85, 0.76, 0.5];
const LEAD: [f64; 3] = [0.003; 3];

/// A window of glass: a lancet and what it shows.
struct Window {
    width: f64,
    springing: f64,
    /// Radius of the rosettes along its middle.
    rosette: f64,
    /// The panes between them, chosen at random.
    panes: [[f64; 3]; 4],
    seed: u64,
}

impl Window {
    fn height(&self) -> f64 {
        // The point of an equilateral arch.
        self.springing + self.width * libm::sqrt(0.75)
    }

    /// Metres from the frame, positive inside.
    fn inside(&self, p: DVec2) -> f64 {
        let half = self.width / 2.0;
        if p.y <= self.springing {
            return (half - p.x.abs()).min(p.y);
        }
        let to_centre = DVec2::new(p.x.abs() + half, p.y - self.springing);
        self.width - libm::hypot(to_centre.x, to_centre.y)
    }

    /// What is seen at a place, in metres from the middle of the foot.
    fn colour(&self, p: DVec2) -> [f64; 3] {
        const LINE: f64 = 0.011;
        const BORDER: f64 = 0.085;
        let inside = self.inside(p);
        let (pane, lead) = if inside < BORDER {
            // Small panes around the frame.
            let along = if p.y < BORDER { p.x + 7.0 } else { p.y };
            let (cell, edge) = cell(along, 0.16);
            let colours = [RUBY, AMBER, COBALT, AMBER];
            let k = cell.rem_euclid(4) as usize;
            (colours[k], edge.min(BORDER - inside).min(inside))
        } else {
            let (pane, lead) = self.field(p);
            (pane, lead.min(inside - BORDER))
        };
        let glass = smoothstep(LINE * 0.7, LINE, lead);
        // Blown glass is uneven.
        let shade = 0.8 + 0.5 * cloud(90 + self.seed, 9, 2, 0.23 * p.x + 0.5, 0.23 * p.y);
        [0, 1, 2].map(|k| LEAD[k] + glass * shade * pane[k])
    }

    /// A pane's colour and the metres to its lead.
    fn field(&self, p: DVec2) -> ([f64; 3], f64) {
        let r = self.rosette;
        let spacing = 2.35 * r;
        let first = 0.35 + r;
        let row = ((p.y - first) / spacing).round().max(0.0);
        let centre = DVec2::new(0.0, first + row * spacing);
        let fits = centre.y + r < self.height() - 1.25 * r;
        let from = p - centre;
        let radius = libm::hypot(from.x, from.y);
        if radius < r && fits {
            return self.rosette_pane(from / r, radius / r, row as u64);
        }
        // Diamonds of a lattice, turned by an eighth.
        let side = 0.19;
        let [a, b] = [p.x + 0.62 * p.y, p.x - 0.62 * p.y].map(|x| cell(x, side));
        let value = cell_value(self.seed, (a.0 + 500) as u32, (b.0 + 500) as u32);
        let pane = self.panes[((value * 4.0) as usize).min(3)];
        let lead = (0.85 * a.1.min(b.1)).min(if fits { radius - r } else { f64::INFINITY });
        (pane, lead)
    }

    /// A flower in a ring: places relative to its radius.
    fn rosette_pane(&self, from: DVec2, radius: f64, row: u64) -> ([f64; 3], f64) {
        const PETALS: f64 = 8.0;
        let turn = libm::atan2(from.y, from.x) / std::f64::consts::TAU * PETALS;
        let (petal, _) = cell(turn + 0.5, 1.0);
        // How far sideways from the petal's axis, as a part of its half width there.
        let off = (turn - turn.round()).abs() * 2.0;
        let width = radius * std::f64::consts::PI / PETALS * self.rosette;
        let odd = (petal + row as i64).rem_euclid(2) == 0;
        if radius < 0.2 {
            return (AMBER, (0.2 - radius) * self.rosette);
        }
        if radius > 0.84 {
            let edge = (1.0 - radius).min(radius - 0.84) * self.rosette;
            let side = (1.0 - off) * width;
            return (if odd { CREAM } else { EMERALD }, edge.min(side));
        }
        let bulge = libm::sin(std::f64::consts::PI * (radius - 0.2) / 0.64);
        let ring = (radius - 0.2).min(0.84 - radius) * self.rosette;
        let border = (off - 0.92 * bulge) * width;
        if border < 0.0 {
            let pane = if odd { RUBY } else { VIOLET };
            (pane, ring.min(-border))
        } else {
            (AZURE, ring.min(border).min((1.0 - off) * width + 0.01))
        }
    }
}

/// The cell of a length that holds `x`, and how far its nearer end is.
fn cell(x: f64, length: f64) -> (i64, f64) {
    let cell = (x / length).floor();
    let within = x - cell * length;
    (cell as i64, within.min(length - within))
}

/// A window whose foot's middle is at `foot`, seen from the side that `towards` points to.
fn window(glb: &mut Glb, name: &str, window: &Window, foot: [f64; 3], towards: DVec3) {
    let (width, height) = (window.width, window.height());
    let png = picture(256, 512, |u, v| {
        window.colour(DVec2::new((u - 0.5) * width, (1.0 - v) * height))
    });
    let material = glb.picture_emitter(name, &png, 6.0, false);
    let outline = Outline::lancet(width, window.springing);
    let mesh = Mesh::polygon_with_picture(&outline, [-width / 2.0, 0.0], [width / 2.0, height]);
    let geometry = glb.geometry(&mesh);
    let mesh = glb.mesh(name, &geometry, material);
    let node = Node::new(name).mesh(mesh).translation(foot);
    glb.root(node.rotation(facing(towards)));
}

fn object(glb: &mut Glb, name: &str, mesh: &Mesh, material: usize) {
    let geometry = glb.geometry(mesh);
    let mesh = glb.mesh(name, &geometry, material);
    glb.root(Node::new(name).mesh(mesh));
}

fn chapel(glb: &mut Glb) {
    let (width, length) = (2.0 * HALF_WIDTH, FRONT - BACK);
    let slabs = Slabs { count: 4 };
    let colours = glb.texture("slabs, reflectance", &slabs.colours([0.42, 0.4, 0.37]));
    let polish = glb.texture("slabs, polish", &slabs.polish(0.1, 0.34));
    let scale = [width / 3.6, length / 3.6];
    let base_colour_texture = glb.tiled(colours, scale);
    let polish_texture = glb.tiled(polish, scale);
    let floor = glb.material(
        "worn slabs",
        json!({ "pbrMetallicRoughness": {
            "baseColorTexture": base_colour_texture,
            "metallicRoughnessTexture": polish_texture,
        }}),
    );
    let quad = Mesh::quad(
        [-HALF_WIDTH, 0.0, FRONT],
        [width, 0.0, 0.0],
        [0.0, 0.0, -length],
    );
    object(glb, "floor", &quad, floor);

    let blocks = Bricks {
        columns: 4,
        rows: 8,
    };
    let colours = glb.texture("blocks, reflectance", &blocks.colours([0.75, 0.72, 0.66]));
    let mut wall = |name: &str, corner: [f64; 3], u: [f64; 3]| {
        let span = DVec3::from(u).length();
        let texture = glb.tiled(colours, [span / 2.8, HEIGHT / 2.8]);
        let material = glb.material(
            name,
            json!({ "pbrMetallicRoughness": {
                "baseColorTexture": texture,
                "metallicFactor": 0.0,
                "roughnessFactor": 0.85,
            }}),
        );
        object(
            glb,
            name,
            &Mesh::quad(corner, u, [0.0, HEIGHT, 0.0]),
            material,
        );
    };
    wall("window wall", [-HALF_WIDTH, 0.0, BACK], [width, 0.0, 0.0]);
    wall("left wall", [-HALF_WIDTH, 0.0, FRONT], [0.0, 0.0, -length]);
    wall("right wall", [HALF_WIDTH, 0.0, BACK], [0.0, 0.0, length]);

    let plinth = glb.surface("plinth", [0.4, 0.38, 0.35], 0.0, 0.6);
    let marble = glb.surface("marble", [0.78, 0.76, 0.72], 0.0, 0.3);
    let ball = glb.geometry(&Mesh::sphere(96, 48));
    for (name, x, z) in [("near", 1.2, -0.2), ("far", 0.95, -2.6)] {
        let half = 0.28;
        let edges = [
            [2.0 * half, 0.0, 0.0],
            [0.0, 0.7, 0.0],
            [0.0, 0.0, 2.0 * half],
        ];
        let block = Mesh::cuboid([x - half, 0.0, z - half], edges);
        object(glb, &format!("{name} plinth"), &block, plinth);
        let name = format!("{name} ball");
        let mesh = glb.mesh(&name, &ball, marble);
        let node = Node::new(&name).mesh(mesh);
        glb.root(node.translation([x, 0.98, z]).scale([half; 3]));
    }
}

pub(crate) fn stained_glass() -> Vec<u8> {
    let mut glb = Glb::new();
    chapel(&mut glb);
    let tall = |seed, panes| Window {
        width: 1.6,
        springing: 2.4,
        rosette: 0.46,
        panes,
        seed,
    };
    let left = -HALF_WIDTH + 0.02;
    let (blue, green) = (
        [COBALT, AZURE, COBALT, VIOLET],
        [EMERALD, AZURE, EMERALD, CREAM],
    );
    let warm = [AMBER, RUBY, AMBER, CREAM];
    for (name, panes, foot, towards) in [
        ("end window", blue, [-0.2, 0.35, BACK + 0.02], DVec3::Z),
        ("far window", green, [left, 0.35, -2.2], DVec3::X),
        ("near window", warm, [left, 0.35, 0.3], DVec3::X),
    ] {
        let seed = name.len() as u64;
        window(&mut glb, name, &tall(seed, panes), foot, towards);
    }
    let camera = glb.camera(1.6, 50_f64.to_radians());
    let eye = DVec3::new(0.75, 1.5, 4.3);
    glb.root(
        Node::new("hero")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::new(-0.1, 1.35, -2.0))),
    );
    glb.finish()
}
