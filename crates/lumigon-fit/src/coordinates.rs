use serde::{Deserialize, Serialize};

use crate::{ltc::Ltc, node::Node};

/// The five numbers that a fit moves, chosen so that each is of order one at every node, varies
/// slowly over the table, and every value is a valid lobe (the determinant cannot change sign).
///
/// `shading_to_cosine = [[cos p / sx, 0, -sin p / sx], [0, 1 / sy, 0],
/// [sin p + t cos p, 0, cos p - t sin p]]`: p turns z into the lobe's peak, sx and sy are the
/// peak's widths, and t tilts the cosine's plane against the peak. The coordinates are
/// `[ln(sx / wx), ln(sy / wy), t / tan theta, (p - p_mirror) / alpha, ln(amplitude)]` with
/// [`Node::widths`] wx and wy. In the limit of small alpha the first four are 0, 0, 1, 0 and
/// exact: the cosine distribution around its peak *is* GGX's, `1 / (pi (1 + r^2)^2)`, and
/// `t = tan theta` lays the cosine's plane on the surface.
///
/// The published factors (Heitz et al. 2016, section 3.1: a frame about the mean direction, two
/// widths, one skew) span the same matrices, but there small alpha sends skew and frame to infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates(pub [f64; Coordinates::COUNT]);

impl Coordinates {
    /// How many there are.
    pub const COUNT: usize = 5;

    /// The limit of small alpha.
    pub fn mirror(node: &Node) -> Self {
        Self([0.0, 0.0, 1.0, 0.0, node.albedo.ln()])
    }

    /// The lobe at these coordinates of the node, its Schlick amplitude still 0.
    pub fn to_ltc(self, node: &Node) -> Ltc {
        let [ln_x, ln_y, tilt, turn, ln_amplitude] = self.0;
        let [wx, wy] = node.widths();
        // Wide enough never to bind, tight enough that no step overflows.
        let sx = wx * ln_x.clamp(-8.0, 8.0).exp();
        let sy = wy * ln_y.clamp(-8.0, 8.0).exp();
        let (sin, cos) = (node.alpha * turn - node.theta).sin_cos();
        let t = tilt * node.theta.tan();
        let ratio = sy / sx;
        Ltc {
            matrix: [
                ratio * cos,
                -ratio * sin,
                sy * (sin + t * cos),
                sy * (cos - t * sin),
            ],
            amplitude: ln_amplitude.clamp(-40.0, 5.0).exp(),
            schlick: 0.0,
        }
    }

    /// The coordinates at `-theta`, which is the same lobe seen from the other side.
    pub(crate) fn mirrored(mut self) -> Self {
        self.0[3] = -self.0[3];
        self
    }

    /// Inverse of [`Coordinates::to_ltc`] for a matrix of positive determinant and a positive
    /// amplitude. At `theta = 0` the tilt has no effect and is 1.
    pub fn from_ltc(ltc: &Ltc, node: &Node) -> Self {
        let [a, b, c, d] = ltc.matrix;
        let [wx, wy] = node.widths();
        let ratio = a.hypot(b);
        let (sin, cos) = (-b / ratio, a / ratio);
        let sy = d * cos + c * sin;
        let t = (c * cos - d * sin) / sy;
        let tan = node.theta.tan();
        Self([
            (sy / ratio / wx).ln(),
            (sy / wy).ln(),
            if tan > 0.0 { t / tan } else { 1.0 },
            (sin.atan2(cos) + node.theta) / node.alpha,
            ltc.amplitude.ln(),
        ])
    }
}

/// Which coordinates a fit may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Parametrisation {
    /// All five.
    Free,
    /// The published one: the frame follows the lobe's mean direction and the amplitude is the
    /// albedo; both widths and the skew are free.
    MeanDirection,
}

impl Parametrisation {
    /// Indices of the coordinates that move.
    pub fn free(self) -> &'static [usize] {
        match self {
            Self::Free => &[0, 1, 2, 3, 4],
            Self::MeanDirection => &[0, 1, 3],
        }
    }

    /// Sets the coordinates that do not move to what the node and the others demand.
    pub fn constrain(self, coordinates: &mut Coordinates, node: &Node) {
        if self == Self::MeanDirection {
            let mean = node.mean_direction;
            let peak = node.alpha * coordinates.0[3] - node.theta;
            // The cosine's axis, (sin p + t cos p, 0, cos p - t sin p), is the mean direction.
            let t = (mean.x.atan2(mean.z) - peak).clamp(-1.5, 1.5).tan();
            let tan = node.theta.tan();
            coordinates.0[2] = if tan > 0.0 { t / tan } else { 1.0 };
            coordinates.0[4] = node.albedo.ln();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::BrdfKind;

    #[test]
    fn round_trip() {
        let (node, _) = Node::new(BrdfKind::Ggx, 0.5, 0.4, 500);
        let coordinates = Coordinates([0.3, -0.2, 0.7, 0.4, -0.1]);
        let back = Coordinates::from_ltc(&coordinates.to_ltc(&node), &node);
        for (a, b) in coordinates.0.iter().zip(back.0) {
            assert!((a - b).abs() < 1e-12, "{coordinates:?} {back:?}");
        }
    }

    /// The mirror lobe peaks in the mirrored view direction, of which x is negative.
    #[test]
    fn mirror_direction() {
        let (node, _) = Node::new(BrdfKind::Ggx, 0.1, 0.6, 500);
        let ltc = Coordinates::mirror(&node).to_ltc(&node);
        let peak = glam::DVec3::new(-node.theta.sin(), 0.0, node.theta.cos());
        let cosine = (ltc.shading_to_cosine() * peak).normalize();
        assert!((cosine - glam::DVec3::Z).length() < 1e-12, "{cosine}");
    }
}
