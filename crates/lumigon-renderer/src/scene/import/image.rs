//! PNG and JPEG to texels, bounded before they are decoded.

use std::{collections::HashMap, io::Cursor, sync::Arc};

use gltf::json;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::source::Source;
use crate::scene::{Limits, error::Fault, texture::Texels};

/// An image's size and texels, shared by the textures that show it.
#[derive(Clone)]
pub(super) struct Image {
    pub(super) size: [u32; 2],
    pub(super) texels: Arc<Texels>,
}

/// The images decoded so far.
pub(super) struct Images {
    done: HashMap<usize, Image>,
    side: u32,
    bytes_left: u64,
}

impl Images {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            done: HashMap::new(),
            side: limits.image_side,
            bytes_left: limits.image_bytes,
        }
    }

    /// `images[index]`, decoded at most once. `user` is the place that asks.
    pub(super) fn get(
        &mut self,
        root: &json::Root,
        source: &mut Source<'_>,
        index: usize,
        user: &str,
    ) -> Result<Image, Fault> {
        if let Some(image) = self.done.get(&index) {
            return Ok(image.clone());
        }
        let image = root.images.get(index).ok_or_else(|| {
            let what = format!("there is no images[{index}]");
            Fault::new(user, what, "use an index that exists")
        })?;
        let place = format!("images[{index}]");
        let image = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                let bytes = source.uri(uri, &format!("{place}.uri"))?;
                self.decode(&bytes, &place)?
            }
            (None, Some(view)) => {
                let view = source.view(view.value(), &place)?;
                self.decode(view.bytes(), &place)?
            }
            (None, None) => {
                return Err(Fault::new(
                    place,
                    "it has neither a uri nor a bufferView",
                    "give it one of them",
                ));
            }
        };
        self.done.insert(index, image.clone());
        Ok(image)
    }

    fn decode(&mut self, bytes: &[u8], place: &str) -> Result<Image, Fault> {
        let broken = |error: image::ImageError| {
            Fault::new(place, error.to_string(), "store it as a valid PNG or JPEG")
        };
        // What the bytes say counts: mimeType and file endings are often wrong.
        let format = image::guess_format(bytes)
            .ok()
            .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg))
            .ok_or_else(|| {
                Fault::new(
                    place,
                    "this is neither PNG nor JPEG",
                    "convert it to one of them",
                )
            })?;
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = image::Limits::no_limits();
        limits.max_image_width = Some(self.side);
        limits.max_image_height = Some(self.side);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(broken)?;
        let (width, height) = decoder.dimensions();
        let wide =
            decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count() > 1;
        if width == 0 || height == 0 || width > self.side || height > self.side {
            return Err(Fault::new(
                place,
                format!(
                    "{width} × {height} texels, outside 1 to {} a side",
                    self.side
                ),
                "resize it or raise the limit",
            ));
        }
        let texel_bytes = if wide { 8 } else { 4 };
        let needed = u64::from(width) * u64::from(height) * texel_bytes;
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
        let decoded = DynamicImage::from_decoder(decoder).map_err(broken)?;
        let texels = if wide {
            Texels::U16(decoded.into_rgba16().pixels().map(|p| p.0).collect())
        } else {
            Texels::U8(decoded.into_rgba8().pixels().map(|p| p.0).collect())
        };
        Ok(Image {
            size: [width, height],
            texels: Arc::new(texels),
        })
    }
}
