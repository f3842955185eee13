//! The report's charts.

use plotters::coord::combinators::IntoLogRange;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::Failure;
use crate::fit::theme::{Area, Theme};

const LABEL: f64 = 25.0;
const TICK: f64 = 23.0;
const LINE: i32 = 36;

/// Numbers over numbers, both above 0, on logarithmic axes.
pub(super) struct Chart<'a> {
    pub(super) x_label: &'a str,
    pub(super) y_label: &'a str,
    pub(super) lines: Vec<Line<'a>>,
}

pub(super) struct Line<'a> {
    pub(super) name: &'a str,
    pub(super) points: Vec<(f64, f64)>,
}

/// The lines' colours, on any paper.
fn color(index: usize, theme: &Theme) -> RGBColor {
    match colorous::TABLEAU10.get(index) {
        Some(color) => RGBColor(color.r, color.g, color.b),
        None => theme.ink,
    }
}

impl Chart<'_> {
    pub(super) fn draw(&self, area: &Area<'_>, theme: &Theme) -> Result<(), Failure> {
        let (legend, rest) = area.split_vertically(24 + LINE * self.lines.len().div_ceil(3) as i32);
        self.draw_legend(&legend, theme)?;
        let points = || self.points();
        let [x, y] = [range(points().map(|p| p.0)), range(points().map(|p| p.1))];
        let (Some(x), Some(y)) = (x, y) else {
            let style = theme.text(LABEL, theme.faded);
            rest.draw(&Text::new("nothing was lit", (60, 60), style))?;
            return Ok(());
        };
        let mut chart = ChartBuilder::on(&rest)
            .margin(12)
            .margin_right(30)
            .x_label_area_size(72)
            .y_label_area_size(110)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(theme.faded)
            .x_labels(0)
            .y_labels(0)
            .x_label_formatter(&|_| String::new())
            .y_label_formatter(&|_| String::new())
            .label_style(theme.text(TICK, theme.ink))
            .axis_desc_style(theme.text(LABEL, theme.ink))
            .x_desc(self.x_label)
            .y_desc(self.y_label)
            .draw()?;
        let mut columns: Vec<f64> = points().map(|p| p.0).collect();
        columns.sort_by(f64::total_cmp);
        columns.dedup();
        let (xs, ys) = chart.plotting_area().get_pixel_range();
        let (left, top) = rest.get_base_pixel();
        let style = |x, y| theme.text(TICK, theme.ink).pos(Pos::new(x, y));
        for &column in &columns {
            let ends = vec![(column, y.0), (column, y.1)];
            chart.draw_series([PathElement::new(ends, theme.line)])?;
            let place = chart.plotting_area().map_coordinate(&(column, y.0));
            let text = Text::new(
                short(column),
                (place.0 - left, ys.end + 10 - top),
                style(HPos::Center, VPos::Top),
            );
            rest.draw(&text)?;
        }
        for row in ticks(y) {
            chart.draw_series([PathElement::new(vec![(x.0, row), (x.1, row)], theme.line)])?;
            let place = chart.plotting_area().map_coordinate(&(x.0, row));
            let text = Text::new(
                short(row),
                (xs.start - 12 - left, place.1 - top),
                style(HPos::Right, VPos::Center),
            );
            rest.draw(&text)?;
        }
        for (index, line) in self.lines.iter().enumerate() {
            let color = color(index, theme);
            let points: Vec<_> = line.points.iter().copied().filter(is_drawn).collect();
            chart.draw_series(LineSeries::new(points.clone(), color.stroke_width(4)))?;
            let dots = points.iter().map(|&p| Circle::new(p, 6, color.filled()));
            chart.draw_series(dots)?;
        }
        Ok(())
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let points = self.lines.iter().flat_map(|line| &line.points);
        points.copied().filter(is_drawn)
    }

    /// Three names a row.
    fn draw_legend(&self, area: &Area<'_>, theme: &Theme) -> Result<(), Failure> {
        let (width, _) = area.dim_in_pixel();
        let column = width as i32 / 3;
        for (index, line) in self.lines.iter().enumerate() {
            let place = index as i32;
            let (x, y) = (30 + place % 3 * column, 14 + place / 3 * LINE);
            let color = color(index, theme);
            area.draw(&Rectangle::new(
                [(x, y + 4), (x + 34, y + 22)],
                color.filled(),
            ))?;
            let style = theme
                .text(LABEL, theme.ink)
                .pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(line.name, (x + 46, y + 13), style))?;
        }
        Ok(())
    }
}

fn is_drawn(&(x, y): &(f64, f64)) -> bool {
    x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite()
}

/// A little more than all of the values.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        Some(ends.map_or((value, value), |(low, high)| {
            (low.min(value), high.max(value))
        }))
    });
    ends.map(|(low, high)| (low / 1.25, high * 1.25))
}

/// 1, 2, 5, 10... within a range; 1, 10, 100... where those were many.
fn ticks((low, high): (f64, f64)) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let steps: &[f64] = if last - first > 4 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    (first..=last)
        .flat_map(|power| steps.iter().map(move |step| step * 10_f64.powi(power)))
        .filter(|tick| (low..=high).contains(tick))
        .collect()
}

fn short(value: f64) -> String {
    match value {
        v if v >= 10.0 => format!("{v:.0}"),
        v if v >= 0.001 => format!("{}", (v * 1e5).round() / 1e5),
        v => format!("{v:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::theme::THEMES;

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks((0.9, 12.0)), [1.0, 2.0, 5.0, 10.0]);
        assert_eq!(ticks((0.5, 2e5)).len(), 6);
    }

    #[test]
    fn any_numbers_can_be_drawn() {
        for points in [
            vec![],
            vec![(1.0, 0.0), (0.0, 1.0), (f64::NAN, 1.0)],
            vec![(1.0, 0.5)],
            vec![(1.0, 1e-9), (1e6, 1e9), (10.0, f64::INFINITY)],
        ] {
            let lines = vec![Line {
                name: "one",
                points,
            }];
            let chart = Chart {
                x_label: "x",
                y_label: "y",
                lines,
            };
            let picture = THEMES[0].paint((600, 400), &|area, theme| chart.draw(area, theme));
            assert!(picture.is_ok());
        }
    }
}
