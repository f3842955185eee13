//! All lights on all hits of a tile, SIMD over the hits that share a lobe.

use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use lumigon::{
    DISTANCE_FIELD_SPREAD, DiffuseMethod, ImageMethod, Lanes, LightImage, LocalOcclusion, Ltc,
    Mask, PlacedDistanceField, PreparedLtc, Real, Sides, SpecularMethod, eon_multiple_cosine,
    eon_single_cosine, ggx_anisotropic_cosine, ggx_cosine, light_direction, ltc_form_factor,
    ltc_mean_image, reflected_distance, reflected_image, reflected_inclusion,
};
use lumigon_wgpu::Light;

use super::batch::Batch;
use super::geometry::Geometry;
use super::hits::{DIRECT, FITTED, FITTED_ANISOTROPIC, Hits};
use super::lobes::Scattered;
use super::vector;
use super::visible::Visible;
use crate::bounce::{LightTargets, VirtualPoint};
use crate::scene::{PunctualLight, Scene};

/// Sums over lights of radiance times response, by channel, one list each.
type Sums = [Vec<f32>; 3];

/// Lights whose sum is rounded as one: single precision adds thousands only in parts.
const LIGHTS_AT_ONCE: usize = 256;

/// How light is computed.
#[derive(Clone, Copy)]
pub(super) struct Methods {
    pub(super) diffuse: DiffuseMethod,
    pub(super) specular: SpecularMethod,
    pub(super) images: ImageMethod,
}

/// The method whose image is weighted by solid angle, as the light vector's shading is.
const BY_SOLID_ANGLE: DiffuseMethod = DiffuseMethod::LightVector {
    occlusion: LocalOcclusion::Exact,
};

/// Adds what each hit scatters of all polygon lights; `fields` are theirs, for the method that reads them.
pub(super) fn add_polygons(
    scattered: &mut [Scattered],
    hits: &Hits,
    lights: &[Light],
    fields: &[PlacedDistanceField<'_, f32>],
    methods: Methods,
    visibility: Visibility<'_>,
) {
    let mut fields = fields.chunks(LIGHTS_AT_ONCE);
    for (i, lights) in lights.chunks(LIGHTS_AT_ONCE).enumerate() {
        let fields = fields.next().unwrap_or_default();
        let sides = |light: &Light| match light.polygon.sides() {
            Sides::Front => Some(Vec3::from(<[f32; 3]>::from(light.polygon.normal()))),
            Sides::Both => None,
        };
        let sides = lights.iter().map(sides);
        let visible = visibility.trace(hits, i * LIGHTS_AT_ONCE, sides);
        add_few_polygons(scattered, hits, lights, fields, methods, visible.as_ref());
    }
}

/// What lies between hits and lights.
#[derive(Clone, Copy)]
pub(super) enum Visibility<'a> {
    /// Nothing.
    Whole,
    /// The scene's surfaces.
    Traced {
        geometry: &'a Geometry,
        scene: &'a Scene,
        /// Of all lights.
        targets: &'a LightTargets,
        is_cancelled: &'a dyn Fn() -> bool,
    },
}

impl Visibility<'_> {
    /// For as many lights as there are `sides`, from the `first` on.
    fn trace(
        &self,
        hits: &Hits,
        first: usize,
        sides: impl Iterator<Item = Option<Vec3>>,
    ) -> Option<Visible> {
        let Self::Traced {
            geometry,
            scene,
            targets,
            is_cancelled,
        } = *self
        else {
            return None;
        };
        let points = &targets.points[first * targets.per_light..];
        let lights: Vec<_> = points.chunks(targets.per_light).zip(sides).collect();
        Some(Visible::trace(geometry, scene, hits, &lights, is_cancelled))
    }
}

