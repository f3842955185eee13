//! Integrals of a polygon's light over the hemisphere of one point, to a requested accuracy.

mod charlie;
mod eon;
mod ggx;

use glam::DVec3;
use thiserror::Error;

use crate::integrands::{Cosine, Direction, One};
use crate::polygon::{Polygon, is_position};
use crate::quadrature::{Outcome, Tolerance, integrate};

pub use charlie::{charlie, charlie_albedo};
pub use eon::{EonIntegral, eon, eon_albedo};
pub use ggx::{GgxIntegral, ggx, ggx_albedo, ggx_anisotropic, ggx_anisotropic_albedo};

/// Why an integral could not be had.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CubatureError {
    /// The point has a coordinate that is NaN, infinite or beyond 1e30.
    #[error("the point {0:?} is not a position; coordinates must be finite and within 1e30")]
    Point([f64; 3]),
    /// A direction is not of unit length, to 1e-5.
    #[error("the {name} {direction:?} has length {}; it must be a unit vector", DVec3::from(*.direction).length())]
    NotUnit {
        /// Which direction: `normal`, `tangent`, `axis` or `view`.
        name: &'static str,
        /// What was given.
        direction: [f64; 3],
    },
    /// The tangent is not orthogonal to the normal, to 1e-5.
    #[error(
        "the tangent {tangent:?} is not orthogonal to the normal {normal:?}; take the normal's part out of it and scale it to unit length"
    )]
    NotOrthogonal {
        /// The tangent as given.
        tangent: [f64; 3],
        /// The normal as given.
        normal: [f64; 3],
    },
    /// A GGX or Charlie width is not in (0, 1].
    #[error("alpha is {0}; it must be above 0 and at most 1")]
    Alpha(f64),
    /// The roughness of a diffuse surface is not in [0, 1].
    #[error("diffuse_roughness is {0}; it must be at least 0 and at most 1")]
    DiffuseRoughness(f64),
    /// The cosine of the view angle is not in (0, 1].
    #[error("the cosine of the view angle is {0}; it must be above 0 and at most 1")]
    CosThetaView(f64),
    /// A map of directions is singular, mirrors, or is not finite.
    #[error(
        "the rows {0:?} are no lobe's map to cosine space; their determinant must be positive and all be finite"
    )]
    NoLobe([[f64; 3]; 3]),
    /// The tolerance was not reached within the allowed evaluations, or is beyond what rounding allows.
    #[error(
        "the integral has an error of about {error:e} after the allowed evaluations; ask for less"
    )]
    NotConverged {
        /// Estimated absolute error reached.
        error: f64,
    },
}

/// An integral and the estimate of its absolute error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integral {
    /// The integral.
    pub value: f64,
    /// Estimated absolute error, usually pessimistic.
    pub error: f64,
}

/// A vector-valued integral and the estimate of its absolute error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorIntegral {
    /// The integral, in the frame of the polygon.
    pub value: [f64; 3],
    /// Estimated absolute error of the worst component.
    pub error: f64,
}

/// Irradiance at `point` on a surface with unit `normal` from a light of radiance 1, in [0, pi].
///
/// Light from below the surface's horizon is clipped off. A one-sided light is dark for points behind its plane and
/// on it.
///
/// # Errors
/// A point or normal that is none, or a tolerance that is out of reach.
pub fn irradiance(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    tolerance: Tolerance,
) -> Result<Integral, CubatureError> {
    let frame = shading_frame(unit("normal", normal)?, DVec3::ZERO);
    let outcome = integrate(&Cosine, clip(light, position(point)?, frame), tolerance);
    Ok(Integral {
        value: checked(&outcome)?[0].max(0.0),
        error: outcome.error,
    })
}

/// Form factor of the light as seen from a surface element, in [0, 1]: the irradiance over pi.
///
/// # Errors
/// As [`irradiance`].
pub fn form_factor(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    tolerance: Tolerance,
) -> Result<Integral, CubatureError> {
    let Integral { value, error } = irradiance(light, point, normal, tolerance)?;
    Ok(Integral {
        value: value * std::f64::consts::FRAC_1_PI,
        error: error * std::f64::consts::FRAC_1_PI,
    })
}

/// Vector irradiance at `point`: the integral of the unit direction over the light's solid angle, in the light's frame.
///
/// No horizon clips it. Its product with a normal is the irradiance where the whole light is above that normal's
/// horizon. Radiance 1; zero behind a one-sided light.
///
/// # Errors
/// As [`irradiance`].
pub fn light_vector(
    light: &Polygon,
    point: [f64; 3],
    tolerance: Tolerance,
) -> Result<VectorIntegral, CubatureError> {
    let outcome = integrate(&Direction, whole(light, position(point)?), tolerance);
    Ok(VectorIntegral {
        value: checked(&outcome)?,
        error: outcome.error,
    })
}

