//! The Charlie sheen lobe over a polygon and over the hemisphere.

use super::{
    CubatureError, Integral, checked, clip, half_hemisphere, position, shading_frame, to_frame,
    unit,
};
use crate::integrands::CharlieLobe;
use crate::polygon::Polygon;
use crate::quadrature::{Tolerance, integrate};

/// Radiance that a Charlie sheen (sheen colour 1, nothing below it) reflects towards `view` from a light of radiance 1.
///
/// `normal` and `view` (from the point to the viewer) are unit vectors; `alpha`, the square of glTF's sheen roughness,
/// is in (0, 1]. The light is clipped by the surface's horizon. A view from below the surface sees nothing. The BRDF is
/// [`charlie_brdf`](crate::charlie_brdf).
///
/// # Errors
/// As [`irradiance`](super::irradiance); also a view or `alpha` that is none.
pub fn charlie(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    view: [f64; 3],
    alpha: f64,
    tolerance: Tolerance,
) -> Result<Integral, CubatureError> {
    let (normal, view) = (unit("normal", normal)?, unit("view", view)?);
    let point = position(point)?;
    let frame = shading_frame(normal, view);
    let lobe = CharlieLobe::new(to_frame(&frame, view), alpha)?;
    if lobe.view.z <= 0.0 {
        return Ok(Integral {
            value: 0.0,
            error: 0.0,
        });
    }
    let outcome = integrate(&lobe, clip(light, point, frame), tolerance);
    Ok(Integral {
        value: checked(&outcome)?[0].max(0.0),
        error: outcome.error,
    })
}

/// Directional albedo of the sheen of [`charlie`]: what it reflects of a uniform hemisphere of radiance 1.
///
/// `cos_theta_view` is n.v in (0, 1].
///
/// # Errors
/// A cosine or `alpha` out of range, or a tolerance that is out of reach.
pub fn charlie_albedo(
    cos_theta_view: f64,
    alpha: f64,
    tolerance: Tolerance,
) -> Result<Integral, CubatureError> {
    let (view, half, halved) = half_hemisphere(cos_theta_view, tolerance)?;
    let outcome = integrate(&CharlieLobe::new(view, alpha)?, half, halved);
    Ok(Integral {
        value: 2.0 * checked(&outcome)?[0].max(0.0),
        error: 2.0 * outcome.error,
    })
}
