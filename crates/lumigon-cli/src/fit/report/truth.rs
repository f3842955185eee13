//! The BRDF that a table stands for.

use std::sync::Arc;

use glam::DVec3;
use lumigon_fit::{Brdf, BrdfKind};

use super::light::Quad;

/// A BRDF at one place of a table, as weighted directions: polygon integrals are sums
/// of weights, with an error of about 3e-4 of the albedo (rms) at [`Truth::DIRECTIONS`].
pub(super) struct Truth {
    brdf: Arc<dyn Brdf>,
    view: DVec3,
    widths: [f64; 2],
    directions: Vec<Direction>,
    albedo: [f64; 2],
}

struct Direction {
    light: DVec3,
    /// With F = 1, and under the BRDF's second weight.
    weights: [f64; 2],
}

impl Truth {
    /// Directions that the report's numbers are measured with.
    pub(super) const DIRECTIONS: u32 = 17_711;

    /// `directions` may be 0 where only the density counts.
    pub(super) fn new(kind: BrdfKind, place: &[f64], directions: u32) -> Self {
        let (brdf, view) = kind.at(place);
        // Mean and half the difference of the logarithms of the limit lobe's widths.
        let [xx, xy, yy] = brdf.limit(view).ln_width;
        let (mean, spread) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let mut truth = Self {
            widths: [(mean - spread).exp(), (mean + spread).exp()],
            brdf,
            view,
            directions: Vec::new(),
            albedo: [0.0; 2],
        };
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let scale = 1.0 / f64::from(directions.max(1));
        for i in 0..directions {
            let u = [
                (f64::from(i) + 0.5) * scale,
                (f64::from(i) * golden).fract(),
            ];
            if let Some(sample) = truth.brdf.sample(truth.view, u) {
                let weight = sample.weight * scale;
                let secondary = truth.brdf.secondary(truth.view, sample.light);
                let weights = [weight, weight * secondary];
                truth.albedo[0] += weights[0];
                truth.albedo[1] += weights[1];
                truth.directions.push(Direction {
                    light: sample.light,
                    weights,
                });
            }
        }
        truth
    }

    /// Directional albedo, with F = 1 and under the second weight.
    pub(super) fn albedo(&self) -> [f64; 2] {
        self.albedo
    }

    /// About how wide the lobe is where it is narrowest and widest, in radians.
    pub(super) fn widths(&self) -> [f64; 2] {
        self.widths
    }

    /// Unit direction of the view.
    pub(super) fn view(&self) -> DVec3 {
        self.view
    }

    /// A direction towards the light, drawn from the BRDF.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<DVec3> {
        self.brdf.sample(self.view, u).map(|sample| sample.light)
    }

    /// Reflected density with F = 1 in 1/sr: the BRDF times the light's cosine.
    pub(super) fn density(&self, light: DVec3) -> f64 {
        self.brdf.eval(self.view, light)
    }

    /// Responses to a light of radiance 1.
    pub(super) fn response(&self, light: &Quad) -> [f64; 2] {
        let [a, b, c, d] = light.edge_planes();
        let mut sums = [0.0; 2];
        for direction in &self.directions {
            let w = direction.light;
            let inside = a.dot(w).min(b.dot(w)).min(c.dot(w)).min(d.dot(w)) > 0.0;
            let keep = if inside { 1.0 } else { 0.0 };
            sums[0] += keep * direction.weights[0];
            sums[1] += keep * direction.weights[1];
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::report::place::in_slice;

    /// The sum over directions against the midpoint rule over the density, for every BRDF.
    #[test]
    fn response_is_the_densitys_integral() {
        for kind in BrdfKind::ALL {
            let truth = Truth::new(kind, &in_slice(kind, 0.7, 0.8), Truth::DIRECTIONS);
            let light = Quad::facing(DVec3::new(-0.5, 0.1, 0.8).normalize(), 0.4);
            let planes = light.edge_planes();
            let n = 500;
            let (mut all, mut inside) = ([0.0; 2], 0.0);
            for i in 0..n {
                for j in 0..n {
                    let z = (f64::from(i) + 0.5) / f64::from(n);
                    let phi = std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(n);
                    let r = (1.0 - z * z).sqrt();
                    let w = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                    let value = truth.density(w) * std::f64::consts::TAU / f64::from(n * n);
                    all[0] += value;
                    all[1] += value * truth.brdf.secondary(truth.view, w);
                    if planes.iter().all(|plane| plane.dot(w) > 0.0) {
                        inside += value;
                    }
                }
            }
            let response = truth.response(&light)[0];
            for (sum, albedo) in all.into_iter().zip(truth.albedo()) {
                assert!((sum - albedo).abs() < 1e-3, "{kind:?}: {sum} {albedo}");
            }
            assert!(
                (inside - response).abs() < 2e-3,
                "{kind:?}: {inside} {response}"
            );
            assert!(response > 0.001, "{kind:?}: {response}");
        }
    }
}
