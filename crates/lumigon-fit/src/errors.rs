use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    form_factor::{Clipped, form_factor},
    node::Node,
    polygon::Quad,
    table::Table,
};

/// What a table misses, measured on lights it wasn't fitted to, between its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorReport {
    /// Range of the perceptual roughness.
    pub perceptual_roughness: [f64; 2],
    /// Random nodes in that range at view angles of 0 to 88 degrees.
    pub nodes: u32,
    /// Random lights a node.
    pub lights: u32,
    /// Root mean square of table minus truth for lights of radiance 1 and F = 1.
    pub rmse: f64,
    /// The same for the Schlick-weighted part.
    pub schlick_rmse: f64,
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
                let perceptual_roughness = smoothest + (roughest - smoothest) * rng.random::<f64>();
                let cos_theta = (88.0 * rng.random::<f64>()).to_radians().cos();
                let directions = self.settings().directions.max(20_000);
                let (node, lobe) = Node::new(
                    self.settings().brdf,
                    perceptual_roughness,
                    cos_theta,
                    directions,
                );
                let ltc = self.lookup(perceptual_roughness, cos_theta);
                let shading_to_cosine = ltc.shading_to_cosine();
                let pairs = (0..lights)
                    .map(|_| {
                        let quad = Quad::random(&mut rng, &node);
                        let [truth, schlick_truth] = lobe.response(&quad);
                        let above = Clipped::new(quad.vertices).clip(DVec3::Z);
                        let transformed = above.vertices().iter().map(|&v| shading_to_cosine * v);
                        let form_factor = form_factor(&Clipped::new(transformed));
                        [
                            ltc.amplitude * form_factor,
                            truth,
                            ltc.schlick * form_factor,
                            schlick_truth,
                        ]
                    })
                    .collect();
                let share = ltc.share_above_horizon();
                Sample {
                    pairs,
                    furnace: ltc.amplitude * share / node.albedo,
                    dielectric_furnace: ltc.specular(0.04) * share
                        / (0.04 * node.albedo + 0.96 * node.schlick_albedo),
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
        ErrorReport {
            perceptual_roughness,
            nodes,
            lights,
            rmse: rms(0),
            schlick_rmse: rms(2),
            median_relative: relative.get(relative.len() / 2).copied().unwrap_or(0.0),
            furnace: range(&|s| s.furnace),
            dielectric_furnace: range(&|s| s.dielectric_furnace),
        }
    }
}
