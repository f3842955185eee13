//! Pictures as files.

use std::path::Path;

use exr::prelude::{Encoding, Image, SpecificChannels, WritableImage as _};
use image::RgbImage;

use super::CompareError;

/// Writes an sRGB picture as PNG.
///
/// # Errors
/// Where the file cannot be written.
pub(super) fn write_png(path: &Path, picture: &RgbImage) -> Result<(), CompareError> {
    picture.save(path).map_err(|source| CompareError::Png {
        path: path.to_owned(),
        source,
    })
}

/// Writes linear values as the float channels R, G and B of an EXR file, without loss.
///
/// # Errors
/// Where the file cannot be written.
pub(super) fn write_exr(
    path: &Path,
    (width, height): (u32, u32),
    pixels: &[[f32; 3]],
) -> Result<(), CompareError> {
    let width = width as usize;
    let channels = SpecificChannels::rgb(|at: exr::prelude::Vec2<usize>| {
        let [r, g, b] = pixels[at.y() * width + at.x()];
        (r, g, b)
    });
    let size = (width, height as usize);
    Image::from_encoded_channels(size, Encoding::SMALL_LOSSLESS, channels)
        .write()
        .to_file(path)
        .map_err(|source| CompareError::Exr {
            path: path.to_owned(),
            source,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_keeps_every_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let pixels: Vec<[f32; 3]> = (0..6).map(|i| [i as f32, -0.1, 1e-30]).collect();
        write_exr(&path, (3, 2), &pixels).unwrap();
        let image = exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |_, _| vec![],
            |read: &mut Vec<([usize; 2], [f32; 3])>, at, (r, g, b, _): (f32, f32, f32, f32)| {
                read.push(([at.x(), at.y()], [r, g, b]));
            },
        )
        .unwrap();
        let mut read = image.layer_data.channel_data.pixels;
        read.sort_by_key(|([x, y], _)| (*y, *x));
        assert_eq!(read.into_iter().map(|(_, p)| p).collect::<Vec<_>>(), pixels);
        assert!(write_exr(&folder.path().join("no/picture.exr"), (3, 2), &pixels).is_err());
    }
}
