//! All images in one buffer.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::Vec4;

use super::device::Gpu;
use super::error::GpuError;
use super::pool::Pool;
use super::record::TextureRecord;
use super::storage::{Records, StagedRecords};
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

/// Whether textures show the very same texels in the same way.
pub(super) fn is_same_texture(a: &Texture, b: &Texture) -> bool {
    Arc::ptr_eq(a.texels(), b.texels())
        && (a.width, a.height) == (b.width, b.height)
        && (a.sampler, a.is_srgb()) == (b.sampler, b.is_srgb())
}

/// What a texture's texels are called by: textures of one key share them. Of use as long as one of them is
/// kept.
type Key = (usize, bool);

fn key(texture: &Texture) -> Key {
    let is_floats = format(texture).0 == FLOATS;
    (Arc::as_ptr(texture.texels()).addr(), is_floats)
}

/// A scene's textures on the device. Texels that several show are there once.
pub(super) struct TextureStore {
    texels: Pool<u32>,
    places: HashMap<Key, Range<u32>>,
    records: Records<TextureRecord>,
    textures: Vec<Texture>,
}

/// Textures that are to replace those of a store; their texels are on the device already.
pub(super) struct StagedTextures {
    textures: Vec<Texture>,
    places: HashMap<Key, Range<u32>>,
    new: Vec<Range<u32>>,
    grown: Option<wgpu::Buffer>,
    records: StagedRecords<TextureRecord>,
}

impl TextureStore {
    /// Lists have at most `limit` bytes.
    pub(super) fn new(gpu: &Gpu, textures: &[Texture], limit: u64) -> Result<Self, GpuError> {
        let (places, total) = places(textures);
        // Words are counted in 32 bits.
        let mut texels = Pool::new(gpu, "texels", total, limit)?;
        let mut all: Vec<u32> = Vec::with_capacity(total as usize);
        all.extend(SRGB_TO_LINEAR.iter().map(|x| x.to_bits()));
        for texture in textures {
            if places[&key(texture)].start as usize == all.len() {
                append(&mut all, texture);
            }
        }
        _ = texels.place(all.len());
        Pool::write(gpu, texels.buffer(), &(0..0), &all);
        let records = textures.iter().map(|t| record(t, &places)).collect();
        Ok(Self {
            texels,
            places,
            records: Records::new(gpu, "textures", records)?,
            textures: textures.to_vec(),
        })
    }

    /// The buffers of the shaders' `textures` and `texels`.
    pub(super) fn buffers(&self) -> [&wgpu::Buffer; 2] {
        [self.records.buffer(), self.texels.buffer()]
    }

    /// Brings what is new in other textures to the device; `Some(None)` where all are the same, `None`
    /// where there is no room for both.
    #[expect(clippy::option_option, reason = "no room, no change, or a change")]
    pub(super) fn stage(
        &mut self,
        gpu: &Gpu,
        textures: &[Texture],
    ) -> Result<Option<Option<StagedTextures>>, GpuError> {
        let same = self.textures.iter().zip(textures);
        if self.textures.len() == textures.len()
            && same.into_iter().all(|(a, b)| is_same_texture(a, b))
        {
            return Ok(Some(None));
        }
        let mut places = HashMap::new();
        let (mut new, mut written) = (Vec::new(), Vec::new());
        for texture in textures {
            let key = key(texture);
            if places.contains_key(&key) {
                continue;
            }
            if let Some(place) = self.places.get(&key) {
                places.insert(key, place.clone());
                continue;
            }
            let Some(place) = self.texels.place(words(texture) as usize) else {
                self.free(new);
                return Ok(None);
            };
            places.insert(key, place.clone());
            new.push(place);
            written.push(texture);
        }
        let records = textures.iter().map(|t| record(t, &places)).collect();
        let records = match self.records.stage(gpu, records) {
            Ok(records) => records,
            Err(fault) => {
                self.free(new);
                return Err(fault);
            }
        };
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let grown = self.texels.grown(gpu, &mut encoder);
        if grown.is_some() {
            // What is written from now on comes after the copy.
            gpu.queue().submit([encoder.finish()]);
        }
        let buffer = grown.as_ref().unwrap_or(self.texels.buffer());
        for (texture, place) in written.into_iter().zip(&new) {
            let mut list = Vec::new();
            append(&mut list, texture);
            Pool::write(gpu, buffer, place, &list);
        }
        Ok(Some(Some(StagedTextures {
            textures: textures.to_vec(),
            places,
            new,
            grown,
            records,
        })))
    }

