//! Radiance to what a screen shows.

use image::{Rgb, RgbImage};

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Tonemap {
    /// Radiance 1 is white; what is brighter is clipped.
    #[default]
    Clip,
}

/// Exposure and tone curve.
#[derive(Clone, Copy, Debug)]
pub struct Display {
    /// Stops.
    pub exposure: f32,
    /// The curve.
    pub tonemap: Tonemap,
}

impl Display {
    /// The picture in sRGB.
    pub fn image(self, (width, height): (u32, u32), pixels: &[[f32; 3]]) -> RgbImage {
        let factor = self.exposure.exp2();
        let mut image = RgbImage::new(width, height);
        for (shown, pixel) in image.pixels_mut().zip(pixels) {
            *shown = Rgb(pixel.map(|value| encode(value * factor)));
        }
        image
    }
}

fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}
