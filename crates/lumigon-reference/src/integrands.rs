//! What is integrated over a light's directions.

use glam::{DVec2, DVec3};

use crate::cubature::CubatureError;
use crate::ggx::{ggx_distribution, ggx_visibility, schlick_weight};
use crate::quadrature::{Integrand, SMOOTH_ANGLE, edge_lengths};

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

/// The GGX lobe times the cosine at the light, in the shading frame.
pub(crate) struct GgxLobe {
    pub(crate) view: DVec3,
    alpha: f64,
}

impl GgxLobe {
    pub(crate) fn new(view: DVec3, alpha: f64) -> Result<Self, CubatureError> {
        match alpha > 0.0 && alpha <= 1.0 {
            true => Ok(Self { view, alpha }),
            false => Err(CubatureError::Alpha(alpha)),
        }
    }
}

impl Integrand<2> for GgxLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 2] {
        // Rounding may put a direction of the horizon just below it.
        let cos_theta = direction.z.max(0.0);
        let half_vector = direction + self.view;
        let value = ggx_distribution(half_vector, self.alpha)
            * ggx_visibility(cos_theta, self.view.z, self.alpha)
            * cos_theta;
        // |l + v| = 2 h.v for unit directions, without the cancellation of the dot product.
        [value, value * schlick_weight(0.5 * half_vector.length())]
    }

    /// D varies on the scale of sqrt(alpha^2 + slope^2) over slopes of the half vector, G2 on that of
    /// sqrt(alpha^2 + cos^2) over the cosine, and the half vector itself on that of |l + v| over directions.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let slopes = triangle.map(|l| {
            let half_vector = l + self.view;
            half_vector.truncate() / half_vector.z
        });
        let slope_scale = self.alpha.hypot(distance_to_origin(&slopes));
        let lowest = triangle.iter().fold(1.0, |m: f64, l| m.min(l.z));
        let cosine_scale = self.alpha.hypot(lowest);
        let angle_scale = triangle
            .iter()
            .fold(SMOOTH_ANGLE, |m: f64, l| m.min(l.distance(-self.view)));
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let angle = triangle[i].distance(triangle[j]) / angle_scale;
            let slope = slopes[i].distance(slopes[j]) / slope_scale;
            let cosine = (triangle[i].z - triangle[j].z).abs() / cosine_scale;
            (angle * angle + slope * slope + 0.5 * cosine * cosine).sqrt()
        })
    }
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
