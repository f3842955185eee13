//! Image files to texels, bounded before they are decoded.
//!
//! What the bytes say counts: MIME types and file endings are often wrong.

mod openexr;
mod radiance;
mod raster;

use std::{path::Path, sync::Arc};

use rayon::prelude::*;

use super::{
    Limits, Sampler, SceneError, Texture, error::Fault, import::read_file, texture::Texels,
};

/// The brightest texel of an image in floating point: beyond it sums leave the range of f32.
const BRIGHTEST: f32 = 1e30;

/// A decoded image, row by row from the upper left.
///
/// PNG and JPEG keep their 8 or 16 bits a channel; Radiance HDR and EXR are linear, in single
/// precision, finite and nowhere negative.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageFile {
    /// What stands for the image in messages.
    pub name: String,
    /// Texels across and down, each at least 1.
    pub size: [u32; 2],
    pub(super) texels: Arc<Texels>,
    /// The file itself, where it is a PNG or JPEG: what is saved in a scene is not encoded anew.
    encoded: Option<Arc<[u8]>>,
}

impl ImageFile {
    /// An image of linear colours, such as a video's frame.
    ///
    /// # Errors
    /// Where there are not `width * height` texels, at least one, or one of them is negative or not
    /// finite.
    pub fn from_linear(
        name: &str,
        [width, height]: [u32; 2],
        texels: &[[f32; 3]],
    ) -> Result<Self, SceneError> {
        let count = u64::from(width) * u64::from(height);
        let opaque = || texels.par_iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        let image = if count == 0 || texels.len() as u64 != count {
            let what = format!("{} texels for {width} × {height}", texels.len());
            Err(Fault::new(
                "image",
                what,
                "give it one colour for each texel",
            ))
        } else {
            Decoded::floats([width, height], opaque(), "image")
        };
        image
            .map(|image| image.named(name))
            .map_err(|fault| fault.in_file(name))
    }

    /// The image as a texture. `srgb`: red, green and blue of 8 or 16 bits are stored with the sRGB
    /// transfer function; those in floating point are linear whatever it says.
    #[must_use]
    pub fn texture(&self, srgb: bool, sampler: Sampler) -> Texture {
        let texels = Arc::clone(&self.texels);
        Texture::new(self.name.clone(), self.size, texels, srgb, sampler)
            .with_encoded(self.encoded.clone())
    }
}

/// Reads a PNG, JPEG, Radiance HDR or EXR file.
///
/// # Errors
/// A [`SceneError`] that names the file, what is wrong with it, and the mend: it cannot be read, is
/// of another format, cut short, outside `limits`, or has texels that are negative or not finite.
pub fn read_image(path: impl AsRef<Path>, limits: &Limits) -> Result<ImageFile, SceneError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let bytes = read_file(path, limits.file_bytes)
        .map_err(|(what, mend)| Fault::new("file", what, mend).in_file(&name))?;
    decode_image(&bytes, &name, limits)
}

/// As [`read_image`], from bytes; `name` stands for the file in errors.
///
/// # Errors
/// As [`read_image`].
pub fn decode_image(bytes: &[u8], name: &str, limits: &Limits) -> Result<ImageFile, SceneError> {
    let image = Budget::new(limits)
        .decode(bytes, "image")
        .map_err(|fault| fault.in_file(name))?;
    let is_raster = !matches!(*image.texels, Texels::F32(_));
    Ok(ImageFile {
        encoded: is_raster.then(|| bytes.into()),
        ..image.named(name)
    })
}

/// An image's size and texels, shared by the textures that show it.
#[derive(Clone)]
pub(super) struct Decoded {
    pub(super) size: [u32; 2],
    pub(super) texels: Arc<Texels>,
}

impl Decoded {
    fn named(self, name: &str) -> ImageFile {
        ImageFile {
            name: name.to_owned(),
            size: self.size,
            texels: self.texels,
            encoded: None,
        }
    }

    /// Texels in floating point, which must be finite, not negative and not too bright; alpha is
    /// bounded by 1.
    fn floats(size: [u32; 2], mut texels: Vec<[f32; 4]>, place: &str) -> Result<Self, Fault> {
        let fits = |x: &f32| (0.0..=BRIGHTEST).contains(x);
        let bad = texels
            .par_iter()
            .position_first(|texel| !texel.iter().all(fits));
        if let Some(index) = bad {
            let (x, y) = (index % size[0] as usize, index / size[0] as usize);
            let channel = texels[index].iter().position(|x| !fits(x)).unwrap_or(0);
            let name = ["red", "green", "blue", "alpha"][channel];
            return Err(Fault::new(
                place,
                format!(
                    "texel ({x}, {y}) has {name} {:e}, outside 0 to {BRIGHTEST:e}",
                    texels[index][channel]
                ),
                "clamp the image to finite numbers that are not negative: light cannot be taken away",
            ));
        }
        texels
            .par_iter_mut()
            .for_each(|texel| texel[3] = texel[3].min(1.0));
        Ok(Self {
            size,
            texels: Arc::new(Texels::F32(texels)),
        })
    }
}

/// How much the images yet to be decoded may take.
pub(super) struct Budget {
    side: u32,
    bytes_left: u64,
}

impl Budget {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            side: limits.image_side,
            bytes_left: limits.image_bytes,
        }
    }

    /// Decodes an image. `place` stands for it in errors.
    pub(super) fn decode(&mut self, bytes: &[u8], place: &str) -> Result<Decoded, Fault> {
        if openexr::is(bytes) {
            return openexr::decode(bytes, place, self);
        }
        if radiance::is(bytes) {
            return radiance::decode(bytes, place, self);
        }
        raster::decode(bytes, place, self)
    }

    /// Takes the bytes of an image of that size from the budget, or says why not.
    fn take(
        &mut self,
        place: &str,
        width: u64,
        height: u64,
        bytes_per_texel: u64,
    ) -> Result<[u32; 2], Fault> {
        let side = u64::from(self.side);
        if width == 0 || height == 0 || width > side || height > side {
            return Err(Fault::new(
                place,
                format!("{width} × {height} texels, outside 1 to {side} a side"),
                "resize it or raise the limit",
            ));
        }
        let needed = width * height * bytes_per_texel;
        self.bytes_left = self.bytes_left.checked_sub(needed).ok_or_else(|| {
            Fault::new(
                place,
                format!(
                    "{width} × {height} texels need {needed} bytes, {} are left for images",
                    self.bytes_left
                ),
                "resize images or raise the limit",
            )
        })?;
        // Both are at most `side`.
        Ok([width as u32, height as u32])
    }
}

#[cfg(test)]
mod tests;
