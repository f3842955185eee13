//! What one pixel pays for one light.

use std::hint::black_box;
use std::time::Instant;

use fearless_simd::{Level, Simd, dispatch};
use lumigon::{
    DiffuseMethod, Lanes, LocalOcclusion, Ltc, LtcSum, LtcTable, PolygonLight, PreparedLtc,
    ProjectionBasis, Real, Sides, Vec3, irradiance, ltc_form_factor,
};

use super::counted::{Counted, operations};
use super::median;

/// Shading points a repetition lights: few enough to stay in the first-level cache.
const POINTS: usize = 512;

/// Lights in the inner loop, so that what is prepared once a pixel is paid for as when rendering.
const LIGHTS: usize = 16;

/// A kernel, by the name it is reported under.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kernel {
    Diffuse(DiffuseMethod),
    /// Transformed cosines alone, one or two.
    Ltc {
        lobes: usize,
    },
    /// Exact diffuse light and transformed cosines, as a rough dielectric has them. The cosine term
    /// of the table named `ggx` shares the diffuse light's integral.
    DiffuseAndLtc {
        lobes: usize,
        cosine: bool,
    },
}

/// The lobes of one BRDF.
struct Lobes<T> {
    one: Ltc<T>,
    /// What goes with the one.
    cosine: Ltc<T>,
    two: [Ltc<T>; 2],
}

impl<T> Lobes<T> {
    #[inline(always)]
    fn of(&self, count: usize) -> &[Ltc<T>] {
        match count {
            1 => std::slice::from_ref(&self.one),
            _ => &self.two,
        }
    }
}

/// Every kernel with its name.
pub(super) fn kernels() -> Vec<(&'static str, Kernel)> {
    let occlusion = LocalOcclusion::Exact;
    let projected = |basis| Kernel::Diffuse(DiffuseMethod::ProjectedArea { basis, occlusion });
    let both = |lobes, cosine| Kernel::DiffuseAndLtc { lobes, cosine };
    vec![
        (
            "diffuse exact",
            Kernel::Diffuse(DiffuseMethod::Exact { occlusion }),
        ),
        (
            "diffuse light vector",
            Kernel::Diffuse(DiffuseMethod::LightVector { occlusion }),
        ),
        (
            "projected area, centroid",
            projected(ProjectionBasis::Centroid),
        ),
        (
            "projected area, weighted",
            projected(ProjectionBasis::Weighted),
        ),
        (
            "projected area, biased",
            projected(ProjectionBasis::Biased { bias: 0.5 }),
        ),
        (
            "projected area, optimal",
            projected(ProjectionBasis::Optimal),
        ),
        ("LTC, one lobe", Kernel::Ltc { lobes: 1 }),
        ("LTC, two lobes", Kernel::Ltc { lobes: 2 }),
        ("diffuse + LTC, one lobe", both(1, false)),
        ("diffuse + LTC and cosine", both(1, true)),
        ("diffuse + LTC, two lobes", both(2, false)),
    ]
}

/// Where the lights are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placement {
    /// Wholly above the surface's horizon.
    Above,
    /// Standing in the surface: every point sees it cut by its horizon.
    Clipped,
}

/// Points on the plane y = 0 and lights over it.
pub(super) struct Workload {
    x: Vec<f32>,
    z: Vec<f32>,
    lights: Vec<PolygonLight<f64>>,
    one: LtcSum<1>,
    two: LtcSum<2>,
}

