//! The GGX lobe over a polygon and over the hemisphere.

use glam::DVec3;

use super::{
    CubatureError, checked, clip, half_hemisphere, position, shading_frame, to_frame, unit,
};
use crate::integrands::GgxLobe;
use crate::polygon::Polygon;
use crate::quadrature::{Outcome, Tolerance, integrate};

/// The two integrals of the GGX lobe that a split-sum Fresnel term needs.
///
/// With Schlick's Fresnel of normal-incidence reflectance f0 the reflected radiance is `f0 (value - schlick) + schlick`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GgxIntegral {
    /// Integral of D G2 / (4 n.l n.v) (n.l), Fresnel factor 1.
    pub value: f64,
    /// The same with the factor (1 - h.v)^5.
    pub schlick: f64,
    /// Estimated absolute error of the worse of the two.
    pub error: f64,
}

/// Radiance that a GGX surface (Fresnel factor 1) reflects towards `view` from a light of radiance 1.
///
/// `normal` and `view` (from the point to the viewer) are unit vectors, `alpha` is the GGX width in (0, 1]. The light
/// is clipped by the surface's horizon. A view from below the surface sees nothing.
///
/// Rounding of directions limits the accuracy to about 1e-16 / (alpha n.v), the inverse width of the lobe: 1e-12 for
/// alpha 0.0025 at 88 degrees, 1e-7 for the same alpha at n.v = 1e-6.
///
/// # Errors
/// As [`irradiance`](super::irradiance); also a view or `alpha` that is none.
pub fn ggx(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    view: [f64; 3],
    alpha: f64,
    tolerance: Tolerance,
) -> Result<GgxIntegral, CubatureError> {
    let (normal, view) = (unit("normal", normal)?, unit("view", view)?);
    let frame = shading_frame(normal, view);
    reflected(light, point, frame, view, [alpha; 2], tolerance)
}

/// As [`ggx`], with the widths `alpha = [alpha_t, alpha_b]` in (0, 1] along and across the unit vector `tangent`.
///
/// # Errors
/// As [`ggx`]; also a tangent that is not orthogonal to the normal.
pub fn ggx_anisotropic(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    tangent: [f64; 3],
    view: [f64; 3],
    alpha: [f64; 2],
    tolerance: Tolerance,
) -> Result<GgxIntegral, CubatureError> {
    let (n, t) = (unit("normal", normal)?, unit("tangent", tangent)?);
    let view = unit("view", view)?;
    if n.dot(t).abs() > 1e-5 {
        return Err(CubatureError::NotOrthogonal { tangent, normal });
    }
    let frame = shading_frame(n, t);
    reflected(light, point, frame, view, alpha, tolerance)
}

fn reflected(
    light: &Polygon,
    point: [f64; 3],
    frame: [DVec3; 3],
    view: DVec3,
    alpha: [f64; 2],
    tolerance: Tolerance,
) -> Result<GgxIntegral, CubatureError> {
    let point = position(point)?;
    let lobe = GgxLobe::new(to_frame(&frame, view), alpha)?;
    if lobe.view.z <= 0.0 {
        return Ok(GgxIntegral {
            value: 0.0,
            schlick: 0.0,
            error: 0.0,
        });
    }
    integral(&integrate(&lobe, clip(light, point, frame), tolerance), 1.0)
}

/// Directional albedo of the GGX surface of [`ggx`]: what it reflects of a uniform hemisphere of radiance 1.
///
/// `cos_theta_view` is n.v in (0, 1].
///
/// # Errors
/// A cosine or `alpha` out of range, or a tolerance that is out of reach.
pub fn ggx_albedo(
    cos_theta_view: f64,
    alpha: f64,
    tolerance: Tolerance,
) -> Result<GgxIntegral, CubatureError> {
    let (view, half, halved) = half_hemisphere(cos_theta_view, tolerance)?;
    let lobe = GgxLobe::new(view, [alpha; 2])?;
    integral(&integrate(&lobe, half, halved), 2.0)
}

/// Directional albedo of the GGX surface of [`ggx_anisotropic`].
///
/// `view` is a unit vector in the shading frame: x along the tangent, z along the normal, z above 0.
///
/// # Errors
/// A view that is none or not above the surface, widths out of range, or a tolerance that is out of reach.
pub fn ggx_anisotropic_albedo(
    view: [f64; 3],
    alpha: [f64; 2],
    tolerance: Tolerance,
) -> Result<GgxIntegral, CubatureError> {
    let view = unit("view", view)?;
    if view.z <= 0.0 {
        return Err(CubatureError::CosThetaView(view.z));
    }
    let lobe = GgxLobe::new(view, alpha)?;
    let quarters = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
    let hemisphere = (0..4).map(|i| [DVec3::Z, quarters[(i + 1) % 4], quarters[i]]);
    integral(&integrate(&lobe, hemisphere, tolerance), 1.0)
}

fn integral(outcome: &Outcome<2>, factor: f64) -> Result<GgxIntegral, CubatureError> {
    let [value, schlick] = checked(outcome)?;
    Ok(GgxIntegral {
        // Rounding only: the lobe is nowhere negative, but the rule's weights are.
        value: factor * value.max(0.0),
        schlick: factor * schlick.max(0.0),
        error: factor * outcome.error,
    })
}
