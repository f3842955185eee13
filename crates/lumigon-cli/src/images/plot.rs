//! The report's charts.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::measure::METHODS;
use super::statistics::Row;
use crate::Failure;
use crate::fit::theme::{Area, Theme};

const LABEL: f64 = 25.0;
const TICK: f64 = 23.0;

/// The methods' colours, on any paper.
fn color(method: usize) -> RGBColor {
    let place = [0.0, 0.28, 0.5, 0.68, 0.88][method];
    let color = colorous::PLASMA.eval_continuous(place);
    RGBColor(color.r, color.g, color.b)
}

/// The root mean square errors of rows as groups of bars, one bar a method.
pub(super) fn bars(area: &Area<'_>, theme: &Theme, rows: &[Row]) -> Result<(), Failure> {
    let (legend, rest) = area.split_vertically(56);
    draw_legend(&legend, theme)?;
    let greatest = rows.iter().flat_map(|row| row.rms).fold(0.0, f64::max);
    let top = (100.0 * greatest * 1.08).max(1e-6);
    let groups = rows.len() as f64;
    let mut chart = ChartBuilder::on(&rest)
        .margin(12)
        .margin_right(26)
        .x_label_area_size(66)
        .y_label_area_size(92)
        .build_cartesian_2d(0.0..groups, 0.0..top)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .bold_line_style(theme.line)
        .light_line_style(theme.paper)
        .axis_style(theme.faded)
        .x_labels(0)
        .y_labels(8)
        .y_label_formatter(&|y| format!("{y:.0}"))
        .label_style(theme.text(TICK, theme.ink))
        .axis_desc_style(theme.text(LABEL, theme.ink))
        .y_desc("RMS, % of the image's mean")
        .draw()?;
    let width = 0.8 / METHODS.len() as f64;
    for (group, row) in rows.iter().enumerate() {
        for (method, rms) in row.rms.iter().enumerate() {
            let left = group as f64 + 0.1 + method as f64 * width;
            let bar = Rectangle::new(
                [(left, 0.0), (left + 0.9 * width, 100.0 * rms)],
                color(method).filled(),
            );
            chart.draw_series([bar])?;
        }
    }
    let plot = chart.plotting_area();
    let (xs, ys) = plot.get_pixel_range();
    let style = theme
        .text(TICK, theme.ink)
        .pos(Pos::new(HPos::Center, VPos::Top));
    let (corner_x, corner_y) = rest.get_base_pixel();
    for (group, row) in rows.iter().enumerate() {
        let share = (group as f64 + 0.5) / groups;
        let x = xs.start + (share * f64::from(xs.end - xs.start)) as i32 - corner_x;
        rest.draw(&Text::new(
            row.name.as_str(),
            (x, ys.end + 14 - corner_y),
            style.clone(),
        ))?;
    }
    Ok(())
}

fn draw_legend(area: &Area<'_>, theme: &Theme) -> Result<(), Failure> {
    let mut x = 30;
    for (method, (name, _)) in METHODS.iter().enumerate() {
        let swatch = Rectangle::new([(x, 20), (x + 34, 42)], color(method).filled());
        area.draw(&swatch)?;
        let style = theme
            .text(LABEL, theme.ink)
            .pos(Pos::new(HPos::Left, VPos::Center));
        let (width, _) = area.estimate_text_size(name, &style)?;
        area.draw(&Text::new(*name, (x + 46, 34), style))?;
        x += 46 + i32::try_from(width)? + 44;
    }
    Ok(())
}
