//! Pictures of plots, on light and on dark paper.

use epaint_default_fonts::UBUNTU_LIGHT;
use image::RgbImage;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;

use crate::Failure;

/// Where a figure or a part of it is drawn.
pub(crate) type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

const FONT: &str = "lumigon";

/// The page's colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Theme {
    pub(crate) name: &'static str,
    pub(crate) paper: RGBColor,
    pub(crate) ink: RGBColor,
    pub(crate) faded: RGBColor,
    pub(crate) line: RGBColor,
    pub(crate) table: RGBColor,
    pub(crate) baseline: RGBColor,
}

/// Both appearances of the page.
pub(crate) const THEMES: [Theme; 2] = [
    Theme {
        name: "light",
        paper: RGBColor(255, 255, 255),
        ink: RGBColor(29, 28, 26),
        faded: RGBColor(107, 103, 97),
        line: RGBColor(227, 223, 216),
        table: RGBColor(190, 84, 4),
        baseline: RGBColor(42, 111, 176),
    },
    Theme {
        name: "dark",
        paper: RGBColor(29, 31, 37),
        ink: RGBColor(233, 231, 227),
        faded: RGBColor(161, 157, 150),
        line: RGBColor(50, 52, 60),
        table: RGBColor(240, 163, 94),
        baseline: RGBColor(127, 181, 232),
    },
];

impl Theme {
    /// Text of a size in pixels.
    pub(crate) fn text(&self, size: f64, color: RGBColor) -> TextStyle<'static> {
        (FONT, size).into_font().color(&color)
    }

    /// A finished picture.
    pub(crate) fn paint(
        &self,
        (width, height): (u32, u32),
        draw: &dyn Fn(&Area<'_>, &Self) -> Result<(), Failure>,
    ) -> Result<RgbImage, Failure> {
        register_font(FONT, FontStyle::Normal, UBUNTU_LIGHT)
            .map_err(|_| "the built-in font cannot be read")?;
        let mut image = RgbImage::new(width, height);
        {
            let area = BitMapBackend::with_buffer(&mut image, (width, height)).into_drawing_area();
            area.fill(&self.paper)?;
            draw(&area, self)?;
            area.present()?;
        }
        Ok(image)
    }
}