/// Adds what each hit scatters of virtual points.
pub(super) fn add_virtual_points(
    scattered: &mut [Scattered],
    hits: &Hits,
    points: &[VirtualPoint],
    specular: SpecularMethod,
    visibility: Visibility<'_>,
) {
    for (i, points) in points.chunks(LIGHTS_AT_ONCE).enumerate() {
        let sides = points.iter().map(|point| Some(point.normal));
        let visible = visibility.trace(hits, i * LIGHTS_AT_ONCE, sides);
        for (hit, (lobes, scattered)) in (0..).zip(hits.lobes().iter().zip(&mut *scattered)) {
            let mut sum = Scattered::default();
            for (light, point) in points.iter().enumerate() {
                let Some((towards, irradiance)) = point.at(lobes.position) else {
                    continue;
                };
                let share = visible
                    .as_ref()
                    .map_or(1.0, |visible| visible.share(hit, light));
                sum += lobes.evaluate_by(towards, specular) * (irradiance * share);
            }
            *scattered += sum;
        }
    }
}

/// Adds what each hit scatters of a few lights.
fn add_few_polygons(
    scattered: &mut [Scattered],
    hits: &Hits,
    lights: &[Light],
    fields: &[PlacedDistanceField<'_, f32>],
    methods: Methods,
    visible: Option<&Visible>,
) {
    let Methods {
        diffuse, images, ..
    } = methods;
    for (surfaces, method) in [
        (&hits.irradiance, diffuse),
        (&hits.exact_irradiance, DiffuseMethod::default()),
    ] {
        if !surfaces.is_empty() {
            let sums = dispatch!(Level::new(), simd => {
                irradiance(simd, surfaces, lights, method, images, visible)
            });
            for (i, &(hit, weight)) in surfaces.entries().iter().enumerate() {
                scattered[hit as usize] += weight * at(&sums, i);
            }
        }
    }
    for fitted in hits.fitted.iter().filter(|batch| !batch.is_empty()) {
        let sums = dispatch!(Level::new(), simd => {
            form_factors(simd, fitted, lights, images, isotropic, visible)
        });
        for (i, &(hit, weight)) in fitted.entries().iter().enumerate() {
            scattered[hit as usize] += weight * at(&sums, i);
        }
    }
    let fitted = &hits.fitted_anisotropic;
    if !fitted.is_empty() {
        let sums = dispatch!(Level::new(), simd => {
            form_factors(simd, fitted, lights, images, anisotropic, visible)
        });
        for (i, &(hit, weight)) in fitted.entries().iter().enumerate() {
            scattered[hit as usize] += weight * at(&sums, i);
        }
    }
    if let DiffuseMethod::LightVector { occlusion } = diffuse
        && !hits.rough.is_empty()
    {
        let [single, multiple] = dispatch!(Level::new(), simd => {
            rough_responses(simd, &hits.rough, lights, occlusion, images, visible)
        });
        for (i, &(hit, weights)) in hits.rough.entries().iter().enumerate() {
            scattered[hit as usize].diffuse +=
                weights[0] * at(&single, i) + weights[1] * at(&multiple, i);
        }
    }
    let isotropic = hits.direct.iter().map(|batch| (batch, false));
    let direct = isotropic.chain([(&hits.direct_anisotropic, true)]);
    for (direct, anisotropic) in direct.filter(|(batch, _)| !batch.is_empty()) {
        let [whole, schlick] = dispatch!(Level::new(), simd => {
            responses(simd, direct, lights, fields, methods, anisotropic, visible)
        });
        for (i, &(hit, [f0, f90])) in direct.entries().iter().enumerate() {
            let (whole, schlick) = (at(&whole, i), at(&schlick, i));
            scattered[hit as usize].specular += f0 * (whole - schlick) + f90 * schlick;
        }
    }
    for (hit, lobes) in &hits.sheens {
        let Some(sheen) = &lobes.sheen else {
            continue;
        };
        let [point, normal] = [lobes.position, lobes.normal].map(vector);
        for (i, light) in lights.iter().enumerate() {
            // A sheen has no mirror direction: whatever the method, all light comes from the
            // light vector's.
            let seen = light_direction(&light.polygon, point, normal, LocalOcclusion::Exact);
            let direction = Vec3::new(seen.direction.x, seen.direction.y, seen.direction.z);
            let response = sheen.evaluate(lobes.normal, lobes.view, direction);
            let shown = light.image.as_ref().map_or(Vec3::ONE, |image| {
                let mean = BY_SOLID_ANGLE.mean_image(&light.polygon, image, point, normal, images);
                Vec3::from(mean)
            });
            let share = visible.map_or(1.0, |visible| visible.share(*hit, i));
            scattered[*hit as usize].specular +=
                response * Vec3::from(light.radiance) * shown * (seen.solid_angle * share);
        }
    }
}

fn at(sums: &Sums, i: usize) -> Vec3 {
    Vec3::new(sums[0][i], sums[1][i], sums[2][i])
}

#[inline(always)]
fn add<S: Simd>(sum: &mut [Lanes<S>; 3], radiance: [Lanes<S>; 3], response: Lanes<S>) {
    for (sum, radiance) in sum.iter_mut().zip(radiance) {
        *sum = response.mul_add(radiance, *sum);
    }
}

/// A light's mean radiance, where any lane has a response.
#[inline(always)]
fn radiance<S: Simd>(
    light: &Light,
    response: Lanes<S>,
    mean_image: impl FnOnce(&LightImage<f32>) -> [Lanes<S>; 3],
) -> [Lanes<S>; 3] {
    let [r, g, b] = light.radiance;
    let whole = [
        response.broadcast(r),
        response.broadcast(g),
        response.broadcast(b),
    ];
    match &light.image {
        Some(image) if response.gt(response.constant(0.0)).any() => {
            let [red, green, blue] = mean_image(image);
            [whole[0] * red, whole[1] * green, whole[2] * blue]
        }
        _ => whole,
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
    surfaces: &Batch<6, Scattered>,
    lights: &[Light],
    method: DiffuseMethod,
    images: ImageMethod,
    visible: Option<&Visible>,
) -> Sums {
    let mut sums = surfaces.dark();
    surfaces.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = surfaces.vectors(simd, 0, start);
            let normal = surfaces.vectors(simd, 3, start);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (i, light) in lights.iter().enumerate() {
                let irradiance = method.irradiance(&light.polygon, point, normal);
                let irradiance = as_seen(simd, irradiance, visible, surfaces.entries(), start, i);
                let radiance = radiance(
                    light,
                    irradiance,
                    #[inline(always)]
                    |image| method.mean_image(&light.polygon, image, point, normal, images),
                );
                add(&mut sum, radiance, irradiance);
            }
            store(sum, &mut sums, start);
        },
    );
    sums
}

