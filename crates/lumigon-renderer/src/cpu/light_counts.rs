//! How many lights each pixel is lit by.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use lumigon::{
    DiffuseMethod, LocalOcclusion, Ltc, PreparedLtc, Sides, SpecularMethod, Vec3 as LightVec3,
    irradiance_bound, ltc_form_factor_bound,
};
use lumigon_wgpu::Light;
use rayon::prelude::*;

use super::hits::{Hits, Wanted};
use super::lobes::Scattered;
use super::{CpuRenderer, check_size, vector};
use crate::render::{RenderError, RenderSettings, Watch};
use crate::scene::Camera;

impl CpuRenderer<'_> {
    /// For each pixel, row by row, how many of the scene's polygon lights are computed at what its centre
    /// sees: those that are at least partly above the surface's horizon, or its coat's, and have the
    /// surface before a side that emits. Where [`RenderSettings::light_bound`] is more than 0 and the
    /// methods allow it, those alone of them that could add as much, as the GPU decides it pixel by
    /// pixel. Nothing blocks lights. 0 where nothing is seen; the settings' samples are of no effect.
    ///
    /// # Errors
    /// Where the size is out of range, or when cancelled.
    pub fn light_counts(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        watch: Watch<'_>,
    ) -> Result<Vec<u32>, RenderError> {
        check_size(settings.width, settings.height, 1)?;
        let (width, height) = (settings.width, settings.height);
        let aspect = width as f32 / height as f32;
        let bound = is_bounded(settings).then(|| Bound {
            least: settings.light_bound,
            radiance: self.lights.par_iter().map(greatest_radiance).collect(),
        });
        let wanted = Wanted {
            diffuse: settings.diffuse,
            specular: settings.specular,
            lobes: true,
        };
        let at = |pixel: u32, size: u32| ((f64::from(pixel) + 0.5) / f64::from(size)) as f32;
        let done = AtomicU64::new(0);
        let rows: Vec<Option<Vec<u32>>> = (0..height)
            .into_par_iter()
            .map_init(Hits::default, |hits, y| {
                let count = |x| {
                    let place = [at(x, width), at(y, height)];
                    let Some(((surface, view), _)) = self.seen(camera, place, aspect) else {
                        return 0;
                    };
                    hits.clear();
                    hits.push(0, &surface, view, &self.fitted, wanted);
                    self.counting(hits, bound.as_ref())
                };
                let row = (!watch.is_cancelled()).then(|| (0..width).map(count).collect());
                (watch.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, height.into());
                row
            })
            .collect();
        let mut counts = Vec::with_capacity(width as usize * height as usize);
        for row in rows {
            counts.extend(row.ok_or(RenderError::Cancelled)?);
        }
        Ok(counts)
    }

    /// The lights that count at the one hit.
    fn counting(&self, hits: &Hits, bound: Option<&Bound>) -> u32 {
        let [lobes] = hits.lobes() else {
            return 0;
        };
        let point = lobes.position;
        let coat = lobes.clearcoat.as_deref().map(|coat| coat.normal);
        let responses = bound.map(|bound| (bound, Responses::new(hits)));
        let counts = |&(i, light): &(usize, &Light)| {
            let mut normals = [Some(lobes.normal), coat].into_iter().flatten();
            faces(light, point)
                && normals.any(|normal| is_above(light, point, normal))
                && responses.as_ref().is_none_or(|(bound, responses)| {
                    let most = responses.most(light) * bound.radiance[i];
                    // As the shader, which keeps what is not a number.
                    most.is_nan() || most >= bound.least
                })
        };
        self.lights.iter().enumerate().filter(counts).count() as u32
    }
}

/// Below what lights do not count.
struct Bound {
    least: f32,
    /// The brightest channel of what each light emits anywhere.
    radiance: Vec<f32>,
}

/// Bounds hold for the integrals themselves.
fn is_bounded(settings: &RenderSettings) -> bool {
    let is_exact = settings.diffuse
        == DiffuseMethod::Exact {
            occlusion: LocalOcclusion::Exact,
        };
    let is_fitted = matches!(
        settings.specular,
        SpecularMethod::None | SpecularMethod::Ltc { .. }
    );
    settings.light_bound > 0.0 && is_exact && is_fitted
}

