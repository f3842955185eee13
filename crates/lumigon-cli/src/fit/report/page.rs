//! The report as a page.

use askama::Template;
use lumigon_fit::Manifest;

use super::figure::Figure;
use super::measure::{Band, Numbers};
use super::place::first_axis;
use super::record::{Record, TableRecord};
use crate::Failure;

/// The report's page.
pub(super) const INDEX: &str = "index.html";

#[derive(Template)]
#[template(path = "fit_report.html")]
struct Page<'a> {
    record: &'a Record,
    /// The first axis' name.
    axis: &'a str,
    /// The second weight's name.
    secondary: String,
    /// Texels of table and baseline.
    size: [String; 2],
    sections: &'a [Section],
    bands: Vec<BandRows>,
    /// What the table's manifest says of its errors.
    stated: Vec<[String; 5]>,
    settings: [(&'a str, String); 2],
}

/// Figures under a heading.
pub(super) struct Section {
    pub(super) title: &'static str,
    pub(super) figures: Vec<Figure>,
}

/// A range of perceptual roughness with its rows.
struct BandRows {
    title: String,
    rows: Vec<Row>,
}

/// What is compared; table and baseline, as text.
struct Row {
    what: &'static str,
    numbers: [String; 2],
}

/// The page.
///
/// # Errors
/// Where the template fails.
pub(super) fn html(record: &Record, sections: &[Section]) -> Result<String, Failure> {
    let axis = first_axis(record.table.settings.brdf);
    let about = |table: &TableRecord| serde_json::to_string(&table.settings);
    let size = |table: &TableRecord| {
        let sizes = table.settings.brdf.sizes(table.settings.size);
        let sizes: Vec<String> = sizes.iter().map(ToString::to_string).collect();
        sizes.join("×")
    };
    let page = Page {
        axis: &axis,
        secondary: record.table.settings.brdf.secondary().replace('_', " "),
        record,
        sections,
        bands: record
            .bands
            .iter()
            .map(|band| BandRows::new(band, &axis))
            .collect(),
        size: [&record.table, &record.baseline].map(size),
        stated: record.table.manifest.iter().flat_map(stated).collect(),
        settings: [
            ("Table", about(&record.table)?),
            ("Baseline", about(&record.baseline)?),
        ],
    };
    Ok(page.render()?)
}

fn stated(manifest: &Manifest) -> [[String; 5]; 2] {
    [&manifest.errors, &manifest.errors_smooth].map(|errors| {
        let [from, to] = errors.perceptual_roughness;
        [
            format!("{from} to {to}"),
            format!("{:.5}", errors.rmse),
            format!("{:.5}", errors.secondary_rmse),
            format!("{:.2} %", 100.0 * errors.median_relative),
            format!("{:.4} to {:.4}", errors.furnace[0], errors.furnace[1]),
        ]
    })
}

impl BandRows {
    fn new(band: &Band, axis: &str) -> Self {
        let row = |what: &'static str, text: &dyn Fn(&Numbers) -> String| Row {
            what,
            numbers: [text(&band.table), text(&band.baseline)],
        };
        let percent = |share: f64| match 100.0 * share {
            p if p < 0.001 => "0 %".to_owned(),
            p if p < 1.0 => format!("{p:.3} %"),
            p => format!("{p:.2} %"),
        };
        let [from, to] = band.first_axis;
        Self {
            title: format!(
                "{axis} {from} to {to}: {} lights at {} places",
                band.lights, band.places
            ),
            rows: vec![
                row("RMSE, F = 1", &|n| format!("{:.5}", n.rmse)),
                row("RMSE, second weight", &|n| {
                    format!("{:.5}", n.secondary_rmse)
                }),
                row("Median relative error", &|n| percent(n.median_relative)),
                row("95th percentile of it", &|n| {
                    percent(n.percentile_95_relative)
                }),
                row("White furnace to 85°", &|n| {
                    format!("{:.4} to {:.4}", n.furnace[0], n.furnace[1])
                }),
                row("Leaked, mean", &|n| percent(n.leaked_mean)),
                row("Leaked, greatest", &|n| percent(n.leaked_greatest)),
            ],
        }
    }
}
