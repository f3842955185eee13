use serde::{Deserialize, Serialize};

use crate::{ltc::Ltc, node::Node};

/// The five numbers that a fit moves, chosen so that each is of order one at every node, varies
/// slowly over the table, and every value is a valid lobe (the determinant cannot change sign).
///
/// `M = rotation_y(phi) [[sx, 0, sx k], [0, sy, 0], [0, 0, 1]]` (Heitz et al. 2016, section 3.1) with
/// `[ln(sx / alpha), ln(sy / alpha), k, (phi - phi_mirror) / alpha, ln(amplitude)]`,
/// where `phi_mirror` turns z into the mirrored view direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates(pub [f64; Coordinates::COUNT]);

impl Coordinates {
    /// How many there are.
    pub const COUNT: usize = 5;

    /// A lobe about the mirror direction, as wide as the microfacet distribution.
    pub fn mirror(node: &Node) -> Self {
        Self([0.0, 0.0, 0.0, 0.0, node.albedo.ln()])
    }

    /// The lobe at these coordinates of the node, its Schlick amplitude still 0.
    pub fn to_ltc(self, node: &Node) -> Ltc {
        let [ln_x, ln_y, k, turn, ln_amplitude] = self.0;
        // Wide enough never to bind, tight enough that no step overflows.
        let sx = node.alpha * ln_x.clamp(-8.0, 8.0).exp();
        let sy = node.alpha * ln_y.clamp(-8.0, 8.0).exp();
        let (sin, cos) = (node.alpha * turn - node.theta).sin_cos();
        // M^-1 sy = diag(sy/sx, 1, sy) [[1, 0, -sx k], [0, 1, 0], [0, 0, 1]] rotation^T.
        let ratio = sy / sx;
        Ltc {
            matrix: [
                ratio * cos - sy * k * sin,
                -ratio * sin - sy * k * cos,
                sy * sin,
                sy * cos,
            ],
            amplitude: ln_amplitude.clamp(-40.0, 5.0).exp(),
            schlick: 0.0,
        }
    }

    /// Inverse of [`Coordinates::to_ltc`] for an invertible matrix and a positive amplitude.
    pub fn from_ltc(ltc: &Ltc, node: &Node) -> Self {
        let [a, b, c, d] = ltc.matrix;
        let sy = c.hypot(d);
        let (sin, cos) = (c / sy, d / sy);
        let ratio = a * cos - b * sin;
        let k = -(a * sin + b * cos) / sy;
        let mut turn = sin.atan2(cos) + node.theta;
        if turn > std::f64::consts::PI {
            turn -= std::f64::consts::TAU;
        }
        Self([
            (sy / ratio / node.alpha).ln(),
            (sy / node.alpha).ln(),
            k,
            turn / node.alpha,
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
            Self::MeanDirection => &[0, 1, 2],
        }
    }

    /// Sets the coordinates that do not move to what the node demands.
    pub fn constrain(self, coordinates: &mut Coordinates, node: &Node) {
        if self == Self::MeanDirection {
            let mean = node.mean_direction;
            let mut turn = mean.x.atan2(mean.z) + node.theta;
            if turn.abs() < 1e-12 {
                turn = 0.0;
            }
            coordinates.0[3] = turn / node.alpha;
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
        let coordinates = Coordinates([0.3, -0.2, 0.7, 1.4, -0.1]);
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
