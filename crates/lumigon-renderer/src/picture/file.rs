//! Writing pictures, whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use super::{PictureError, ToneMap, srgb8};
use crate::whole_file::{self, beside};
use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage,
};

/// The two kinds of picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// sRGB, 8 bits a channel.
    Png,
    /// Linear radiance, 32-bit floats.
    Exr,
}

impl PictureFormat {
    /// What the name's ending asks for; upper case counts.
    ///
    /// # Errors
    /// Any other ending than `.png` and `.exr`.
    pub fn from_path(path: &Path) -> Result<Self, PictureError> {
        let extension = path.extension().unwrap_or_default();
        if extension.eq_ignore_ascii_case("png") {
            Ok(Self::Png)
        } else if extension.eq_ignore_ascii_case("exr") {
            Ok(Self::Exr)
        } else {
            Err(PictureError::Format {
                path: path.to_owned(),
            })
        }
    }
}

/// Finds out whether a file can be written there, and leaves nothing behind: better before an
/// hour's rendering than after.
///
/// # Errors
/// Where `path` is a folder, or its folder is missing or does not let files be made.
pub fn check_writable(path: &Path) -> Result<(), PictureError> {
    if path.is_dir() {
        return Err(PictureError::Folder {
            path: path.to_owned(),
        });
    }
    beside(path).map(drop).map_err(|source| PictureError::Io {
        path: path.to_owned(),
        source,
    })
}

/// Writes linear radiance as a PNG: exposed, tone mapped and encoded as [`srgb8`] does.
///
/// The file appears whole or not at all; one that was there before stays until then.
///
/// # Errors
/// Where a pixel is not finite, the size does not fit, or the system does not write.
pub fn write_png(
    path: &Path,
    width: u32,
    height: u32,
    radiance: &[[f32; 3]],
    exposure_ev: f32,
    tone_map: ToneMap,
) -> Result<(), PictureError> {
    check_pixels(path, width, height, radiance)?;
    let bytes = srgb8(radiance, exposure_ev, tone_map);
    write_whole(path, |file| {
        let mut encoder = png::Encoder::new(file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(())
    })
}

/// Writes linear radiance as an EXR with float channels R, G and B, compressed without loss.
///
/// The file appears whole or not at all; one that was there before stays until then.
///
/// # Errors
/// As [`write_png`].
pub fn write_exr(
    path: &Path,
    width: u32,
    height: u32,
    radiance: &[[f32; 3]],
) -> Result<(), PictureError> {
    check_pixels(path, width, height, radiance)?;
    let size = (width as usize, height as usize);
    let channels = SpecificChannels::rgb(|Vec2(x, y)| {
        let [r, g, b] = radiance[y * size.0 + x];
        (r, g, b)
    });
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        channels,
    );
    let image = Image::from_layer(layer);
    write_whole(path, |file| {
        image
            .write()
            .to_buffered(file)
            .map_err(|error| match error {
                exr::error::Error::Io(error) => error,
                other => io::Error::other(other.to_string()),
            })
    })
}

fn check_pixels(
    path: &Path,
    width: u32,
    height: u32,
    radiance: &[[f32; 3]],
) -> Result<(), PictureError> {
    let count = radiance.len();
    if count == 0 || count as u64 != u64::from(width) * u64::from(height) {
        return Err(PictureError::Size {
            path: path.to_owned(),
            width,
            height,
            count,
        });
    }
    let is_bad = |pixel: &[f32; 3]| !pixel.iter().all(|x| x.is_finite());
    match radiance.iter().position(is_bad) {
        None => Ok(()),
        Some(first) => Err(PictureError::NotFinite {
            path: path.to_owned(),
            count: radiance.iter().filter(|pixel| is_bad(pixel)).count(),
            column: first % width as usize,
            row: first / width as usize,
        }),
    }
}

/// As [`whole_file::write_whole`].
fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), PictureError> {
    whole_file::write_whole(path, write).map_err(|source| PictureError::Io {
        path: PathBuf::from(path),
        source,
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn pixels() -> Vec<[f32; 3]> {
        (0..35).map(|i| [i as f32, 0.5, 1e-30 * i as f32]).collect()
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn exr_gives_every_number_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, 7, 5, &pixels()).unwrap();
        let image = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        let layer = &image.layer_data;
        assert_eq!(layer.size, Vec2(7, 5));
        let channels = &layer.channel_data.list;
        let names: Vec<_> = channels.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R"]);
        for (channel, component) in channels.iter().zip([2, 1, 0]) {
            let exr::prelude::FlatSamples::F32(samples) = &channel.sample_data else {
                panic!("{} is not float", channel.name)
            };
            let expected: Vec<_> = pixels().iter().map(|p| p[component]).collect();
            assert_eq!(*samples, expected);
        }
    }

    #[test]
    fn png_holds_the_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_png(&path, 5, 7, &pixels(), -3.0, ToneMap::Aces).unwrap();
        let image = image::open(&path).unwrap().into_rgb8();
        assert_eq!(image.dimensions(), (5, 7));
        assert_eq!(image.into_raw(), srgb8(&pixels(), -3.0, ToneMap::Aces));
        assert_eq!(names(folder.path()), ["a.png"]);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let made = File::create(folder.path().join("plain")).unwrap();
            let mode = |metadata: std::fs::Metadata| metadata.permissions().mode();
            let plain = mode(made.metadata().unwrap());
            assert_eq!(mode(path.metadata().unwrap()), plain);
        }
    }

    /// A disk that fills up halfway: the write fails after some bytes went to the file.
    #[test]
    fn full_disk_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, "old").unwrap();
        let error = write_whole(&path, |file| {
            file.write_all(&[1; 100_000])?;
            Err(io::ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert!(error.to_string().contains("a.png"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn pixels_that_are_not_finite_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut radiance = pixels();
        radiance[16][1] = f32::NAN;
        radiance[20][2] = f32::INFINITY;
        for result in [
            write_exr(&folder.path().join("a.exr"), 7, 5, &radiance),
            write_png(
                &folder.path().join("a.png"),
                7,
                5,
                &radiance,
                0.0,
                ToneMap::None,
            ),
        ] {
            let message = result.unwrap_err().to_string();
            assert!(
                message.contains("2 pixels are not finite, the first at column 2, row 2"),
                "{message}"
            );
        }
        assert!(names(folder.path()).is_empty());
        let result = write_exr(&folder.path().join("a.exr"), 7, 6, &pixels());
        assert!(matches!(result, Err(PictureError::Size { count: 35, .. })));
        let result = write_exr(&folder.path().join("a.exr"), 0, 0, &[]);
        assert!(matches!(result, Err(PictureError::Size { count: 0, .. })));
    }

    #[test]
    fn paths_are_checked_before_work_begins() {
        let folder = tempfile::tempdir().unwrap();
        for (name, format) in [
            ("a.png", Some(PictureFormat::Png)),
            ("a.EXR", Some(PictureFormat::Exr)),
            ("a.jpg", None),
            ("png", None),
            ("", None),
        ] {
            assert_eq!(PictureFormat::from_path(Path::new(name)).ok(), format);
        }
        check_writable(&folder.path().join("a.png")).unwrap();
        assert!(names(folder.path()).is_empty());
        let missing = folder.path().join("no/a.png");
        let message = check_writable(&missing).unwrap_err().to_string();
        assert!(message.contains("no/a.png"), "{message}");
        let message = check_writable(folder.path()).unwrap_err().to_string();
        assert!(message.contains("folder"), "{message}");
    }
}
