//! All lights on all hits of a tile, SIMD over the hits that share a lobe.

use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use lumigon::{
    DiffuseMethod, Lanes, LocalOcclusion, PolygonLight, PreparedLtc, Real, SpecularMethod,
    ggx_cosine, light_direction, ltc_form_factor, reflected_inclusion,
};

use super::batch::Batch;
use super::hits::{DIRECT, FITTED, Hits};
use super::lobes::Scattered;
use crate::scene::PunctualLight;

/// A polygon light and its radiance.
pub(super) struct ShadingLight {
    pub(super) polygon: PolygonLight<f32>,
    pub(super) radiance: [f32; 3],
}

/// Sums over lights of radiance times response, by channel, one list each.
type Sums = [Vec<f32>; 3];

/// What each hit scatters of all polygon lights.
pub(super) fn polygons(
    hits: &Hits,
    lights: &[ShadingLight],
    diffuse: DiffuseMethod,
    specular: SpecularMethod,
) -> Vec<Scattered> {
    let mut scattered = vec![Scattered::default(); hits.surfaces().len()];
    if lights.is_empty() {
        return scattered;
    }
    let irradiance = dispatch!(Level::new(), simd => {
        irradiance(simd, &hits.diffuse, lights, diffuse)
    });
    for (i, &(hit, weight)) in hits.diffuse.entries().iter().enumerate() {
        scattered[hit as usize].diffuse += weight * at(&irradiance, i);
    }
    for fitted in hits.fitted.iter().filter(|batch| !batch.is_empty()) {
        let form_factors = dispatch!(Level::new(), simd => {
            form_factors(simd, fitted, lights)
        });
        for (i, &(hit, weight)) in fitted.entries().iter().enumerate() {
            scattered[hit as usize].specular += weight * at(&form_factors, i);
        }
    }
    for direct in hits.direct.iter().filter(|batch| !batch.is_empty()) {
        let [whole, schlick] = dispatch!(Level::new(), simd => {
            responses(simd, direct, lights, specular)
        });
        for (i, &(hit, [f0, f90])) in direct.entries().iter().enumerate() {
            let (whole, schlick) = (at(&whole, i), at(&schlick, i));
            scattered[hit as usize].specular += f0 * (whole - schlick) + f90 * schlick;
        }
    }
    scattered
}

fn at(sums: &Sums, i: usize) -> Vec3 {
    Vec3::new(sums[0][i], sums[1][i], sums[2][i])
}

#[inline(always)]
fn add<S: Simd>(sum: &mut [Lanes<S>; 3], radiance: [f32; 3], response: Lanes<S>) {
    for (sum, radiance) in sum.iter_mut().zip(radiance) {
        *sum = response.mul_add(response.broadcast(radiance), *sum);
    }
}

#[inline(always)]
fn store<S: Simd>(sum: [Lanes<S>; 3], to: &mut Sums, start: usize) {
    for (sum, to) in sum.into_iter().zip(to) {
        sum.store(&mut to[start..]);
    }
}

#[inline(always)]
fn irradiance<S: Simd>(
    simd: S,
    surfaces: &Batch<6, Vec3>,
    lights: &[ShadingLight],
    method: DiffuseMethod,
) -> Sums {
    let mut sums = surfaces.dark();
    surfaces.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = surfaces.vectors(simd, 0, start);
            let normal = surfaces.vectors(simd, 3, start);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for light in lights {
                let irradiance = method.irradiance(&light.polygon, point, normal);
                add(&mut sum, light.radiance, irradiance);
            }
            store(sum, &mut sums, start);
        },
    );
    sums
}

/// The fitted lobes' form factors.
#[inline(always)]
fn form_factors<S: Simd>(simd: S, lobes: &Batch<FITTED, Vec3>, lights: &[ShadingLight]) -> Sums {
    let mut sums = lobes.dark();
    lobes.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = lobes.vectors(simd, 0, start);
            let normal = lobes.vectors(simd, 3, start);
            let rows = [
                lobes.vectors(simd, 6, start),
                lobes.vectors(simd, 9, start),
                lobes.vectors(simd, 12, start),
            ];
            let prepared = PreparedLtc::from_world_to_cosine(rows, normal);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for light in lights {
                let form_factor = ltc_form_factor(&light.polygon, point, &prepared);
                add(&mut sum, light.radiance, form_factor);
            }
            store(sum, &mut sums, start);
        },
    );
    sums
}

/// Response of GGX lobes with F = 1, and the same weighted by Schlick's (1 - h.v)^5, by methods
/// that know one direction a light.
#[inline(always)]
fn responses<S: Simd>(
    simd: S,
    lobes: &Batch<DIRECT, [Vec3; 2]>,
    lights: &[ShadingLight],
    method: SpecularMethod,
) -> [Sums; 2] {
    let (mut all_whole, mut all_schlick) = (lobes.dark(), lobes.dark());
    lobes.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = lobes.vectors(simd, 0, start);
            let normal = lobes.vectors(simd, 3, start);
            let view = lobes.vectors(simd, 6, start);
            let mut whole = [Lanes::splat(simd, 0.0); 3];
            let mut schlick = whole;
            match method {
                SpecularMethod::None | SpecularMethod::Ltc { .. } => {}
                SpecularMethod::ReflectedInclusion(rule) => {
                    let weight = schlick_weight(normal.dot(view));
                    for light in lights {
                        let inside = reflected_inclusion(&light.polygon, point, normal, view, rule);
                        add(&mut whole, light.radiance, inside);
                        add(&mut schlick, light.radiance, inside * weight);
                    }
                }
                SpecularMethod::LightVector => {
                    let alpha = lobes.lanes(simd, 12, start);
                    for light in lights {
                        let seen =
                            light_direction(&light.polygon, point, normal, LocalOcclusion::Exact);
                        let response =
                            ggx_cosine(alpha, normal, view, seen.direction) * seen.solid_angle;
                        let half = (view + seen.direction).normalize_or_zero();
                        let weight = schlick_weight(half.dot(view));
                        add(&mut whole, light.radiance, response);
                        add(&mut schlick, light.radiance, response * weight);
                    }
                }
            }
            store(whole, &mut all_whole, start);
            store(schlick, &mut all_schlick, start);
        },
    );
    [all_whole, all_schlick]
}

/// (1 - cosine)^5, for a cosine in \[0, 1\].
#[inline(always)]
fn schlick_weight<T: Real>(cosine: T) -> T {
    lumigon::schlick(cosine.constant(0.0), cosine)
}

/// Adds what each hit scatters of a light without extent, unshadowed.
pub(super) fn add_punctual(
    scattered: &mut [Scattered],
    hits: &Hits,
    light: &PunctualLight,
    specular: SpecularMethod,
) {
    for (lobes, scattered) in hits.lobes().iter().zip(scattered) {
        let Some((towards, _, irradiance)) = light.at(lobes.position) else {
            continue;
        };
        let response = lobes.evaluate(towards);
        scattered.diffuse += response.diffuse * irradiance;
        if specular != SpecularMethod::None {
            scattered.specular += response.specular * irradiance;
        }
    }
}
