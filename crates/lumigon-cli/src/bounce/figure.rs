//! The report's figures.

use std::fs;

use image::RgbImage;
use lumigon_renderer::{ToneMap, srgb8};

use super::Study;
use super::cost::CostRow;
use super::errors::{ErrorRow, Errors, StudyScene};
use super::page::Figure;
use super::plot::{Chart, Line};
use super::table::{Over, own_error};
use super::variant::{
    POINT_SCENE, POLYGON_CAMERA, POLYGON_CAMERA_SHADOWED, POLYGON_SCENE, POLYGON_SCENE_SHADOWED,
    RSM, RSM_SHADOWED, VARIANTS, Variant,
};
use crate::Failure;
use crate::compare::contact_sheet::{Cell, Section, contact_sheet, thumbnail};
use crate::compare::false_color::FalseColor;
use crate::compare::quantity::percent;
use crate::fit::theme::THEMES;

const SIZE: (u32, u32) = (1600, 900);

impl Study<'_> {
    /// All figures, written.
    pub(super) fn figures(
        &self,
        scenes: &[StudyScene],
        rows: &[ErrorRow],
        cost: &[CostRow],
        sections: &[Section],
    ) -> Result<Vec<Figure>, Failure> {
        let pictures = self.folder.join("pictures");
        fs::create_dir_all(&pictures).map_err(|e| format!("{}: {e}", pictures.display()))?;
        let mut figures = vec![self.sheet(sections)?];
        for (number, scene) in scenes.iter().enumerate() {
            for (over, id, title, x_label) in [
                (
                    Over::VirtualLights,
                    "lights",
                    "errors over virtual lights",
                    "virtual lights, at most",
                ),
                (
                    Over::CubeSize,
                    "sizes",
                    "errors over the cube map’s size",
                    "texels a side of a face",
                ),
            ] {
                let chart = Chart {
                    x_label,
                    y_label: "relative RMSE, %",
                    lines: self.lines(&scene.name, rows, over),
                };
                let words = "Relative RMSE of each against the path tracer in which surfaces block the \
                    same light, and of polygons without rays against the truth.";
                let title = format!("{}: {title}", scene.name);
                figures.push(self.chart(&format!("{id}-{number}"), title, words, &chart)?);
            }
        }
        let line = |name, milliseconds: fn(&CostRow) -> f64| Line {
            name,
            points: cost
                .iter()
                .map(|row| (row.lights as f64, milliseconds(row)))
                .collect(),
        };
        let chart = Chart {
            x_label: "lights",
            y_label: "milliseconds",
            lines: vec![
                line("one cube map", |row| row.cube_map_milliseconds),
                line("reflective shadow maps", |row| row.shadow_maps_milliseconds),
            ],
        };
        let words = "Milliseconds to make equally many virtual lights: see, light and reduce.";
        figures.push(self.chart("cost", "Cost over lights".to_owned(), words, &chart)?);
        Ok(figures)
    }

    fn lines<'a>(&self, scene: &str, rows: &'a [ErrorRow], over: Over) -> Vec<Line<'a>> {
        let sweep = self.command.sweep();
        let line = |variant: &Variant, name, error: &dyn Fn(&ErrorRow) -> Option<f64>| {
            let of_line = rows.iter().filter(|row| {
                row.scene == scene
                    && row.variant == variant.id
                    && over.has(row, [sweep.count, sweep.size])
            });
            let mut points: Vec<_> = of_line
                .filter_map(|row| Some((f64::from(over.of(row)), 100.0 * error(row)?)))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            Line { name, points }
        };
        let mut lines: Vec<_> = VARIANTS
            .iter()
            .filter(|variant| over == Over::VirtualLights || variant.over_sizes)
            .map(|variant| line(variant, variant.title, &|row| own_error(variant, row)))
            .collect();
        let leaking = "polygons, scene, no rays, to the truth";
        lines.push(line(&POLYGON_SCENE, leaking, &|row| row.rmse[2]));
        lines
    }

    fn chart(
        &self,
        id: &str,
        title: String,
        words: &'static str,
        chart: &Chart<'_>,
    ) -> Result<Figure, Failure> {
        let mut files = [String::new(), String::new()];
        for (theme, file) in THEMES.iter().zip(&mut files) {
            self.interrupt.check()?;
            *file = format!("pictures/{id}-{}.png", theme.name);
            let image = theme.paint(SIZE, &|area, theme| chart.draw(area, theme))?;
            self.save(file, &image)?;
        }
        Ok(Figure {
            title,
            words,
            files,
            width: SIZE.0,
            height: SIZE.1,
        })
    }

    fn sheet(&self, sections: &[Section]) -> Result<Figure, Failure> {
        let sweep = self.command.sweep();
        let facts = format!(
            "diffuse bounce light; at most {} virtual lights, cube maps of {size} × {size}; below each \
             picture its difference from the path-traced one on the left",
            sweep.count,
            size = sweep.size,
        );
        let title = "Bounce light by virtual lights";
        let sheet = contact_sheet(title, &facts, sections)?;
        let file = "pictures/contact-sheet.png".to_owned();
        self.save(&file, &sheet)?;
        Ok(Figure {
            title: title.to_owned(),
            words: "Each beside the path tracer’s, and its difference below: blue is too dark, red too \
                bright.",
            files: [file.clone(), file],
            width: sheet.width(),
            height: sheet.height(),
        })
    }

    /// Two of each scene: nothing blocked, and the truth.
    pub(super) fn sections(&self, scene: &StudyScene, errors: &Errors) -> Vec<Section> {
        let unblocked = [POLYGON_CAMERA, POLYGON_SCENE, POINT_SCENE, RSM];
        let shadowed = [
            POLYGON_SCENE,
            POLYGON_CAMERA_SHADOWED,
            POLYGON_SCENE_SHADOWED,
            RSM_SHADOWED,
        ];
        [
            (0, "nothing is blocked", unblocked),
            (2, "the truth", shadowed),
        ]
        .map(|(truth, title, variants)| {
            let reference = &errors.truths[truth];
            let scale = FalseColor::for_reference(&reference.pixels);
            let stops = exposure(&reference.pixels);
            let shown = |pixels: &[[f32; 3]]| self.shown(pixels, stops);
            let mut cells = vec![Some(Cell {
                id: "path",
                title: "Path traced".to_owned(),
                picture: thumbnail(&shown(&reference.pixels)),
                difference: None,
                numbers: format!("noise {}", percent(reference.noise())),
            })];
            cells.extend(variants.iter().map(|variant| {
                let mut pictures = errors.pictures.iter();
                let (_, pixels) = pictures.find(|(shown, _)| shown.id == variant.id)?;
                let size = self.command.size();
                let size = (size.width, size.height);
                let colored = scale.image(size, pixels, &reference.pixels);
                let difference = reference.difference(pixels);
                Some(Cell {
                    id: variant.id,
                    title: variant.title.to_owned(),
                    picture: thumbnail(&shown(pixels)),
                    difference: Some(thumbnail(&colored)),
                    numbers: format!(
                        "RMSE {}, bias {}",
                        percent(difference.rmse),
                        percent(difference.bias)
                    ),
                })
            }));
            Section {
                title: format!("{}: {title}", scene.name),
                scale,
                cells,
            }
        })
        .into()
    }

    fn shown(&self, pixels: &[[f32; 3]], stops: f32) -> RgbImage {
        let size = self.command.size();
        let bytes = srgb8(pixels, stops, ToneMap::default());
        RgbImage::from_raw(size.width, size.height, bytes)
            .unwrap_or_else(|| RgbImage::new(size.width, size.height))
    }

    fn save(&self, name: &str, picture: &RgbImage) -> Result<(), Failure> {
        let path = self.folder.join(name);
        picture
            .save(&path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(())
    }
}

/// Stops that bring what is bright, not what is brightest, close to white.
fn exposure(pixels: &[[f32; 3]]) -> f32 {
    let mut values: Vec<f32> = pixels
        .iter()
        .flatten()
        .copied()
        .filter(|value| *value > 0.0 && value.is_finite())
        .collect();
    values.sort_by(f32::total_cmp);
    let bright = values
        .len()
        .checked_sub(1)
        .map(|last| values[last * 95 / 100]);
    let stops = bright.map_or(0.0, |bright| (0.7 / bright).log2());
    if stops.is_finite() {
        stops.clamp(-100.0, 100.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::exposure;

    #[test]
    fn any_light_is_shown() {
        assert!((exposure(&[[0.35; 3]; 9]) - 1.0).abs() < 1e-6);
        assert_eq!(exposure(&[]), 0.0);
        assert_eq!(exposure(&[[0.0, f32::NAN, -1.0]]), 0.0);
        assert_eq!(exposure(&[[f32::MIN_POSITIVE; 3]]), 100.0);
    }
}
