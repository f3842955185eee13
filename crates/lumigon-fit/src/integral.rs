use std::rc::Rc;

use glam::{DMat3, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg32;

use crate::{
    form_factor::{Clipped, form_factor},
    lobe::Lobe,
    ltc::Ltc,
    node::Node,
    objective::{Objective, Residuals},
    polygon::Quad,
};

/// Weight of amplitudes above 1 in all, relative to the furnace's.
const ENERGY: f64 = 10.0;

/// Weight of the cosine's amplitude among the residuals. A broad lobe and the cosine can stand for
/// each other; without a price on one of them neighbours share the work differently, and between
/// them the table is wrong.
const RESTRAINT: f64 = 0.2;

/// Most lobes of a sum.
const MAX_LOBES: usize = 3;

/// Fits the integrals themselves: the relative error `(table - truth) / (truth + floor)` over random
/// polygonal lights, clipped by the true horizon and by the cosine's own plane as a renderer does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integral {
    /// Training lights.
    pub samples: u32,
    /// Seed of the training lights. All nodes share it: common random numbers make the fits of
    /// neighbours vary smoothly.
    pub seed: u64,
    /// Added to a response in the denominator of its relative error: below, errors count as
    /// absolute.
    pub floor: f64,
    /// Weight of the white furnace, relative to all lights together.
    pub furnace: f64,
    /// Weight of the responses under the second weight beside those with F = 1.
    pub secondary: f64,
    /// The last lobe is the clamped cosine itself, whose form factor a renderer has at hand from
    /// its diffuse light: its amplitude is solved for.
    pub cosine: bool,
}

impl Objective for Integral {
    fn prepare(&self, node: &Node, lobe: &Lobe) -> Box<dyn Residuals> {
        let mut rng = Pcg32::seed_from_u64(self.seed);
        let lights = (0..self.samples)
            .map(|_| {
                let quad = Quad::random(&mut rng, node);
                let [truth, secondary_truth] = lobe.response(&quad);
                let visible = Clipped::new(quad.vertices).clip(DVec3::Z);
                Light {
                    vertices: visible.vertices().iter().map(|v| v.as_vec3()).collect(),
                    truth: truth as f32,
                    secondary_truth: secondary_truth as f32,
                }
            })
            .collect();
        Box::new(IntegralResiduals {
            lights,
            albedo: node.albedo,
            secondary_albedo: node.secondary_albedo,
            objective: *self,
        })
    }
}

/// A light above the horizon with its true responses; f32 because a table has thousands of nodes.
struct Light {
    vertices: Box<[glam::Vec3]>,
    truth: f32,
    secondary_truth: f32,
}

struct IntegralResiduals {
    lights: Vec<Light>,
    albedo: f64,
    secondary_albedo: f64,
    objective: Integral,
}

impl IntegralResiduals {
    /// Of each light, under each lobe.
    fn form_factors(&self, parts: &[Rc<Vec<f64>>]) -> Vec<[f64; MAX_LOBES]> {
        let mut form_factors = vec![[0.0; MAX_LOBES]; self.lights.len()];
        for (lobe, part) in parts.iter().enumerate() {
            for (of_light, &value) in form_factors.iter_mut().zip(part.iter()) {
                of_light[lobe] = value;
            }
        }
        form_factors
    }

    fn shares(lobes: &[Ltc]) -> [f64; MAX_LOBES] {
        let mut shares = [0.0; MAX_LOBES];
        for (share, lobe) in shares.iter_mut().zip(lobes) {
            *share = lobe.share_above_horizon();
        }
        shares
    }

    /// Non-negative linear least squares of the second amplitudes over the same lights and furnace:
    /// unknowns solved for in closed form at every set of lobes.
    fn best_secondary(
        &self,
        form_factors: &[[f64; MAX_LOBES]],
        shares: &[f64; MAX_LOBES],
        count: usize,
    ) -> [f64; MAX_LOBES] {
        let mut normal = Normal::default();
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        let floor = self.objective.floor;
        for (values, light) in form_factors.iter().zip(&self.lights) {
            let truth = f64::from(light.secondary_truth);
            normal.add(values, truth, per_light / (truth + floor));
        }
        let weight = self.objective.furnace / (self.secondary_albedo + floor);
        normal.add(shares, self.secondary_albedo, weight);
        normal.solve(count)
    }
}

/// Normal equations of a linear least squares problem of a few unknowns.
#[derive(Default)]
struct Normal {
    matrix: [[f64; MAX_LOBES]; MAX_LOBES],
    right: [f64; MAX_LOBES],
}

impl Normal {
    fn add(&mut self, values: &[f64; MAX_LOBES], truth: f64, weight: f64) {
        let squared = weight * weight;
        for i in 0..MAX_LOBES {
            self.right[i] += squared * values[i] * truth;
            for j in 0..MAX_LOBES {
                self.matrix[i][j] += squared * values[i] * values[j];
            }
        }
    }

    /// The best solution without negative entries among the first `count` unknowns: of every
    /// subset's the one that explains most (there are at most seven subsets).
    fn solve(&self, count: usize) -> [f64; MAX_LOBES] {
        let mut best = ([0.0; MAX_LOBES], 0.0);
        for subset in 1..(1_usize << count) {
            let unknowns: Vec<usize> = (0..count).filter(|i| subset & (1 << i) != 0).collect();
            let Some(solution) = self.solve_for(&unknowns) else {
                continue;
            };
            if solution.iter().any(|&x| x < 0.0) {
                continue;
            }
            // Of the least squares solution: x . right is what the residuals lose.
            let gain: f64 = solution.iter().zip(self.right).map(|(x, r)| x * r).sum();
            if gain > best.1 {
                best = (solution, gain);
            }
        }
        best.0
    }

