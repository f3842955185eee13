use std::sync::Arc;

use glam::DVec3;

use crate::{
    brdf::Brdf,
    lobe::Lobe,
    ltc::Ltc,
    node::Node,
    objective::{Objective, Residuals},
};

/// The published objective: the cubed absolute difference of the LTC's density and the BRDF,
/// integrated over directions drawn from both (Heitz et al. 2016, section 4; multiple importance
/// sampling with the balance heuristic).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Density {
    /// Directions from each of the two distributions.
    pub samples: u32,
}

impl Objective for Density {
    fn prepare(&self, node: &Node, _: &Lobe) -> Box<dyn Residuals> {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let lattice: Vec<[f64; 2]> = (0..self.samples)
            .map(|i| {
                [
                    (f64::from(i) + 0.5) / f64::from(self.samples),
                    (f64::from(i) * golden).fract(),
                ]
            })
            .collect();
        let brdf = Arc::clone(&node.brdf);
        let lights = lattice
            .iter()
            .map(|&u| brdf.sample(node.view, u).map(|s| s.light))
            .map(|light| light.map(|l| (l, brdf.eval(node.view, l), brdf.pdf(node.view, l))))
            .collect();
        Box::new(DensityResiduals {
            lattice,
            lights,
            brdf,
            view: node.view,
            schlick_albedo: node.schlick_albedo,
            // Dimensionless: errors count relative to the lobe's peak density.
            scale: node.alpha * node.alpha,
        })
    }
}

struct DensityResiduals {
    lattice: Vec<[f64; 2]>,
    /// Direction, BRDF value and density of the BRDF's own samples.
    lights: Vec<Option<(DVec3, f64, f64)>>,
    brdf: Arc<dyn Brdf>,
    view: DVec3,
    schlick_albedo: f64,
    scale: f64,
}

impl DensityResiduals {
    /// Its square is the cubed error over the samples' joint density.
    fn residual(&self, ltc: &Ltc, light: DVec3, value: f64, pdf: f64) -> f64 {
        let density = ltc.density(light);
        let joint = pdf + density;
        if joint <= 0.0 {
            return 0.0;
        }
        let error = self.scale * (ltc.amplitude * density - value);
        let per_sample = 1.0 / (self.scale * joint * self.lattice.len() as f64);
        (error.abs().powi(3) * per_sample).sqrt().copysign(error)
    }
}

impl Residuals for DensityResiduals {
    fn evaluate(&self, ltc: &Ltc, residuals: &mut Vec<f64>) {
        for light in &self.lights {
            residuals.push(match *light {
                Some((light, value, pdf)) => self.residual(ltc, light, value, pdf),
                None => 0.0,
            });
        }
        for &u in &self.lattice {
            let light = ltc.sample(u);
            let value = self.brdf.eval(self.view, light);
            let pdf = self.brdf.pdf(self.view, light);
            residuals.push(self.residual(ltc, light, value, pdf));
        }
    }

    fn schlick(&self, _: &Ltc) -> f64 {
        self.schlick_albedo
    }
}
