//! Every method's mean image beside that of cubature.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use lumigon::{DiffuseMethod, ImageMethod, LtcTable, irradiance, ltc_form_factor, ltc_mean_image};
use lumigon_reference::{TexelWeights, Tolerance, Weighting, texel_weights};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::light::{Shown, StudyLight};
use super::place::{Distance, Place, Surface, unit, vector};
use super::texture::Kind;
use crate::Failure;
use crate::interrupt::Interrupt;

/// The methods, the conventional one first.
pub(super) const METHODS: [(&str, ImageMethod); 5] = [
    ("lookup", ImageMethod::Lookup),
    ("1x1", ImageMethod::Quadrature { taps: 1 }),
    ("2x2", ImageMethod::Quadrature { taps: 2 }),
    ("3x3", ImageMethod::Quadrature { taps: 3 }),
    ("4x4", ImageMethod::Quadrature { taps: 4 }),
];

/// One number a method.
pub(super) type Numbers = [f64; METHODS.len()];

/// Errors of the weights' sum, relative to it.
const TOLERANCE: Tolerance = Tolerance {
    absolute: 0.0,
    relative: 1e-4,
    max_evaluations: 50_000_000,
};

/// Less of a specular lobe is not seen.
const LEAST_SHARE: f64 = 0.01;

/// Less of what a diffuse surface would get from the light facing it is not seen.
const LEAST_IRRADIANCE: f64 = 0.02;

/// Draws until there is a place.
const MOST_DRAWS: usize = 1_000_000;

/// One image at one place.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub(super) distance: Distance,
    pub(super) surface: Surface,
    pub(super) perceptual_roughness: Option<f32>,
    pub(super) outline: &'static str,
    pub(super) kind: Kind,
    /// Share of the lobe, or form factor, that the light covers.
    pub(super) share: f64,
    /// Root mean square over the channels, as a share of the image's mean.
    pub(super) errors: Numbers,
    /// The same against GGX itself instead of its fitted lobe.
    pub(super) ggx_errors: Option<Numbers>,
}

/// A place with its light.
pub(super) struct Task {
    pub(super) light: usize,
    pub(super) distance: Distance,
    pub(super) surface: Surface,
    pub(super) place: Place,
}

/// Draws `count` places of every class.
pub(super) fn draw(
    lights: &[StudyLight],
    count: u32,
    seed: u64,
    interrupt: &Interrupt,
) -> Result<Vec<Task>, Failure> {
    let table = LtcTable::ggx();
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut tasks = Vec::new();
    for distance in Distance::ALL {
        for surface in Surface::ALL {
            for _ in 0..count {
                interrupt.check()?;
                let task = (0..MOST_DRAWS).find_map(|_| {
                    let light = rng.random_range(0..lights.len());
                    let place = Place::draw(&lights[light], distance, surface, &table, &mut rng)?;
                    is_seen(&lights[light], &place).then_some(Task {
                        light,
                        distance,
                        surface,
                        place,
                    })
                });
                tasks.push(task.ok_or("no light is seen from anywhere")?);
            }
        }
    }
    Ok(tasks)
}

/// Whether a light adds enough to a place to show.
fn is_seen(light: &StudyLight, place: &Place) -> bool {
    let (point, normal) = (vector(place.point), vector(place.normal));
    match &place.lobe {
        Some(lobe) => {
            let share = ltc_form_factor(&light.light, point, &lobe.prepared);
            f64::from(share) >= LEAST_SHARE
        }
        None => {
            let squared = DVec3::from(place.point.map(f64::from)).length_squared();
            let facing = (f64::from(light.light.area()) / squared).min(1.0);
            let irradiance: f32 = irradiance(&light.light, point, normal);
            f64::from(irradiance) >= LEAST_IRRADIANCE * facing
        }
    }
}

/// Measures every image at every place.
pub(super) fn measure(
    lights: &[StudyLight],
    tasks: &[Task],
    progress: &(impl Fn(u64, u64) + Sync),
    interrupt: &Interrupt,
) -> Result<Vec<Sample>, Failure> {
    let done = AtomicU64::new(0);
    let samples: Result<Vec<Vec<Sample>>, Failure> = tasks
        .par_iter()
        .map(|task| {
            interrupt.check()?;
            let samples = samples(&lights[task.light], task)?;
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, tasks.len() as u64);
            Ok(samples)
        })
        .collect();
    Ok(samples?.into_iter().flatten().collect())
}

fn samples(light: &StudyLight, task: &Task) -> Result<Vec<Sample>, Failure> {
    let place = &task.place;
    let weights = truth(light, place, &weighting(place))?;
    let ggx = match ggx(place) {
        Some(weighting) => Some(truth(light, place, &weighting)?),
        None => None,
    };
    let samples = light.images.iter().filter_map(|shown| {
        let found = METHODS.map(|(_, method)| mean_image(light, shown, place, method));
        let errors = |weights: &TexelWeights| {
            let truth = weights.mean(&shown.texels)?.value;
            Some(found.map(|found| error(found, truth) / shown.mean))
        };
        Some(Sample {
            distance: task.distance,
            surface: task.surface,
            perceptual_roughness: place.lobe.as_ref().map(|lobe| lobe.perceptual_roughness),
            outline: light.name,
            kind: shown.kind,
            share: match task.surface {
                Surface::Diffuse => weights.total() * std::f64::consts::FRAC_1_PI,
                Surface::Specular => weights.total(),
            },
            errors: errors(&weights)?,
            ggx_errors: ggx.as_ref().and_then(errors),
        })
    });
    Ok(samples.collect())
}

/// Root mean square over the channels.
pub(super) fn error(found: [f32; 3], truth: [f64; 3]) -> f64 {
    let squares = found
        .iter()
        .zip(truth)
        .map(|(found, truth)| (f64::from(*found) - truth).powi(2));
    (squares.sum::<f64>() / 3.0).sqrt()
}

/// The mean image by a method, as a renderer has it: in single precision.
pub(super) fn mean_image(
    light: &StudyLight,
    shown: &Shown,
    place: &Place,
    method: ImageMethod,
) -> [f32; 3] {
    let point = vector(place.point);
    match &place.lobe {
        Some(lobe) => ltc_mean_image(&light.light, &shown.image, point, &lobe.prepared, method),
        None => DiffuseMethod::default().mean_image(
            &light.light,
            &shown.image,
            point,
            vector(place.normal),
            method,
        ),
    }
}

/// What the methods estimate the mean under.
pub(super) fn weighting(place: &Place) -> Weighting {
    let normal = unit(place.normal);
    match &place.lobe {
        None => Weighting::Cosine { normal },
        Some(lobe) => Weighting::TransformedCosine {
            to_cosine: lobe
                .prepared
                .world_to_cosine()
                .map(|row| <[f32; 3]>::from(row).map(f64::from)),
            normal,
        },
    }
}

fn ggx(place: &Place) -> Option<Weighting> {
    let lobe = place.lobe.as_ref()?;
    Some(Weighting::Ggx {
        normal: unit(place.normal),
        view: unit(lobe.view),
        alpha: f64::from(lobe.perceptual_roughness).powi(2),
    })
}

pub(super) fn truth(
    light: &StudyLight,
    place: &Place,
    weighting: &Weighting,
) -> Result<TexelWeights, Failure> {
    let point = place.point.map(f64::from);
    let weights = texel_weights(&light.reference, &light.grid, point, weighting, TOLERANCE)?;
    Ok(weights)
}
