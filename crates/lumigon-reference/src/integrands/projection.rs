//! Area projected on a plane as an integrand.

use glam::DVec3;

use super::EDGES;
use crate::quadrature::{Integrand, SMOOTH_ANGLE, edge_lengths};

/// The inverse cube of the cosine with an axis: what a steradian covers of a plane at a distance of 1.
pub(crate) struct ProjectedArea {
    pub(crate) axis: DVec3,
}

impl Integrand<1> for ProjectedArea {
    fn evaluate(&self, direction: DVec3) -> [f64; 1] {
        [self.axis.dot(direction).powi(-3)]
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let cosines = triangle.map(|l| self.axis.dot(l));
        let lowest = cosines.iter().fold(1.0, |m: f64, c| m.min(*c)).max(1e-9);
        let angles = edge_lengths(triangle);
        [0, 1, 2].map(|k| {
            let (i, j) = EDGES[k];
            (angles[k] / SMOOTH_ANGLE).hypot((cosines[i] - cosines[j]) / lowest)
        })
    }
}
