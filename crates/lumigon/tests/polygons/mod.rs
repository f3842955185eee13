//! Random polygons of every awkward kind, and places from which to look at them.

#![allow(dead_code, reason = "every test file uses its own part")]

use std::f64::consts::TAU;

use lumigon::{PolygonLight, Sides, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub(crate) type Vector = Vec3<f64>;

/// Seeded random numbers.
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    pub(crate) fn range(&mut self, least: f64, greatest: f64) -> f64 {
        least + (greatest - least) * self.0.random::<f64>()
    }

    /// Uniform in the logarithm.
    pub(crate) fn log_range(&mut self, least: f64, greatest: f64) -> f64 {
        self.range(least.ln(), greatest.ln()).exp()
    }

    pub(crate) fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// Uniform on the unit sphere.
    pub(crate) fn direction(&mut self) -> Vector {
        let z = self.range(-1.0, 1.0);
        let (s, c) = self.range(0.0, TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    }

    /// Uniform on the hemisphere about `normal`.
    pub(crate) fn direction_above(&mut self, normal: Vector) -> Vector {
        let d = self.direction();
        if d.dot(normal) < 0.0 { -d } else { d }
    }

    /// One of the six axes.
    pub(crate) fn axis(&mut self) -> Vector {
        let mut axis = [0.0; 3];
        axis[self.index(3)] = if self.chance(0.5) { 1.0 } else { -1.0 };
        axis.into()
    }
}

/// Outlines in the plane, within about one unit of the origin: outer loops counter-clockwise.
pub(crate) type Outlines = Vec<Vec<[f64; 2]>>;

/// Number of [`outlines`]' kinds.
pub(crate) const KINDS: usize = 10;

/// The kind that has hardly any width.
pub(crate) const SLIVER: usize = 6;

/// A random simple polygon of the given kind.
pub(crate) fn outlines(kind: usize, random: &mut Random) -> Outlines {
    match kind {
        0 => vec![around(3, 0.3, 1.0, random)],
        1 => vec![around(4, 0.7, 1.0, random)],
        // Concave stars.
        2 => {
            let points = 3 + random.index(10);
            vec![star(points, random.range(0.1, 0.7))]
        }
        3 => {
            let count = 8 + random.index(30);
            vec![around(count, 0.15, 1.0, random)]
        }
        // Combs: many crossings of one horizon.
        4 => vec![comb(2 + random.index(7), random.range(0.2, 0.8))],
        // Holes.
        5 => {
            let count = 5 + random.index(6);
            let mut loops = vec![around(count, 0.75, 1.0, random)];
            for [x, y] in [[-0.2, 0.1], [0.25, 0.2], [0.05, -0.25]] {
                let count = 3 + random.index(4);
                let mut hole = around(count, 0.06, 0.15, random);
                hole.iter_mut().for_each(|v| *v = [v[0] + x, v[1] + y]);
                hole.reverse();
                loops.push(hole);
            }
            loops
        }
        SLIVER => {
            let width = random.log_range(1e-6, 1e-1);
            vec![vec![
                [-1.0, 0.0],
                [1.0, random.range(0.0, width)],
                [random.range(-0.9, 0.9), width],
            ]]
        }
        // Collinear vertices.
        7 => {
            let mut outline = Vec::new();
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            for i in 0..4 {
                let (a, b): ([f64; 2], [f64; 2]) = (corners[i], corners[(i + 1) % 4]);
                for t in [0.0, 0.25, 0.5, 0.875] {
                    outline.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
                }
            }
            vec![outline]
        }
        // Repeated vertices.
        8 => {
            let mut outline = around(3, 0.5, 1.0, random);
            for _ in 0..3 {
                let i = random.index(outline.len());
                outline.insert(i, outline[i]);
            }
            vec![outline]
        }
        // Two islands.
        _ => {
            let mut loops = vec![around(5, 0.2, 0.4, random), around(4, 0.2, 0.4, random)];
            loops[0].iter_mut().for_each(|v| v[0] += 0.5);
            loops[1].iter_mut().for_each(|v| v[0] -= 0.5);
            loops
        }
    }
}

/// Vertices at random radii, seen from the origin at rising angles less than half a turn apart.
fn around(count: usize, least: f64, greatest: f64, random: &mut Random) -> Vec<[f64; 2]> {
    let turn = random.range(0.0, TAU);
    (0..count)
        .map(|i| {
            let jitter = random.range(-0.2, 0.2);
            let angle = turn + (i as f64 + jitter) / count as f64 * TAU;
            let radius = random.range(least, greatest);
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect()
}

fn star(points: usize, inner: f64) -> Vec<[f64; 2]> {
    (0..2 * points)
        .map(|i| {
            let radius = if i % 2 == 0 { 1.0 } else { inner };
            let angle = i as f64 / points as f64 * std::f64::consts::PI;
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect()
}

fn comb(teeth: usize, depth: f64) -> Vec<[f64; 2]> {
    let mut outline = vec![[-1.0, -0.5], [1.0, -0.5]];
    let width = 2.0 / (2 * teeth - 1) as f64;
    for i in (0..teeth).rev() {
        let left = -1.0 + 2.0 * i as f64 * width;
        outline.push([left + width, 0.5]);
        outline.push([left, 0.5]);
        if i > 0 {
            outline.push([left, 0.5 - depth]);
            outline.push([left - width, 0.5 - depth]);
        }
    }
    outline
}

/// A polygon somewhere in space.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub(crate) kind: usize,
    pub(crate) loops: Vec<Vec<[f64; 3]>>,
    /// The outlines' origin, and unit axes of their plane with its normal, towards the front.
    pub(crate) origin: Vector,
    pub(crate) axes: [Vector; 3],
    /// Scale: about the radius.
    pub(crate) size: f64,
}

impl Placed {
    pub(crate) fn new(
        kind: usize,
        outlines: &Outlines,
        origin: Vector,
        normal: Vector,
        size: f64,
    ) -> Self {
        let (x, y) = normal.orthonormal_basis();
        let axes = [x, y, normal];
        let mut placed = Self {
            kind,
            loops: Vec::new(),
            origin,
            axes,
            size,
        };
        placed.loops = outlines
            .iter()
            .map(|outline| {
                let place = |&[x, y]: &[f64; 2]| placed.at(x, y, 0.0).into();
                outline.iter().map(place).collect()
            })
            .collect();
        placed
    }

    /// Of the given kind, unit size, near the world's origin, turned anyhow.
    pub(crate) fn random(kind: usize, random: &mut Random) -> Self {
        let shape = outlines(kind, random);
        let origin = random.direction() * random.range(0.0, 2.0);
        let normal = random.direction();
        Self::new(kind, &shape, origin, normal, 1.0)
    }

    /// The point with coordinates (x, y) in the plane and `height` over its front, in sizes.
    pub(crate) fn at(&self, x: f64, y: f64, height: f64) -> Vector {
        let [u, v, n] = self.axes;
        self.origin + (u * x + v * y + n * height) * self.size
    }

    pub(crate) fn light(&self, sides: Sides) -> PolygonLight<f64> {
        PolygonLight::new(&self.loops, sides)
            .unwrap_or_else(|fault| panic!("{fault}: {:?}", self.loops))
    }

    pub(crate) fn vertices(&self) -> Vec<Vector> {
        self.loops.iter().flatten().map(|&v| v.into()).collect()
    }

    /// Start and end of every edge.
    pub(crate) fn edges(&self) -> Vec<(Vector, Vector)> {
        let of_loop = |vertices: &Vec<[f64; 3]>| {
            let count = vertices.len();
            let edge = |i: usize| (vertices[i].into(), vertices[(i + 1) % count].into());
            (0..count).map(edge).collect::<Vec<_>>()
        };
        self.loops.iter().flat_map(of_loop).collect()
    }

    /// Loops relative to a point.
    pub(crate) fn loops_from(&self, point: Vector) -> Vec<Vec<Vector>> {
        let relative =
            |vertices: &Vec<[f64; 3]>| vertices.iter().map(|&v| Vec3::from(v) - point).collect();
        self.loops.iter().map(relative).collect()
    }

    /// Distance of a point from the nearest edge, in sizes.
    pub(crate) fn distance_to_edges(&self, point: Vector) -> f64 {
        let distance = |(a, b): (Vector, Vector)| {
            let (along, to) = (b - a, point - a);
            let t = (to.dot(along) / along.dot(along).max(1e-300)).clamp(0.0, 1.0);
            (to - along * t).length()
        };
        self.edges()
            .into_iter()
            .map(distance)
            .fold(f64::INFINITY, f64::min)
            / self.size
    }
}

pub(crate) fn array(v: Vector) -> [f64; 3] {
    v.into()
}

/// Form factor of loops by Lambert's edge sum about z, clockwise seen from the origin positive.
pub(crate) fn edge_sum(loops: &[Vec<Vector>]) -> f64 {
    let mut sum = 0.0;
    for vertices in loops {
        for i in 0..vertices.len() {
            let (a, b) = (vertices[i], vertices[(i + 1) % vertices.len()]);
            let cross = a.cross(b);
            let length = cross.length();
            if length > 0.0 {
                sum -= cross.z / length * length.atan2(a.dot(b));
            }
        }
    }
    sum / TAU
}

/// A unit normal: any, an axis, or one whose horizon touches a vertex or holds an edge, or whose
/// zenith is on an edge or in the light.
pub(crate) fn hostile_normal(placed: &Placed, point: Vector, random: &mut Random) -> Vector {
    let edges = placed.edges();
    let (a, b) = edges[random.index(edges.len())];
    // In sizes, so that products of offsets neither vanish nor overflow.
    let scaled = |v: Vector| (v - point) * (1.0 / placed.size);
    let (a, b) = (scaled(a), scaled(b));
    let across = |v: Vector, random: &mut Random| {
        let (s, t) = v.normalize_or_zero().orthonormal_basis();
        let (sin, cos) = random.range(0.0, TAU).sin_cos();
        s * sin + t * cos
    };
    let normal = match random.index(8) {
        0 => random.axis(),
        1 => across(a, random),
        2 => a.cross(b),
        3 => a + (b - a) * random.range(0.0, 1.0),
        4 => placed.axes[2],
        5 => -placed.axes[2],
        6 => across(placed.axes[2], random),
        _ => random.direction(),
    };
    let unit = normal.normalize_or_zero();
    if (unit.length() - 1.0).abs() < 1e-12 {
        unit
    } else {
        random.axis()
    }
}