impl Workload {
    pub(super) fn new(vertices: usize, placement: Placement) -> Self {
        let side = 32;
        let grid = |i: usize| (i as f32 + 0.5) / side as f32;
        let (mut x, mut z) = (Vec::new(), Vec::new());
        for i in 0..POINTS {
            // Neighbours in 4 x 4 blocks, as a renderer's tiles are.
            let (block, inner) = (i / 16, i % 16);
            let (column, row) = (block % 8 * 4 + inner % 4, block / 8 * 4 + inner / 4);
            x.push(grid(column) * 4.0 - 2.0);
            z.push(grid(row) * 4.0 + 0.5);
        }
        let lights = (0..LIGHTS)
            .map(|i| {
                let turn = i as f64 * 0.1;
                let corner = |k: usize| {
                    let angle = turn + k as f64 / vertices as f64 * std::f64::consts::TAU;
                    let (s, c) = angle.sin_cos();
                    match placement {
                        Placement::Above => [s, 2.0 + 0.05 * i as f64, 2.0 + c],
                        Placement::Clipped => [s, c, -0.1 * i as f64],
                    }
                };
                // Counter-clockwise seen from below, respectively from in front.
                let outline: Vec<_> = (0..vertices).rev().map(corner).collect();
                PolygonLight::new(&[outline], Sides::Front).expect("regular polygons are lights")
            })
            .collect();
        Self {
            x,
            z,
            lights,
            one: LtcTable::ggx().lookup(0.5, 0.6),
            two: LtcTable::ggx_2().lookup(0.5, 0.6),
        }
    }

    /// Operations a pixel and light, counted.
    pub(super) fn operations(&self, kernel: Kernel) -> f64 {
        let lights: Vec<PolygonLight<Counted>> = self
            .lights
            .iter()
            .map(|light| light.cast().expect("fits"))
            .collect();
        let lobes = self.lobes_of(Counted);
        let mut sum = Counted(0.0);
        let count = operations(|| {
            for (&x, &z) in self.x.iter().zip(&self.z) {
                let point = Vec3::new(Counted(x), Counted(0.0), Counted(z));
                sum = shade(kernel, &lights, point, &lobes, sum);
            }
        });
        black_box(sum);
        count as f64 / (self.x.len() * lights.len()) as f64
    }

    fn lobes_of<T: Copy>(&self, number: impl Fn(f32) -> T) -> Lobes<T> {
        let lobe = |lobe: &Ltc<f32>| Ltc {
            shading_to_cosine: lobe.shading_to_cosine.map(&number),
            amplitude: number(lobe.amplitude),
            schlick: number(lobe.schlick),
        };
        Lobes {
            one: lobe(&self.one.lobes[0]),
            cosine: lobe(&self.one.cosine),
            two: [lobe(&self.two.lobes[0]), lobe(&self.two.lobes[1])],
        }
    }

    /// Nanoseconds a pixel and light on one lane at a time: the median of several repetitions.
    pub(super) fn time_scalar(&self, kernel: Kernel) -> f64 {
        let lights: Vec<PolygonLight<f32>> = self.single_lights();
        let lobes = self.lobes_of(|x| x);
        self.time(|| {
            let mut sum = 0.0;
            for (&x, &z) in self.x.iter().zip(&self.z) {
                sum = shade(kernel, &lights, Vec3::new(x, 0.0, z), &lobes, sum);
            }
            black_box(sum);
        })
    }

    /// The same on all SIMD lanes that the processor has.
    pub(super) fn time_simd(&self, kernel: Kernel) -> f64 {
        let lights = self.single_lights();
        self.time(|| {
            dispatch!(Level::new(), simd => shade_simd(simd, kernel, self, &lights));
        })
    }

    /// The same on all threads at once: per pixel and light of all of them together.
    pub(super) fn time_simd_on_all_threads(&self, kernel: Kernel) -> f64 {
        let rates = rayon::broadcast(|_| self.time_simd(kernel).recip());
        rates.iter().sum::<f64>().recip()
    }

    fn single_lights(&self) -> Vec<PolygonLight<f32>> {
        self.lights
            .iter()
            .map(|light| light.cast().expect("fits"))
            .collect()
    }

    fn time(&self, work: impl Fn()) -> f64 {
        let per_repetition = (self.x.len() * self.lights.len()) as f64;
        median_seconds(work) * 1e9 / per_repetition
    }
}

/// Median time of one call, over repetitions of at least 2 ms each.
pub(super) fn median_seconds(work: impl Fn()) -> f64 {
    work();
    let start = Instant::now();
    work();
    let once = start.elapsed().as_secs_f64().max(1e-9);
    let calls = (2e-3 / once).ceil().clamp(1.0, 1e6) as u32;
    let mut seconds: Vec<f64> = (0..11)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..calls {
                work();
            }
            start.elapsed().as_secs_f64() / f64::from(calls)
        })
        .collect();
    median(&mut seconds)
}

