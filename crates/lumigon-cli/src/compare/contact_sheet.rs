//! All pictures on one sheet.

use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

use super::error::CompareError;
use super::false_color::FalseColor;
use super::label::Label;

/// Columns of the sheet: a reference, and four methods beside it.
pub(crate) const COLUMNS: u32 = 5;
const GAP: u32 = 20;
const THUMBNAIL: u32 = 480;
const MARGIN: u32 = 36;
const LINE: u32 = 32;
const TITLE: f32 = 24.0;
const SMALL: f32 = 21.0;

const PAPER: Rgb<u8> = Rgb([23, 25, 30]);
const INK: Rgb<u8> = Rgb([238, 238, 242]);
const FADED: Rgb<u8> = Rgb([164, 168, 180]);

/// Pictures of one part of the light, with the scale of their differences.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    /// Its heading.
    pub(crate) title: String,
    /// The scale of its differences.
    pub(crate) scale: FalseColor,
    /// Its pictures in rows of five, the first column the references; gaps are empty.
    pub(crate) cells: Vec<Option<Cell>>,
}

/// One picture with its difference and its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Names the picture.
    pub(crate) id: &'static str,
    /// The method's name.
    pub(crate) title: String,
    /// The picture.
    pub(crate) picture: RgbImage,
    /// Its difference from the reference; none for the reference itself.
    pub(crate) difference: Option<RgbImage>,
    /// Its numbers, in words.
    pub(crate) numbers: String,
}

/// The size that a picture has on the sheet: 480 pixels across, or 640 down where that is less.
pub(crate) fn thumbnail_size((width, height): (u32, u32)) -> (u32, u32) {
    let (w, h) = (f64::from(width.max(1)), f64::from(height.max(1)));
    let scale = (f64::from(THUMBNAIL) / w).min(640.0 / h);
    let side = |length: f64| (length * scale).round().max(1.0) as u32;
    (side(w), side(h))
}

/// A picture in its size on the sheet.
pub(crate) fn thumbnail(picture: &RgbImage) -> RgbImage {
    let (width, height) = thumbnail_size(picture.dimensions());
    // Small pictures keep their pixels' edges: what is seen is what was rendered.
    let filter = if width > picture.width() {
        FilterType::Nearest
    } else {
        FilterType::Triangle
    };
    imageops::resize(picture, width, height, filter)
}

/// Lays out the sheet. All thumbnails must have one size.
///
/// # Errors
/// Where the built-in font is broken.
pub(crate) fn contact_sheet(
    title: &str,
    facts: &str,
    sections: &[Section],
) -> Result<RgbImage, CompareError> {
    let label = Label::new()?;
    let cells = sections.iter().flat_map(|s| s.cells.iter().flatten());
    let (picture_width, picture_height) = cells
        .map(|cell| cell.picture.dimensions())
        .fold((1, 1), |(w, h), (width, height)| {
            (w.max(width), h.max(height))
        });
    // Portrait pictures are narrower than their words.
    let column = picture_width.max(THUMBNAIL);
    let row = 2 * picture_height + 2 * LINE + 6 + GAP;
    let width = 2 * MARGIN + COLUMNS * column + (COLUMNS - 1) * GAP;
    let header = MARGIN + 104;
    let heading = 96;
    let rows = |section: &Section| section.cells.len().div_ceil(COLUMNS as usize) as u32;
    let height = header
        + sections
            .iter()
            .map(|s| heading + rows(s) * row)
            .sum::<u32>()
        + MARGIN;

    let mut sheet = RgbImage::from_pixel(width, height, PAPER);
    let across = (width - 2 * MARGIN) as f32;
    let left = MARGIN as f32;
    let words = label.fitted(title, 46.0, across);
    label.draw(&mut sheet, (left, MARGIN as f32 - 10.0), 46.0, INK, &words);
    let words = label.fitted(facts, SMALL, across);
    label.draw(
        &mut sheet,
        (left, MARGIN as f32 + 48.0),
        SMALL,
        FADED,
        &words,
    );

    let mut top = header;
    for section in sections {
        label.draw(&mut sheet, (left, top as f32), 36.0, INK, &section.title);
        let legend_left = width - MARGIN - LEGEND_WIDTH;
        draw_legend(&mut sheet, &label, (legend_left, top), section.scale);
        top += heading;
        for cells in section.cells.chunks(COLUMNS as usize) {
            for (cell, index) in cells.iter().zip(0..) {
                if let Some(cell) = cell {
                    let x = MARGIN + index * (column + GAP);
                    draw_cell(&mut sheet, &label, (x, top), column, picture_height, cell);
                }
            }
            top += row;
        }
    }
    Ok(sheet)
}