/// A response, as far as its light is seen.
#[inline(always)]
fn as_seen<S: Simd, W>(
    simd: S,
    response: Lanes<S>,
    visible: Option<&Visible>,
    entries: &[(u32, W)],
    start: usize,
    light: usize,
) -> Lanes<S> {
    match visible {
        Some(visible) => response * visible.lanes(simd, entries, start, light),
        None => response,
    }
}

/// The lobes of one packet.
#[inline(always)]
fn isotropic<S: Simd>(
    simd: S,
    lobes: &Batch<FITTED, Scattered>,
    start: usize,
) -> PreparedLtc<Lanes<S>> {
    let normal = lobes.vectors(simd, 3, start);
    let view = lobes.vectors(simd, 6, start);
    // Amplitudes are in the batch's weights.
    let mut lobe = Ltc::cosine(Lanes::splat(simd, 0.0));
    lobe.shading_to_cosine = [
        lobes.lanes(simd, 9, start),
        lobes.lanes(simd, 10, start),
        lobes.lanes(simd, 11, start),
        lobes.lanes(simd, 12, start),
    ];
    PreparedLtc::new(&lobe, normal, view)
}

/// The same without symmetry.
#[inline(always)]
fn anisotropic<S: Simd>(
    simd: S,
    lobes: &Batch<FITTED_ANISOTROPIC, Scattered>,
    start: usize,
) -> PreparedLtc<Lanes<S>> {
    let rows = [
        lobes.vectors(simd, 6, start),
        lobes.vectors(simd, 9, start),
        lobes.vectors(simd, 12, start),
    ];
    PreparedLtc::from_world_to_cosine(rows, lobes.vectors(simd, 3, start))
}

