//! All lights on all hits of a tile, SIMD over hits.

use fearless_simd::{Level, Simd, dispatch};
use lumigon::{
    DiffuseMethod, Lanes, LocalOcclusion, Ltc, PolygonLight, PreparedLtc, Real, SpecularMethod,
    Vec3, ggx_cosine, light_direction, ltc_form_factor, reflected_inclusion,
};

use super::hits::{Coordinates, Hits, PADDING};
use super::vector;
use crate::scene::PunctualLight;

/// A polygon light and its radiance.
pub(super) struct ShadingLight {
    pub(super) polygon: PolygonLight<f32>,
    pub(super) radiance: [f32; 3],
}

/// Light on each hit, by channel.
pub(super) struct ShadedLight {
    pub(super) irradiance: [Vec<f32>; 3],
    /// Response of the GGX lobe with F = 1.
    pub(super) specular: [Vec<f32>; 3],
    /// The same weighted by Schlick's (1 - h.v)^5.
    pub(super) schlick: [Vec<f32>; 3],
}

/// Sums over all polygon lights.
pub(super) fn polygons(
    hits: &Hits,
    lights: &[ShadingLight],
    diffuse: DiffuseMethod,
    specular: SpecularMethod,
) -> ShadedLight {
    let length = hits.surfaces().len().next_multiple_of(PADDING);
    let dark = || std::array::from_fn(|_| vec![0.0; length]);
    let mut light = ShadedLight {
        irradiance: dark(),
        specular: dark(),
        schlick: dark(),
    };
    if lights.is_empty() {
        return light;
    }
    dispatch!(Level::new(), simd => {
        diffuse_light(simd, hits, lights, diffuse, &mut light);
        specular_light(simd, hits, lights, specular, &mut light);
    });
    light
}

