//! The report's pictures.

use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3};
use lumigon_fit::{BrdfKind, Table};

use super::continuity::{self, LARGEST_ANGLE, Strip, Sweep};
use super::measure::{COLUMNS, Measurement};
use super::place::{first_axis, in_slice, slice_words};
use super::plot::{Curves, Hemisphere, Panel, charts, heat_maps, hemispheres};
use super::response::Lobes;
use super::scale::Scale;
use super::theme::{Area, THEMES, Theme};
use super::truth::Truth;
use crate::Failure;
use crate::interrupt::Interrupt;

/// A picture on light and on dark paper, with its words.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    pub(super) title: &'static str,
    /// What to see in it.
    pub(super) words: String,
    /// Paths in the report, light and dark.
    pub(super) files: [String; 2],
    pub(super) width: u32,
    pub(super) height: u32,
}

/// Draws the figures into the report's folder.
pub(super) struct Figures<'a> {
    pub(super) folder: &'a Path,
    pub(super) tables: [&'a Table; 2],
    /// What they are called.
    pub(super) names: [&'a str; 2],
    pub(super) interrupt: &'a Interrupt,
}

impl Figures<'_> {
    fn brdf(&self) -> BrdfKind {
        self.tables[0].brdf()
    }

    fn paint(
        &self,
        id: &str,
        title: &'static str,
        words: String,
        (width, height): (u32, u32),
        draw: &dyn Fn(&Area<'_>, &Theme) -> Result<(), Failure>,
    ) -> Result<Figure, Failure> {
        self.interrupt.check()?;
        let pictures = self.folder.join("pictures");
        fs::create_dir_all(&pictures).map_err(|e| format!("{}: {e}", pictures.display()))?;
        let mut files = [String::new(), String::new()];
        for (theme, file) in THEMES.iter().zip(&mut files) {
            *file = format!("pictures/{id}-{}.png", theme.name);
            let path = self.folder.join(file.as_str());
            let image = theme.paint((width, height), draw)?;
            image
                .save(&path)
                .map_err(|error| format!("{}: {error}", path.display()))?;
        }
        Ok(Figure {
            title,
            words,
            files,
            width,
            height,
        })
    }

    fn side_by_side(
        &self,
        (id, title): (&str, &'static str),
        words: String,
        (columns, degrees): (usize, f64),
        numbers: &[&[f64]; 2],
        scale: &Scale,
    ) -> Result<Figure, Failure> {
        let first = first_axis(self.brdf());
        self.paint(id, title, words, (1600, 660), &|area, theme| {
            let panel = |which: usize| Panel {
                title: self.names[which],
                x_label: &first,
                columns,
                numbers: numbers[which],
                degrees,
            };
            heat_maps(area, theme, &[panel(0), panel(1)], scale)
        })
    }

    /// Errors, furnace and leaked energy.
    pub(super) fn measured(&self, measurement: &Measurement) -> Result<Vec<Figure>, Failure> {
        let cells = (COLUMNS, 90.0);
        let errors = [0, 1].map(|weight| [0, 1].map(|which| measurement.rmse(which, weight)));
        let scale = Scale::logarithmic("RMSE", errors.iter().flatten().flatten(), 4);
        let mut figures = Vec::new();
        let secondary = match self.brdf().secondary() {
            "schlick" => "weighted by Schlick’s (1 − h·v)⁵, the part of a coloured reflectance",
            _ => "under the BRDF’s second weight",
        };
        for (numbers, (id, title, what)) in errors.iter().zip([
            ("error", "Error, F = 1", "without a Fresnel term"),
            ("error-secondary", "Error, second weight", secondary),
        ]) {
            // A BRDF without a second weight.
            if id != "error" && numbers.iter().flatten().all(|rmse| *rmse == 0.0) {
                continue;
            }
            let words = format!(
                "Root mean square of table minus BRDF over random lights of radiance 1, {what}. \
                 The error figures share one scale."
            );
            let numbers = [&*numbers[0], &*numbers[1]];
            figures.push(self.side_by_side((id, title), words, cells, &numbers, &scale)?);
        }
        let furnace = [0, 1].map(|which| measurement.furnace(which));
        let scale = Scale::about_one("albedo / BRDF’s", furnace.iter().flatten());
        figures.push(self.side_by_side(
            ("furnace", "White furnace"),
            "Directional albedo above the horizon over the BRDF’s own: 1 is right, red too dark, \
             blue too bright."
                .to_owned(),
            cells,
            &[&furnace[0], &furnace[1]],
            &scale,
        )?);
        let leaked = [0, 1].map(|which| measurement.leaked(which));
        let scale = Scale::logarithmic("share below horizon", leaked.iter().flatten(), 4);
        figures.push(self.side_by_side(
            ("leaked", "Leaked energy"),
            "Share of the lobes below the horizon. Clipping at the horizon makes the light from \
             there exactly 0; a table fitted without it in mind loses this share."
                .to_owned(),
            cells,
            &[&leaked[0], &leaked[1]],
            &scale,
        )?);
        Ok(figures)
    }

    /// Densities in the plane of incidence, and over the hemisphere.
    pub(super) fn lobes(&self) -> Result<Vec<Figure>, Failure> {
        let brdf = self.brdf();
        let (axis, slice) = (first_axis(brdf), slice_words(brdf));
        let names = ["BRDF", self.names[0], self.names[1]];
        let mut data = Vec::new();
        for first in [0.1, 0.3, 0.6, 1.0] {
            for degrees in [0.0, 45.0, 75.0, 85.0_f64] {
                let place = in_slice(brdf, first, degrees.to_radians());
                let truth = Truth::new(brdf, &place, 0);
                let lobes = self.tables.map(|table| Lobes::look_up(table, &place));
                let view = truth.view();
                let azimuth = view.truncate().normalize_or(DVec2::X);
                // A few widths about the mirror direction, up to the whole plane.
                let reach = (5.5 * truth.widths()[1].to_degrees()).clamp(1.0, 180.0);
                let (low, high) = ((degrees - reach).max(-90.0), (degrees + reach).min(90.0));
                let curve = |density: &dyn Fn(DVec3) -> f64| -> Vec<(f64, f64)> {
                    let at = |i: i32| low + (high - low) * f64::from(i) / 400.0;
                    (0..=400)
                        .map(|i| {
                            let (sin, cos) = at(i).to_radians().sin_cos();
                            (at(i), density((-sin * azimuth).extend(cos)))
                        })
                        .collect()
                };
                data.push((
                    format!("{axis} {first}, view {degrees}°"),
                    curve(&|light| truth.density(light)),
                    lobes
                        .each_ref()
                        .map(|lobes| curve(&|light| lobes.density(light))),
                ));
            }
        }
        let curves = self.paint(
            "lobes",
            "Lobes in the plane of incidence",
            "Reflected density with F = 1 (the BRDF times the light’s cosine) in the plane of \
             incidence, about the mirror direction; a light at positive angles is opposite to the \
             viewer."
                .to_owned()
                + &slice,
            (1840, 1640),
            &|area, theme| {
                let curves: Vec<Curves<'_>> = data
                    .iter()
                    .map(|(title, truth, fitted)| Curves {
                        title: title.clone(),
                        x_label: "light angle (degrees)",
                        y_label: "density (1/sr)",
                        truth,
                        truth_as_points: false,
                        fitted,
                    })
                    .collect();
                charts(area, theme, names, &curves, 4)
            },
        )?;

        let places = [(0.3, 30.0), (0.45, 65.0), (0.6, 80.0), (0.9, 75.0_f64)];
        let in_slice = places.map(|(first, degrees)| in_slice(brdf, first, degrees.to_radians()));
        let truths = in_slice.each_ref().map(|place| Truth::new(brdf, place, 0));
        let lobes = self.tables.map(|table| {
            let places = in_slice.each_ref();
            places.map(|place| Lobes::look_up(table, place))
        });
        let peaks = truths.each_ref().map(|truth| {
            let azimuth = truth.view().truncate().normalize_or(DVec2::X);
            let grid = |i: i32| {
                let (sin, cos) = (f64::from(i) * 0.05).to_radians().sin_cos();
                truth.density((-sin * azimuth).extend(cos))
            };
            (-1799..1800).map(grid).fold(f64::MIN_POSITIVE, f64::max)
        });
        let scale = Scale::linear("√(density / BRDF’s peak)", 0.0, 1.0);
        let hemisphere = self.paint(
            "hemispheres",
            "Lobes over the hemisphere",
            "The hemisphere of lights seen from above, +x to the right, the viewer there in an \
             isotropic table; rows are the BRDF, the table and the baseline."
                .to_owned()
                + &slice,
            (1840, 1280),
            &|area, theme| {
                let densities: Vec<Vec<Density<'_>>> = vec![
                    truths
                        .iter()
                        .map(|truth| {
                            let density = move |light| truth.density(light);
                            Box::new(density) as Density<'_>
                        })
                        .collect(),
                    boxed(&lobes[0]),
                    boxed(&lobes[1]),
                ];
                let short = ["BRDF", "table", "baseline"];
                let rows: Vec<Vec<Hemisphere<'_>>> = densities
                    .iter()
                    .zip(short)
                    .map(|(row, name)| {
                        let cells = row.iter().zip(places).zip(peaks);
                        cells
                            .map(|((density, (p, degrees)), peak)| Hemisphere {
                                name,
                                place: format!("{axis} {p}, view {degrees}°"),
                                peak,
                                density,
                            })
                            .collect()
                    })
                    .collect();
                hemispheres(area, theme, &rows, &scale)
            },
        )?;
        Ok(vec![curves, hemisphere])
    }

    /// Responses, their second differences, and two sweeps with the BRDF beside them.
    pub(super) fn continuity(&self, strips: &[Strip; 2]) -> Result<Vec<Figure>, Failure> {
        let cells = (continuity::WIDTH, LARGEST_ANGLE);
        let responses = strips.each_ref().map(|strip| &*strip.responses);
        let strip = self.side_by_side(
            ("continuity", "Continuity"),
            "Response to a light with one edge through the mirror direction, which moves along as \
             the view sweeps: a jump or a band would show as an edge."
                .to_owned()
                + &slice_words(self.brdf()),
            cells,
            &responses,
            &Scale::from_zero("response", responses.iter().copied().flatten()),
        )?;
        let differences = strips.each_ref().map(|strip| &*strip.second_differences);
        let scale = Scale::logarithmic(
            "second difference",
            differences.iter().copied().flatten(),
            5,
        );
        let second = self.side_by_side(
            ("second-differences", "Second differences"),
            format!(
                "The greater of |f(−1) − 2 f(0) + f(1)| along both axes of the picture above, in \
                 steps of 1/{} and {:.2}°. Bilinear lookup bends at every node, which draws the \
                 table’s own grid; an eighth-bit step of a display is 0.0039.",
                continuity::WIDTH - 1,
                LARGEST_ANGLE / (continuity::HEIGHT - 1) as f64
            ),
            cells,
            &differences,
            &scale,
        )?;
        let sweeps = [
            Sweep::over_first(self.tables, self.interrupt)?,
            Sweep::over_view(self.tables, self.interrupt)?,
        ];
        let names = ["BRDF", self.names[0], self.names[1]];
        let axis = first_axis(self.brdf());
        let sweep = self.paint(
            "sweeps",
            "Sweeps",
            "The same light along one axis; circles are the BRDF.".to_owned(),
            (1840, 760),
            &|area, theme| {
                let titles = [
                    (
                        format!("view {}°", continuity::SWEEP_DEGREES),
                        axis.as_str(),
                    ),
                    (
                        format!("{axis} {}", continuity::SWEEP_FIRST),
                        "view angle (degrees)",
                    ),
                ];
                let curves: Vec<Curves<'_>> = sweeps
                    .iter()
                    .zip(titles)
                    .map(|(sweep, (title, x_label))| Curves {
                        title,
                        x_label,
                        y_label: "response",
                        truth: &sweep.truth,
                        truth_as_points: true,
                        fitted: &sweep.fitted,
                    })
                    .collect();
                charts(area, theme, names, &curves, 2)
            },
        )?;
        Ok(vec![strip, second, sweep])
    }
}

/// In 1/sr towards a unit direction.
type Density<'a> = Box<dyn Fn(DVec3) -> f64 + Sync + 'a>;

fn boxed(lobes: &[Lobes]) -> Vec<Density<'_>> {
    lobes
        .iter()
        .map(|lobes| {
            let density = move |light| lobes.density(light);
            Box::new(density) as Density<'_>
        })
        .collect()
}
