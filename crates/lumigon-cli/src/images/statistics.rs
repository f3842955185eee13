//! From samples to tables.

use serde::Serialize;

use super::measure::{METHODS, Numbers, Sample};
use super::place::{Distance, Surface};
use super::texture::Kind;

/// Bands of perceptual roughness.
const BANDS: [[f32; 2]; 5] = [
    [0.05, 0.15],
    [0.15, 0.3],
    [0.3, 0.5],
    [0.5, 0.75],
    [0.75, 1.0],
];

/// Ranges of the share of a specular lobe that a light covers.
const SHARES: [[f64; 2]; 3] = [[0.0, 0.05], [0.05, 0.2], [0.2, 1.0]];

/// Errors of the methods over some samples, as shares of the images' means.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) name: String,
    pub(super) samples: usize,
    pub(super) rms: Numbers,
    pub(super) percentile_95: Numbers,
}

impl Row {
    fn new<'a>(name: &str, errors: impl Iterator<Item = &'a Numbers>) -> Self {
        let errors: Vec<&Numbers> = errors.collect();
        let column = |method: usize| errors.iter().map(move |errors| errors[method]);
        let samples = errors.len();
        Self {
            name: name.to_owned(),
            samples,
            rms: std::array::from_fn(|method| {
                let sum: f64 = column(method).map(|e| e * e).sum();
                (sum / samples.max(1) as f64).sqrt()
            }),
            percentile_95: std::array::from_fn(|method| {
                let mut sorted: Vec<f64> = column(method).collect();
                sorted.sort_by(f64::total_cmp);
                let last = samples.saturating_sub(1);
                sorted.get(last * 95 / 100).copied().unwrap_or(0.0)
            }),
        }
    }

    /// RMS over the conventional method's.
    pub(super) fn ratio(&self, method: usize) -> f64 {
        self.rms[method] / self.rms[0]
    }
}

/// Rows that split the samples in one way.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Table {
    pub(super) title: &'static str,
    pub(super) rows: Vec<Row>,
}

/// All tables, the summary first.
pub(super) fn tables(samples: &[Sample]) -> Vec<Table> {
    let counted = |sample: &&Sample| Kind::COUNTED.contains(&sample.kind);
    let row = |name: &str, of: &dyn Fn(&Sample) -> bool| {
        let matching = samples.iter().filter(counted).filter(|s| of(s));
        Row::new(name, matching.map(|s| &s.errors))
    };
    let summary = Table {
        title: "All of them",
        rows: vec![
            row("all", &|_| true),
            row("diffuse", &|s| s.surface == Surface::Diffuse),
            row("specular", &|s| s.surface == Surface::Specular),
        ],
    };
    let classes = Distance::ALL.iter().flat_map(|&distance| {
        Surface::ALL.map(|surface| {
            row(&format!("{}, {}", distance.name(), surface.name()), &|s| {
                s.distance == distance && s.surface == surface
            })
        })
    });
    let kinds = Kind::COUNTED.map(|kind| row(kind.name(), &|s| s.kind == kind));
    let mut outlines: Vec<&str> = samples.iter().map(|s| s.outline).collect();
    outlines.sort_unstable();
    outlines.dedup();
    let outlines = outlines
        .iter()
        .map(|name| row(name, &|s| s.outline == *name));
    let shares = SHARES.map(|[from, to]| {
        row(
            &format!("{:.0} to {:.0} % of the lobe", 100.0 * from, 100.0 * to),
            &|s| s.surface == Surface::Specular && s.share > from && s.share <= to,
        )
    });
    let bands = BANDS.map(|[from, to]| {
        row(&format!("perceptual roughness {from} to {to}"), &|s| {
            s.perceptual_roughness
                .is_some_and(|r| (from..to).contains(&r))
        })
    });
    let ggx = Distance::ALL.map(|distance| {
        let matching = samples
            .iter()
            .filter(counted)
            .filter(|s| s.distance == distance);
        Row::new(
            distance.name(),
            matching.filter_map(|s| s.ggx_errors.as_ref()),
        )
    });
    let bright = Distance::ALL.map(|distance| {
        let matching = samples
            .iter()
            .filter(|s| s.kind == Kind::BrightTexel && s.distance == distance);
        Row::new(distance.name(), matching.map(|s| &s.errors))
    });
    vec![
        summary,
        Table {
            title: "By distance and surface",
            rows: classes.collect(),
        },
        Table {
            title: "By texture",
            rows: kinds.into(),
        },
        Table {
            title: "By outline",
            rows: outlines.collect(),
        },
        Table {
            title: "Specular, by roughness",
            rows: bands.into(),
        },
        Table {
            title: "Specular, by how much of the lobe the light covers",
            rows: shares.into(),
        },
        Table {
            title: "Specular, against GGX itself instead of its fitted lobe",
            rows: ggx.into(),
        },
        Table {
            title: "One texel a thousand times as bright as the others",
            rows: bright.into(),
        },
    ]
}

/// Tables as Markdown, in percent of the images' means.
pub(super) fn markdown(tables: &[Table], time_ratios: &[Numbers; 2]) -> String {
    let names = METHODS.map(|(name, _)| name);
    let mut text = String::new();
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head = |first: &str, columns: &[&str]| {
        let cells: Vec<String> = std::iter::once(first)
            .chain(columns.iter().copied())
            .map(ToOwned::to_owned)
            .collect();
        let rule: Vec<String> = (0..cells.len())
            .map(|i| if i == 0 { "---" } else { "---:" }.to_owned())
            .collect();
        line(&cells) + &line(&rule)
    };
    for table in tables {
        text += &format!("\n### {}\n\n", table.title);
        text += &head("RMS (95th percentile), % of the image's mean", &names);
        for row in &table.rows {
            let mut cells = vec![row.name.clone()];
            cells.extend((0..METHODS.len()).map(|method| {
                let [rms, high] = [row.rms[method], row.percentile_95[method]];
                format!("{:.1} ({:.1})", 100.0 * rms, 100.0 * high)
            }));
            text += &line(&cells);
        }
    }
    text += "\n### Time of a mean image, over the lookup's\n\n";
    text += &head("scalar, single precision", &names);
    for (surface, ratios) in Surface::ALL.iter().zip(time_ratios) {
        let mut cells = vec![surface.name().to_owned()];
        cells.extend(ratios.iter().map(|ratio| format!("{ratio:.2}")));
        text += &line(&cells);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_root_mean_squares() {
        let errors = [[0.3, 0.0, 0.1, 0.2, 1.0], [0.4, 0.0, 0.1, 0.2, 0.0]];
        let row = Row::new("both", errors.iter());
        assert_eq!(row.samples, 2);
        assert!((row.rms[0] - 0.125_f64.sqrt()).abs() < 1e-12);
        assert!((row.ratio(2) - 0.1 / 0.125_f64.sqrt()).abs() < 1e-12);
        let many: Vec<Numbers> = (0..101).map(|i| [f64::from(i); 5]).collect();
        assert_eq!(Row::new("many", many.iter()).percentile_95, [95.0; 5]);
        let none = Row::new("none", std::iter::empty());
        assert_eq!((none.rms, none.percentile_95), ([0.0; 5], [0.0; 5]));
    }
}
