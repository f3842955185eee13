//! The report as a page.

use askama::Template;

use super::bounce::{BounceGroup, BounceMethodRecord};
use super::contact_sheet::signed;
use super::error::CompareError;
use super::false_color::FalseColor;
use super::method::{EXACT, Part, REFERENCE_SOURCE, REFERENCE_WORDS};
use super::metrics::{Noise, ZScores};
use super::quantity::{duration, percent, scene_name};
use super::record::{Against, MethodRecord, Record, ReferenceRecord};
use crate::bounce_light::Blocking;

/// The report's page.
pub(super) const INDEX: &str = "index.html";
/// All pictures on one sheet.
pub(super) const CONTACT_SHEET: &str = "contact-sheet.png";

#[derive(Template)]
#[template(path = "compare.html")]
struct Page<'a> {
    record: &'a Record,
    name: String,
    machine: String,
    verdict: Verdict,
    groups: Vec<Group<'a>>,
    bounce: Vec<Group<'a>>,
    shadows: Option<Row<'a>>,
    reference_seconds: [String; 2],
    seconds_without_lights: String,
    reference_words: &'static str,
    reference_source: &'static str,
}

/// Whether the exact diffuse method is as far from the reference as the reference's noise.
struct Verdict {
    /// None where no pixel has noise to judge by.
    holds: Option<bool>,
    pooled_rms: String,
    pooled_mean: String,
    rms: String,
    mean: String,
    beyond: String,
    count: u64,
    noise: String,
    rmse: String,
}

/// The methods of one part, with its reference and its scale.
struct Group<'a> {
    id: &'a str,
    title: &'a str,
    intro: &'static str,
    reference: &'a str,
    rows: Vec<Row<'a>>,
    ticks: [(f64, String); 5],
    scale: String,
    noise: String,
}

/// One method, in words and formatted numbers.
struct Row<'a> {
    id: &'a str,
    title: &'a str,
    words: &'a str,
    source: &'a str,
    picture: &'a str,
    difference: &'a str,
    relative_rmse: String,
    beyond_noise: String,
    bias: String,
    best_scale: String,
    at_best_scale: String,
    flip: String,
    seconds: String,
    ratio: String,
    lighting_ratio: String,
    /// Of virtual lights: how many, from how many texels, what making them took.
    gathering: [String; 3],
}

/// The report of a comparison; `scales` are the differences', in the order of [`Part::ALL`].
///
/// # Errors
/// Where the template fails.
pub(super) fn html(record: &Record, scales: [FalseColor; 3]) -> Result<String, CompareError> {
    let [unshadowed, shadowed] = &record.references;
    let groups = Part::ALL.into_iter().zip(scales);
    let groups = groups.map(|(part, scale)| {
        let noise = unshadowed.noise(part);
        let methods = record.methods.iter().filter(|m| m.part == part);
        Group {
            id: part.id(),
            title: part.title(),
            intro: intro(part),
            reference: &unshadowed.pictures[part as usize].picture,
            rows: methods.map(Row::of_method).collect(),
            ticks: scale
                .ticks()
                .map(|(place, difference)| (100.0 * place, signed(difference))),
            scale: format!("pictures/scale-{}.png", part.id()),
            noise: percent(noise.relative),
        }
    });
    let exact = record.methods.iter().find(|m| m.id == EXACT);
    let cpu = record.machine.cpu.as_deref().unwrap_or("unnamed CPU");
    let page = Page {
        name: scene_name(record.scene.path.as_ref()),
        machine: format!(
            "{cpu}, {} threads, methods {}",
            record.machine.threads, record.machine.methods
        ),
        verdict: Verdict::new(
            &record.exact_diffuse_z_scores,
            unshadowed.diffuse_noise,
            exact.and_then(|m| m.against.difference.relative_rmse),
        ),
        groups: groups.collect(),
        bounce: record
            .bounce
            .iter()
            .flat_map(|b| &b.groups)
            .map(Group::of_bounce)
            .collect(),
        shadows: shadowed
            .against_unshadowed
            .as_ref()
            .map(|against| Row::of_shadows(shadowed, against)),
        reference_seconds: [duration(unshadowed.seconds), duration(shadowed.seconds)],
        seconds_without_lights: duration(record.seconds_without_polygon_lights),
        reference_words: REFERENCE_WORDS,
        reference_source: REFERENCE_SOURCE,
        record,
    };
    Ok(page.render()?)
}

