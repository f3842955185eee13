//! The kinds of plots.

use glam::DVec3;
use plotters::element::BitMapElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::scale::Scale;
use super::theme::{Area, Theme};
use crate::Failure;

const TITLE: f64 = 30.0;
const LABEL: f64 = 25.0;
const TICK: f64 = 23.0;
const BAR: i32 = 180;

/// Numbers over the first axis (columns, 0 to 1) and the view angle (rows).
pub(super) struct Panel<'a> {
    pub(super) title: &'a str,
    /// What the first axis is.
    pub(super) x_label: &'a str,
    pub(super) columns: usize,
    pub(super) numbers: &'a [f64],
    /// The view angle at the end of the rows, in degrees.
    pub(super) degrees: f64,
}

/// Panels side by side with one scale.
pub(super) fn heat_maps(
    area: &Area<'_>,
    theme: &Theme,
    panels: &[Panel<'_>],
    scale: &Scale,
) -> Result<(), Failure> {
    let (width, height) = area.dim_in_pixel();
    let (maps, bar) = area.split_horizontally(width as i32 - BAR);
    for (area, panel) in maps.split_evenly((1, panels.len())).iter().zip(panels) {
        let mut chart = ChartBuilder::on(area)
            .margin(16)
            .margin_right(26)
            .caption(panel.title, theme.text(TITLE, theme.ink))
            .x_label_area_size(74)
            .y_label_area_size(84)
            .build_cartesian_2d(0.0..1.0, 0.0..panel.degrees)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(theme.faded)
            .x_labels(6)
            .y_labels(7)
            .x_label_formatter(&|x| format!("{x:.1}"))
            .y_label_formatter(&|y| format!("{y:.0}"))
            .label_style(theme.text(TICK, theme.ink))
            .axis_desc_style(theme.text(LABEL, theme.ink))
            .x_desc(panel.x_label)
            .y_desc("view angle (degrees)")
            .draw()?;
        // Pixel by pixel: rectangles would leave gaps between them.
        let plot = chart.plotting_area();
        let (xs, ys) = plot.get_pixel_range();
        let (width, height) = (xs.len(), ys.len());
        let rows = panel.numbers.len() / panel.columns;
        let mut pixels = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            let row = (height - 1 - y) * rows / height;
            for x in 0..width {
                let number = panel.numbers[row * panel.columns + x * panel.columns / width];
                let RGBColor(r, g, b) = scale.color(number);
                pixels.extend([r, g, b]);
            }
        }
        let corner = (0.0, panel.degrees);
        plot.draw(&bitmap(corner, (width, height), pixels)?)?;
    }
    color_bar(&bar, theme, scale, height as i32)
}

/// A picture of RGB bytes at a place.
fn bitmap<'a, C>(
    corner: C,
    (width, height): (usize, usize),
    pixels: Vec<u8>,
) -> Result<BitMapElement<'a, C>, Failure> {
    let size = (u32::try_from(width)?, u32::try_from(height)?);
    let element = BitMapElement::with_owned_buffer(corner, size, pixels);
    Ok(element.ok_or("a plot's pixels don't fill it")?)
}

fn color_bar(bar: &Area<'_>, theme: &Theme, scale: &Scale, height: i32) -> Result<(), Failure> {
    let (top, bottom) = (70, height - 92);
    let (left, right) = (8, 40);
    for y in top..bottom {
        let place = f64::from(bottom - 1 - y) / f64::from(bottom - top - 1);
        let color = scale.color_at(place);
        bar.draw(&Rectangle::new([(left, y), (right, y + 1)], color.filled()))?;
    }
    bar.draw(&Rectangle::new([(left, top), (right, bottom)], theme.faded))?;
    for (place, text) in scale.ticks() {
        let y = bottom - (place * f64::from(bottom - top)).round() as i32;
        bar.draw(&PathElement::new([(right, y), (right + 8, y)], theme.faded))?;
        let style = theme
            .text(TICK, theme.ink)
            .pos(Pos::new(HPos::Left, VPos::Center));
        bar.draw(&Text::new(text, (right + 14, y), style))?;
    }
    let style = theme
        .text(LABEL, theme.ink)
        .transform(FontTransform::Rotate90)
        .pos(Pos::new(HPos::Center, VPos::Top));
    let middle = (top + bottom) / 2;
    bar.draw(&Text::new(scale.label, (BAR - 14, middle), style))?;
    Ok(())
}

/// Curves of the BRDF, the table and the baseline.
pub(super) struct Curves<'a> {
    pub(super) title: String,
    pub(super) x_label: &'a str,
    pub(super) y_label: &'a str,
    pub(super) truth: &'a [(f64, f64)],
    /// Points instead of a line.
    pub(super) truth_as_points: bool,
    pub(super) fitted: &'a [Vec<(f64, f64)>; 2],
}