/// Calls `each` with the first index of every packet of hits.
#[inline(always)]
fn for_each_packet<S: Simd>(hits: &Hits, mut each: impl FnMut(usize)) {
    let mut start = 0;
    while start < hits.surfaces().len() {
        each(start);
        start += Lanes::<S>::COUNT;
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, list: &[f32], start: usize) -> Lanes<S> {
    Lanes::from_slice(simd, &Hits::packet(list, start))
}

#[inline(always)]
fn vectors<S: Simd>(simd: S, list: &Coordinates, start: usize) -> Vec3<Lanes<S>> {
    Vec3::new(
        lanes(simd, &list.x, start),
        lanes(simd, &list.y, start),
        lanes(simd, &list.z, start),
    )
}

#[inline(always)]
fn add<S: Simd>(sum: &mut [Lanes<S>; 3], radiance: [f32; 3], response: Lanes<S>) {
    for (sum, radiance) in sum.iter_mut().zip(radiance) {
        *sum = response.mul_add(response.broadcast(radiance), *sum);
    }
}

#[inline(always)]
fn scaled<S: Simd>([r, g, b]: [Lanes<S>; 3], factor: Lanes<S>) -> [Lanes<S>; 3] {
    [r * factor, g * factor, b * factor]
}

#[inline(always)]
fn store<S: Simd>(sum: [Lanes<S>; 3], to: &mut [Vec<f32>; 3], start: usize) {
    for (sum, to) in sum.into_iter().zip(to) {
        sum.store(&mut to[start..]);
    }
}

#[inline(always)]
fn diffuse_light<S: Simd>(
    simd: S,
    hits: &Hits,
    lights: &[ShadingLight],
    method: DiffuseMethod,
    to: &mut ShadedLight,
) {
    for_each_packet::<S>(
        hits,
        #[inline(always)]
        |start| {
            let point = vectors(simd, &hits.position, start);
            let normal = vectors(simd, &hits.normal, start);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for light in lights {
                let irradiance = method.irradiance(&light.polygon, point, normal);
                add(&mut sum, light.radiance, irradiance);
            }
            store(sum, &mut to.irradiance, start);
        },
    );
}

#[inline(always)]
fn specular_light<S: Simd>(
    simd: S,
    hits: &Hits,
    lights: &[ShadingLight],
    method: SpecularMethod,
    to: &mut ShadedLight,
) {
    if method == SpecularMethod::None {
        return;
    }
    for_each_packet::<S>(
        hits,
        #[inline(always)]
        |start| {
            let point = vectors(simd, &hits.position, start);
            let normal = vectors(simd, &hits.normal, start);
            let view = vectors(simd, &hits.view, start);
            let mut whole = [Lanes::splat(simd, 0.0); 3];
            let mut schlick = whole;
            match method {
                SpecularMethod::None => {}
                SpecularMethod::Ltc { lobes: _ } => {
                    let number = &hits.ltc;
                    let amplitude = lanes(simd, &number[4], start);
                    let schlick_amplitude = lanes(simd, &number[5], start);
                    let lobe = Ltc {
                        shading_to_cosine: [
                            lanes(simd, &number[0], start),
                            lanes(simd, &number[1], start),
                            lanes(simd, &number[2], start),
                            lanes(simd, &number[3], start),
                        ],
                        amplitude,
                        schlick: schlick_amplitude,
                    };
                    let prepared = PreparedLtc::new(&lobe, normal, view);
                    let mut sum = whole;
                    for light in lights {
                        let form_factor = ltc_form_factor(&light.polygon, point, &prepared);
                        add(&mut sum, light.radiance, form_factor);
                    }
                    whole = scaled(sum, amplitude);
                    schlick = scaled(sum, schlick_amplitude);
                }
                SpecularMethod::ReflectedInclusion(rule) => {
                    for light in lights {
                        let inside = reflected_inclusion(&light.polygon, point, normal, view, rule);
                        add(&mut whole, light.radiance, inside);
                    }
                    let weight = schlick_weight(normal.dot(view));
                    schlick = scaled(whole, weight);
                }
                SpecularMethod::LightVector => {
                    let alpha = lanes(simd, &hits.alpha, start);
                    for light in lights {
                        let seen =
                            light_direction(&light.polygon, point, normal, LocalOcclusion::Exact);
                        let response =
                            ggx_cosine(alpha, normal, view, seen.direction) * seen.solid_angle;
                        add(&mut whole, light.radiance, response);
                        let half = (view + seen.direction).normalize_or_zero();
                        let weight = schlick_weight(half.dot(view));
                        add(&mut schlick, light.radiance, response * weight);
                    }
                }
            }
            store(whole, &mut to.specular, start);
            store(schlick, &mut to.schlick, start);
        },
    );
}

/// (1 - cosine)^5, for a cosine in \[0, 1\].
#[inline(always)]
fn schlick_weight<T: Real>(cosine: T) -> T {
    lumigon::schlick(cosine.constant(0.0), cosine)
}

impl ShadedLight {
    /// Adds a light without extent, unshadowed.
    pub(super) fn add_punctual(
        &mut self,
        hits: &Hits,
        light: &PunctualLight,
        specular: SpecularMethod,
    ) {
        for i in 0..hits.surfaces().len() {
            let at = |list: &Coordinates| glam::Vec3::new(list.x[i], list.y[i], list.z[i]);
            let (normal, view) = (at(&hits.normal), at(&hits.view));
            let Some((towards, _, irradiance)) = light.at(at(&hits.position)) else {
                continue;
            };
            let cosine = normal.dot(towards).max(0.0);
            let response = match specular {
                SpecularMethod::None => 0.0,
                _ => ggx_cosine(hits.alpha[i], vector(normal), vector(view), vector(towards)),
            };
            let weight = schlick_weight((view + towards).normalize_or_zero().dot(view).max(0.0));
            for channel in 0..3 {
                self.irradiance[channel][i] += irradiance[channel] * cosine;
                self.specular[channel][i] += irradiance[channel] * response;
                self.schlick[channel][i] += irradiance[channel] * response * weight;
            }
        }
    }
}
