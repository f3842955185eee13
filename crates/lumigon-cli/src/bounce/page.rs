//! The report as a page.

use askama::Template;

use super::record::Record;
use super::table::Table;
use crate::Failure;
use crate::compare::quantity::percent;

/// The report's page.
pub(super) const INDEX: &str = "index.html";

#[derive(Template)]
#[template(path = "bounce.html")]
struct Page<'a> {
    record: &'a Record,
    machine: String,
    noise: String,
    tables: &'a [Table],
    figures: &'a [Figure],
}

/// A picture on light and on dark paper, or on any.
pub(super) struct Figure {
    pub(super) title: String,
    pub(super) words: &'static str,
    /// Paths in the report, light and dark.
    pub(super) files: [String; 2],
    pub(super) width: u32,
    pub(super) height: u32,
}

/// The page.
///
/// # Errors
/// Where the template fails.
pub(super) fn html(
    record: &Record,
    tables: &[Table],
    figures: &[Figure],
) -> Result<String, Failure> {
    let machine = &record.machine;
    let noise = record.scenes.iter().map(|scene| {
        let [nothing, bounces, all] = scene.noise.map(percent);
        format!("{}: {nothing}, {bounces}, {all}", scene.name)
    });
    let page = Page {
        noise: noise.collect::<Vec<_>>().join("; "),
        machine: format!(
            "{}, {} threads, {}",
            machine.cpu.as_deref().unwrap_or("unnamed CPU"),
            machine.threads,
            machine.methods
        ),
        record,
        tables,
        figures,
    };
    Ok(page.render()?)
}
