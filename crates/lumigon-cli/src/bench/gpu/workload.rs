//! What is lit in the benchmark, and by which lights.

use bytemuck::{Pod, Zeroable};
use lumigon::{
    Ltc, LtcTable, PolygonLight, PreparedLtc, Real, Scalar, Sides, Vec3, irradiance,
    ltc_form_factor,
};
use lumigon_wgpu::Light;

use super::shading::Shading;
use crate::bench::counted::{Counted, operations};
use crate::bench::kernels::Placement;

/// Where the lights of a workload are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lights {
    /// All of them so.
    All(Placement),
    /// Every other one is clipped.
    Mixed,
}

/// A pixel as the shaders read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct PixelRecord {
    position: [f32; 3],
    perceptual_roughness: f32,
    normal: [f32; 3],
    padding: f32,
    view: [f32; 3],
    more_padding: f32,
}

/// The lights that operations are counted on, and points along each axis of a frame.
const COUNTED_LIGHTS: usize = 98;
const COUNTED_POINTS: u32 = 12;

/// Multiply-adds that weigh a form factor by an RGB radiance.
const OPERATIONS_A_FORM_FACTOR: f64 = 3.0;

/// Bumpy ground, seen from above its near edge, of changing roughness.
pub(super) fn pixels(width: u32, height: u32) -> Vec<PixelRecord> {
    let pixel = |i: u32| {
        let (column, row) = (i % width, i / width);
        let x = (f64::from(column) + 0.5) / f64::from(width) * 4.0 - 2.0;
        let z = (f64::from(row) + 0.5) / f64::from(height) * 4.0 + 0.5;
        let normal = unit([0.04 * (9.0 * x).sin(), 1.0, 0.04 * (7.0 * z + x).sin()]);
        let view = unit([-x, 3.0, -3.0 - z]);
        PixelRecord {
            position: [x as f32, 0.0, z as f32],
            perceptual_roughness: (0.5 + 0.35 * (3.0 * x).sin() * (2.0 * z).cos()) as f32,
            normal,
            padding: 0.0,
            view,
            more_padding: 0.0,
        }
    };
    (0..width * height).map(pixel).collect()
}

fn unit(v: [f64; 3]) -> [f32; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| (x / length) as f32)
}

/// Regular polygons about as large as they are far away.
pub(super) fn lights(count: usize, vertices: usize, lights: Lights) -> Vec<ExactLight> {
    let light = |i: usize| {
        // Additive sequences of irrational steps fill their ranges evenly, however many are taken.
        let spread = |step: f64, from: f64, to: f64| {
            from + (to - from) * ((i as f64 + 0.5) * step).rem_euclid(1.0)
        };
        let placement = match lights {
            Lights::All(placement) => placement,
            Lights::Mixed if i.is_multiple_of(2) => Placement::Above,
            Lights::Mixed => Placement::Clipped,
        };
        let (x, turn) = (spread(0.754_877, -3.0, 3.0), spread(0.618_034, 0.0, 6.3));
        let radius = spread(0.414_214, 0.7, 1.2);
        let corner = |k: usize| {
            let angle = turn + k as f64 / vertices as f64 * std::f64::consts::TAU;
            let (s, c) = angle.sin_cos();
            let (s, c) = (radius * s, radius * c);
            match placement {
                Placement::Above => {
                    let (y, z) = (spread(0.569_840, 2.4, 4.0), spread(0.732_051, 0.0, 5.0));
                    [x + s, y, z + c]
                }
                Placement::Clipped => {
                    let (y, z) = (spread(0.569_840, -0.3, 0.3), spread(0.732_051, -2.0, 0.3));
                    [x + s, y + c, z]
                }
            }
        };
        // Counter-clockwise seen from below, respectively from in front.
        let outline: Vec<_> = (0..vertices).rev().map(corner).collect();
        let polygon =
            PolygonLight::new(&[outline], Sides::Front).expect("regular polygons are lights");
        let power = spread(0.302_776, 0.5, 1.5) as f32;
        ExactLight {
            polygon,
            radiance: [power, 0.9 * power, 0.8 * power],
        }
    };
    (0..count).map(light).collect()
}

/// A light before it is rounded.
pub(super) struct ExactLight {
    pub(super) polygon: PolygonLight<f64>,
    radiance: [f32; 3],
}

impl ExactLight {
    fn cast<S: Scalar>(&self) -> PolygonLight<S> {
        self.polygon.cast().expect("these lights fit any number")
    }

    /// As the GPU has it.
    pub(super) fn rounded(&self) -> Light {
        Light {
            polygon: self.cast(),
            radiance: self.radiance,
            image: None,
        }
    }

    /// World-space vertices, clockwise seen from the front.
    pub(super) fn world_vertices(&self) -> Vec<[f32; 4]> {
        let vertices = self.polygon.loops().flatten();
        let mut vertices: Vec<_> = vertices
            .map(|v| [v.x as f32, v.y as f32, v.z as f32, 1.0])
            .collect();
        vertices.reverse();
        vertices
    }
}

/// A surface and its lobes, in any number type.
struct Surface<T> {
    point: Vec3<T>,
    normal: Vec3<T>,
    view: Vec3<T>,
    /// Lobes with their responses to white light.
    lobes: Vec<(Ltc<T>, f64)>,
    cosine_response: f64,
}

