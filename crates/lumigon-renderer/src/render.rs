//! What to render, and what comes back.

use std::sync::atomic::{AtomicBool, Ordering};

use lumigon::{DiffuseMethod, ImageMethod, SpecularMethod};

/// Longest side of a picture, in pixels.
pub const MAXIMUM_SIDE: u32 = 32_768;

/// A picture's size and the methods that light it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels across, 1 to [`MAXIMUM_SIDE`].
    pub width: u32,
    /// Pixels down, 1 to [`MAXIMUM_SIDE`].
    pub height: u32,
    /// Rays a pixel: 1 through its centre, more stratified, the same pattern in every pixel.
    pub samples: u32,
    /// How diffuse light is computed.
    pub diffuse: DiffuseMethod,
    /// How specular light is computed. [`LtcLobes::Two`](lumigon::LtcLobes::Two) holds for isotropic
    /// GGX, coats included: anisotropic surfaces, sheens and rough diffuse ones keep their one lobe.
    pub specular: SpecularMethod,
    /// How the images on lights are averaged.
    pub image_method: ImageMethod,
    /// Radiance, at least 0: lights that add less than this to a pixel may be left out, each of
    /// them, where diffuse light is exact and specular light, if any, by LTC. 0 leaves out none, and
    /// the CPU never does.
    pub light_bound: f32,
    /// Bytes that the lights' distance fields may have together, for
    /// [`SpecularMethod::ReflectedDistanceField`]: one field for each shape of a light.
    pub distance_field_budget: u64,
    /// Whether the scene's own lights light what is seen, and are seen; if not, virtual lights alone do.
    pub direct: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            width: 1440,
            height: 900,
            samples: 4,
            diffuse: DiffuseMethod::default(),
            specular: SpecularMethod::default(),
            image_method: ImageMethod::default(),
            light_bound: 0.0,
            distance_field_budget: 256 << 20,
            direct: true,
        }
    }
}

/// A path-traced picture's size and quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReferenceSettings {
    /// Pixels across, 1 to [`MAXIMUM_SIDE`].
    pub width: u32,
    /// Pixels down, 1 to [`MAXIMUM_SIDE`].
    pub height: u32,
    /// Camera rays a pixel, at the same places as [`RenderSettings::samples`].
    pub samples: u32,
    /// Light paths a pixel; rounded up to a multiple of `samples` and to at least two for each.
    pub paths: u32,
    /// Surfaces a path may scatter at: 1 is direct light alone.
    pub bounces: u32,
    /// Whether surfaces block light that comes from the lights.
    pub shadows: bool,
    /// Whether light counts that comes straight from a light to the surface that is seen, and what
    /// that surface emits itself. False leaves the indirect light alone: with 2 bounces that is a
    /// single bounce, with 1 it is nothing.
    pub direct: bool,
    /// Whether surfaces block light that comes from other surfaces. False lets each send its light
    /// through all others: with `shadows` off as well, what virtual lights without visibility add
    /// up to where there are enough of them.
    pub bounce_shadows: bool,
    /// Seed of the random numbers: equal seeds give equal pictures on any number of threads.
    pub seed: u64,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self {
            width: 1440,
            height: 900,
            samples: 4,
            paths: 64,
            bounces: 1,
            shadows: true,
            direct: true,
            bounce_shadows: true,
            seed: 0,
        }
    }
}

/// Linear radiance, RGB, row by row from the upper left.
pub type Pixels = Vec<[f32; 3]>;

/// A rendered picture in its parts; radiance is their sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendering {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Light that surfaces emit towards the camera.
    pub emitted: Pixels,
    /// Light scattered by the diffuse lobe.
    pub diffuse: Pixels,
    /// Light scattered by the specular lobe.
    pub specular: Pixels,
}

impl Rendering {
    /// All black.
    pub(crate) fn black(width: u32, height: u32) -> Result<Self, RenderError> {
        let count = (width as usize).saturating_mul(height as usize);
        // The parts and their sum, asked for at once: systems that promise each of them would break
        // their word when all are written to.
        Vec::<[[f32; 3]; 4]>::new()
            .try_reserve_exact(count)
            .map_err(|_| RenderError::TooLarge { width, height })?;
        let part = || vec![[0.0; 3]; count];
        Ok(Self {
            width,
            height,
            emitted: part(),
            diffuse: part(),
            specular: part(),
        })
    }

    /// The sum of the parts.
    #[must_use]
    pub fn radiance(&self) -> Pixels {
        let parts = self.emitted.iter().zip(&self.diffuse).zip(&self.specular);
        parts
            .map(|((e, d), s)| std::array::from_fn(|i| e[i] + d[i] + s[i]))
            .collect()
    }
}

/// A path-traced picture with the standard errors of its means.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceRendering {
    /// The means.
    pub mean: Rendering,
    /// Standard error of `mean.diffuse`.
    pub diffuse_error: Pixels,
    /// Standard error of `mean.specular`.
    pub specular_error: Pixels,
    /// Standard error of the sum.
    pub radiance_error: Pixels,
}

/// Follows and stops long work.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Called from any thread with the work done and all there is.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
    /// Set it to stop the work with [`RenderError::Cancelled`].
    pub cancelled: &'a AtomicBool,
}

impl Watch<'_> {
    /// Neither follows nor stops.
    #[must_use]
    pub fn none() -> Watch<'static> {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Watch {
            progress: &|_, _| {},
            cancelled: &NEVER,
        }
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The size or the number of samples is out of range.
    #[error("{what} is {value}: give {least} to {greatest}")]
    OutOfRange {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: u64,
        /// The least that works.
        least: u64,
        /// The greatest that works.
        greatest: u64,
    },
    /// The picture is larger than the memory.
    #[error(
        "there is too little memory for a picture of {width} x {height} pixels: render a smaller one"
    )]
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The lights' distance fields are over their budget.
    #[error(transparent)]
    DistanceField(#[from] lumigon::DistanceFieldError),
    /// A light has no picture to replace.
    #[error("light {light} shows no picture: only lights with a texture can show another one")]
    NoPicture {
        /// Its index.
        light: usize,
    },
    /// A picture cannot be shown.
    #[error(transparent)]
    Picture(#[from] lumigon::LightImageError),
    /// A texture cannot be drawn into.
    #[error(
        "the texture to draw into {fault}: give one of {width} x {height} pixels that can be rendered to, \
         in the format Rgba8Unorm, Bgra8Unorm or Rgba16Float"
    )]
    Target {
        /// What is wrong with it.
        fault: String,
        /// Pixels across that it should have.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// [`Watch::cancelled`] was set.
    #[error("interrupted")]
    Cancelled,
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] crate::GpuError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_larger_than_memory_is_refused() {
        let fault = Rendering::black(u32::MAX, u32::MAX).unwrap_err();
        assert!(fault.to_string().contains("4294967295 x 4294967295"));
        assert_eq!(Rendering::black(3, 2).unwrap().radiance(), [[0.0; 3]; 6]);
    }
}
