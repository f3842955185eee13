//! A path tracer with an honest error bar.
//!
//! At every surface, light from the polygon lights is estimated with one sample of each technique - a point on a
//! light, and a direction of each lobe that the material has - weighted by the balance heuristic (Veach and Guibas
//! 1995): each sample counts f / (sum of all the densities). Lights are found along sampled directions by
//! intersecting their own triangles, so the same code renders with shadows and without.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::bsdf::Bsdf;
use crate::emitter::EmitterPoint;
use crate::estimate::{Channel, Estimate, Moments, Welford};
use crate::lobes::Lobes;
use crate::sampling::Random;
use crate::scene::{Ray, Scene, Surface};
use crate::settings::{RenderError, Settings};

/// Bounces after which paths of little throughput may end by chance.
const ROULETTE_AFTER: u32 = 4;

/// Surfaces along one ray that may send light past each other.
const SURFACES_ALONG_A_RAY: usize = 256;

/// Renders an image; the same settings give the same bits on any number of threads.
///
/// `camera` maps image positions, in pixels from the top left corner, to rays. `progress` hears after each row how
/// many rows of how many are done, from any thread. Setting `cancel` stops within a pixel's time.
///
/// # Errors
/// Settings that make no sense, or [`RenderError::Cancelled`].
pub fn render(
    scene: &impl Scene,
    camera: &(impl Fn(f64, f64) -> Ray + Sync),
    settings: &Settings<'_>,
    progress: &(impl Fn(usize, usize) + Sync),
    cancel: &AtomicBool,
) -> Result<Estimate, RenderError> {
    let &Settings { width, height, .. } = settings;
    settings.check()?;
    let tracer = Tracer { scene, settings };
    let rows_done = AtomicUsize::new(0);
    let rows: Vec<Vec<Pixel>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let row = (0..width)
                .map(|x| match cancel.load(Ordering::Relaxed) {
                    true => Err(RenderError::Cancelled),
                    false => Ok(tracer.pixel(camera, x, y)),
                })
                .collect();
            progress(rows_done.fetch_add(1, Ordering::Relaxed) + 1, height);
            row
        })
        .collect::<Result<_, _>>()?;

    let pixels = || rows.iter().flatten();
    let channel = |part: fn(&Pixel) -> Moments| Channel {
        mean: pixels().map(|p| part(p).mean.into()).collect(),
        standard_error: pixels()
            .map(|p| part(p).variance.map(f64::sqrt).into())
            .collect(),
    };
    Ok(Estimate {
        width,
        height,
        emitted: pixels().map(|p| p.emitted.into()).collect(),
        diffuse: channel(|p| p.diffuse),
        specular: channel(|p| p.specular),
        total: channel(|p| p.total),
        invalid_samples: pixels().map(|p| p.invalid_samples).sum(),
    })
}

#[derive(Default)]
struct Pixel {
    emitted: DVec3,
    diffuse: Moments,
    specular: Moments,
    total: Moments,
    invalid_samples: usize,
}

/// A surface on a path, with what every sample there needs.
struct Vertex {
    position: DVec3,
    geometric_normal: DVec3,
    bsdf: Bsdf,
    /// Probability of choosing each emitter.
    choice: Vec<f64>,
}

struct Tracer<'a, S> {
    scene: &'a S,
    settings: &'a Settings<'a>,
}

