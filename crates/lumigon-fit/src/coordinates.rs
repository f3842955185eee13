use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    limit::{Limit, turn},
    ltc::Ltc,
    node::Node,
    symmetric,
};

/// The eight numbers of one lobe that a fit moves, relative to the BRDF's [`Limit`]: each is of
/// order one at every node, varies slowly over the table, and every value is a valid lobe (the
/// determinant cannot change sign).
///
/// In peak space, turned by p, the matrix is `[[S^-1, 0], [t, 1]]`: the symmetric S holds the
/// peak's widths, t tilts the cosine's plane against the peak. A further rotation about the
/// cosine's own axis would change nothing. The coordinates are
/// `[ln S - limit's (xx, xy, yy), t (x, y) and p (x, y) in the limit's units, ln(amplitude)]`.
///
/// The published factors (Heitz et al. 2016, section 3.1: a frame about the mean direction, two
/// widths, one skew) span the same matrices, but there small alpha sends skew and frame to infinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coordinates(pub [f64; Coordinates::COUNT]);

impl Coordinates {
    /// How many there are.
    pub const COUNT: usize = 8;

    /// The limit lobe itself, with an amplitude.
    pub fn limit(limit: &Limit, amplitude: f64) -> Self {
        let tilt = limit.limit_tilt;
        Self([0.0, 0.0, 0.0, tilt.x, tilt.y, 0.0, 0.0, amplitude.ln()])
    }

    /// The lobe at these coordinates, its second amplitude still 0.
    pub fn to_ltc(self, limit: &Limit) -> Ltc {
        let [xx, xy, yy, tx, ty, px, py, ln_amplitude] = self.0;
        // Wide enough never to bind, tight enough that no step overflows.
        let bounded = |x: f64| x.clamp(-8.0, 8.0);
        let inverse = symmetric::exp([
            -limit.ln_width[0] - bounded(xx),
            -limit.ln_width[1] - bounded(xy),
            -limit.ln_width[2] - bounded(yy),
        ]);
        let tilt = limit.tilt * DVec2::new(tx, ty);
        let peak_to_cosine = DMat3::from_cols(
            DVec3::new(inverse[0], inverse[1], tilt.x),
            DVec3::new(inverse[1], inverse[2], tilt.y),
            DVec3::Z,
        );
        Ltc {
            shading_to_cosine: peak_to_cosine
                * turn(limit.turn * DVec2::new(px, py))
                * limit.shading_to_peak,
            amplitude: ln_amplitude.clamp(-40.0, 5.0).exp(),
            secondary: 0.0,
        }
    }

    /// Inverse of [`Coordinates::to_ltc`] for a matrix of positive determinant, of any scale and
    /// turned about the cosine's axis at will, and a positive amplitude.
    pub fn from_ltc(ltc: &Ltc, limit: &Limit) -> Self {
        let matrix = ltc.shading_to_cosine * limit.shading_to_peak.transpose();
        let rows = matrix.transpose();
        // What the cosine's x and y are both at right angles to is its peak.
        let peak = rows.x_axis.cross(rows.y_axis).normalize_or(DVec3::Z);
        let sine = peak.truncate().length();
        let by = if sine > 0.0 {
            peak.truncate() * (sine.atan2(peak.z) / sine)
        } else {
            DVec2::ZERO
        };
        let straight = matrix * turn(by).transpose();
        let [x, y] = [straight.x_axis, straight.y_axis].map(|column| column / straight.z_axis.z);
        // The symmetric part of the polar decomposition: turned about the cosine's axis.
        let (sin, cos) = (x.y - y.x).atan2(x.x + y.y).sin_cos();
        let inverse = [
            cos * x.x + sin * x.y,
            cos * y.x + sin * y.y,
            cos * y.y - sin * y.x,
        ];
        let ln_inverse = symmetric::ln(inverse);
        let tilt = |by: f64, limit_tilt: f64| {
            if limit.tilt > 0.0 {
                by / limit.tilt
            } else {
                limit_tilt
            }
        };
        Self([
            -ln_inverse[0] - limit.ln_width[0],
            -ln_inverse[1] - limit.ln_width[1],
            -ln_inverse[2] - limit.ln_width[2],
            tilt(x.z, limit.limit_tilt.x),
            tilt(y.z, limit.limit_tilt.y),
            by.x / limit.turn,
            by.y / limit.turn,
            ltc.amplitude.ln(),
        ])
    }

