use std::{rc::Rc, sync::Arc};

use glam::{DMat3, DVec3};

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
            secondary_albedo: node.secondary_albedo,
            // Dimensionless: errors count relative to the lobe's peak density.
            scale: node.limit.scale * node.limit.scale,
        })
    }
}

struct DensityResiduals {
    lattice: Vec<[f64; 2]>,
    /// Direction, BRDF value and density of the BRDF's own samples.
    lights: Vec<Option<(DVec3, f64, f64)>>,
    brdf: Arc<dyn Brdf>,
    view: DVec3,
    secondary_albedo: f64,
    scale: f64,
}

impl DensityResiduals {
    /// Its square is the cubed error over the samples' joint density.
    fn residual(&self, lobes: &[Ltc], light: DVec3, value: f64, pdf: f64) -> f64 {
        let total: f64 = lobes
            .iter()
            .map(|lobe| lobe.amplitude * lobe.density(light))
            .sum();
        // The lobes' own samples, in equal numbers.
        let own = lobes.iter().map(|lobe| lobe.density(light)).sum::<f64>() / lobes.len() as f64;
        let joint = pdf + own;
        if joint <= 0.0 {
            return 0.0;
        }
        let error = self.scale * (total - value);
        let per_sample = 1.0 / (self.scale * joint * self.lattice.len() as f64);
        (error.abs().powi(3) * per_sample).sqrt().copysign(error)
    }
}

impl Residuals for DensityResiduals {
    fn of_matrix(&self, _: &DMat3) -> Vec<f64> {
        Vec::new()
    }

    fn evaluate(&self, lobes: &[Ltc], _: &[Rc<Vec<f64>>], residuals: &mut Vec<f64>) {
        for light in &self.lights {
            residuals.push(match *light {
                Some((light, value, pdf)) => self.residual(lobes, light, value, pdf),
                None => 0.0,
            });
        }
        for (i, &u) in self.lattice.iter().enumerate() {
            let light = lobes[i % lobes.len()].sample(u);
            let value = self.brdf.eval(self.view, light);
            let pdf = self.brdf.pdf(self.view, light);
            residuals.push(self.residual(lobes, light, value, pdf));
        }
    }

    /// In proportion to the amplitudes.
    fn complete(&self, lobes: &mut [Ltc], _: &[Rc<Vec<f64>>]) {
        let total: f64 = lobes.iter().map(|lobe| lobe.amplitude).sum();
        for lobe in lobes {
            lobe.secondary = self.secondary_albedo * lobe.amplitude / total.max(1e-300);
        }
    }
}
