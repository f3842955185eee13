use glam::DVec3;

use crate::{
    brdf::{Brdf, schlick_factor},
    polygon::Quad,
};

/// A BRDF's lobe for one view direction as weighted directions: the truth of polygon integrals.
///
/// The directions are the images of a Fibonacci lattice under the BRDF's own importance sampling,
/// so that a polygon's response is a sum of weights and its error that of the lattice's
/// discrepancy, about 3e-4 of the albedo at 10946 directions.
/// Stored as structure of arrays in f32, which the inner loop needs to vectorise.
#[derive(Clone, Debug)]
pub struct Lobe {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    weight: Vec<f32>,
    schlick_weight: Vec<f32>,
    albedo: f64,
    schlick_albedo: f64,
    mean_direction: DVec3,
}

impl Lobe {
    /// Samples the lobe at `count` lattice points; those below the horizon are dropped.
    pub fn new(brdf: &dyn Brdf, view: DVec3, count: u32) -> Self {
        let mut lobe = Self {
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            weight: Vec::new(),
            schlick_weight: Vec::new(),
            albedo: 0.0,
            schlick_albedo: 0.0,
            mean_direction: DVec3::ZERO,
        };
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let scale = 1.0 / f64::from(count.max(1));
        for i in 0..count {
            let u = [
                (f64::from(i) + 0.5) * scale,
                (f64::from(i) * golden).fract(),
            ];
            let Some(sample) = brdf.sample(view, u) else {
                continue;
            };
            let weight = sample.weight * scale;
            let schlick_weight = weight * schlick_factor(view, sample.light);
            lobe.albedo += weight;
            lobe.schlick_albedo += schlick_weight;
            lobe.mean_direction += weight * sample.light;
            lobe.x.push(sample.light.x as f32);
            lobe.y.push(sample.light.y as f32);
            lobe.z.push(sample.light.z as f32);
            lobe.weight.push(weight as f32);
            lobe.schlick_weight.push(schlick_weight as f32);
        }
        // Isotropic: symmetric in y, up to the lattice.
        lobe.mean_direction.y = 0.0;
        lobe.mean_direction = lobe.mean_direction.normalize_or(DVec3::Z);
        lobe
    }

    /// Directional albedo with F = 1, in [0,1].
    pub fn albedo(&self) -> f64 {
        self.albedo
    }

    /// Directional albedo weighted with Schlick's `(1 - h.v)^5`.
    pub fn schlick_albedo(&self) -> f64 {
        self.schlick_albedo
    }

    /// Mean light direction, unit length, y = 0.
    pub fn mean_direction(&self) -> DVec3 {
        self.mean_direction
    }

    /// Response to a light of radiance 1, and the same with Schlick's weight.
    pub(crate) fn response(&self, light: &Quad) -> [f64; 2] {
        let planes = light.edge_planes().map(DVec3::as_vec3);
        let (mut sum, mut schlick_sum) = (0.0, 0.0);
        // Short blocks: f32 accumulators stay accurate and the loop below vectorises.
        const BLOCK: usize = 512;
        for start in (0..self.x.len()).step_by(BLOCK) {
            let block = start..(start + BLOCK).min(self.x.len());
            let (xs, ys, zs) = (
                &self.x[block.clone()],
                &self.y[block.clone()],
                &self.z[block.clone()],
            );
            let (ws, ss) = (&self.weight[block.clone()], &self.schlick_weight[block]);
            let (mut lanes, mut schlick_lanes) = ([0.0_f32; 8], [0.0_f32; 8]);
            let mut add = |lane: usize, i: usize| {
                let inside = planes
                    .iter()
                    .map(|p| p.x * xs[i] + p.y * ys[i] + p.z * zs[i])
                    .fold(f32::INFINITY, |m, d| if d < m { d } else { m });
                let keep = if inside > 0.0 { 1.0 } else { 0.0 };
                lanes[lane] += keep * ws[i];
                schlick_lanes[lane] += keep * ss[i];
            };
            let whole = xs.len() / 8 * 8;
            for i in (0..whole).step_by(8) {
                for lane in 0..8 {
                    add(lane, i + lane);
                }
            }
            for i in whole..xs.len() {
                add(i - whole, i);
            }
            sum += f64::from(lanes.iter().sum::<f32>());
            schlick_sum += f64::from(schlick_lanes.iter().sum::<f32>());
        }
        [sum, schlick_sum]
    }
}
