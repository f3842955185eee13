//! Lights to measure with.

use glam::DVec3;
use rand::{Rng, RngExt};

use super::truth::Truth;

/// A rectangle as the shaded point sees it: shading space, counter-clockwise seen from there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quad {
    pub(super) vertices: [DVec3; 4],
}

impl Quad {
    /// A square around a unit direction at distance 1, facing the point, `2 half` a side.
    #[cfg(test)]
    pub(super) fn facing(direction: DVec3, half: f64) -> Self {
        let x = direction.any_orthonormal_vector();
        Self::new(direction, half * x, half * direction.cross(x))
    }

    /// A rectangle by its centre and half its edges.
    pub(super) fn new(centre: DVec3, half_x: DVec3, half_y: DVec3) -> Self {
        let mut vertices = [
            centre - half_x - half_y,
            centre + half_x - half_y,
            centre + half_x + half_y,
            centre - half_x + half_y,
        ];
        // Towards the point: the edges turn the other way than seen from behind.
        if half_x.cross(half_y).dot(centre) > 0.0 {
            vertices.reverse();
        }
        Self { vertices }
    }

    /// Draws a light: three in four are placed so that a direction of the BRDF's own lobe passes
    /// through or just beside them, the others look anywhere above and a little below the horizon.
    /// Sizes run log-uniformly from half the lobe's width to twice the distance.
    pub(super) fn random(rng: &mut impl Rng, truth: &Truth) -> Self {
        let mut unit = || rng.random::<f64>();
        let aimed = (unit() < 0.75)
            .then(|| truth.sample([unit(), unit()]))
            .flatten();
        let direction = aimed.unwrap_or_else(|| {
            let z = 1.1 * unit() - 0.1;
            let (sin, cos) = (std::f64::consts::TAU * unit()).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            DVec3::new(r * cos, r * sin, z)
        });
        let smallest = match aimed {
            Some(_) => (0.5 * truth.widths()[0]).min(0.1),
            None => 0.05,
        };
        let half = smallest * (2.0 / smallest).powf(unit());
        let aspect = 2.0_f64.powf(2.0 * unit() - 1.0);
        let tilt = DVec3::from_array(std::array::from_fn(|_| 2.0 * unit() - 1.0));
        let normal = (direction + 0.8 * tilt).normalize_or(direction);
        let normal = if normal.dot(direction) < 0.2 {
            direction
        } else {
            normal
        };
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let (sin, cos) = (std::f64::consts::TAU * unit()).sin_cos();
        let half_x = half * aspect * (cos * x + sin * y);
        let half_y = half / aspect * (cos * y - sin * x);
        let [s, t] = [2.6 * unit() - 1.3, 2.6 * unit() - 1.3];
        Self::new(direction - s * half_x - t * half_y, half_x, half_y)
    }

    /// Inward normals of the planes through the point and each edge: a direction lies inside where
    /// all four dot products are positive.
    pub(super) fn edge_planes(&self) -> [DVec3; 4] {
        let v = &self.vertices;
        std::array::from_fn(|i| v[(i + 1) % 4].cross(v[i]).normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use lumigon_fit::BrdfKind;
    use rand::SeedableRng;
    use rand_pcg::Pcg32;

    use super::*;
    use crate::fit::report::place::in_slice;

    #[test]
    fn the_centre_is_inside_whatever_the_orientation() {
        let centre = DVec3::new(0.3, -0.2, 1.0);
        for (x, y) in [(DVec3::X, DVec3::Y), (DVec3::Y, DVec3::X)] {
            let planes = Quad::new(centre, 0.1 * x, 0.2 * y).edge_planes();
            assert!(planes.iter().all(|plane| plane.dot(centre) > 0.0));
        }
    }

    #[test]
    fn most_lights_matter() {
        let truth = Truth::new(BrdfKind::Ggx, &in_slice(BrdfKind::Ggx, 0.4, 0.9), 2000);
        let mut rng = Pcg32::seed_from_u64(3);
        let lights = (0..400).map(|_| Quad::random(&mut rng, &truth));
        let lit = lights
            .filter(|light| truth.response(light)[0] > 1e-3)
            .count();
        assert!(lit > 200, "{lit}");
    }
}