/// Solid angle of the light at `point` in steradians, in [0, 2 pi]; no horizon clips it. Zero behind a one-sided light.
///
/// # Errors
/// As [`irradiance`].
pub fn solid_angle(
    light: &Polygon,
    point: [f64; 3],
    tolerance: Tolerance,
) -> Result<Integral, CubatureError> {
    let outcome = integrate(&One, whole(light, position(point)?), tolerance);
    Ok(Integral {
        value: checked(&outcome)?[0].max(0.0),
        error: outcome.error,
    })
}

fn checked<const N: usize>(outcome: &Outcome<N>) -> Result<[f64; N], CubatureError> {
    match outcome.converged {
        true => Ok(outcome.value),
        false => Err(CubatureError::NotConverged {
            error: outcome.error,
        }),
    }
}

pub(crate) fn position(point: [f64; 3]) -> Result<DVec3, CubatureError> {
    match is_position(point) {
        true => Ok(point.into()),
        false => Err(CubatureError::Point(point)),
    }
}

pub(crate) fn unit(name: &'static str, direction: [f64; 3]) -> Result<DVec3, CubatureError> {
    let vector = DVec3::from(direction);
    match (vector.length() - 1.0).abs() <= 1e-5 {
        true => Ok(vector.normalize()),
        false => Err(CubatureError::NotUnit { name, direction }),
    }
}

/// Rows of the rotation into the shading frame: z along the normal, x towards the view's azimuth where it has one.
pub(crate) fn shading_frame(normal: DVec3, view: DVec3) -> [DVec3; 3] {
    let x = (view - normal * normal.dot(view))
        .try_normalize()
        // A view along the normal leaves a remainder of pure rounding, which need not be orthogonal.
        .filter(|x| x.dot(normal).abs() < 1e-12)
        .unwrap_or_else(|| normal.any_orthonormal_vector());
    [x, normal.cross(x), normal]
}

/// The view of an albedo, whose cosine must be in (0, 1], and half of the hemisphere: what is even in y needs no more.
fn half_hemisphere(
    cos_theta_view: f64,
    tolerance: Tolerance,
) -> Result<(DVec3, [[DVec3; 3]; 2], Tolerance), CubatureError> {
    if !(cos_theta_view > 0.0 && cos_theta_view <= 1.0) {
        return Err(CubatureError::CosThetaView(cos_theta_view));
    }
    let sine = (1.0 - cos_theta_view * cos_theta_view).sqrt();
    let half = [
        [DVec3::Z, DVec3::Y, DVec3::X],
        [DVec3::Z, DVec3::NEG_X, DVec3::Y],
    ];
    let halved = Tolerance {
        absolute: 0.5 * tolerance.absolute,
        ..tolerance
    };
    Ok((DVec3::new(sine, 0.0, cos_theta_view), half, halved))
}

pub(crate) fn to_frame(rows: &[DVec3; 3], vector: DVec3) -> DVec3 {
    DVec3::from(rows.map(|row| row.dot(vector)))
}

/// Normalises any vector but zero, also one so short that its square is not a number above zero.
fn unit_direction(vector: DVec3) -> DVec3 {
    (vector / vector.abs().max_element()).normalize()
}

/// The light's triangles as unit directions from `point`, clockwise; none where the light is dark.
fn whole(light: &Polygon, point: DVec3) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    seen(light, point).map(|triangle| triangle.map(unit_direction))
}

/// The light's triangles as vectors from `point`, turned so that the lit side is always the same.
fn seen(light: &Polygon, point: DVec3) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    let height = light.height(point);
    let dark = height == 0.0 || (height < 0.0 && !light.is_two_sided());
    let triangles = if dark {
        &[][..]
    } else {
        light.triangle_vertices()
    };
    triangles.iter().map(move |triangle| {
        let [a, b, c] = triangle.map(|vertex| vertex - point);
        if height > 0.0 { [a, b, c] } else { [a, c, b] }
    })
}

/// The light's triangles as unit directions in the shading frame, cut off at the horizon z = 0.
fn clip(light: &Polygon, point: DVec3, rows: [DVec3; 3]) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    seen(light, point).flat_map(move |triangle| {
        let triangle = triangle.map(|v| to_frame(&rows, v));
        let mut kept = Vec::with_capacity(4);
        for (i, &a) in triangle.iter().enumerate() {
            let b = triangle[(i + 1) % 3];
            if a.z > 0.0 {
                kept.push(unit_direction(a));
            }
            if (a.z > 0.0) != (b.z > 0.0) {
                let crossing = a + a.z / (a.z - b.z) * (b - a);
                // Exactly on the horizon, whatever rounding says; through the point itself there is no direction.
                let crossing = crossing.with_z(0.0);
                if crossing != DVec3::ZERO {
                    kept.push(unit_direction(crossing));
                }
            }
        }
        (2..kept.len())
            .map(|i| [kept[0], kept[i - 1], kept[i]])
            .collect::<Vec<_>>()
    })
}

#[cfg(test)]
mod tests;
