use glam::{DMat3, DVec2, DVec3};

use crate::symmetric;

/// The lobe that a BRDF tends to, seen from one direction: where a fit starts from, what its
/// coordinates and a table's numbers are relative to. All of it is known in closed form, so that
/// neither has to carry what changes fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Shading space to *peak space*, a rotation: the direction of the limit lobe's peak becomes z.
    pub shading_to_peak: DMat3,
    /// Logarithm of the peak's widths, a symmetric matrix `[xx, xy, yy]` in peak space, radians.
    pub ln_width: [f64; 3],
    /// How far one unit of a fit turns the peak, radians.
    pub turn: f64,
    /// How far one unit of a fit tilts the cosine's plane against the peak, as a tangent.
    pub tilt: f64,
    /// Tilt of the limit lobe, in those units.
    pub limit_tilt: DVec2,
    /// Shading space to *unit space*, peak space stretched until the microfacets' widths are 1 both
    /// ways: what a table's matrices start from. The cosine of the view angle stays in them: at
    /// grazing views the lobe's width no longer goes with it.
    pub shading_to_unit: DMat3,
}

impl Limit {
    /// No peak: the clamped cosine about the normal.
    pub fn cosine() -> Self {
        Self {
            shading_to_peak: DMat3::IDENTITY,
            ln_width: [0.0; 3],
            turn: 1.0,
            tilt: 1.0,
            limit_tilt: DVec2::ZERO,
            shading_to_unit: DMat3::IDENTITY,
        }
    }

    /// A microfacet BRDF of small widths `alpha` along x and y. The cosine distribution around its
    /// peak *is* GGX's, `1 / (pi (1 + r^2)^2)`, and a tilt by `tan theta` lays the cosine's plane on
    /// the surface: both are exact as alpha goes to 0.
    ///
    /// The peak is the mirrored view. A microfacet's tilt by one turns the light by two in the
    /// plane of incidence, and across it by 2 cos theta, at grazing views at least by the order of
    /// alpha.
    pub fn mirror(alpha: [f64; 2], view: DVec3) -> Self {
        let across = view.truncate();
        let sine = across.length();
        let azimuth = if sine > 0.0 { across / sine } else { DVec2::X };
        let theta = sine.atan2(view.z);
        let [ax, ay] = alpha;
        // Width of the microfacets in the plane of incidence and across it.
        let along_view = (ax * azimuth.x).hypot(ay * azimuth.y);
        let cosine = view.z.hypot(along_view);
        // d light / d half vector, J = 2 u u^T + 2 cos (1 - u u^T); covariance J diag(alpha^2) J^T.
        let (ux, uy) = (azimuth.x, azimuth.y);
        let j = [
            2.0 * (ux * ux + cosine * uy * uy),
            2.0 * (1.0 - cosine) * ux * uy,
            2.0 * (uy * uy + cosine * ux * ux),
        ];
        let (x, y) = (ax * ax, ay * ay);
        let covariance = [
            j[0] * j[0] * x + j[1] * j[1] * y,
            j[1] * (j[0] * x + j[2] * y),
            j[1] * j[1] * x + j[2] * j[2] * y,
        ];
        let shading_to_peak = turn(-theta * azimuth);
        let peak_to_unit = DMat3::from_diagonal(DVec3::new(1.0 / ax, 1.0 / ay, 1.0));
        Self {
            shading_to_peak,
            ln_width: symmetric::ln(covariance).map(|x| 0.5 * x),
            turn: 2.0 * ax * ay / (ax + ay),
            tilt: sine / view.z,
            limit_tilt: azimuth,
            shading_to_unit: peak_to_unit * shading_to_peak,
        }
    }

    /// The narrower width of the peak, radians.
    pub fn narrowest(&self) -> f64 {
        let [xx, xy, yy] = self.ln_width;
        (0.5 * (xx + yy) - (0.5 * (xx - yy)).hypot(xy)).exp()
    }
}

/// The rotation about an axis in the x-y plane that turns the plane of `by` and z: the direction
/// `(sin |by| by / |by|, cos |by|)` becomes z.
pub(crate) fn turn(by: DVec2) -> DMat3 {
    let angle = by.length();
    if angle == 0.0 {
        return DMat3::IDENTITY;
    }
    let u = by / angle;
    let (sin, cos) = angle.sin_cos();
    let row = |a: f64, b: f64, c: f64| DVec3::new(a, b, c);
    DMat3::from_cols(
        row(
            1.0 + (cos - 1.0) * u.x * u.x,
            (cos - 1.0) * u.x * u.y,
            sin * u.x,
        ),
        row(
            (cos - 1.0) * u.x * u.y,
            1.0 + (cos - 1.0) * u.y * u.y,
            sin * u.y,
        ),
        row(-sin * u.x, -sin * u.y, cos),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrored_view_is_the_peak() {
        for (theta, phi) in [(0.0_f64, 0.3_f64), (0.7, 0.0), (1.2, 1.1), (1.5, 4.0)] {
            let view = DVec3::new(
                theta.sin() * phi.cos(),
                theta.sin() * phi.sin(),
                theta.cos(),
            );
            let limit = Limit::mirror([0.01, 0.04], view);
            let mirrored = DVec3::new(-view.x, -view.y, view.z);
            let rotation = limit.shading_to_peak;
            assert!((rotation * mirrored - DVec3::Z).length() < 1e-12);
            assert!(
                (rotation * rotation.transpose() - DMat3::IDENTITY)
                    .x_axis
                    .length()
                    < 1e-14
            );
        }
    }

    /// In the plane of incidence twice alpha, across it 2 alpha cos theta, whatever the azimuth.
    #[test]
    fn widths_of_an_isotropic_peak() {
        let (alpha, theta) = (1e-3, 1.0_f64);
        for phi in [0.0_f64, 0.5, 2.0] {
            let view = DVec3::new(
                theta.sin() * phi.cos(),
                theta.sin() * phi.sin(),
                theta.cos(),
            );
            let limit = Limit::mirror([alpha, alpha], view);
            let width = symmetric::exp(limit.ln_width);
            let along = width[0] * phi.cos().powi(2)
                + 2.0 * width[1] * phi.cos() * phi.sin()
                + width[2] * phi.sin().powi(2);
            assert!((along / (2.0 * alpha) - 1.0).abs() < 1e-5);
            assert!((limit.narrowest() / (2.0 * alpha * theta.cos()) - 1.0).abs() < 1e-5);
        }
    }
}