fn draw_cell(
    sheet: &mut RgbImage,
    label: &Label,
    (x, y): (u32, u32),
    width: u32,
    picture_height: u32,
    cell: &Cell,
) {
    let title = label.fitted(&cell.title, TITLE, width as f32);
    label.draw(sheet, (x as f32, y as f32 - 2.0), TITLE, INK, &title);
    let y = y + LINE;
    imageops::replace(sheet, &cell.picture, x.into(), y.into());
    let mut y = y + picture_height + 2;
    if let Some(difference) = &cell.difference {
        imageops::replace(sheet, difference, x.into(), y.into());
        y += picture_height;
    }
    let numbers = label.fitted(&cell.numbers, SMALL, width as f32);
    label.draw(sheet, (x as f32, y as f32 + 4.0), SMALL, FADED, &numbers);
}

const LEGEND_WIDTH: u32 = 720;

/// Draws a scale of differences with its numbers.
fn draw_legend(sheet: &mut RgbImage, label: &Label, (x, y): (u32, u32), scale: FalseColor) {
    let bar = legend(LEGEND_WIDTH, 18, scale);
    let words = "difference from the reference in luminance: too dark to too bright";
    let indent = (LEGEND_WIDTH as f32 - label.width(words, SMALL)) * 0.5;
    label.draw(
        sheet,
        (x as f32 + indent, y as f32 - 10.0),
        SMALL,
        FADED,
        words,
    );
    imageops::replace(sheet, &bar, x.into(), i64::from(y) + 20);
    for (place, difference) in scale.ticks() {
        let text = signed(difference);
        let text_width = label.width(&text, SMALL);
        let center = x as f32 + place as f32 * LEGEND_WIDTH as f32;
        let last = (x + LEGEND_WIDTH) as f32 - text_width;
        let left = (center - 0.5 * text_width).clamp(x as f32, last);
        label.draw(sheet, (left, y as f32 + 42.0), SMALL, FADED, &text);
    }
}

/// The scale of differences as a bar, too dark on the left.
pub(crate) fn legend(width: u32, height: u32, scale: FalseColor) -> RgbImage {
    RgbImage::from_fn(width, height, |x, _| {
        let place = (f64::from(x) + 0.5) / f64::from(width);
        scale.color(scale.difference_at(place))
    })
}

/// A difference with its sign, without needless digits.
pub(crate) fn signed(difference: f64) -> String {
    let magnitude = difference.abs();
    let digits = if magnitude == 0.0 || (1e-3..1e5).contains(&magnitude) {
        // Four significant digits are enough for a quarter of 1, 2 or 5.
        format!("{}", (magnitude * 1e6).round() / 1e6)
    } else {
        format!("{magnitude:e}")
    };
    match difference {
        d if d > 0.0 => format!("+{digits}"),
        d if d < 0.0 => format!("−{digits}"),
        _ => digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(shade: u8) -> Cell {
        let picture = RgbImage::from_pixel(320, 200, Rgb([shade; 3]));
        Cell {
            id: "exact",
            title: "Exact".to_owned(),
            difference: Some(picture.clone()),
            picture,
            numbers: "RMSE 1.0 %".to_owned(),
        }
    }

    #[test]
    fn every_picture_is_on_the_sheet() {
        let section = |cells| Section {
            title: "Diffuse light".to_owned(),
            scale: FalseColor { limit: 0.5 },
            cells,
        };
        let cells: Vec<_> = (0..6).map(|i| (i != 1).then(|| cell(100 + i))).collect();
        let sections = [section(cells), section(vec![Some(cell(90))])];
        let sheet = contact_sheet("Title", "facts", &sections).unwrap();
        for shade in [100, 102, 103, 104, 105, 90] {
            let count = sheet.pixels().filter(|p| p.0 == [shade; 3]).count();
            // Where antialiased grey text happens to have this shade there may be a few more.
            assert!(count >= 2 * 320 * 200, "{shade}: {count}");
        }
        assert!(sheet.pixels().filter(|p| p.0 == [101; 3]).count() < 320);
    }

    #[test]
    fn thumbnails_keep_their_aspect() {
        assert_eq!(thumbnail_size((720, 450)), (480, 300));
        assert_eq!(thumbnail_size((96, 60)), (480, 300));
        assert_eq!(thumbnail_size((480, 960)), (320, 640));
        assert_eq!(thumbnail_size((1, 32_768)), (1, 640));
        assert_eq!(thumbnail_size((32_768, 1)), (480, 1));
    }

    #[test]
    fn differences_have_signs() {
        assert_eq!(signed(0.5), "+0.5");
        assert_eq!(signed(-0.0125), "−0.0125");
        assert_eq!(signed(0.0), "0");
        assert_eq!(signed(2e-6), "+2e-6");
    }
}