/// The fitted lobes' form factors.
#[inline(always)]
fn form_factors<S: Simd, const N: usize>(
    simd: S,
    lobes: &Batch<N, Scattered>,
    lights: &[Light],
    images: ImageMethod,
    prepare: impl Fn(S, &Batch<N, Scattered>, usize) -> PreparedLtc<Lanes<S>>,
    visible: Option<&Visible>,
) -> Sums {
    let mut sums = lobes.dark();
    lobes.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = lobes.vectors(simd, 0, start);
            let prepared = prepare(simd, lobes, start);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (i, light) in lights.iter().enumerate() {
                let form_factor = ltc_form_factor(&light.polygon, point, &prepared);
                let form_factor = as_seen(simd, form_factor, visible, lobes.entries(), start, i);
                let radiance = radiance(
                    light,
                    form_factor,
                    #[inline(always)]
                    |image| ltc_mean_image(&light.polygon, image, point, &prepared, images),
                );
                add(&mut sum, radiance, form_factor);
            }
            store(sum, &mut sums, start);
        },
    );
    sums
}

/// What rough diffuse surfaces scatter once and more than once, all light coming along the light
/// vector.
#[inline(always)]
fn rough_responses<S: Simd>(
    simd: S,
    surfaces: &Batch<10, [Vec3; 2]>,
    lights: &[Light],
    occlusion: LocalOcclusion,
    images: ImageMethod,
    visible: Option<&Visible>,
) -> [Sums; 2] {
    let (mut all_single, mut all_multiple) = (surfaces.dark(), surfaces.dark());
    surfaces.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = surfaces.vectors(simd, 0, start);
            let normal = surfaces.vectors(simd, 3, start);
            let view = surfaces.vectors(simd, 6, start);
            let roughness = surfaces.lanes(simd, 9, start);
            let mut single = [Lanes::splat(simd, 0.0); 3];
            let mut multiple = single;
            for (i, light) in lights.iter().enumerate() {
                let mut seen = light_direction(&light.polygon, point, normal, occlusion);
                let entries = surfaces.entries();
                seen.solid_angle = as_seen(simd, seen.solid_angle, visible, entries, start, i);
                let once = eon_single_cosine(roughness, normal, view, seen.direction);
                let more = eon_multiple_cosine(roughness, normal, view, seen.direction);
                let radiance = radiance(
                    light,
                    seen.solid_angle,
                    #[inline(always)]
                    |image| {
                        let by_solid_angle = DiffuseMethod::LightVector { occlusion };
                        by_solid_angle.mean_image(&light.polygon, image, point, normal, images)
                    },
                );
                add(&mut single, radiance, once * seen.solid_angle);
                add(&mut multiple, radiance, more * seen.solid_angle);
            }
            store(single, &mut all_single, start);
            store(multiple, &mut all_multiple, start);
        },
    );
    [all_single, all_multiple]
}

