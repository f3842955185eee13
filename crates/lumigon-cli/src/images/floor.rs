//! Pictures: a floor before a textured light, by each method beside the truth.

use glam::DVec3;
use image::RgbImage;
use lumigon::{LtcTable, PreparedLtc, irradiance, ltc_form_factor};
use lumigon_renderer::{ToneMap, srgb8};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::light::StudyLight;
use super::measure::{METHODS, mean_image, truth, weighting};
use super::place::{Lobe, Place, Surface, vector};
use super::texture::Kind;
use crate::Failure;
use crate::compare::contact_sheet::{Cell, Section, thumbnail};
use crate::compare::false_color::FalseColor;
use crate::interrupt::Interrupt;

/// Texels a side of the light's image.
const TEXELS: usize = 64;
/// The wide rectangle.
const LIGHT: usize = 4;
/// Of the glossy floor.
const PERCEPTUAL_ROUGHNESS: f32 = 0.35;
/// The methods shown, beside the truth.
const SHOWN: [usize; 4] = [0, 1, 2, 4];

/// One section of pictures for each surface and image, `side` pixels a side.
pub(super) fn sections(
    side: u32,
    seed: u64,
    progress: &(impl Fn(u64, u64) + Sync),
    interrupt: &Interrupt,
) -> Result<Vec<Section>, Failure> {
    let kinds = [Kind::Checkerboard, Kind::Noise];
    let light = StudyLight::new(LIGHT, TEXELS, &kinds, &mut Pcg64::seed_from_u64(seed))?;
    let mut sections = Vec::new();
    for (index, surface) in Surface::ALL.into_iter().enumerate() {
        let rows: Result<Vec<Vec<Pixel>>, Failure> = (0..side)
            .into_par_iter()
            .map(|y| {
                interrupt.check()?;
                let row: Result<_, _> = (0..side)
                    .map(|x| pixel(&light, &place(&light, surface, [x, y], side)))
                    .collect();
                progress(
                    u64::from(side) * index as u64 + u64::from(y) + 1,
                    2 * u64::from(side),
                );
                row
            })
            .collect();
        let pixels: Vec<Pixel> = rows?.into_iter().flatten().collect();
        for (image, kind) in kinds.iter().enumerate() {
            let title = format!("{} floor, {}", surface.name(), kind.name());
            sections.push(section(title, &pixels, image, side));
        }
    }
    Ok(sections)
}

/// Light that one point of the floor reflects, for each image.
struct Pixel {
    truth: Vec<[f32; 3]>,
    found: Vec<[[f32; 3]; METHODS.len()]>,
}

/// The floor lies at right angles to the light, below its edge, seen from above its far end.
fn place(light: &StudyLight, surface: Surface, [x, y]: [u32; 2], side: u32) -> Place {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let bottom = light.frame[0][1];
    let point = DVec3::new(2.6 * (at(x) - 0.5), bottom - 0.05, 0.02 + 2.0 * at(y));
    let normal = [0.0, 1.0, 0.0];
    let view = (DVec3::new(0.0, 1.0, 4.0) - point).normalize();
    let view = view.to_array().map(|x| x as f32);
    let lobe = (surface == Surface::Specular).then(|| {
        let table = LtcTable::ggx();
        let ltc = table.lookup(PERCEPTUAL_ROUGHNESS, view[1]).lobes[0];
        Lobe {
            perceptual_roughness: PERCEPTUAL_ROUGHNESS,
            view,
            prepared: PreparedLtc::new(&ltc, vector(normal), vector(view)),
        }
    });
    Place {
        point: point.to_array().map(|x| x as f32),
        normal,
        lobe,
    }
}

fn pixel(light: &StudyLight, place: &Place) -> Result<Pixel, Failure> {
    let point = vector(place.point);
    let response = match &place.lobe {
        Some(lobe) => ltc_form_factor(&light.light, point, &lobe.prepared),
        None => irradiance(&light.light, point, vector(place.normal)) * std::f32::consts::FRAC_1_PI,
    };
    let weights = truth(light, place, &weighting(place))?;
    let reflected = |mean: [f32; 3]| mean.map(|c| c * response);
    let images = light.images.iter();
    Ok(Pixel {
        truth: images
            .clone()
            .map(|shown| {
                let mean = weights.mean(&shown.texels);
                reflected(mean.map_or([0.0; 3], |mean| mean.value.map(|c| c as f32)))
            })
            .collect(),
        found: images
            .map(|shown| {
                METHODS.map(|(_, method)| reflected(mean_image(light, shown, place, method)))
            })
            .collect(),
    })
}

fn section(title: String, pixels: &[Pixel], image: usize, side: u32) -> Section {
    let truth: Vec<[f32; 3]> = pixels.iter().map(|pixel| pixel.truth[image]).collect();
    let brightest = truth.iter().flatten().fold(0.0, |m: f32, c| m.max(*c));
    let exposure = -brightest.max(1e-6).log2();
    // Differences of an eighth of the usual scale show.
    let scale = FalseColor::for_reference(&truth);
    let scale = FalseColor {
        limit: 0.5 * scale.limit,
    };
    let shown = |colors: &[[f32; 3]]| {
        let bytes = srgb8(colors, exposure, ToneMap::None);
        thumbnail(&RgbImage::from_raw(side, side, bytes).unwrap_or_default())
    };
    let squares = |colors: &[[f32; 3]], other: &dyn Fn(usize, usize) -> f32| {
        let terms = colors
            .iter()
            .enumerate()
            .flat_map(|(i, color)| (0..3).map(move |c| f64::from(color[c] - other(i, c)).powi(2)));
        terms.sum::<f64>()
    };
    let mut cells = vec![Some(Cell {
        id: "truth",
        title: "cubature".to_owned(),
        picture: shown(&truth),
        difference: None,
        numbers: String::new(),
    })];
    let norm = squares(&truth, &|_, _| 0.0).max(1e-30);
    for method in SHOWN {
        let found: Vec<[f32; 3]> = pixels.iter().map(|p| p.found[image][method]).collect();
        let relative = (squares(&found, &|i, c| truth[i][c]) / norm).sqrt();
        let difference = scale.image((side, side), &found, &truth);
        cells.push(Some(Cell {
            id: METHODS[method].0,
            title: METHODS[method].0.to_owned(),
            picture: shown(&found),
            difference: Some(thumbnail(&difference)),
            numbers: format!("RMS {:.1} % of the floor's", 100.0 * relative),
        }));
    }
    Section {
        title,
        scale,
        cells,
    }
}
