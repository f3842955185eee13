use glam::DVec3;
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

/// Added to a response in the denominator of its relative error: below, errors count as absolute.
const FLOOR: f64 = 0.05;

/// Weight of an amplitude above 1, relative to the furnace's.
const ENERGY: f64 = 10.0;

/// Fits the integrals themselves: the relative error `(table - truth) / (truth + 0.05)` over random
/// polygonal lights, clipped by the true horizon and by the cosine's own plane as a renderer does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integral {
    /// Training lights.
    pub samples: u32,
    /// Seed of the training lights. All nodes share it: common random numbers make the fits of
    /// neighbours vary smoothly.
    pub seed: u64,
    /// Weight of the white furnace, relative to all lights together.
    pub furnace: f64,
    /// Weight of the Schlick-weighted responses beside those with F = 1. They share one matrix.
    pub schlick: f64,
}

impl Objective for Integral {
    fn prepare(&self, node: &Node, lobe: &Lobe) -> Box<dyn Residuals> {
        let mut rng = Pcg32::seed_from_u64(self.seed);
        let lights = (0..self.samples)
            .map(|_| {
                let quad = Quad::random(&mut rng, node);
                let [truth, schlick_truth] = lobe.response(&quad);
                let visible = Clipped::new(quad.vertices).clip(DVec3::Z);
                Light {
                    vertices: visible.vertices().iter().map(|v| v.as_vec3()).collect(),
                    truth: truth as f32,
                    schlick_truth: schlick_truth as f32,
                }
            })
            .collect();
        Box::new(IntegralResiduals {
            lights,
            albedo: node.albedo,
            schlick_albedo: node.schlick_albedo,
            furnace: self.furnace,
            schlick: self.schlick,
        })
    }
}

/// A light above the horizon with its true responses; f32 because a table has 4096 nodes.
struct Light {
    vertices: Box<[glam::Vec3]>,
    truth: f32,
    schlick_truth: f32,
}

struct IntegralResiduals {
    lights: Vec<Light>,
    albedo: f64,
    schlick_albedo: f64,
    furnace: f64,
    schlick: f64,
}

impl IntegralResiduals {
    fn form_factors(&self, ltc: &Ltc) -> impl Iterator<Item = f64> {
        let shading_to_cosine = ltc.shading_to_cosine();
        self.lights.iter().map(move |light| {
            let vertices = light
                .vertices
                .iter()
                .map(|v| shading_to_cosine * v.as_dvec3());
            form_factor(&Clipped::new(vertices))
        })
    }

    /// Linear least squares of the Schlick amplitude over the same lights and furnace: the sixth
    /// unknown, solved for in closed form at every lobe.
    fn best_schlick(&self, form_factors: &[f64], ltc: &Ltc) -> f64 {
        let (mut numerator, mut denominator) = (0.0, 0.0);
        let mut add = |value: f64, truth: f64, weight: f64| {
            numerator += weight * weight * value * truth;
            denominator += weight * weight * value * value;
        };
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        for (form_factor, light) in form_factors.iter().zip(&self.lights) {
            let truth = f64::from(light.schlick_truth);
            add(*form_factor, truth, per_light / (truth + FLOOR));
        }
        let furnace = self.furnace / (self.schlick_albedo + FLOOR);
        add(ltc.share_above_horizon(), self.schlick_albedo, furnace);
        if denominator > 0.0 {
            numerator / denominator
        } else {
            0.0
        }
    }
}

impl Residuals for IntegralResiduals {
    fn evaluate(&self, ltc: &Ltc, residuals: &mut Vec<f64>) {
        let form_factors: Vec<f64> = self.form_factors(ltc).collect();
        let schlick = self.best_schlick(&form_factors, ltc);
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        for (form_factor, light) in form_factors.iter().zip(&self.lights) {
            let truth = f64::from(light.truth);
            residuals.push(per_light * (ltc.amplitude * form_factor - truth) / (truth + FLOOR));
        }
        if self.schlick > 0.0 {
            let weight = self.schlick * per_light;
            for (form_factor, light) in form_factors.iter().zip(&self.lights) {
                let truth = f64::from(light.schlick_truth);
                residuals.push(weight * (schlick * form_factor - truth) / (truth + FLOOR));
            }
        }
        let furnace = ltc.amplitude * ltc.share_above_horizon() / self.albedo;
        residuals.push(self.furnace * (furnace - 1.0));
        // An amplitude above 1 can be right at a texel whose lobe dips below the horizon and still
        // make energy between texels, where the two interpolate apart.
        residuals.push(self.furnace * ENERGY * (ltc.amplitude - 1.0).max(0.0));
    }

    fn schlick(&self, ltc: &Ltc) -> f64 {
        let form_factors: Vec<f64> = self.form_factors(ltc).collect();
        self.best_schlick(&form_factors, ltc)
    }
}
