//! The GGX lobe as an integrand.

use glam::{DVec2, DVec3};

use super::{EDGES, angle_scale, distance_to_origin, is_alpha, lowest};
use crate::cubature::CubatureError;
use crate::ggx::{ggx_distribution, ggx_visibility, schlick_weight};
use crate::quadrature::Integrand;

/// The GGX lobe times the cosine at the light, in the shading frame.
pub(crate) struct GgxLobe {
    pub(crate) view: DVec3,
    alpha: [f64; 2],
}

impl GgxLobe {
    pub(crate) fn new(view: DVec3, alpha: [f64; 2]) -> Result<Self, CubatureError> {
        match alpha.iter().find(|&&a| !is_alpha(a)) {
            None => Ok(Self { view, alpha }),
            Some(&wrong) => Err(CubatureError::Alpha(wrong)),
        }
    }
}

impl Integrand<2> for GgxLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 2] {
        // Rounding may put a direction of the horizon just below it.
        let light = direction.with_z(direction.z.max(0.0));
        let half_vector = direction + self.view;
        let value = ggx_distribution(half_vector, self.alpha)
            * ggx_visibility(light, self.view, self.alpha)
            * light.z;
        // |l + v| = 2 h.v for unit directions, without the cancellation of the dot product.
        [value, value * schlick_weight(0.5 * half_vector.length())]
    }

    /// D varies on the scale of sqrt(1 + slope^2) over slopes of the half vector in units of the widths, G2 on that of
    /// sqrt(alpha^2 + cos^2) over the cosine, and the half vector itself on that of |l + v| over directions.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let slope = |l: DVec3| {
            let half_vector = l + self.view;
            half_vector.truncate() / half_vector.z / DVec2::from(self.alpha)
        };
        let slopes = triangle.map(slope);
        let slope_scale = distance_to_origin(&slopes).hypot(1.0);
        let cosine_scale = lowest(triangle).hypot(self.alpha[0].min(self.alpha[1]));
        let angle_scale = angle_scale(triangle, self.view);
        EDGES.map(|(i, j)| {
            let angle = triangle[i].distance(triangle[j]) / angle_scale;
            // By way of its middle: an arc with both ends on a narrow lobe's crest may bulge far out of the lobe.
            let middle = slope((triangle[i] + triangle[j]).normalize_or(triangle[i]));
            let slope = (slopes[i].distance(middle) + middle.distance(slopes[j])) / slope_scale;
            let cosine = (triangle[i].z - triangle[j].z) / cosine_scale;
            (angle * angle + slope * slope + 0.5 * cosine * cosine).sqrt()
        })
    }
}