impl<S: Scene> Tracer<'_, S> {
    /// All samples of one pixel: each pixel sample's first surface is found once, its light sampled again and again.
    fn pixel(&self, camera: &impl Fn(f64, f64) -> Ray, x: usize, y: usize) -> Pixel {
        let Settings {
            width,
            pixel_samples,
            samples_per_pixel,
            seed,
            ..
        } = *self.settings;
        let mut random = Random::new(seed, (y * width + x) as u64);
        let share = 1.0 / pixel_samples.len() as f64;
        let mut pixel = Pixel::default();
        for [dx, dy] in pixel_samples {
            let ray = camera(x as f64 + dx, y as f64 + dy);
            let direction = DVec3::from(ray.direction).normalize_or_zero();
            let Some(surface) = self.scene.intersect(ray.origin, direction.into()) else {
                continue;
            };
            let vertex = self.vertex(&surface, -direction);
            let (constant, emitted) = if self.settings.direct {
                let emitted = DVec3::from(surface.emitted) * vertex.bsdf.below_clearcoat();
                (self.punctual(&vertex), emitted)
            } else {
                (Lobes::default(), DVec3::ZERO)
            };
            let [mut diffuse, mut specular, mut total] = [Welford::default(); 3];
            for _ in 0..samples_per_pixel / pixel_samples.len() {
                let mut sample = constant + self.path(&vertex, &mut random);
                if !sample.sum().is_finite() {
                    pixel.invalid_samples += 1;
                    sample = Lobes::default();
                }
                diffuse.add(sample.diffuse);
                specular.add(sample.specular);
                total.add(emitted + sample.sum());
            }
            pixel.emitted += share * emitted;
            for (sum, part) in [
                (&mut pixel.diffuse, diffuse),
                (&mut pixel.specular, specular),
                (&mut pixel.total, total),
            ] {
                // Shares are independent: variances within them add up, differences between them are no noise.
                let Moments { mean, variance } = part.moments();
                sum.mean += share * mean;
                sum.variance += share * share * variance;
            }
        }
        pixel
    }

    fn vertex(&self, surface: &Surface, view: DVec3) -> Vertex {
        let position = DVec3::from(surface.position);
        let bsdf = Bsdf::new(surface, view);
        let (normal, clearcoat_normal) = bsdf.normals();
        let mut choice: Vec<f64> = self
            .scene
            .emitters()
            .iter()
            .map(|emitter| {
                let above = |normal| emitter.importance(position, normal);
                clearcoat_normal.map_or(0.0, above).max(above(normal))
            })
            .collect();
        let sum: f64 = choice.iter().sum();
        if sum > 0.0 {
            choice.iter_mut().for_each(|weight| *weight /= sum);
        }
        Vertex {
            position,
            geometric_normal: surface.geometric_normal.into(),
            bsdf,
            choice,
        }
    }

    /// Reflected light of one random path, but for the punctual lights at its first surface, which need no chance.
    fn path(&self, first: &Vertex, random: &mut Random) -> Lobes {
        let mut light = Lobes::default();
        if self.settings.direct {
            light = self.emitters(first, random);
        }
        let Some((mut position, mut direction, mut throughput)) = self.continuation(first, random)
        else {
            return light;
        };
        for bounce in 2..=self.settings.bounces {
            let vertices = self.senders(position, direction);
            for vertex in &vertices {
                let arriving = self.punctual(vertex) + self.emitters(vertex, random);
                light += throughput * arriving.sum();
            }
            // One of them stands for all: as likely as any other, and as strong as they are many.
            let vertex = match vertices.as_slice() {
                [] => break,
                [only] => only,
                several => {
                    throughput = throughput * DVec3::splat(several.len() as f64);
                    let index = (random.uniform() * several.len() as f64) as usize;
                    &several[index.min(several.len() - 1)]
                }
            };
            if bounce >= ROULETTE_AFTER {
                let survival = throughput.sum().max_element().min(0.95);
                if random.uniform() >= survival {
                    break;
                }
                throughput = throughput * DVec3::splat(1.0 / survival);
            }
            let Some((next_position, next_direction, weight)) = self.continuation(vertex, random)
            else {
                break;
            };
            (position, direction) = (next_position, next_direction);
            throughput = throughput * weight.sum();
        }
        light
    }

    /// The surfaces that send light against `direction` to `position`: the nearest one, or all if none blocks another.
    fn senders(&self, mut position: DVec3, direction: DVec3) -> Vec<Vertex> {
        let limit = match self.settings.bounce_shadows {
            true => 1,
            false => SURFACES_ALONG_A_RAY,
        };
        let mut vertices = vec![];
        while vertices.len() < limit
            && let Some(surface) = self.scene.intersect(position.into(), direction.into())
        {
            position = surface.position.into();
            vertices.push(self.vertex(&surface, -direction));
        }
        vertices
    }

    /// Where a path goes on from a surface, and by what factor; `None` if the surface swallows it.
    fn continuation(&self, vertex: &Vertex, random: &mut Random) -> Option<(DVec3, DVec3, Lobes)> {
        if self.settings.bounces == 1 {
            return None;
        }
        let (direction, weight) = vertex.bsdf.sample(random)?;
        // Shading normals bend some directions into the surface itself.
        (direction.dot(vertex.geometric_normal) > 0.0).then_some((
            vertex.position,
            direction,
            weight,
        ))
    }

    /// Light of the punctual lights, reflected once.
    fn punctual(&self, vertex: &Vertex) -> Lobes {
        let mut light = Lobes::default();
        for source in self.scene.punctual_lights() {
            let (direction, distance, irradiance) = source.incident(vertex.position);
            let reflected = vertex.bsdf.evaluate(direction) * irradiance;
            if reflected != Lobes::default() && self.visible(vertex, direction, distance) {
                light += reflected;
            }
        }
        light
    }

    /// Light of the polygon lights, reflected once: one sample of each technique.
    fn emitters(&self, vertex: &Vertex, random: &mut Random) -> Lobes {
        let emitters = self.scene.emitters();
        let mut light = Lobes::default();
        if vertex.choice.iter().all(|&probability| probability == 0.0) {
            return light;
        }
        let chosen = choose(&vertex.choice, random.uniform());
        if let Some(seen) = emitters[chosen].sample(vertex.position, random) {
            light += self.weighted(vertex, chosen, &seen);
        }
        for direction in vertex.bsdf.sample_each(random) {
            for (index, emitter) in emitters.iter().enumerate() {
                for seen in emitter.hits(vertex.position, direction) {
                    light += self.weighted(vertex, index, &seen);
                }
            }
        }
        light
    }

    /// Reflected light over the sum of the densities with which the techniques find this point of this emitter.
    fn weighted(&self, vertex: &Vertex, index: usize, seen: &EmitterPoint) -> Lobes {
        let emitter = &self.scene.emitters()[index];
        let place = vertex.position + seen.direction * seen.distance;
        let radiance = self.scene.emitter_radiance(index, place.into());
        let reflected = vertex.bsdf.evaluate(seen.direction) * DVec3::from(radiance);
        if reflected == Lobes::default() || !self.visible(vertex, seen.direction, seen.distance) {
            return Lobes::default();
        }
        let by_light = vertex.choice[index] / (emitter.area() * seen.solid_angle_per_area);
        reflected * DVec3::splat(1.0 / (by_light + vertex.bsdf.density_of_each(seen.direction)))
    }

    fn visible(&self, vertex: &Vertex, direction: DVec3, distance: f64) -> bool {
        !self.settings.shadows
            || !self
                .scene
                .occluded(vertex.position.into(), direction.into(), distance)
    }
}

/// Index drawn with the given probabilities, of which at least one is not zero.
fn choose(probabilities: &[f64], u: f64) -> usize {
    let mut left = u;
    let mut last = 0;
    for (index, &probability) in probabilities.iter().enumerate() {
        if probability > 0.0 {
            if left < probability {
                return index;
            }
            left -= probability;
            last = index;
        }
    }
    // Rounding may leave a little over.
    last
}

#[cfg(test)]
mod tests;
