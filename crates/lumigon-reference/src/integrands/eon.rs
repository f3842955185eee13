//! The EON rough diffuse lobe as an integrand.

use glam::DVec3;

use super::{EDGES, rise, straddles};
use crate::cubature::CubatureError;
use crate::eon::eon;
use crate::quadrature::{Integrand, SMOOTH_ANGLE, edge_lengths};

/// Single and multiple scattering of the EON lobe times the cosine at the light, in the shading frame with x towards
/// the view.
pub(crate) struct EonLobe {
    pub(crate) view: DVec3,
    diffuse_roughness: f64,
}

impl EonLobe {
    pub(crate) fn new(view: DVec3, diffuse_roughness: f64) -> Result<Self, CubatureError> {
        match (0.0..=1.0).contains(&diffuse_roughness) {
            true => Ok(Self {
                view,
                diffuse_roughness,
            }),
            false => Err(CubatureError::DiffuseRoughness(diffuse_roughness)),
        }
    }
}

impl Integrand<2> for EonLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 2] {
        let cos_theta = direction.z.max(0.0);
        let tangential = direction.truncate().dot(self.view.truncate());
        let brdf = eon(cos_theta, self.view.z, tangential, self.diffuse_roughness);
        [brdf.single * cos_theta, brdf.multiple * cos_theta]
    }

    /// Single scattering bends where the light passes the view's cosine. What it does in a corner that no sample
    /// reaches is not seen, so the triangles there are made thin.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let angles = edge_lengths(triangle).map(|length| length / SMOOTH_ANGLE);
        if !straddles(triangle, self.view.z) {
            return angles;
        }
        [0, 1, 2].map(|k| {
            let (i, j) = EDGES[k];
            angles[k].hypot(rise(triangle[i], triangle[j]) / (THIN * self.view.z))
        })
    }
}

/// Height of triangles across the bend of [`EonLobe`] in units of the view's cosine; leaves an error of about 1e-8.
const THIN: f64 = 0.02;
