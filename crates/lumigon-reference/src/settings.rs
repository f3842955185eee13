//! What a rendering is asked to be.

use thiserror::Error;

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<'a> {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Positions inside the pixel, in [0, 1)^2 from its top left corner, the same for every pixel.
    ///
    /// Every position gets an equal share of the samples, and the standard error is that of the light at these fixed
    /// positions: an image without noise sampled at the same ones should differ by no more.
    pub pixel_samples: &'a [[f64; 2]],
    /// Paths per pixel: a multiple of the number of positions, and at least twice that for an error to be known.
    pub samples_per_pixel: usize,
    /// Reflections between light and camera; 1 is direct light only.
    pub bounces: u32,
    /// Whether surfaces block light that comes from the lights, at every surface of a path.
    pub shadows: bool,
    /// Whether light counts that comes straight from a light to the surface that is seen.
    ///
    /// False leaves the indirect light alone: what a path gathers from its second surface on, and nothing at all with
    /// one bounce. What the seen surface emits doesn't count then either. 2 bounces without direct light are the light
    /// of a single bounce.
    pub direct: bool,
    /// Whether surfaces block light that comes from other surfaces.
    ///
    /// False lets every surface along a path's direction send its reflected light, as if it were the nearest: the
    /// integral over all surfaces' area without visibility. Surfaces turn the side to the receiver that
    /// [`Scene::intersect`](crate::Scene::intersect) reports, and past 256 of them along one ray none counts.
    pub bounce_shadows: bool,
    /// Other seeds give independent noise.
    pub seed: u64,
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No pixels, or more than 2^28.
    #[error("an image of {width} x {height} pixels cannot be rendered; it needs 1 to 2^28 of them")]
    Size {
        /// Pixels per row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// No pixel samples, or one outside [0, 1)^2.
    #[error("pixel samples must be one or more positions in [0, 1) x [0, 1)")]
    PixelSamples,
    /// The paths don't divide into the pixel samples, or leave fewer than two for each.
    #[error(
        "{samples_per_pixel} samples per pixel don't give each of {count} pixel samples the same number, two or more; take a multiple of {count} from {}", 2 * count
    )]
    SamplesPerPixel {
        /// What was asked.
        samples_per_pixel: usize,
        /// How many positions share them.
        count: usize,
    },
    /// No bounce at all.
    #[error("bounces is 0; 1 is direct light")]
    Bounces,
    /// The caller said stop.
    #[error("rendering was stopped")]
    Cancelled,
}

impl Settings<'_> {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let &Settings {
            width,
            height,
            pixel_samples,
            samples_per_pixel,
            ..
        } = self;
        if !width
            .checked_mul(height)
            .is_some_and(|pixels| (1..=1 << 28).contains(&pixels))
        {
            return Err(RenderError::Size { width, height });
        }
        let count = pixel_samples.len();
        if count == 0
            || !pixel_samples
                .iter()
                .flatten()
                .all(|x| (0.0..1.0).contains(x))
        {
            return Err(RenderError::PixelSamples);
        }
        if !samples_per_pixel.is_multiple_of(count) || samples_per_pixel / count < 2 {
            return Err(RenderError::SamplesPerPixel {
                samples_per_pixel,
                count,
            });
        }
        if self.bounces == 0 {
            return Err(RenderError::Bounces);
        }
        Ok(())
    }
}
