//! Text in pictures.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use epaint_default_fonts::UBUNTU_LIGHT;
use image::{Rgb, RgbImage};

use super::error::CompareError;

/// Writes text into pictures with the Ubuntu font.
#[derive(Debug)]
pub(super) struct Label {
    font: FontRef<'static>,
}

impl Label {
    /// Reads the font.
    ///
    /// # Errors
    /// Where the font that was built in is broken.
    pub(super) fn new() -> Result<Self, CompareError> {
        let font = FontRef::try_from_slice(UBUNTU_LIGHT).map_err(|_| CompareError::Font)?;
        Ok(Self { font })
    }

    /// How wide a line of text is, in pixels.
    pub(super) fn width(&self, text: &str, size: f32) -> f32 {
        self.line(text, size).1
    }

    /// The text, shortened until it fits.
    pub(super) fn fitted(&self, text: &str, size: f32, width: f32) -> String {
        if self.width(text, size) <= width {
            return text.to_owned();
        }
        let mut kept: Vec<char> = text.chars().collect();
        while kept.pop().is_some() {
            let shortened: String = kept.iter().chain(&['…']).collect();
            if self.width(&shortened, size) <= width {
                return shortened;
            }
        }
        String::new()
    }

    /// Draws one line of text; (`x`, `y`) is the upper left corner of the line.
    pub(super) fn draw(
        &self,
        image: &mut RgbImage,
        (x, y): (f32, f32),
        size: f32,
        color: Rgb<u8>,
        text: &str,
    ) {
        let ascent = self.font.as_scaled(size).ascent();
        for mut glyph in self.line(text, size).0 {
            glyph.position += point(x, y + ascent);
            let Some(outline) = self.font.outline_glyph(glyph) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, coverage| {
                let x = corner.x as i64 + i64::from(dx);
                let y = corner.y as i64 + i64::from(dy);
                let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
                    return;
                };
                if let Some(pixel) = image.get_pixel_mut_checked(x, y) {
                    for (below, above) in pixel.0.iter_mut().zip(color.0) {
                        let mixed = f32::from(*below)
                            + (f32::from(above) - f32::from(*below)) * coverage.clamp(0.0, 1.0);
                        *below = mixed.round() as u8;
                    }
                }
            });
        }
    }

    /// The glyphs of a line on a baseline at the origin, and the line's width.
    fn line(&self, text: &str, size: f32) -> (Vec<Glyph>, f32) {
        let font = self.font.as_scaled(PxScale::from(size));
        let mut x = 0.0;
        let mut previous = None;
        let mut glyphs = Vec::new();
        for character in text.chars().filter(|c| !c.is_control()) {
            let id = font.glyph_id(character);
            if let Some(previous) = previous {
                x += font.kern(previous, id);
            }
            previous = Some(id);
            glyphs.push(id.with_scale_and_position(size, point(x, 0.0)));
            x += font.h_advance(id);
        }
        (glyphs, x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_leaves_its_color_inside_its_line() {
        let label = Label::new().unwrap();
        let mut image = RgbImage::new(200, 40);
        label.draw(&mut image, (4.0, 4.0), 24.0, Rgb([255, 0, 0]), "Light");
        let width = label.width("Light", 24.0);
        assert!(width > 30.0 && width < 120.0);
        let marked: Vec<_> = image
            .enumerate_pixels()
            .filter(|(_, _, p)| p.0[0] > 128)
            .collect();
        assert!(marked.len() > 50);
        for (x, y, pixel) in marked {
            assert!((x as f32) < 5.0 + width && y < 34 && pixel.0[1] == 0);
        }
    }

    #[test]
    fn text_outside_of_the_picture_is_cut() {
        let label = Label::new().unwrap();
        let mut image = RgbImage::new(8, 8);
        label.draw(&mut image, (-20.0, -5.0), 24.0, Rgb([255; 3]), "Light\n");
        label.draw(&mut image, (1e9, 1e9), 24.0, Rgb([255; 3]), "Light");
    }

    #[test]
    fn long_text_is_shortened() {
        let label = Label::new().unwrap();
        let short = label.fitted("projected area with the optimal basis", 16.0, 100.0);
        assert!(short.ends_with('…') && label.width(&short, 16.0) <= 100.0);
        assert_eq!(label.fitted("short", 16.0, 100.0), "short");
        assert_eq!(label.fitted("short", 16.0, 1.0), "");
    }
}
