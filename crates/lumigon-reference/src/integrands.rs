//! What is integrated over a light's directions.

mod charlie;
mod eon;
mod ggx;
mod ltc;
mod projection;

use glam::{DVec2, DVec3};

use crate::quadrature::{Integrand, SMOOTH_ANGLE, edge_lengths};

pub(crate) use charlie::CharlieLobe;
pub(crate) use eon::EonLobe;
pub(crate) use ggx::GgxLobe;
pub(crate) use ltc::LtcDensity;
pub(crate) use projection::ProjectedArea;

pub(crate) struct One;

impl Integrand<1> for One {
    fn evaluate(&self, _: DVec3) -> [f64; 1] {
        [1.0]
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        edge_lengths(triangle).map(|length| length / SMOOTH_ANGLE)
    }
}

pub(crate) struct Cosine;

impl Integrand<1> for Cosine {
    fn evaluate(&self, direction: DVec3) -> [f64; 1] {
        [direction.z]
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        One.edge_extents(triangle)
    }
}

pub(crate) struct Direction;

impl Integrand<3> for Direction {
    fn evaluate(&self, direction: DVec3) -> [f64; 3] {
        direction.into()
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        One.edge_extents(triangle)
    }
}

/// The edges of a triangle, in the order of the vertices they lie opposite of.
const EDGES: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Whether the spherical triangle may reach to both sides of the circle of this cosine.
fn straddles(triangle: &[DVec3; 3], cosine: f64) -> bool {
    let length2 = edge_lengths(triangle).map(|l| l * l);
    let length2 = length2.iter().fold(0.0, |m: f64, l| m.max(*l));
    // Arcs rise above their ends.
    let highest = triangle.iter().fold(0.0, |m: f64, l| m.max(l.z)) * (1.0 + 0.25 * length2);
    lowest(triangle) < cosine && highest > cosine
}

/// How far the cosine changes along an arc, by way of its middle.
fn rise(a: DVec3, b: DVec3) -> f64 {
    let middle = (a + b).normalize_or(a);
    (a.z - middle.z).abs() + (middle.z - b.z).abs()
}

fn lowest(triangle: &[DVec3; 3]) -> f64 {
    triangle.iter().fold(1.0, |m: f64, l| m.min(l.z))
}

/// Angle over which half vectors vary smoothly: they turn ever faster towards l = -v.
fn angle_scale(triangle: &[DVec3; 3], view: DVec3) -> f64 {
    triangle
        .iter()
        .fold(SMOOTH_ANGLE, |m: f64, l| m.min(l.distance(-view)))
}

fn is_alpha(alpha: f64) -> bool {
    alpha > 0.0 && alpha <= 1.0
}

/// Distance of a plane triangle from the origin, zero inside.
fn distance_to_origin(triangle: &[DVec2; 3]) -> f64 {
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (triangle[i], triangle[j]));
    // Sines of the angles the edges span. A sliver in line with the origin has only rounding here, of any sign; it is
    // the distance to its edges that tells.
    let turns = edges.map(|(a, b)| a.perp_dot(b) / (a.length() * b.length()));
    if turns.iter().all(|t| *t > 1e-12) || turns.iter().all(|t| *t < -1e-12) {
        return 0.0;
    }
    let to_edge = |(a, b): (DVec2, DVec2)| {
        let along = b - a;
        let t = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        // A NaN from an edge without length loses to the other edges' distances.
        (a + t * along).length()
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}
