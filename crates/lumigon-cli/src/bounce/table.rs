//! From numbers to tables.

use super::cost::CostRow;
use super::errors::ErrorRow;
use super::flicker::{FlickerRow, Moving};
use super::variant::{VARIANTS, Variant};
use crate::bounce_light::Blocking;
use crate::compare::quantity::percent;

/// Text in rows; the first cell of each names it.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) title: String,
    pub(super) words: &'static str,
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

const ERRORS: &str = "Relative RMSE of diffuse bounce light against the path tracer’s in which surfaces \
    block the same light, and after the stroke against the truth, in which they block all; the \
    reference’s noise is taken out.";

/// What is varied.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Over {
    VirtualLights,
    CubeSize,
}

impl Over {
    pub(super) fn of(self, row: &ErrorRow) -> u32 {
        match self {
            Self::VirtualLights => row.virtual_lights,
            Self::CubeSize => row.cube_size,
        }
    }

    /// Whether a row is part of this, where the other quantity is fixed.
    pub(super) fn has(self, row: &ErrorRow, [count, size]: [u32; 2]) -> bool {
        match self {
            Self::VirtualLights => row.cube_size == size,
            Self::CubeSize => row.virtual_lights == count,
        }
    }
}

/// The error of a row against what the variant should tend to.
pub(super) fn own_error(variant: &Variant, row: &ErrorRow) -> Option<f64> {
    row.rmse[place(variant.blocking)]
}

fn place(blocking: Blocking) -> usize {
    Blocking::ALL
        .iter()
        .position(|b| *b == blocking)
        .unwrap_or(0)
}

/// Errors of one scene over one quantity, the other fixed.
pub(super) fn errors(scene: &str, rows: &[ErrorRow], over: Over, fixed: [u32; 2]) -> Table {
    let rows: Vec<_> = rows
        .iter()
        .filter(|row| row.scene == scene && over.has(row, fixed))
        .collect();
    let mut columns: Vec<u32> = rows.iter().map(|row| over.of(row)).collect();
    columns.sort_unstable();
    columns.dedup();
    let [count, size] = fixed;
    let (title, name) = match over {
        Over::VirtualLights => (
            format!("{scene}: over virtual lights, cube maps of {size} × {size}"),
            "at most",
        ),
        Over::CubeSize => (
            format!("{scene}: over the cube map’s size, at most {count} virtual lights"),
            "texels a side",
        ),
    };
    let cells = |variant: &Variant| -> Option<Vec<String>> {
        let found = |&column: &u32| {
            let is_it = |row: &&&ErrorRow| row.variant == variant.id && over.of(row) == column;
            rows.iter().find(is_it).copied()
        };
        let found: Vec<_> = columns.iter().map(found).collect();
        let several = found.iter().flatten().count() > usize::from(over == Over::CubeSize);
        let cell = |row: &Option<&ErrorRow>| match row {
            None => String::new(),
            Some(row) if variant.blocking == Blocking::All => percent(row.rmse[2]),
            Some(row) => format!(
                "{} / {}",
                percent(own_error(variant, row)),
                percent(row.rmse[2])
            ),
        };
        several.then(|| {
            let cells = found.iter().map(cell);
            std::iter::once(variant.title.to_owned())
                .chain(cells)
                .collect()
        })
    };
    Table {
        title,
        words: ERRORS,
        head: std::iter::once(name.to_owned())
            .chain(columns.iter().map(u32::to_string))
            .collect(),
        rows: VARIANTS.iter().filter_map(cells).collect(),
    }
}

/// All about the pictures at the default number and size.
pub(super) fn details(scene: &str, rows: &[ErrorRow], [count, size]: [u32; 2]) -> Table {
    let head = [
        "",
        "virtual lights",
        "texels",
        "flux error",
        "bias",
        "bias to the truth",
        "make, ms",
        "light, ms",
    ];
    let cells = |variant: &Variant| {
        let row = rows.iter().find(|row| {
            row.scene == scene
                && row.variant == variant.id
                && [row.virtual_lights, row.cube_size] == [count, size]
        })?;
        Some(vec![
            variant.title.to_owned(),
            row.lights.to_string(),
            row.texels.to_string(),
            row.flux_error
                .map_or("–".to_owned(), |error| format!("{error:.1e}")),
            percent(row.bias[place(variant.blocking)]),
            percent(row.bias[2]),
            format!("{:.1}", row.gather_milliseconds),
            format!("{:.1}", row.light_milliseconds),
        ])
    };
    Table {
        title: format!("{scene}: at most {count} virtual lights, cube maps of {size} × {size}"),
        words: "Flux error: the lights’ flux against that of the texels they came from, in the worst \
            channel. Times are of one picture, once.",
        head: head.map(str::to_owned).to_vec(),
        rows: VARIANTS.iter().filter_map(cells).collect(),
    }
}

