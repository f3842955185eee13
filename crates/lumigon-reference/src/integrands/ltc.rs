//! A linearly transformed cosine as an integrand: its density, direction by direction.

use glam::{DMat3, DVec3};

use crate::quadrature::{Integrand, SMOOTH_ANGLE, edge_lengths};

/// The normalised clamped cosine seen through a linear map of directions.
///
/// Heitz, Dupuy, Hill and Neubelt, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines", ACM TOG 35(4),
/// 2016, eq. 2.
pub(crate) struct LtcDensity {
    /// Of unit determinant.
    to_cosine: DMat3,
}

impl LtcDensity {
    /// `to_cosine` maps directions to the space where the lobe is the clamped cosine about z; `None` where it is
    /// singular, mirrors, or is not finite.
    pub(crate) fn new(to_cosine: DMat3) -> Option<Self> {
        let largest = to_cosine
            .to_cols_array()
            .iter()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let scaled = to_cosine * (1.0 / largest);
        let determinant = scaled.determinant();
        (scaled.is_finite() && determinant > 1e-30).then(|| Self {
            to_cosine: scaled * (1.0 / determinant.cbrt()),
        })
    }

    /// Direction, of any length, whose plane bounds the lobe.
    pub(crate) fn horizon(&self) -> DVec3 {
        self.to_cosine.row(2)
    }
}

impl Integrand<1> for LtcDensity {
    fn evaluate(&self, direction: DVec3) -> [f64; 1] {
        let cosine = self.to_cosine * direction;
        let squared = cosine.length_squared();
        [cosine.z.max(0.0) / (std::f64::consts::PI * squared * squared)]
    }

    /// The cosine is smooth in its own space, and so is the map's distortion in the space where it is the smaller.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let transformed = triangle.map(|l| (self.to_cosine * l).normalize_or_zero());
        let (here, there) = (edge_lengths(triangle), edge_lengths(&transformed));
        [0, 1, 2].map(|edge| here[edge].max(there[edge]) / SMOOTH_ANGLE)
    }
}
