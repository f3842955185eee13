use glam::DVec3;

use crate::{brdf::Brdf, polygon::Quad};

/// Directions a block: enough for any SIMD register of today.
const LANES: usize = 8;

/// A few weighted directions, one array a component, which the compiler turns into SIMD.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    weight: [f32; LANES],
    secondary_weight: [f32; LANES],
}

/// A BRDF's lobe for one view direction as weighted directions: the truth of polygon integrals.
///
/// The directions are the images of a Fibonacci lattice under the BRDF's own importance sampling,
/// so that a polygon's response is a sum of weights and its error that of the lattice's
/// discrepancy: rms 5e-4 of the albedo at 10946 directions, at most 2e-3.
#[derive(Clone, Debug)]
pub struct Lobe {
    blocks: Vec<Block>,
    albedo: f64,
    secondary_albedo: f64,
    mean_direction: DVec3,
}

impl Lobe {
    /// Samples the lobe at `count` lattice points; those below the horizon are dropped.
    pub fn new(brdf: &dyn Brdf, view: DVec3, count: u32) -> Self {
        let mut lobe = Self {
            blocks: Vec::new(),
            albedo: 0.0,
            secondary_albedo: 0.0,
            mean_direction: DVec3::ZERO,
        };
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let scale = 1.0 / f64::from(count.max(1));
        let mut lane = 0;
        for i in 0..count {
            let u = [
                (f64::from(i) + 0.5) * scale,
                (f64::from(i) * golden).fract(),
            ];
            let Some(sample) = brdf.sample(view, u) else {
                continue;
            };
            let weight = sample.weight * scale;
            let secondary_weight = weight * brdf.secondary(view, sample.light);
            lobe.albedo += weight;
            lobe.secondary_albedo += secondary_weight;
            lobe.mean_direction += weight * sample.light;
            if lane == 0 {
                lobe.blocks.push(Block::default());
            }
            if let Some(block) = lobe.blocks.last_mut() {
                block.x[lane] = sample.light.x as f32;
                block.y[lane] = sample.light.y as f32;
                block.z[lane] = sample.light.z as f32;
                block.weight[lane] = weight as f32;
                block.secondary_weight[lane] = secondary_weight as f32;
            }
            lane = (lane + 1) % LANES;
        }
        lobe.mean_direction = lobe.mean_direction.normalize_or(DVec3::Z);
        lobe
    }

    /// Directional albedo with F = 1, in `[0,1]`.
    pub fn albedo(&self) -> f64 {
        self.albedo
    }

    /// Directional albedo under the BRDF's second weight.
    pub fn secondary_albedo(&self) -> f64 {
        self.secondary_albedo
    }

    /// Mean light direction, unit length.
    pub fn mean_direction(&self) -> DVec3 {
        self.mean_direction
    }

    /// Response to a light of radiance 1, and the same under the second weight.
    pub(crate) fn response(&self, light: &Quad) -> [f64; 2] {
        let planes = light.edge_planes().map(DVec3::as_vec3);
        let mut sums = [0.0_f64; 2];
        // Short runs keep f32 sums accurate.
        for run in self.blocks.chunks(64) {
            let (mut sum, mut secondary_sum) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            for block in run {
                for i in 0..LANES {
                    let inside = planes
                        .map(|p| p.x * block.x[i] + p.y * block.y[i] + p.z * block.z[i])
                        .into_iter()
                        .fold(f32::INFINITY, |least, d| if d < least { d } else { least });
                    let keep = if inside > 0.0 { 1.0 } else { 0.0 };
                    sum[i] += keep * block.weight[i];
                    secondary_sum[i] += keep * block.secondary_weight[i];
                }
            }
            sums[0] += f64::from(sum.iter().sum::<f32>());
            sums[1] += f64::from(secondary_sum.iter().sum::<f32>());
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::{kind::BrdfKind, node::Node};

    /// The documented error, against a lattice twenty times finer.
    #[test]
    fn response_is_accurate() {
        for (perceptual_roughness, cos_theta) in [(0.05, 0.9_f64), (0.4, 0.1), (1.0, 0.5)] {
            let (node, coarse) = Node::new(
                BrdfKind::Ggx,
                &[perceptual_roughness, (1.0 - cos_theta).sqrt()],
                10_946,
            );
            let fine = Lobe::new(node.brdf.as_ref(), node.view, 250_000);
            let mut rng = rand_pcg::Pcg32::seed_from_u64(5);
            let (mut sum, mut worst) = (0.0, 0.0_f64);
            for _ in 0..40 {
                let quad = Quad::random(&mut rng, &node);
                let error = (coarse.response(&quad)[0] - fine.response(&quad)[0]) / node.albedo;
                sum += error * error;
                worst = worst.max(error.abs());
            }
            let rms = (sum / 40.0_f64).sqrt();
            println!("{perceptual_roughness} {cos_theta}: rms {rms:.1e}, worst {worst:.1e}");
            assert!(
                rms < 6e-4 && worst < 2e-3,
                "{perceptual_roughness} {cos_theta}: {rms} {worst}"
            );
        }
    }

    /// The whole upper hemisphere, as two lights, reflects the albedo.
    #[test]
    fn halves_make_the_whole() {
        let (node, lobe) = Node::new(BrdfKind::Ggx, &[0.6, 0.7_f64.sqrt()], 5000);
        let far = 1e6;
        let half = |side: f64| {
            let corners = [
                DVec3::new(0.0, -far, 1.0),
                DVec3::new(0.0, far, 1.0),
                DVec3::new(side * far, far, 1.0),
                DVec3::new(side * far, -far, 1.0),
            ];
            let mut vertices = corners;
            if side < 0.0 {
                vertices.reverse();
            }
            lobe.response(&Quad { vertices })
        };
        let (left, right) = (half(-1.0), half(1.0));
        assert!((left[0] + right[0] - node.albedo).abs() < 1e-4);
        assert!((left[1] + right[1] - node.secondary_albedo).abs() < 1e-4);
        assert!(
            left[0] > right[0],
            "the light comes from the mirror direction, x < 0"
        );
    }
}
