//! The report as a page.

use askama::Template;

use super::measure::METHODS;
use super::place::Surface;
use super::record::Record;
use super::statistics::Row;
use crate::Failure;

/// The report's page.
pub(super) const INDEX: &str = "index.html";

#[derive(Template)]
#[template(path = "images.html")]
struct Page<'a> {
    record: &'a Record,
    tables: Vec<Rows>,
    times: Vec<(&'static str, Vec<String>)>,
    figures: &'a [Figure],
}

/// A picture on light and on dark paper, or on any.
pub(super) struct Figure {
    pub(super) title: &'static str,
    pub(super) words: &'static str,
    /// Paths in the report, light and dark.
    pub(super) files: [String; 2],
    pub(super) width: u32,
    pub(super) height: u32,
}

struct Rows {
    title: &'static str,
    rows: Vec<(String, usize, Vec<[String; 3]>)>,
}

/// The page.
///
/// # Errors
/// Where the template fails.
pub(super) fn html(record: &Record, figures: &[Figure]) -> Result<String, Failure> {
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let cells = |row: &Row| {
        (0..METHODS.len())
            .map(|method| {
                [
                    percent(row.rms[method]),
                    percent(row.percentile_95[method]),
                    format!("{:.2}", row.ratio(method)),
                ]
            })
            .collect()
    };
    let tables = record.tables.iter().map(|table| Rows {
        title: table.title,
        rows: table
            .rows
            .iter()
            .map(|row| (row.name.clone(), row.samples, cells(row)))
            .collect(),
    });
    let nanoseconds = [record.nanoseconds.diffuse, record.nanoseconds.specular];
    let times = Surface::ALL.iter().zip(nanoseconds).map(|(surface, ns)| {
        let cells = ns.map(|n| format!("{n:.0} ns, {:.2}", n / ns[0]));
        (surface.name(), cells.to_vec())
    });
    let page = Page {
        record,
        tables: tables.collect(),
        times: times.collect(),
        figures,
    };
    Ok(page.render()?)
}
