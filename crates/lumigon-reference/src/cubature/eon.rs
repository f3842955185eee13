//! The EON rough diffuse lobe over a polygon and over the hemisphere.

use glam::DVec3;

use super::{
    CubatureError, checked, clip, half_hemisphere, position, shading_frame, to_frame, unit,
};
use crate::eon::eon_multiple_scattering_albedo;
use crate::integrands::EonLobe;
use crate::polygon::Polygon;
use crate::quadrature::{Outcome, Tolerance, integrate};

/// The integrals of the two scattering orders of the EON lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EonIntegral {
    /// Integral of single scattering at albedo 1, times the cosine.
    pub single: f64,
    /// Integral of multiple scattering at multiple-scattering albedo 1, times the cosine.
    pub multiple: f64,
    /// Estimated absolute error of the worse of the two.
    pub error: f64,
}

impl EonIntegral {
    /// The reflected radiance of a surface with this albedo in [0, 1] and `diffuse_roughness`.
    pub fn with_albedo(self, albedo: f64, diffuse_roughness: f64) -> f64 {
        albedo * self.single
            + eon_multiple_scattering_albedo(albedo, diffuse_roughness) * self.multiple
    }
}

/// Radiance that an EON surface reflects towards `view` from a light of radiance 1, by scattering order.
///
/// `normal` and `view` (from the point to the viewer) are unit vectors; `diffuse_roughness` is in [0, 1]. The light is
/// clipped by the surface's horizon. A view from below the surface sees nothing. The BRDF is
/// [`eon_brdf`](crate::eon_brdf).
///
/// # Errors
/// As [`irradiance`](super::irradiance); also a view or `diffuse_roughness` that is none.
pub fn eon(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    view: [f64; 3],
    diffuse_roughness: f64,
    tolerance: Tolerance,
) -> Result<EonIntegral, CubatureError> {
    let (normal, view) = (unit("normal", normal)?, unit("view", view)?);
    let point = position(point)?;
    let frame = shading_frame(normal, view);
    let lobe = EonLobe::new(to_frame(&frame, view), diffuse_roughness)?;
    if lobe.view.z <= 0.0 {
        return Ok(EonIntegral {
            single: 0.0,
            multiple: 0.0,
            error: 0.0,
        });
    }
    let triangles = clip(light, point, frame).flat_map(|triangle| cut_across(&triangle));
    integral(&integrate(&lobe, triangles, tolerance), 1.0)
}

/// Cuts a triangle of directions in two where it crosses the plane x = 0, on which single scattering bends.
fn cut_across(triangle: &[DVec3; 3]) -> Vec<[DVec3; 3]> {
    let mut pieces = Vec::with_capacity(3);
    for side in [1.0, -1.0] {
        let mut kept = Vec::with_capacity(4);
        for (i, &a) in triangle.iter().enumerate() {
            let b = triangle[(i + 1) % 3];
            if side * a.x >= 0.0 {
                kept.push(a);
            }
            if a.x * b.x < 0.0 {
                let crossing = a + a.x / (a.x - b.x) * (b - a);
                kept.push(crossing.with_x(0.0).normalize_or(a));
            }
        }
        // What only touches the plane is left to the other side.
        if kept.iter().any(|v| side * v.x > 0.0) || (side > 0.0 && kept.len() == 3) {
            pieces.extend((2..kept.len()).map(|i| [kept[0], kept[i - 1], kept[i]]));
        }
    }
    pieces
}

/// Directional albedo of the EON surface of [`eon`]: what it reflects of a uniform hemisphere of radiance 1.
///
/// `cos_theta_view` is n.v in (0, 1]. The two parts add up to 1, by construction of the BRDF.
///
/// # Errors
/// A cosine or `diffuse_roughness` out of range, or a tolerance that is out of reach.
pub fn eon_albedo(
    cos_theta_view: f64,
    diffuse_roughness: f64,
    tolerance: Tolerance,
) -> Result<EonIntegral, CubatureError> {
    let (view, half, halved) = half_hemisphere(cos_theta_view, tolerance)?;
    let lobe = EonLobe::new(view, diffuse_roughness)?;
    integral(&integrate(&lobe, half, halved), 2.0)
}

fn integral(outcome: &Outcome<2>, factor: f64) -> Result<EonIntegral, CubatureError> {
    let [single, multiple] = checked(outcome)?;
    Ok(EonIntegral {
        // Rounding only: the lobe is nowhere negative, but the rule's weights are.
        single: factor * single.max(0.0),
        multiple: factor * multiple.max(0.0),
        error: factor * outcome.error,
    })
}
