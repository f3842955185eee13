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
}

impl Objective for Integral {
    fn prepare(&self, node: &Node, lobe: &Lobe) -> Box<dyn Residuals> {
        let mut rng = Pcg32::seed_from_u64(self.seed);
        let lights = (0..self.samples)
            .map(|_| {
                let quad = Quad::random(&mut rng, node.brdf.as_ref(), node.view, node.alpha);
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
}

impl IntegralResiduals {
    fn form_factors(&self, ltc: &Ltc) -> impl Iterator<Item = (f64, &Light)> {
        let shading_to_cosine = ltc.shading_to_cosine();
        self.lights.iter().map(move |light| {
            let vertices = light
                .vertices
                .iter()
                .map(|v| shading_to_cosine * v.as_dvec3());
            (form_factor(&Clipped::new(vertices)), light)
        })
    }
}

impl Residuals for IntegralResiduals {
    fn evaluate(&self, ltc: &Ltc, residuals: &mut Vec<f64>) {
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        residuals.extend(self.form_factors(ltc).map(|(form_factor, light)| {
            let truth = f64::from(light.truth);
            per_light * (ltc.amplitude * form_factor - truth) / (truth + FLOOR)
        }));
        let furnace = ltc.amplitude * ltc.share_above_horizon() / self.albedo.max(1e-6);
        residuals.push(self.furnace * (furnace - 1.0));
    }

    /// Linear least squares over the same lights and furnace.
    fn schlick(&self, ltc: &Ltc) -> f64 {
        let (mut numerator, mut denominator) = (0.0, 0.0);
        let mut add = |value: f64, truth: f64, weight: f64| {
            numerator += weight * weight * value * truth;
            denominator += weight * weight * value * value;
        };
        // The floor scales with the term itself, which is small away from grazing views.
        let floor = FLOOR * self.schlick_albedo.max(1e-12);
        let per_light = 1.0 / (self.lights.len() as f64).sqrt();
        for (form_factor, light) in self.form_factors(ltc) {
            let truth = f64::from(light.schlick_truth);
            add(form_factor, truth, per_light / (truth + floor));
        }
        let furnace = self.furnace / self.schlick_albedo.max(1e-12);
        add(ltc.share_above_horizon(), self.schlick_albedo, furnace);
        if denominator > 0.0 {
            numerator / denominator
        } else {
            0.0
        }
    }
}
