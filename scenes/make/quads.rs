//! `quads-N.glb`: one surface that fills the picture, lit by N quads, to time the cost of a light.
//!
//! The comparison is of a screen of 1440 x 900 pixels covered by one lit surface. The camera hangs below
//! the lights and looks straight down, so no light hides the surface; every fifth light stands at the border
//! outside the picture, cuts the surface's horizon and faces inwards.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::random::Random;
use super::rotation::{facing, looking, turn};
use glam::{DQuat, DVec3};

const EYE: f64 = 2.0;
const HALF_WIDTH: f64 = 3.2;
const HALF_HEIGHT: f64 = 2.0;

/// Where a light stands and how it is turned.
struct Placement {
    position: DVec3,
    rotation: DQuat,
    size: [f64; 2],
}

impl Placement {
    fn corners(&self) -> [DVec3; 4] {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| {
            self.position + self.rotation * DVec3::new(x * self.size[0], y * self.size[1], 0.0)
        })
    }

    /// Does the light's front face every point of the picture?
    fn lights_the_picture(&self) -> bool {
        let normal = self.rotation * DVec3::Z;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .into_iter()
            .all(|(x, z)| {
                let point = DVec3::new(x * HALF_WIDTH, 0.0, z * HALF_HEIGHT);
                normal.dot(point - self.position) > 0.0
            })
    }

    /// Is the light wholly above the camera, or wholly beyond one side of its pyramid of view?
    fn leaves_the_view_free(&self) -> bool {
        let corners = self.corners();
        let beyond = |inside: fn(DVec3) -> f64| corners.iter().all(|&p| inside(p) < 0.0);
        beyond(|p| EYE - p.y)
            || beyond(|p| HALF_WIDTH * (1.0 - p.y / EYE) - p.x)
            || beyond(|p| HALF_WIDTH * (1.0 - p.y / EYE) + p.x)
            || beyond(|p| HALF_HEIGHT * (1.0 - p.y / EYE) - p.z)
            || beyond(|p| HALF_HEIGHT * (1.0 - p.y / EYE) + p.z)
    }

    /// Does the surface cut the light?
    fn crosses_the_horizon(&self) -> bool {
        let corners = self.corners();
        corners.iter().any(|p| p.y < 0.0) && corners.iter().any(|p| p.y > 0.0)
    }
}

/// Cell `k` of `count` over the visible rectangle, jittered, above the camera and facing down within 45 degrees.
fn above(k: u32, count: u32, random: &mut Random) -> Placement {
    let columns = libm::ceil(libm::sqrt(f64::from(count) * HALF_WIDTH / HALF_HEIGHT)) as u32;
    let rows = count.div_ceil(columns);
    let mut cell = |index: u32, of: u32, half: f64| {
        let jittered = f64::from(index) + 0.5 + random.range(-0.3, 0.3);
        1.1 * half * (2.0 * jittered / f64::from(of) - 1.0)
    };
    let x = cell(k % columns, columns, HALF_WIDTH);
    let z = cell(k / columns, rows, HALF_HEIGHT);
    let tilt = DVec3::new(random.range(-0.7, 0.7), -1.0, random.range(-0.7, 0.7));
    let size = [random.range(0.25, 0.7), random.range(0.25, 0.7)];
    Placement {
        position: DVec3::new(x, EYE + 0.45 + random.range(0.0, 0.5), z),
        rotation: facing(tilt) * turn(DVec3::Z, random.range(0.0, 90.0)),
        size,
    }
}

/// Light `k` of `count` around the picture, cutting the surface.
fn border(k: u32, count: u32, random: &mut Random) -> Placement {
    let angle = (f64::from(k) + random.range(0.3, 0.7)) / f64::from(count);
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * angle);
    // Out to a rectangle a quarter larger than the picture.
    let reach = 1.25 / sin.abs().max(cos.abs());
    let position = DVec3::new(
        reach * HALF_WIDTH * cos,
        random.range(-0.1, 0.2),
        reach * HALF_HEIGHT * sin,
    );
    // Square to the nearest side, or a corner of the picture would see the light's back.
    let inwards = if cos.abs() > sin.abs() {
        DVec3::new(-cos.signum(), 0.0, random.range(-0.1, 0.1))
    } else {
        DVec3::new(random.range(-0.1, 0.1), 0.0, -sin.signum())
    };
    let inwards = inwards + DVec3::Y * random.range(-0.2, 0.2);
    Placement {
        position,
        rotation: facing(inwards) * turn(DVec3::Z, random.range(-20.0, 20.0)),
        size: [random.range(0.5, 1.0), random.range(0.5, 0.9)],
    }
}

/// A pure hue in [0, 1) softened towards white.
fn tint(hue: f64) -> [f64; 3] {
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|offset| {
        let x = (hue + offset) % 1.0;
        0.25 + 0.75 * ((6.0 * x - 3.0).abs() - 1.0).clamp(0.0, 1.0)
    })
}

/// Light `k` of `count`, drawn until every pixel sees its front and it hides none.
fn placement(k: u32, count: u32, random: &mut Random) -> Placement {
    let cutting = count / 5;
    loop {
        let placement = if k < cutting {
            border(k, cutting, random)
        } else {
            above(k - cutting, count - cutting, random)
        };
        if placement.lights_the_picture()
            && placement.leaves_the_view_free()
            && placement.crosses_the_horizon() == (k < cutting)
        {
            return placement;
        }
    }
}

pub(crate) fn quads(count: u32) -> Vec<u8> {
    let mut glb = Glb::new();
    let mut random = Random(u64::from(count));
    let surface = glb.surface("surface", [0.7, 0.68, 0.65], 0.0, 0.5);
    let floor = glb.geometry(&Mesh::quad(
        [-20.0, 0.0, 20.0],
        [40.0, 0.0, 0.0],
        [0.0, 0.0, -40.0],
    ));
    let floor = glb.mesh("surface", &floor, surface);
    glb.root(Node::new("surface").mesh(floor));

    let square = glb.geometry(&Mesh::polygon(&Outline::rectangle(1.0, 1.0)));
    for k in 0..count {
        let Placement {
            position,
            rotation,
            size,
        } = placement(k, count, &mut random);
        // Total power stays about the same for every count.
        let strength = random.range(120.0, 240.0) / f64::from(count);
        let radiance = tint(random.unit()).map(|x| strength * x);
        let name = format!("light {k}");
        let material = glb.emitter(&name, radiance, false);
        let mesh = glb.mesh(&name, &square, material);
        glb.root(
            Node::new(&name)
                .mesh(mesh)
                .translation(position.to_array())
                .rotation(rotation)
                .scale([size[0], size[1], 1.0]),
        );
    }

    let camera = glb.camera(1.6, 2.0 * libm::atan(HALF_HEIGHT / EYE));
    let eye = DVec3::new(0.0, EYE, 0.0);
    glb.root(
        Node::new("camera")
            .camera(camera)
            .translation(eye.to_array())
            .rotation(looking(eye, DVec3::ZERO)),
    );
    glb.finish()
}
