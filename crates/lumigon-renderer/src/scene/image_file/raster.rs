//! PNG and JPEG.

use std::{io::Cursor, sync::Arc};

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::{Budget, Decoded};
use crate::scene::{error::Fault, texture::Texels};

pub(super) fn decode(bytes: &[u8], place: &str, budget: &mut Budget) -> Result<Decoded, Fault> {
    let broken = |error: image::ImageError| {
        Fault::new(place, error.to_string(), "store it as a valid PNG or JPEG")
    };
    let format = image::guess_format(bytes)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg))
        .ok_or_else(|| {
            Fault::new(
                place,
                "this is neither PNG, JPEG, Radiance HDR nor OpenEXR",
                "convert it to one of them",
            )
        })?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = image::Limits::no_limits();
    limits.max_image_width = Some(budget.side);
    limits.max_image_height = Some(budget.side);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let wide = decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count() > 1;
    let texel_bytes = if wide { 8 } else { 4 };
    let size = budget.take(place, width.into(), height.into(), texel_bytes)?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let texels = if wide {
        Texels::U16(decoded.into_rgba16().pixels().map(|p| p.0).collect())
    } else {
        Texels::U8(decoded.into_rgba8().pixels().map(|p| p.0).collect())
    };
    Ok(Decoded {
        size,
        texels: Arc::new(texels),
    })
}