fn ratio(ratio: Option<f64>) -> String {
    match ratio {
        Some(ratio) => format!("{ratio:.2}"),
        None => "–".to_owned(),
    }
}

fn intro(part: Part) -> &'static str {
    match part {
        Part::Radiance => {
            "The default methods together, and what they leave out: shadows, which need rays."
        }
        Part::Diffuse => {
            "Each method alone, without specular light, against the reference's diffuse part. \
             A projected area has a free intensity: “at best scale” is what stays wrong \
             whichever is chosen."
        }
        Part::Specular => {
            "The specular part of pictures with exact diffuse light, against the reference's \
             specular part; the times include that diffuse light."
        }
    }
}

impl<'a> Group<'a> {
    fn of_bounce(group: &'a BounceGroup) -> Self {
        let ticks = group.scale.ticks();
        Self {
            id: group.id,
            title: group.title,
            intro: match group.blocking {
                Blocking::Nothing => {
                    "Light passes through surfaces on all of its way: what virtual lights without \
                     rays tend to if the cube maps see all that is lit. What differs is sampling."
                }
                Blocking::Bounces => {
                    "Light from a light passes through surfaces, light from a surface does not: \
                     what traced virtual lights tend to."
                }
                Blocking::All => "The truth of a single bounce.",
            },
            reference: &group.picture,
            rows: group.methods.iter().map(Row::of_bounce).collect(),
            ticks: ticks.map(|(place, difference)| (100.0 * place, signed(difference))),
            scale: format!("pictures/scale-{}.png", group.id),
            noise: percent(group.noise.relative),
        }
    }
}

impl Verdict {
    fn new(z: &ZScores, noise: Noise, rmse: Option<f64>) -> Self {
        let digits = |value: Option<f64>| match value {
            Some(value) => format!("{value:.3}"),
            None => "–".to_owned(),
        };
        Self {
            holds: z.is_noise(),
            pooled_rms: digits(z.pooled_rms),
            pooled_mean: digits(z.pooled_mean).replace('-', "−"),
            rms: digits(z.rms),
            mean: digits(z.mean).replace('-', "−"),
            beyond: percent(z.fraction_beyond_3),
            count: z.count,
            noise: percent(noise.relative),
            rmse: percent(rmse),
        }
    }
}

impl<'a> Row<'a> {
    fn new(id: &'a str, title: &'a str, against: &'a Against) -> Self {
        let difference = &against.difference;
        Self {
            id,
            title,
            words: "",
            source: "",
            picture: &against.picture,
            difference: &against.difference_picture,
            relative_rmse: percent(difference.relative_rmse),
            beyond_noise: if difference.rmse_beyond_noise > 0.0 {
                percent(difference.relative_rmse_beyond_noise)
            } else {
                "none".to_owned()
            },
            bias: percent(difference.relative_bias).replace('-', "−"),
            best_scale: match difference.best_scale {
                Some(scale) => format!("{scale:.3}"),
                None => "–".to_owned(),
            },
            at_best_scale: percent(difference.relative_rmse_at_best_scale),
            flip: format!("{:.4}", against.flip),
            seconds: String::new(),
            ratio: String::new(),
            lighting_ratio: String::new(),
            gathering: Default::default(),
        }
    }

    fn of_method(method: &'a MethodRecord) -> Self {
        Self {
            words: method.words,
            source: method.source,
            seconds: duration(method.seconds),
            ratio: ratio(method.ratio_to_exact),
            lighting_ratio: ratio(method.lighting_ratio_to_exact),
            ..Self::new(method.id, method.title, &method.against)
        }
    }

    fn of_bounce(method: &'a BounceMethodRecord) -> Self {
        Self {
            words: method.words,
            source: method.source,
            seconds: duration(method.seconds),
            gathering: [
                method.virtual_lights.to_string(),
                method.texels.to_string(),
                duration(method.gather_seconds),
            ],
            ..Self::new(method.id, method.title, &method.against)
        }
    }

    fn of_shadows(reference: &'a ReferenceRecord, against: &'a Against) -> Self {
        Self {
            words: "The same path tracer with surfaces that block light. Its difference from the \
                reference without shadows is what no method here accounts for.",
            source: REFERENCE_SOURCE,
            seconds: duration(reference.seconds),
            ..Self::new(reference.id, reference.title, against)
        }
    }
}