/// One pixel under all lights.
#[inline(always)]
fn shade<T: Real>(
    kernel: Kernel,
    lights: &[PolygonLight<T::Scalar>],
    point: Vec3<T>,
    lobes: &Lobes<T>,
    mut sum: T,
) -> T {
    let (zero, one) = (sum.constant(0.0), sum.constant(1.0));
    let normal = Vec3::new(zero, one, zero);
    match kernel {
        Kernel::Diffuse(method) => {
            for light in lights {
                sum += method.irradiance(light, point, normal);
            }
        }
        Kernel::Ltc { lobes: count } => sum = transformed(lobes.of(count), lights, point, sum),
        Kernel::DiffuseAndLtc {
            lobes: count,
            cosine,
        } => {
            let mut diffuse = zero;
            for light in lights {
                diffuse += irradiance(light, point, normal);
            }
            sum += diffuse;
            if cosine {
                let per_form_factor = sum.constant(std::f64::consts::FRAC_1_PI);
                sum = diffuse.mul_add(lobes.cosine.amplitude * per_form_factor, sum);
            }
            sum = transformed(lobes.of(count), lights, point, sum);
        }
    }
    sum
}

/// One pixel's specular light from all lights.
#[inline(always)]
fn transformed<T: Real>(
    lobes: &[Ltc<T>],
    lights: &[PolygonLight<T::Scalar>],
    point: Vec3<T>,
    mut sum: T,
) -> T {
    let (zero, one) = (sum.constant(0.0), sum.constant(1.0));
    let normal = Vec3::new(zero, one, zero);
    let view = Vec3::new(sum.constant(0.8), sum.constant(0.6), zero);
    for lobe in lobes {
        let prepared = PreparedLtc::new(lobe, normal, view);
        for light in lights {
            let form_factor = ltc_form_factor(light, point, &prepared);
            sum = form_factor.mul_add(lobe.amplitude, sum);
        }
    }
    sum
}

#[inline(always)]
fn shade_simd<S: Simd>(simd: S, kernel: Kernel, workload: &Workload, lights: &[PolygonLight<f32>]) {
    let number = |x| Lanes::splat(simd, x);
    let lobes = workload.lobes_of(number);
    let mut sum = number(0.0);
    let width = Lanes::<S>::COUNT;
    for (x, z) in workload
        .x
        .chunks_exact(width)
        .zip(workload.z.chunks_exact(width))
    {
        let point = Vec3::new(
            Lanes::from_slice(simd, x),
            number(0.0),
            Lanes::from_slice(simd, z),
        );
        sum = shade(kernel, lights, point, &lobes, sum);
    }
    black_box(sum);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is timed must be light, not the early-outs of darkness.
    #[test]
    fn every_point_is_lit_by_every_light() {
        for placement in [Placement::Above, Placement::Clipped] {
            for vertices in [3, 4, 10] {
                let workload = Workload::new(vertices, placement);
                for light in workload.single_lights() {
                    for (&x, &z) in workload.x.iter().zip(&workload.z) {
                        let point = Vec3::new(x, 0.0, z);
                        let normal = Vec3::new(0.0, 1.0, 0.0);
                        let whole = lumigon::light_vector(&light, point).y;
                        let seen = irradiance(&light, point, normal);
                        assert!(seen > 0.0, "{placement:?} {vertices} at {x} {z}");
                        let is_clipped = (seen - whole).abs() > 1e-5 * seen;
                        assert_eq!(is_clipped, placement == Placement::Clipped);
                    }
                }
            }
        }
    }

    #[test]
    fn a_light_costs_operations() {
        let workload = Workload::new(4, Placement::Above);
        for (name, kernel) in kernels() {
            let operations = workload.operations(kernel);
            assert!(
                (100.0..3_000.0).contains(&operations),
                "{name}: {operations}"
            );
        }
    }
}
