//! EXR: the display window of the first layer with red, green and blue.

use std::io::Cursor;

use exr::{
    meta::header::Header,
    prelude::{ReadChannels, ReadLayers, Vec2, read},
};

use super::{Budget, Decoded};
use crate::scene::error::Fault;

/// Whether these bytes start as the format does.
pub(super) fn is(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// Texels outside the data window are black and transparent, as the format has it. Files without
/// alpha are opaque.
pub(super) fn decode(bytes: &[u8], place: &str, budget: &mut Budget) -> Result<Decoded, Fault> {
    let refuse = |what: String| {
        Fault::new(
            place,
            what,
            "write it again, flat, with channels R, G and B, compressed without loss",
        )
    };
    let broken =
        |error: exr::error::Error| refuse(format!("this is no sound OpenEXR image: {error}"));
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(broken)?;
    if reader.headers().iter().any(|header| header.deep) {
        return Err(refuse("deep OpenEXR images are not read".to_owned()));
    }
    let header = reader.headers().iter().find(|header| has_colors(header));
    let header = header.ok_or_else(|| refuse("no layer has R, G and B channels".to_owned()))?;
    let (window, data) = (
        header.shared_attributes.display_window,
        header.data_window(),
    );
    let size = budget.take(
        place,
        window.size.width() as u64,
        window.size.height() as u64,
        16,
    )?;
    // What lies outside the display window is decoded too, in rows or tiles of all channels.
    let side = budget.side as usize;
    if data.size.width() > side || data.size.height() > side {
        return Err(Fault::new(
            place,
            format!(
                "its data window has {} × {} texels, more than {side} a side",
                data.size.width(),
                data.size.height()
            ),
            "crop it to its display window or raise the limit",
        ));
    }
    let count = header.channels.list.len();
    if count > MOST_CHANNELS {
        return Err(Fault::new(
            place,
            format!("its layer has {count} channels, more than {MOST_CHANNELS}"),
            "store the colours alone",
        ));
    }

    let at = |position: Vec2<i32>| [i64::from(position.x()), i64::from(position.y())];
    let ([x0, y0], [wx, wy]) = (at(data.position), at(window.position));
    let (shift, [width, height]) = ([x0 - wx, y0 - wy], size);
    let area = width as usize * height as usize;
    let set = move |texels: &mut Vec<[f32; 4]>, p: Vec2<usize>, (r, g, b, a): Rgba| {
        let (x, y) = (p.x() as i64 + shift[0], p.y() as i64 + shift[1]);
        if (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y) {
            texels[(y * i64::from(width) + x) as usize] = [r, g, b, a];
        }
    };
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(move |_, _| vec![[0.0; 4]; area], set)
        .first_valid_layer()
        .all_attributes()
        .from_chunks(reader)
        .map_err(broken)?;
    Decoded::floats(size, image.layer_data.channel_data.pixels, place)
}

type Rgba = (f32, f32, f32, f32);

/// Whole rows of all channels are unpacked at a time.
const MOST_CHANNELS: usize = 256;

fn has_colors(header: &Header) -> bool {
    let has = |name: &str| header.channels.list.iter().any(|c| c.name.eq(name));
    ["R", "G", "B"].into_iter().all(has)
}
