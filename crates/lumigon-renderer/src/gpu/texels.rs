//! All images in one buffer.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec4;

use super::record::TextureRecord;
use crate::scene::{Filter, SRGB_TO_LINEAR, Texels, Texture, Wrap};

// The shader's TEXELS constants.
const BYTES: u32 = 0;
const SRGB: u32 = 1;
const SHORTS: u32 = 2;
const FLOATS: u32 = 3;

/// The words that a texture takes.
fn words(texture: &Texture) -> u64 {
    let (_, words) = format(texture);
    u64::from(texture.width) * u64::from(texture.height) * words
}

/// The shader's format of a texture's texels, and the words of one.
fn format(texture: &Texture) -> (u32, u64) {
    match (&**texture.texels(), texture.is_srgb()) {
        (Texels::U8(_), false) => (BYTES, 1),
        (Texels::U8(_), true) => (SRGB, 1),
        (Texels::U16(_), false) => (SHORTS, 2),
        // Decoded here: shaders raise to powers with errors of their own.
        (Texels::U16(_), true) => (FLOATS, 4),
        (Texels::F32(_), _) => (FLOATS, 4),
    }
}

/// The records of all textures and the words of their texels; images that several show are there
/// once. `Err` is the number of words where they are more than `limit`.
pub(super) fn packed(
    textures: &[Texture],
    limit: u64,
) -> Result<(Vec<TextureRecord>, Vec<u32>), u64> {
    let key = |texture: &Texture| (Arc::as_ptr(texture.texels()), format(texture).0 == FLOATS);
    let mut places = HashMap::new();
    let mut total = SRGB_TO_LINEAR.len() as u64;
    for texture in textures {
        places.entry(key(texture)).or_insert_with(|| {
            let first = total;
            total += words(texture);
            first
        });
    }
    if total > limit {
        return Err(total);
    }
    let mut all: Vec<u32> = Vec::with_capacity(total as usize);
    all.extend(SRGB_TO_LINEAR.iter().map(|x| x.to_bits()));
    let mut records = Vec::with_capacity(textures.len());
    for texture in textures {
        let first_word = places[&key(texture)];
        if first_word == all.len() as u64 {
            append(&mut all, texture);
        }
        records.push(TextureRecord {
            first_word: first_word as u32,
            width: texture.width,
            height: texture.height,
            format: format(texture).0,
            wrap: [texture.sampler.wrap_s, texture.sampler.wrap_t].map(wrap),
            is_linear: u32::from(texture.sampler.filter == Filter::Linear),
            padding: 0,
        });
    }
    Ok((records, all))
}

fn append(all: &mut Vec<u32>, texture: &Texture) {
    match &**texture.texels() {
        Texels::U8(texels) => all.extend(texels.iter().map(|t| u32::from_le_bytes(*t))),
        Texels::U16(texels) if !texture.is_srgb() => {
            let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
            all.extend(
                texels
                    .iter()
                    .flat_map(|&[r, g, b, a]| [pair(r, g), pair(b, a)]),
            );
        }
        Texels::U16(_) | Texels::F32(_) => {
            for y in 0..texture.height {
                let row = (0..texture.width).map(|x| texture.texel(x, y));
                all.extend(row.flat_map(|texel: Vec4| texel.to_array().map(f32::to_bits)));
            }
        }
    }
}

/// The shader's WRAP constants.
fn wrap(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 0,
        Wrap::MirroredRepeat => 1,
        Wrap::ClampToEdge => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sampler;

    #[test]
    fn images_are_stored_once() {
        let texels = vec![[1, 2, 3, 4]; 6];
        let texture = Texture::from_rgba8("", [3, 2], texels, true, Sampler::default()).unwrap();
        let other = texture.clone();
        let (records, words) = packed(&[texture.clone(), other], u64::MAX).unwrap();
        assert_eq!(records[0], records[1]);
        assert_eq!(words.len(), 256 + 6);
        assert_eq!(words[256], 0x0403_0201);
        assert_eq!(packed(&[texture], 261), Err(262));
        assert_eq!(packed(&[], u64::MAX).unwrap().1.len(), 256);
    }
}