/// Charts in a grid, with a legend above.
pub(super) fn charts(
    area: &Area<'_>,
    theme: &Theme,
    names: [&str; 3],
    curves: &[Curves<'_>],
    columns: usize,
) -> Result<(), Failure> {
    let (legend, rest) = area.split_vertically(56);
    let points = curves.iter().any(|curves| curves.truth_as_points);
    draw_legend(&legend, theme, names, points)?;
    let rows = curves.len().div_ceil(columns);
    for (area, curves) in rest.split_evenly((rows, columns)).iter().zip(curves) {
        chart(area, theme, curves)?;
    }
    Ok(())
}

fn draw_legend(
    area: &Area<'_>,
    theme: &Theme,
    names: [&str; 3],
    truth_as_points: bool,
) -> Result<(), Failure> {
    let colors = [theme.faded, theme.table, theme.baseline];
    let mut x = 30;
    for (i, (name, color)) in names.into_iter().zip(colors).enumerate() {
        let stroke = if i == 0 { 9 } else { 3 };
        if i == 0 && truth_as_points {
            let circle = Circle::new((x + 24, 30), 6, theme.ink.stroke_width(2));
            area.draw(&circle)?;
        } else {
            let line = PathElement::new([(x, 30), (x + 48, 30)], color.stroke_width(stroke));
            area.draw(&line)?;
        }
        let style = theme
            .text(LABEL, theme.ink)
            .pos(Pos::new(HPos::Left, VPos::Center));
        let (width, _) = area.estimate_text_size(name, &style)?;
        area.draw(&Text::new(name, (x + 60, 34), style))?;
        x += 60 + i32::try_from(width)? + 50;
    }
    Ok(())
}

fn chart(area: &Area<'_>, theme: &Theme, curves: &Curves<'_>) -> Result<(), Failure> {
    let points = || curves.truth.iter().chain(curves.fitted.iter().flatten());
    let finite = |greatest: f64, &(_, y): &(f64, f64)| match y.is_finite() {
        true => greatest.max(y),
        false => greatest,
    };
    let greatest = points().fold(0.0, finite);
    let top = if greatest > 0.0 { 1.08 * greatest } else { 1.0 };
    let ends = curves.truth.first().zip(curves.truth.last());
    let (low, high) = ends.map_or((0.0, 1.0), |(first, last)| (first.0, last.0));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(26)
        .caption(&curves.title, theme.text(LABEL, theme.ink))
        .x_label_area_size(66)
        .y_label_area_size(108)
        .build_cartesian_2d(low..high, 0.0..top)?;
    // As many digits as tell a fifth of the range apart.
    let digits = |range: f64| (1.0 - range.log10()).ceil().clamp(0.0, 9.0) as usize;
    chart
        .configure_mesh()
        .bold_line_style(theme.line)
        .light_line_style(theme.paper)
        .axis_style(theme.faded)
        .x_labels((area.dim_in_pixel().0 / 100) as usize)
        .y_labels(5)
        .x_label_formatter(&|x| format!("{x:.*}", digits(high - low)))
        .y_label_formatter(&|y| match top {
            top if (1e-3..1e4).contains(&top) => format!("{y:.*}", digits(top)),
            _ => format!("{y:.1e}"),
        })
        .label_style(theme.text(TICK, theme.ink))
        .axis_desc_style(theme.text(TICK, theme.ink))
        .x_desc(curves.x_label)
        .y_desc(curves.y_label)
        .draw()?;
    if !curves.truth_as_points {
        let finite = curves.truth.iter().copied().filter(|p| p.1.is_finite());
        let style = theme.faded.stroke_width(8);
        chart.draw_series(LineSeries::new(finite, style))?;
    }
    for (points, color) in [
        (&curves.fitted[1], theme.baseline),
        (&curves.fitted[0], theme.table),
    ] {
        let finite = points
            .windows(2)
            .filter(|pair| pair.iter().all(|p| p.1.is_finite()));
        // Piece by piece: the join of a narrow peak would shoot out of the chart.
        let pieces = finite.map(|pair| PathElement::new(pair.to_vec(), color.stroke_width(3)));
        chart.draw_series(pieces)?;
    }
    if curves.truth_as_points {
        let points = curves.truth.iter();
        chart.draw_series(points.map(|&at| Circle::new(at, 6, theme.ink.stroke_width(2))))?;
    }
    Ok(())
}

/// A density over the hemisphere of lights.
pub(super) struct Hemisphere<'a> {
    pub(super) name: &'a str,
    /// Where it is.
    pub(super) place: String,
    /// What is shown at the end of the scale.
    pub(super) peak: f64,
    pub(super) density: &'a (dyn Fn(DVec3) -> f64 + Sync),
}

/// Hemispheres from above, in columns; colours by the square root of the density over its peak.
pub(super) fn hemispheres(
    area: &Area<'_>,
    theme: &Theme,
    rows: &[Vec<Hemisphere<'_>>],
    scale: &Scale,
) -> Result<(), Failure> {
    let (width, height) = area.dim_in_pixel();
    let (pictures, bar) = area.split_horizontally(width as i32 - BAR);
    let columns = rows.first().map_or(1, Vec::len);
    let areas = pictures.split_evenly((rows.len(), columns));
    for (area, hemisphere) in areas.iter().zip(rows.iter().flatten()) {
        let (width, height) = area.dim_in_pixel();
        let style = theme
            .text(TICK, theme.ink)
            .pos(Pos::new(HPos::Center, VPos::Top));
        let middle = width as i32 / 2;
        area.draw(&Text::new(hemisphere.name, (middle, 14), style.clone()))?;
        area.draw(&Text::new(hemisphere.place.as_str(), (middle, 42), style))?;
        let side = (width.min(height.saturating_sub(74)).saturating_sub(16)) as usize;
        let RGBColor(r, g, b) = theme.paper;
        let mut pixels = Vec::with_capacity(3 * side * side);
        for y in 0..side {
            for x in 0..side {
                let unit = |at: usize| 2.0 * (at as f64 + 0.5) / side as f64 - 1.0;
                let (x, y) = (unit(x), -unit(y));
                let z2 = 1.0 - x * x - y * y;
                if z2 <= 0.0 {
                    pixels.extend([r, g, b]);
                    continue;
                }
                let density = (hemisphere.density)(DVec3::new(x, y, z2.sqrt()));
                let RGBColor(r, g, b) = scale.color((density / hemisphere.peak).max(0.0).sqrt());
                pixels.extend([r, g, b]);
            }
        }
        let corner = ((width as i32 - side as i32) / 2, 74);
        area.draw(&bitmap(corner, (side, side), pixels)?)?;
    }
    color_bar(&bar, theme, scale, height as i32)
}
