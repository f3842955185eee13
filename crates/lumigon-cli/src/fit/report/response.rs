//! What a fitted table answers.

use std::f64::consts::TAU;

use glam::DVec3;
use lumigon_fit::{Ltc, Table};

use super::light::Quad;

/// A table's lobes at one place: a response is their sum.
#[derive(Clone, Debug)]
pub(super) struct Lobes(Vec<Ltc>);

impl Lobes {
    /// Looks them up.
    pub(super) fn look_up(table: &Table, place: &[f64]) -> Self {
        Self(table.lookup_at(place))
    }

    /// Reflected density with F = 1 towards a unit direction in 1/sr; 0 below the horizon.
    pub(super) fn density(&self, light: DVec3) -> f64 {
        if light.z <= 0.0 {
            return 0.0;
        }
        let densities = self.0.iter().map(|ltc| ltc.amplitude * ltc.density(light));
        densities.sum()
    }

    /// Responses to a light of radiance 1, clipped as a renderer clips it: at the surface's
    /// horizon and where the lobe ends.
    pub(super) fn response(&self, light: &Quad) -> [f64; 2] {
        let above = clip(&light.vertices, DVec3::Z);
        let mut sum = [0.0; 2];
        for lobe in &self.0 {
            let seen: Vec<DVec3> = above.iter().map(|&v| lobe.shading_to_cosine * v).collect();
            let form_factor = form_factor(&clip(&seen, DVec3::Z));
            for (sum, amplitude) in sum.iter_mut().zip([lobe.amplitude, lobe.secondary]) {
                *sum += amplitude * form_factor;
            }
        }
        sum
    }

    /// Directional albedo: the responses to the whole hemisphere above the horizon.
    pub(super) fn albedo(&self) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for ltc in &self.0 {
            let share = ltc.share_above_horizon();
            sum[0] += ltc.amplitude * share;
            sum[1] += ltc.secondary * share;
        }
        sum
    }

    /// Share of the lobes that lies below the horizon, where clipping cuts it off.
    pub(super) fn leaked(&self) -> f64 {
        let total: f64 = self.0.iter().map(|ltc| ltc.amplitude).sum();
        if total > 0.0 {
            (1.0 - self.albedo()[0] / total).max(0.0)
        } else {
            0.0
        }
    }
}

/// The part of a convex polygon with `plane . v > 0` (Sutherland and Hodgman 1974).
fn clip(polygon: &[DVec3], plane: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (da, db) = (plane.dot(a), plane.dot(b));
        if da > 0.0 {
            kept.push(a);
        }
        if (da > 0.0) != (db > 0.0) {
            kept.push(a + (da / (da - db)) * (b - a));
        }
    }
    kept
}

/// Lambert's sum over the edges of a polygon above z = 0, counter-clockwise seen from the origin.
fn form_factor(polygon: &[DVec3]) -> f64 {
    let edges = polygon.iter().enumerate().map(|(i, &a)| {
        let b = polygon[(i + 1) % polygon.len()];
        let normal = a.cross(b);
        let sine = normal.length();
        if sine > 0.0 {
            -normal.z * sine.atan2(a.dot(b)) / sine
        } else {
            0.0
        }
    });
    (edges.sum::<f64>() / TAU).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    fn skewed() -> Lobes {
        Lobes(vec![
            Ltc {
                shading_to_cosine: DMat3::from_cols(
                    DVec3::new(1.3, 0.1, -0.3),
                    DVec3::Y,
                    DVec3::new(0.6, 0.0, 0.5),
                ),
                amplitude: 0.7,
                secondary: 0.1,
            },
            Ltc {
                shading_to_cosine: DMat3::IDENTITY,
                amplitude: 0.2,
                secondary: 0.05,
            },
        ])
    }

    /// Albedo, response and density are three views of one function: the midpoint rule over the
    /// density agrees with both closed forms.
    #[test]
    fn density_response_and_albedo_agree() {
        let light = Quad::facing(DVec3::new(-0.6, 0.2, 0.5).normalize(), 0.7);
        let planes = light.edge_planes();
        let n = 700;
        let (mut all, mut inside) = (0.0, 0.0);
        for i in 0..n {
            for j in 0..n {
                let z = (f64::from(i) + 0.5) / f64::from(n);
                let phi = TAU * (f64::from(j) + 0.5) / f64::from(n);
                let r = (1.0 - z * z).sqrt();
                let direction = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                let value = skewed().density(direction) * TAU / f64::from(n * n);
                all += value;
                if planes.iter().all(|plane| plane.dot(direction) > 0.0) {
                    inside += value;
                }
            }
        }
        assert!((all - skewed().albedo()[0]).abs() < 1e-4, "{all}");
        assert!(
            (inside - skewed().response(&light)[0]).abs() < 2e-4,
            "{inside}"
        );
        assert!(inside > 0.1);
        let leaked = 1.0 - all / 0.9;
        assert!(leaked > 0.005 && (skewed().leaked() - leaked).abs() < 1e-3);
    }

    #[test]
    fn nothing_comes_from_below() {
        let below = Quad::facing(DVec3::new(0.3, 0.0, -0.9).normalize(), 0.2);
        assert_eq!(skewed().response(&below), [0.0; 2]);
        assert_eq!(skewed().density(DVec3::new(0.6, 0.0, -0.8)), 0.0);
    }
}