    fn solve_for(&self, unknowns: &[usize]) -> Option<[f64; MAX_LOBES]> {
        let n = unknowns.len();
        let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| {
            let value = self.matrix[unknowns[i]][unknowns[j]];
            // Two lobes alike share their amplitude instead of cancelling each other.
            if i == j { value * (1.0 + 1e-6) } else { value }
        });
        let right = nalgebra::DVector::from_fn(n, |i, _| self.right[unknowns[i]]);
        let solved = matrix.cholesky()?.solve(&right);
        let mut solution = [0.0; MAX_LOBES];
        for (&i, &x) in unknowns.iter().zip(solved.iter()) {
            solution[i] = x;
        }
        Some(solution)
    }
}

impl IntegralResiduals {
    fn amplitudes(
        &self,
        lobes: &[Ltc],
        form_factors: &[[f64; MAX_LOBES]],
        shares: &[f64; MAX_LOBES],
    ) -> [f64; MAX_LOBES] {
        let mut amplitudes = [0.0; MAX_LOBES];
        for (amplitude, lobe) in amplitudes.iter_mut().zip(lobes) {
            *amplitude = lobe.amplitude;
        }
        if !self.objective.cosine {
            return amplitudes;
        }
        let last = lobes.len() - 1;
        amplitudes[last] = 0.0;
        let (mut numerator, mut denominator) = (0.0, RESTRAINT * RESTRAINT);
        let mut add = |values: &[f64; MAX_LOBES], truth: f64, weight: f64| {
            let left = truth - dot(values, &amplitudes);
            numerator += weight * weight * values[last] * left;
            denominator += weight * weight * values[last] * values[last];
        };
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        for (values, light) in form_factors.iter().zip(&self.lights) {
            let truth = f64::from(light.truth);
            add(values, truth, per_light / (truth + self.objective.floor));
        }
        add(shares, self.albedo, self.objective.furnace / self.albedo);
        amplitudes[last] = (numerator / denominator.max(1e-300)).max(0.0);
        amplitudes
    }
}

fn dot(values: &[f64; MAX_LOBES], amplitudes: &[f64; MAX_LOBES]) -> f64 {
    values.iter().zip(amplitudes).map(|(v, a)| v * a).sum()
}

impl Residuals for IntegralResiduals {
    /// Form factors of all lights.
    fn of_matrix(&self, matrix: &DMat3) -> Vec<f64> {
        let of_light = |light: &Light| {
            let vertices = light.vertices.iter().map(|v| *matrix * v.as_dvec3());
            form_factor(&Clipped::new(vertices))
        };
        self.lights.iter().map(of_light).collect()
    }

    fn evaluate(&self, lobes: &[Ltc], parts: &[Rc<Vec<f64>>], residuals: &mut Vec<f64>) {
        let Integral {
            floor,
            furnace,
            secondary,
            ..
        } = self.objective;
        let form_factors = self.form_factors(parts);
        let shares = Self::shares(lobes);
        let amplitudes = self.amplitudes(lobes, &form_factors, &shares);
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        for (values, light) in form_factors.iter().zip(&self.lights) {
            let truth = f64::from(light.truth);
            residuals.push(per_light * (dot(values, &amplitudes) - truth) / (truth + floor));
        }
        if secondary > 0.0 && self.secondary_albedo > 0.0 {
            let second = self.best_secondary(&form_factors, &shares, lobes.len());
            let weight = secondary * per_light;
            for (values, light) in form_factors.iter().zip(&self.lights) {
                let truth = f64::from(light.secondary_truth);
                residuals.push(weight * (dot(values, &second) - truth) / (truth + floor));
            }
        }
        residuals.push(furnace * (dot(&shares, &amplitudes) / self.albedo - 1.0));
        // Amplitudes above 1 can be right at a texel whose lobe dips below the horizon and still
        // make energy between texels, where the two interpolate apart.
        if self.objective.cosine {
            residuals.push(RESTRAINT * amplitudes[lobes.len() - 1]);
        }
        let excess = (amplitudes.iter().sum::<f64>() - 1.0).max(0.0);
        residuals.push(furnace * ENERGY * excess);
    }

    fn complete(&self, lobes: &mut [Ltc], parts: &[Rc<Vec<f64>>]) {
        let form_factors = self.form_factors(parts);
        let shares = Self::shares(lobes);
        let amplitudes = self.amplitudes(lobes, &form_factors, &shares);
        let second = self.best_secondary(&form_factors, &shares, lobes.len());
        for (i, lobe) in lobes.iter_mut().enumerate() {
            lobe.amplitude = amplitudes[i];
            lobe.secondary = second[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_without_negative_amplitudes() {
        let mut normal = Normal::default();
        // x + y = 1 and x - y = 3 want y = -1: without it x = 2.
        normal.add(&[1.0, 1.0, 0.0], 1.0, 1.0);
        normal.add(&[1.0, -1.0, 0.0], 3.0, 1.0);
        let [x, y, z] = normal.solve(2);
        assert!((x - 2.0).abs() < 1e-5 && y == 0.0 && z == 0.0, "{x} {y}");
        normal.add(&[0.0, 1.0, 0.0], 4.0, 10.0);
        let [_, y, _] = normal.solve(2);
        assert!(y > 3.0, "{y}");
    }
}