    fn free(&mut self, places: Vec<Range<u32>>) {
        for place in places {
            self.texels.free(place);
        }
    }

    /// Forgets what was staged.
    pub(super) fn withdraw(&mut self, staged: &StagedTextures) {
        self.free(staged.new.clone());
    }

    /// Takes what was staged.
    pub(super) fn commit(&mut self, gpu: &Gpu, staged: StagedTextures) {
        let old = std::mem::replace(&mut self.places, staged.places);
        let gone = old
            .into_iter()
            .filter(|(key, _)| !self.places.contains_key(key));
        let gone = gone.map(|(_, place)| place).collect();
        self.free(gone);
        self.texels.take(staged.grown);
        self.records.commit(gpu, staged.records);
        self.textures = staged.textures;
    }
}

/// Where the texels of textures go, one after the other after the sRGB transfer function, and how many
/// words they are. Places beyond 32 bits are none.
fn places(textures: &[Texture]) -> (HashMap<Key, Range<u32>>, u64) {
    let mut places = HashMap::new();
    let mut total = SRGB_TO_LINEAR.len() as u64;
    for texture in textures {
        places.entry(key(texture)).or_insert_with(|| {
            let first = total;
            total += words(texture);
            first as u32..total as u32
        });
    }
    (places, total)
}

fn record(texture: &Texture, places: &HashMap<Key, Range<u32>>) -> TextureRecord {
    TextureRecord {
        first_word: places[&key(texture)].start,
        width: texture.width,
        height: texture.height,
        format: format(texture).0,
        wrap: [texture.sampler.wrap_s, texture.sampler.wrap_t].map(wrap),
        is_linear: u32::from(texture.sampler.filter == Filter::Linear),
        padding: 0,
    }
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
#[expect(
    clippy::single_range_in_vec_init,
    reason = "lists of ranges, some of one"
)]
mod tests {
    use super::*;
    use crate::gpu::GpuPreference;
    use crate::scene::Sampler;

    #[test]
    fn images_are_stored_once() {
        let image = |color: u8| {
            let texels = vec![[color, 2, 3, 4]; 6];
            Texture::from_rgba8("", [3, 2], texels, true, Sampler::default()).unwrap()
        };
        let texture = image(1);
        let (shared, total) = places(&[texture.clone(), texture.clone()]);
        assert_eq!((shared.len(), total), (1, 256 + 6));
        assert_eq!(places(&[]).1, 256);

        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let limit = (256 + 5) * 4;
        let fault = TextureStore::new(&gpu, std::slice::from_ref(&texture), limit).err();
        assert!(matches!(fault, Some(GpuError::TooMuch { .. })), "{fault:?}");

        let mut store = TextureStore::new(&gpu, &[texture.clone(), image(2)], u64::MAX).unwrap();
        let same = [texture.clone(), store.textures[1].clone()];
        assert!(matches!(store.stage(&gpu, &same), Ok(Some(None))));
        // One goes, one comes: its place is that of the first that is free.
        let other = [image(3), texture.clone(), texture.clone()];
        for _ in 0..2 {
            let staged = store.stage(&gpu, &other).unwrap().unwrap().unwrap();
            assert_eq!(staged.new, [268..274]);
            store.withdraw(&staged);
        }
        let staged = store.stage(&gpu, &other).unwrap().unwrap().unwrap();
        store.commit(&gpu, staged);
        assert_eq!(store.places[&key(&texture)], 256..262);
        let staged = store.stage(&gpu, &[image(4)]).unwrap().unwrap().unwrap();
        assert_eq!(staged.new, [262..268]);
        store.commit(&gpu, staged);
        assert_eq!(store.places.len(), 1);
    }
}