impl Surface<f32> {
    fn new(pixel: &PixelRecord, shading: Shading, tables: &(LtcTable<1>, LtcTable<2>)) -> Self {
        let vector = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z);
        let (normal, view) = (vector(pixel.normal), vector(pixel.view));
        let (roughness, cosine) = (pixel.perceptual_roughness, normal.dot(view));
        let response = |lobe: &Ltc<f32>| f64::from(lobe.reflectance(0.04, 1.0));
        let with_response = |lobe: &Ltc<f32>| (*lobe, response(lobe));
        let (lobes, cosine_response) = match shading.lobes() {
            0 => (Vec::new(), 0.0),
            1 => {
                let sum = tables.0.lookup(roughness, cosine);
                let lobes = sum.lobes.iter().map(with_response).collect();
                (lobes, response(&sum.cosine))
            }
            _ => {
                let sum = tables.1.lookup(roughness, cosine);
                (sum.lobes.iter().map(with_response).collect(), 0.0)
            }
        };
        Self {
            point: vector(pixel.position),
            normal,
            view,
            lobes,
            cosine_response,
        }
    }

    fn cast<T>(&self, number: impl Fn(f32) -> T) -> Surface<T> {
        let vector = |v: Vec3<f32>| Vec3::new(number(v.x), number(v.y), number(v.z));
        let lobe = |(lobe, response): &(Ltc<f32>, f64)| {
            let lobe = Ltc {
                shading_to_cosine: lobe.shading_to_cosine.map(&number),
                amplitude: number(lobe.amplitude),
                schlick: number(lobe.schlick),
            };
            (lobe, *response)
        };
        Surface {
            point: vector(self.point),
            normal: vector(self.normal),
            view: vector(self.view),
            lobes: self.lobes.iter().map(lobe).collect(),
            cosine_response: self.cosine_response,
        }
    }
}

impl<T: Real<Scalar = T> + Scalar> Surface<T> {
    /// Radiance towards the viewer in each light's own unit of radiance, by `weights`.
    fn reflected(&self, lights: &[PolygonLight<T>], weights: &[f64]) -> f64 {
        let prepared: Vec<_> = self
            .lobes
            .iter()
            .map(|(lobe, response)| {
                let prepared = PreparedLtc::new(lobe, self.normal, self.view);
                (prepared, *response)
            })
            .collect();
        let mut sum = 0.0;
        for (light, weight) in lights.iter().zip(weights) {
            let diffuse = irradiance(light, self.point, self.normal).to_f64();
            let mut seen = diffuse * std::f64::consts::FRAC_1_PI * (1.0 + self.cosine_response);
            for (lobe, response) in &prepared {
                seen += response * ltc_form_factor(light, self.point, lobe).to_f64();
            }
            sum += weight * seen;
        }
        sum
    }
}

/// The green channel of every pixel in double precision.
pub(super) fn truth(pixels: &[PixelRecord], lights: &[ExactLight], shading: Shading) -> Vec<f64> {
    let tables = (LtcTable::ggx(), LtcTable::ggx_2());
    let weights: Vec<_> = lights.iter().map(|l| f64::from(l.radiance[1])).collect();
    let exact: Vec<PolygonLight<f64>> = lights.iter().map(ExactLight::cast).collect();
    pixels
        .iter()
        .map(|pixel| {
            let surface = Surface::new(pixel, shading, &tables);
            surface.cast(f64::from).reflected(&exact, &weights)
        })
        .collect()
}

/// Operations a pixel and light that the CPU's functions count on these lights, with what weighs
/// their results; what is done once a pixel is shared by the lights, lookups left out.
pub(super) fn counted_operations(lights: &[ExactLight], shading: Shading) -> f64 {
    let tables = (LtcTable::ggx(), LtcTable::ggx_2());
    let lights: Vec<PolygonLight<Counted>> = lights
        .iter()
        .take(COUNTED_LIGHTS)
        .map(ExactLight::cast)
        .collect();
    let weights = vec![1.0; lights.len()];
    let pixels = pixels(COUNTED_POINTS, COUNTED_POINTS);
    let mut done = 0;
    for pixel in &pixels {
        let surface = Surface::new(pixel, shading, &tables).cast(Counted);
        done += operations(|| {
            std::hint::black_box(surface.reflected(&lights, &weights));
        });
    }
    let form_factors = 1 + shading.lobes();
    done as f64 / (pixels.len() * lights.len()) as f64
        + OPERATIONS_A_FORM_FACTOR * f64::from(form_factors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_where_they_should_be() {
        let pixels = pixels(15, 9);
        for placement in [Placement::Above, Placement::Clipped] {
            for light in lights(40, 4, Lights::All(placement)) {
                let light = light.rounded();
                let mut clipped = 0;
                for pixel in &pixels {
                    let vector = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z);
                    let (point, normal) = (vector(pixel.position), vector(pixel.normal));
                    let whole = lumigon::light_vector(&light.polygon, point).dot(normal);
                    let seen = irradiance(&light.polygon, point, normal);
                    assert!(seen > 0.0);
                    clipped += usize::from((seen - whole).abs() > 1e-4 * seen);
                }
                match placement {
                    Placement::Above => assert_eq!(clipped, 0),
                    Placement::Clipped => assert!(clipped > pixels.len() / 2, "{clipped}"),
                }
            }
        }
    }

    #[test]
    fn every_lobe_costs_operations() {
        let lights = lights(10, 4, Lights::Mixed);
        let counts = Shading::ALL.map(|shading| counted_operations(&lights, shading));
        assert!(100.0 < counts[0] && counts[0] < 1000.0, "{counts:?}");
        assert!(1.5 * counts[0] < counts[1], "{counts:?}");
        assert!(1.3 * counts[1] < counts[2], "{counts:?}");
    }
}
