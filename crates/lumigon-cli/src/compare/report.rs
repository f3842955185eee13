//! The report as a page.

use askama::Template;

use super::CompareError;
use super::contact_sheet::signed;
use super::false_color::FalseColor;
use super::method::{Part, REFERENCE_SOURCE, REFERENCE_WORDS};
use super::record::{MethodRecord, Record, ReferenceRecord};
use super::run::{duration, percent, scene_name};

/// The report's page.
pub const INDEX: &str = "index.html";
/// All pictures on one sheet.
pub const CONTACT_SHEET: &str = "contact-sheet.png";

#[derive(Template)]
#[template(path = "compare.html")]
struct Page<'a> {
    record: &'a Record,
    name: String,
    groups: Vec<Group<'a>>,
    unshadowed: &'a ReferenceRecord,
    shadowed: &'a ReferenceRecord,
}

/// The methods of one part, with its reference and its scale.
struct Group<'a> {
    part: Part,
    reference: &'a str,
    methods: Vec<&'a MethodRecord>,
    ticks: [(f64, String); 5],
    noise: String,
}

/// The report of a comparison; `scales` are the differences', in the order of [`Part::ALL`].
///
/// # Errors
/// Where the template fails.
pub fn html(record: &Record, scales: Vec<FalseColor>) -> Result<String, CompareError> {
    let [unshadowed, shadowed] = &record.references[..] else {
        return Err(CompareError::Template(askama::Error::Fmt));
    };
    let noises = [
        unshadowed.radiance_noise,
        unshadowed.diffuse_noise,
        unshadowed.specular_noise,
    ];
    let groups = Part::ALL.into_iter().zip(scales).zip(noises);
    let groups = groups.map(|((part, scale), noise)| Group {
        part,
        reference: &unshadowed.pictures[part as usize].picture,
        methods: record.methods.iter().filter(|m| m.part == part).collect(),
        ticks: scale
            .ticks()
            .map(|(place, difference)| (100.0 * place, signed(difference))),
        noise: percent(noise.relative),
    });
    let page = Page {
        record,
        name: scene_name(record.scene.path.as_ref()),
        groups: groups.collect(),
        unshadowed,
        shadowed,
    };
    Ok(page.render()?)
}
