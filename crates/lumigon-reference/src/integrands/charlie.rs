//! The Charlie sheen lobe as an integrand.

use glam::DVec3;

use super::{EDGES, angle_scale, distance_to_origin, is_alpha, lowest, rise, straddles};
use crate::charlie::{charlie_distribution, charlie_visibility_cosine};
use crate::cubature::CubatureError;
use crate::quadrature::Integrand;

/// The Charlie lobe times the cosine at the light, in the shading frame.
pub(crate) struct CharlieLobe {
    pub(crate) view: DVec3,
    alpha: f64,
}

impl CharlieLobe {
    pub(crate) fn new(view: DVec3, alpha: f64) -> Result<Self, CubatureError> {
        match is_alpha(alpha) {
            true => Ok(Self { view, alpha }),
            false => Err(CubatureError::Alpha(alpha)),
        }
    }
}

impl Integrand<1> for CharlieLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 1] {
        let half_vector = direction + self.view;
        [charlie_distribution(half_vector, self.alpha)
            * charlie_visibility_cosine(direction.z.max(0.0), self.view.z, self.alpha)]
    }

    /// D is about exp(-c^2 / 2 alpha) of the half vector's cosine c. Lambda is a function of powers of about 1/5 of the
    /// cosine and of 1 - cosine, singular at the horizon and at the zenith: layers and rings of constant ratios, down
    /// to where little is left, make it smooth. It has a step in its second derivative at the cosine 1/2.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let cosines = triangle.map(|l| {
            let half_vector = l + self.view;
            half_vector.z / half_vector.length()
        });
        let least = cosines.iter().fold(1.0, |m: f64, c| m.min(*c));
        let half_scale = least.hypot(2.0 * self.alpha.sqrt());
        let cosine_scale = lowest(triangle).hypot(1e-3);
        let zenith = distance_to_origin(&triangle.map(DVec3::truncate));
        let angle_scale = angle_scale(triangle, self.view).min(2.0 * zenith.max(0.01));
        let bends = straddles(triangle, 0.5);
        [0, 1, 2].map(|k| {
            let (i, j) = EDGES[k];
            let angle = triangle[i].distance(triangle[j]) / angle_scale;
            let half = (cosines[i] - cosines[j]) / half_scale;
            let rise = rise(triangle[i], triangle[j]);
            let cosine = match bends {
                true => rise / 0.05,
                false => 0.25 * rise / cosine_scale,
            };
            (angle * angle + half * half + cosine * cosine).sqrt()
        })
    }
}
