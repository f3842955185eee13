use glam::DVec3;
use rand::{Rng, RngExt};

use crate::node::Node;

/// A convex training light of at most four vertices as seen from the shaded point: shading space,
/// counter-clockwise seen from that point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quad {
    pub(crate) vertices: [DVec3; 4],
}

impl Quad {
    /// Draws a light: three in four are placed so that a direction of the BRDF's own lobe passes
    /// through or just beside them (every other one on the outline, where a light says most about
    /// the lobe's shape), the others look anywhere, also below the horizon. Sizes run
    /// log-uniformly from about the lobe's width to three times the distance.
    pub(crate) fn random(rng: &mut impl Rng, node: &Node) -> Self {
        let u: [f64; 8] = std::array::from_fn(|_| rng.random());
        let aimed = u[0] < 0.75;
        // Every draw consumes the same count of numbers, so that the lights of neighbouring
        // nodes change smoothly and with them the fit.
        let lobe = node.brdf.sample(node.view, [u[1], u[2]]).map(|s| s.light);
        let anywhere = {
            let z = 1.1 * u[1] - 0.1;
            let (sin, cos) = (std::f64::consts::TAU * u[2]).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            DVec3::new(r * cos, r * sin, z)
        };
        let direction = if aimed {
            lobe.unwrap_or(anywhere)
        } else {
            anywhere
        };
        let smallest = if aimed {
            (0.5 * node.limit.narrowest()).min(0.1)
        } else {
            0.05
        };
        let half = smallest * (3.0_f64 / smallest).powf(u[3]);
        let aspect = 2.0_f64.powf(2.0 * u[4] - 1.0);
        // A plane tilted by up to about 60 degrees from facing the point.
        let tilt: [f64; 3] = std::array::from_fn(|_| rng.random::<f64>() * 2.0 - 1.0);
        let normal = (-direction + 0.8 * DVec3::from_array(tilt)).normalize_or(-direction);
        let normal = if normal.dot(direction) > -0.2 {
            -direction
        } else {
            normal
        };
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let (sin, cos) = (std::f64::consts::TAU * u[5]).sin_cos();
        let edge_x = half * aspect * (cos * x + sin * y);
        let edge_y = half / aspect * (cos * y - sin * x);
        // Where the aim meets the light: on the outline, or inside and just beside it.
        let [s, t] = [2.0 * u[6] - 1.0, 2.0 * u[7] - 1.0];
        let [s, t] = if u[0] < 0.375 {
            [1.0, t]
        } else {
            [1.3 * s, 1.3 * t]
        };
        let centre = direction - s * edge_x - t * edge_y;
        // Counter-clockwise about the normal, which faces the point.
        Self {
            vertices: [
                centre - edge_x - edge_y,
                centre + edge_x - edge_y,
                centre + edge_x + edge_y,
                centre - edge_x + edge_y,
            ],
        }
    }

    /// Inward normals of the planes through the point and each edge: a direction `w` lies inside
    /// where all four dot products are positive. Unit length.
    pub(crate) fn edge_planes(&self) -> [DVec3; 4] {
        let v = &self.vertices;
        std::array::from_fn(|i| -v[i].cross(v[(i + 1) % 4]).normalize_or_zero())
    }
}
