use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    form_factor::{Clipped, form_factor},
    ltc::Ltc,
    node::Node,
    polygon::Quad,
    settings::Settings,
    table::Table,
};

/// What a table misses, measured on lights it wasn't fitted to, between its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorReport {
    /// Range of the first axis: perceptual roughness.
    pub perceptual_roughness: [f64; 2],
    /// Random nodes in that range, at view angles of 0 to 88 degrees, uniform along other axes.
    pub nodes: u32,
    /// Random lights a node.
    pub lights: u32,
    /// Root mean square of table minus truth for lights of radiance 1 and F = 1.
    pub rmse: f64,
    /// The same for the part under the second weight.
    pub secondary_rmse: f64,
    /// Median of `|table - truth| / truth` over lights of response above 1e-3.
    pub median_relative: f64,
    /// Smallest and largest albedo of the table in units of the true one (the white furnace).
    pub furnace: [f64; 2],
    /// The same with Schlick's Fresnel term of a dielectric, `f0 = 0.04`.
    pub dielectric_furnace: [f64; 2],
}

impl Table {
    /// Measures the table on random lights at random places in a range of perceptual roughness;
    /// `seed` should differ from the fit's.
    pub fn errors(
        &self,
        perceptual_roughness: [f64; 2],
        seed: u64,
        nodes: u32,
        lights: u32,
    ) -> ErrorReport {
        let lookup = |place: &[f64]| self.lookup_at(place);
        ErrorReport::measure(
            self.settings(),
            &lookup,
            perceptual_roughness,
            seed,
            [nodes, lights],
        )
    }
}

impl ErrorReport {
    /// Of anything that gives lobes for a place of a table.
    pub(crate) fn measure(
        settings: &Settings,
        lookup: &(dyn Fn(&[f64]) -> Vec<Ltc> + Sync),
        perceptual_roughness: [f64; 2],
        seed: u64,
        [nodes, lights]: [u32; 2],
    ) -> Self {
        let [smoothest, roughest] = perceptual_roughness;
        struct Sample {
            pairs: Vec<[f64; 4]>,
            furnace: f64,
            dielectric_furnace: f64,
        }
        let samples: Vec<Sample> = (0..nodes)
            .into_par_iter()
            .map(|i| {
                let mut rng =
                    Pcg32::seed_from_u64(seed.wrapping_mul(0x1_0000_0001).wrapping_add(i.into()));
                let view_axis = settings.brdf.view_axis();
                let place: Vec<f64> = (0..settings.brdf.axes().len())
                    .map(|axis| {
                        let u: f64 = rng.random();
                        if axis == 0 {
                            smoothest + (roughest - smoothest) * u
                        } else if axis == view_axis {
                            (1.0 - (88.0 * u).to_radians().cos()).sqrt()
                        } else {
                            u
                        }
                    })
                    .collect();
                let directions = settings.directions.max(20_000);
                let (node, lobe) = Node::new(settings.brdf, &place, directions);
                let lobes = lookup(&place);
                let pairs = (0..lights)
                    .map(|_| {
                        let quad = Quad::random(&mut rng, &node);
                        let [truth, secondary_truth] = lobe.response(&quad);
                        let above = Clipped::new(quad.vertices).clip(DVec3::Z);
                        let (mut value, mut secondary) = (0.0, 0.0);
                        for ltc in &lobes {
                            let matrix = ltc.shading_to_cosine;
                            let transformed = above.vertices().iter().map(|&v| matrix * v);
                            let form_factor = form_factor(&Clipped::new(transformed));
                            value += ltc.amplitude * form_factor;
                            secondary += ltc.secondary * form_factor;
                        }
                        [value, truth, secondary, secondary_truth]
                    })
                    .collect();
                let albedo = |of: &dyn Fn(&Ltc) -> f64| -> f64 {
                    lobes.iter().map(|l| of(l) * l.share_above_horizon()).sum()
                };
                Sample {
                    pairs,
                    furnace: albedo(&|l| l.amplitude) / node.albedo,
                    dielectric_furnace: albedo(&|l| l.specular(0.04))
                        / (0.04 * node.albedo + 0.96 * node.secondary_albedo),
                }
            })
            .collect();
        let all = || samples.iter().flat_map(|s| &s.pairs);
        let count = all().count().max(1) as f64;
        let rms =
            |at: usize| (all().map(|p| (p[at] - p[at + 1]).powi(2)).sum::<f64>() / count).sqrt();
        let mut relative: Vec<f64> = all()
            .filter(|p| p[1] > 1e-3)
            .map(|p| (p[0] - p[1]).abs() / p[1])
            .collect();
        relative.sort_by(f64::total_cmp);
        let range = |of: &dyn Fn(&Sample) -> f64| {
            samples
                .iter()
                .map(of)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                    [low.min(x), high.max(x)]
                })
        };
        Self {
            perceptual_roughness,
            nodes,
            lights,
            rmse: rms(0),
            secondary_rmse: rms(2),
            median_relative: relative.get(relative.len() / 2).copied().unwrap_or(0.0),
            furnace: range(&|s| s.furnace),
            dielectric_furnace: range(&|s| s.dielectric_furnace),
        }
    }
}