fn greatest_radiance(light: &Light) -> f32 {
    let mut greatest = [1.0_f32; 3];
    if let Some(image) = &light.image {
        greatest = [0.0; 3];
        for &[r, g, b, weight] in image.pyramid().level(0) {
            for (greatest, channel) in greatest.iter_mut().zip([r, g, b]) {
                *greatest = greatest.max(channel / weight);
            }
        }
    }
    let channels = light.radiance.iter().zip(greatest);
    channels.map(|(a, b)| a * b).fold(0.0, f32::max)
}

/// Whether a point lies before a side of the light that emits.
fn faces(light: &Light, point: Vec3) -> bool {
    let (center, _) = light.polygon.circumscribed_circle();
    let height = light.polygon.normal().dot(vector(point) - center);
    match light.polygon.sides() {
        Sides::Front => height > 0.0,
        Sides::Both => height != 0.0,
    }
}

/// Whether some of the light is above the horizon.
fn is_above(light: &Light, point: Vec3, normal: Vec3) -> bool {
    let (center, radius) = light.polygon.circumscribed_circle();
    let normal = vector(normal);
    let height = normal.dot(center - vector(point)) / radius;
    let mut offsets = light.polygon.offsets().iter();
    height > -1.0 && (height >= 1.0 || offsets.any(|&offset| height + normal.dot(offset) > 0.0))
}

/// What one hit scatters at most, for light of radiance 1.
struct Responses {
    /// Weights of irradiance, about which point and normal.
    irradiance: Vec<(f32, LightVec3<f32>, LightVec3<f32>)>,
    point: LightVec3<f32>,
    /// Weights of form factors.
    fitted: Vec<(f32, PreparedLtc<f32>)>,
}

impl Responses {
    fn new(hits: &Hits) -> Self {
        let weight = |scattered: &Scattered| (scattered.diffuse + scattered.specular).max_element();
        let mut irradiance = Vec::new();
        let mut fitted = Vec::new();
        for batch in [&hits.irradiance, &hits.exact_irradiance] {
            for (i, (_, scattered)) in batch.entries().iter().enumerate() {
                let numbers = batch.numbers(i);
                let [point, normal] = [0, 3].map(|from| vector_at(&numbers, from));
                irradiance.push((weight(scattered), point, normal));
            }
        }
        for batch in &hits.fitted {
            for (i, (_, scattered)) in batch.entries().iter().enumerate() {
                let numbers = batch.numbers(i);
                let mut ltc = Ltc::cosine(0.0);
                ltc.shading_to_cosine = [numbers[9], numbers[10], numbers[11], numbers[12]];
                let [normal, view] = [3, 6].map(|from| vector_at(&numbers, from));
                fitted.push((weight(scattered), PreparedLtc::new(&ltc, normal, view)));
            }
        }
        let batch = &hits.fitted_anisotropic;
        for (i, (_, scattered)) in batch.entries().iter().enumerate() {
            let numbers = batch.numbers(i);
            let rows = [6, 9, 12].map(|from| vector_at(&numbers, from));
            let lobe = PreparedLtc::from_world_to_cosine(rows, vector_at(&numbers, 3));
            fitted.push((weight(scattered), lobe));
        }
        let point = hits
            .lobes()
            .first()
            .map_or(Vec3::ZERO, |lobes| lobes.position);
        Self {
            irradiance,
            point: vector(point),
            fitted,
        }
    }

    fn most(&self, light: &Light) -> f32 {
        let polygon = &light.polygon;
        let irradiance = self.irradiance.iter();
        let irradiance =
            irradiance.map(|&(weight, point, n)| weight * irradiance_bound(polygon, point, n));
        let fitted = self.fitted.iter();
        let fitted =
            fitted.map(|(weight, lobe)| weight * ltc_form_factor_bound(polygon, self.point, lobe));
        irradiance.chain(fitted).sum()
    }
}

fn vector_at(numbers: &[f32], from: usize) -> LightVec3<f32> {
    LightVec3::new(numbers[from], numbers[from + 1], numbers[from + 2])
}