/// Response of GGX lobes with F = 1, and the same weighted by Schlick's (1 - h.v)^5, by methods
/// that know one direction a light.
#[inline(always)]
fn responses<S: Simd>(
    simd: S,
    lobes: &Batch<DIRECT, [Vec3; 2]>,
    lights: &[Light],
    fields: &[PlacedDistanceField<'_, f32>],
    methods: Methods,
    anisotropic: bool,
    visible: Option<&Visible>,
) -> [Sums; 2] {
    let images = methods.images;
    let (mut all_whole, mut all_schlick) = (lobes.dark(), lobes.dark());
    lobes.for_each_packet::<S>(
        #[inline(always)]
        |start| {
            let point = lobes.vectors(simd, 0, start);
            let normal = lobes.vectors(simd, 3, start);
            let view = lobes.vectors(simd, 6, start);
            let mut whole = [Lanes::splat(simd, 0.0); 3];
            let mut schlick = whole;
            match methods.specular {
                SpecularMethod::None | SpecularMethod::Ltc { .. } => {}
                SpecularMethod::ReflectedInclusion(rule) => {
                    let weight = schlick_weight(normal.dot(view));
                    for (i, light) in lights.iter().enumerate() {
                        let inside = reflected_inclusion(&light.polygon, point, normal, view, rule);
                        let inside = as_seen(simd, inside, visible, lobes.entries(), start, i);
                        let radiance = radiance(
                            light,
                            inside,
                            #[inline(always)]
                            |image| {
                                let mirror = inside.constant(0.0);
                                reflected_image(&light.polygon, image, point, normal, view, mirror)
                            },
                        );
                        add(&mut whole, radiance, inside);
                        add(&mut schlick, radiance, inside * weight);
                    }
                }
                SpecularMethod::ReflectedDistanceField { smoothness, .. } => {
                    let weight = schlick_weight(normal.dot(view));
                    // Distances have no direction: of two widths their mean.
                    let alpha = lobes.lanes(simd, 12, start) * lobes.lanes(simd, 13, start);
                    let alpha = alpha.sqrt();
                    let spread = alpha * alpha.constant(DISTANCE_FIELD_SPREAD);
                    for (i, (light, &field)) in lights.iter().zip(fields).enumerate() {
                        let polygon = &light.polygon;
                        let near = reflected_distance(
                            polygon, field, point, normal, view, alpha, smoothness,
                        );
                        let near = as_seen(simd, near, visible, lobes.entries(), start, i);
                        let radiance = radiance(
                            light,
                            near,
                            #[inline(always)]
                            |image| reflected_image(polygon, image, point, normal, view, spread),
                        );
                        add(&mut whole, radiance, near);
                        add(&mut schlick, radiance, near * weight);
                    }
                }
                SpecularMethod::LightVector => {
                    let tangent = lobes.vectors(simd, 9, start);
                    let bitangent = normal.cross(tangent);
                    let alpha = [lobes.lanes(simd, 12, start), lobes.lanes(simd, 13, start)];
                    for (i, light) in lights.iter().enumerate() {
                        let mut seen =
                            light_direction(&light.polygon, point, normal, LocalOcclusion::Exact);
                        let entries = lobes.entries();
                        seen.solid_angle =
                            as_seen(simd, seen.solid_angle, visible, entries, start, i);
                        let towards = seen.direction;
                        let response = if anisotropic {
                            ggx_anisotropic_cosine(alpha, tangent, bitangent, normal, view, towards)
                        } else {
                            ggx_cosine(alpha[0], normal, view, towards)
                        } * seen.solid_angle;
                        let half = (view + seen.direction).normalize_or_zero();
                        let weight = schlick_weight(half.dot(view));
                        let radiance = radiance(
                            light,
                            response,
                            #[inline(always)]
                            |image| {
                                let polygon = &light.polygon;
                                BY_SOLID_ANGLE.mean_image(polygon, image, point, normal, images)
                            },
                        );
                        add(&mut whole, radiance, response);
                        add(&mut schlick, radiance, response * weight);
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

/// Adds what each hit scatters of a light without extent, as far as it is visible.
pub(super) fn add_punctual(
    scattered: &mut [Scattered],
    hits: &Hits,
    light: &PunctualLight,
    specular: SpecularMethod,
    is_visible: impl Fn(Vec3, Vec3, f32) -> bool,
) {
    for (lobes, scattered) in hits.lobes().iter().zip(scattered) {
        let Some((towards, distance, irradiance)) = light.at(lobes.position) else {
            continue;
        };
        let response = lobes.evaluate_by(towards, specular);
        if !response.is_black() && is_visible(lobes.position, towards, distance) {
            *scattered += response * irradiance;
        }
    }
}
