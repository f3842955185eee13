//! Radiance HDR: three mantissas that share an exponent (Ward 1991, "Real Pixels", Graphics Gems II).

use std::io::Cursor;

use image::{ImageDecoder, codecs::hdr::HdrDecoder};

use super::{Budget, Decoded};
use crate::scene::error::Fault;

/// Whether these bytes start as the format does.
pub(super) fn is(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?RADIANCE") || bytes.starts_with(b"#?RGBE")
}

/// The texels as they are stored: exposure and colour correction in the header, which record what
/// was done to the picture, are left as they are, as other readers do.
pub(super) fn decode(bytes: &[u8], place: &str, budget: &mut Budget) -> Result<Decoded, Fault> {
    let broken = |error: image::ImageError| {
        Fault::new(
            place,
            error.to_string(),
            "store it as a valid Radiance HDR image",
        )
    };
    // Not strict: that wants one of the two signatures, and headers vary.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let size = budget.take(place, width.into(), height.into(), 16)?;
    // Zeroed pages cost nothing until a scanline fills them.
    let mut buffer = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut buffer).map_err(broken)?;
    let channel = |bytes: &[u8]| f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let texels = buffer
        .as_chunks::<12>()
        .0
        .iter()
        .map(|t| [channel(&t[..4]), channel(&t[4..8]), channel(&t[8..]), 1.0]);
    Decoded::floats(size, texels.collect(), place)
}