    /// The coordinates of the lobe mirrored in the planes x = 0 and y = 0, as `signs` say (-1
    /// mirrors).
    pub(crate) fn mirrored(mut self, [x, y]: [f64; 2]) -> Self {
        for (i, sign) in [(1, x * y), (3, x), (4, y), (5, x), (6, y)] {
            self.0[i] *= sign;
        }
        self
    }

    /// The coordinates at `-theta`, which is the same lobe seen from the other side: the tilt is
    /// in units of tan theta, which changes its sign too.
    pub(crate) fn seen_from_behind(mut self, limit: &Limit) -> Self {
        self = self.mirrored([-1.0, -1.0]);
        if limit.limit_tilt != DVec2::ZERO {
            self.0[3] = -self.0[3];
            self.0[4] = -self.0[4];
        }
        self
    }
}

/// Which coordinates a fit may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Parametrisation {
    /// All of them.
    Free,
    /// The published one: the frame follows the lobe's mean direction and the amplitude is the
    /// albedo; both widths and the skew are free.
    MeanDirection,
}

impl Parametrisation {
    /// Indices of the coordinates that move, where the BRDF and the view are symmetric in y and
    /// where they are not.
    pub fn free(self, symmetric: bool) -> &'static [usize] {
        match (self, symmetric) {
            (Self::Free, true) => &[0, 2, 3, 5, 7],
            (Self::Free, false) => &[0, 1, 2, 3, 4, 5, 6, 7],
            (Self::MeanDirection, true) => &[0, 2, 5],
            (Self::MeanDirection, false) => &[0, 1, 2, 5, 6],
        }
    }

    /// Sets the coordinates that do not move to what the node and the others demand.
    pub fn constrain(self, coordinates: &mut Coordinates, node: &Node) {
        if self == Self::MeanDirection {
            let limit = &node.limit;
            let by = limit.turn * DVec2::new(coordinates.0[5], coordinates.0[6]);
            // The cosine's axis, the matrix's third row, is the mean direction.
            let mean = turn(by) * limit.shading_to_peak * node.mean_direction;
            let tilt = mean.truncate() / mean.z.max(0.07);
            if limit.tilt > 0.0 {
                coordinates.0[3] = tilt.x / limit.tilt;
                coordinates.0[4] = tilt.y / limit.tilt;
            }
            coordinates.0[7] = node.albedo.ln();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        )
    }

    #[test]
    fn round_trip() {
        let limit = Limit::mirror([0.2, 0.05], view(1.1, 0.6));
        let coordinates = Coordinates([0.3, 0.1, -0.2, 0.7, 0.2, 0.4, -0.3, -0.1]);
        let mut ltc = coordinates.to_ltc(&limit);
        // What does not matter: a factor, and a turn about the cosine's axis.
        ltc.shading_to_cosine = 3.0 * DMat3::from_rotation_z(0.8) * ltc.shading_to_cosine;
        let back = Coordinates::from_ltc(&ltc, &limit);
        for (a, b) in coordinates.0.iter().zip(back.0) {
            assert!((a - b).abs() < 1e-11, "{coordinates:?} {back:?}");
        }
    }

    #[test]
    fn mirrors_agree_with_mirrored_views() {
        let alpha = [0.2, 0.05];
        let coordinates = Coordinates([0.3, 0.1, -0.2, 0.7, 0.2, 0.4, -0.3, -0.1]);
        let light = DVec3::new(-0.3, 0.4, 0.6).normalize();
        let here = coordinates.to_ltc(&Limit::mirror(alpha, view(0.9, 0.4)));
        let flip = DVec3::new(1.0, -1.0, 1.0);
        let there = coordinates
            .mirrored([1.0, -1.0])
            .to_ltc(&Limit::mirror(alpha, view(0.9, -0.4)));
        let (a, b) = (here.density(light), there.density(light * flip));
        assert!((a - b).abs() < 1e-12 * a, "{a} {b}");
    }
}