pub(super) fn cost(rows: &[CostRow]) -> Table {
    let head = [
        "lights",
        "cube map, ms",
        "shadow maps, ms",
        "ratio",
        "cube map: virtual lights",
        "texels",
        "shadow maps: virtual lights",
        "texels",
    ];
    let cells = |row: &CostRow| {
        let ratio = row.shadow_maps_milliseconds / row.cube_map_milliseconds;
        vec![
            row.lights.to_string(),
            format!("{:.1}", row.cube_map_milliseconds),
            format!("{:.1}", row.shadow_maps_milliseconds),
            format!("{ratio:.1}"),
            row.cube_map[0].to_string(),
            row.cube_map[1].to_string(),
            row.shadow_maps[0].to_string(),
            row.shadow_maps[1].to_string(),
        ]
    };
    Table {
        title: "Making virtual lights as lights grow in number".to_owned(),
        words: "Seeing, lighting and reducing: one cube map for all lights, or one for each. The \
            fastest of a few repetitions.",
        head: head.map(str::to_owned).to_vec(),
        rows: rows.iter().map(cells).collect(),
    }
}

pub(super) fn flicker(rows: &[FlickerRow], moving: Moving) -> Table {
    let head = [
        "",
        "at most",
        "largest change",
        "99.9 %",
        "largest uneven",
        "99.9 % uneven",
    ];
    let cells = |row: &FlickerRow| {
        let mut cells = vec![format!("{}: {}", row.scene, row.title)];
        cells.push(row.virtual_lights.map_or("–".to_owned(), |k| k.to_string()));
        let numbers = [
            row.largest,
            row.percentile_999,
            row.uneven,
            row.uneven_percentile_999,
        ];
        cells.extend(numbers.map(percent));
        cells
    };
    let (title, words) = match moving {
        Moving::Camera => (
            "Flicker: the camera moves",
            "Largest and 99.9th percentile change of a pixel from frame to frame, over the mean bounce \
             light, while the cube map moves with the camera and each pixel shows the same point: all \
             of it is wrong.",
        ),
        Moving::Light => (
            "Flicker: a light moves",
            "The same while a light moves, but for pixels that see a light. Uneven is a pixel’s distance from the mean of the frames \
             before and after it: even motion has none.",
        ),
    };
    Table {
        title: title.to_owned(),
        words,
        head: head.map(str::to_owned).to_vec(),
        rows: rows
            .iter()
            .filter(|row| row.moving == moving)
            .map(cells)
            .collect(),
    }
}

/// Tables as Markdown.
pub(super) fn markdown(tables: &[Table]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = String::new();
    for table in tables {
        let rule: Vec<String> = (0..table.head.len())
            .map(|column| if column == 0 { "---" } else { "---:" }.to_owned())
            .collect();
        text += &format!("\n### {}\n\n{}\n\n", table.title, table.words);
        text += &(line(&table.head) + &line(&rule));
        text.extend(table.rows.iter().map(|row| line(row)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::variant::{POLYGON_CAMERA, POLYGON_SCENE_SHADOWED};
    use super::*;

    fn row(variant: &Variant, virtual_lights: u32, cube_size: u32, rmse: f64) -> ErrorRow {
        ErrorRow {
            scene: "room".to_owned(),
            variant: variant.id,
            virtual_lights,
            cube_size,
            lights: 1,
            texels: 6,
            gather_milliseconds: 1.0,
            light_milliseconds: 1.0,
            flux_error: Some(1e-9),
            rmse: [Some(rmse), None, Some(2.0 * rmse)],
            bias: [None; 3],
        }
    }

    #[test]
    fn numbers_find_their_places() {
        let rows = [
            row(&POLYGON_CAMERA, 64, 16, 0.5),
            row(&POLYGON_CAMERA, 256, 16, 0.25),
            row(&POLYGON_CAMERA, 64, 32, 0.125),
            row(&POLYGON_SCENE_SHADOWED, 256, 16, 0.1),
        ];
        let table = errors("room", &rows, Over::VirtualLights, [64, 16]);
        assert_eq!(table.head, ["at most", "64", "256"]);
        assert_eq!(
            table.rows,
            [
                vec!["polygons, camera", "50.0 % / 100 %", "25.0 % / 50.0 %"],
                vec!["polygons, scene, all traced", "", "20.0 %"],
            ]
        );
        let table = errors("room", &rows, Over::CubeSize, [64, 16]);
        assert_eq!(table.head, ["texels a side", "16", "32"]);
        assert_eq!(table.rows.len(), 1);
        assert!(
            errors("hall", &rows, Over::CubeSize, [64, 16])
                .rows
                .is_empty()
        );
        let text = markdown(&[table]);
        assert!(text.contains("| texels a side | 16 | 32 |\n| --- | ---: | ---: |\n"));
        assert_eq!(details("room", &rows, [256, 16]).rows.len(), 2);
    }
}
