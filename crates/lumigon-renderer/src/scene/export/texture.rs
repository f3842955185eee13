//! Textures that the file does not have, and the images they show.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use image::{DynamicImage, ImageBuffer, ImageFormat};
use rayon::prelude::*;
use serde_json::json;

use super::{SaveError, document::Document};
use crate::scene::{Filter, Sampler, Scene, Texels, Texture, Wrap, texture::linear_to_srgb};

/// The textures of an edited scene, as far as they are in the document.
pub(super) struct Textures<'a> {
    original: &'a Scene,
    edited: &'a Scene,
    /// By index and whether it may be scaled: the document's texture, and what to multiply it by.
    done: HashMap<(usize, bool), (usize, f32)>,
    /// The document's images, by the texels' address, whether they are sRGB, and scaled.
    images: HashMap<(*const Texels, bool, bool), (usize, f32)>,
    samplers: HashMap<[u32; 3], usize>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(original: &'a Scene, edited: &'a Scene) -> Self {
        Self {
            original,
            edited,
            done: HashMap::new(),
            images: HashMap::new(),
            samplers: HashMap::new(),
        }
    }

    /// The file's own texture that this one still is.
    fn kept(&self, texture: &Texture) -> Option<usize> {
        let source = texture.source()?;
        let same = |old: &Texture| {
            old.source() == Some(source)
                && Arc::ptr_eq(old.texels(), texture.texels())
                && old.sampler == texture.sampler
                && old.is_srgb() == texture.is_srgb()
        };
        self.original.textures.iter().any(same).then_some(source)
    }

    /// Whether a texture is another than the file's of that index.
    pub(super) fn is_changed(&self, index: usize) -> bool {
        let kept = self.edited.textures.get(index).and_then(|t| self.kept(t));
        kept.is_none() || kept != self.original.textures.get(index).and_then(Texture::source)
    }

    /// The document's index of a texture, and what its colours are to be multiplied by: 1, unless it is
    /// in floating point and may be `scaled`.
    pub(super) fn index(
        &mut self,
        document: &mut Document<'_>,
        index: usize,
        scaled: bool,
        user: &str,
    ) -> Result<(usize, f32), SaveError> {
        if let Some(&done) = self.done.get(&(index, scaled)) {
            return Ok(done);
        }
        let texture = self.edited.textures.get(index);
        let texture = texture
            .ok_or_else(|| SaveError::scene(user, format!("the scene has no texture {index}")))?;
        let done = match self.kept(texture) {
            Some(source) => (source, 1.0),
            None => self.append(document, texture, scaled, user)?,
        };
        self.done.insert((index, scaled), done);
        Ok(done)
    }

    fn append(
        &mut self,
        document: &mut Document<'_>,
        texture: &Texture,
        scaled: bool,
        user: &str,
    ) -> Result<(usize, f32), SaveError> {
        let key = (Arc::as_ptr(texture.texels()), texture.is_srgb(), scaled);
        let (image, scale) = match self.images.get(&key) {
            Some(&done) => done,
            None => {
                let (bytes, scale) = encode(texture, scaled)
                    .map_err(|error| SaveError::scene(user, format!("its picture: {error}")))?;
                let done = (document.image(&texture.name, Cow::Owned(bytes))?, scale);
                self.images.insert(key, done);
                done
            }
        };
        let sampler = self.sampler(document, texture.sampler)?;
        let mut value = json!({"sampler": sampler, "source": image});
        if !texture.name.is_empty() {
            value["name"] = json!(texture.name);
        }
        Ok((document.push("textures", value)?, scale))
    }

    fn sampler(
        &mut self,
        document: &mut Document<'_>,
        sampler: Sampler,
    ) -> Result<usize, SaveError> {
        let wrap = |wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::MirroredRepeat => 33648,
            Wrap::ClampToEdge => 33071,
        };
        let filter = match sampler.filter {
            Filter::Nearest => 9728,
            Filter::Linear => 9729,
        };
        let numbers = [wrap(sampler.wrap_s), wrap(sampler.wrap_t), filter];
        if let Some(&done) = self.samplers.get(&numbers) {
            return Ok(done);
        }
        let [wrap_s, wrap_t, filter] = numbers;
        // Smaller than life, others should blend texels.
        let smaller = if filter == 9728 { 9728 } else { 9987 };
        let value = json!({
            "wrapS": wrap_s, "wrapT": wrap_t, "magFilter": filter, "minFilter": smaller,
        });
        let done = document.push("samplers", value)?;
        self.samplers.insert(numbers, done);
        Ok(done)
    }
}

/// The texture's image as PNG or JPEG, and what its colours are to be multiplied by.
fn encode(texture: &Texture, scaled: bool) -> Result<(Vec<u8>, f32), image::ImageError> {
    if let Some(encoded) = texture.encoded() {
        return Ok((encoded.to_vec(), 1.0));
    }
    let mut scale = 1.0;
    let image = match &**texture.texels() {
        Texels::U8(texels) => raster(texture, texels.as_flattened()).map(DynamicImage::ImageRgba8),
        Texels::U16(texels) => {
            raster(texture, texels.as_flattened()).map(DynamicImage::ImageRgba16)
        }
        Texels::F32(texels) => {
            let brightest = texels.iter().flat_map(|t| t[..3].iter().copied());
            let brightest = brightest.fold(0.0, f32::max);
            if scaled && brightest > 0.0 {
                scale = brightest;
            }
            let quantized = |c: f32| (c.clamp(0.0, 1.0) * 65535.0).round() as u16;
            let encode = |&[r, g, b, a]: &[f32; 4]| {
                let color = |c: f32| quantized(linear_to_srgb((c / scale).clamp(0.0, 1.0)));
                [color(r), color(g), color(b), quantized(a)]
            };
            let texels: Vec<[u16; 4]> = texels.par_iter().map(encode).collect();
            raster(texture, texels.as_flattened()).map(DynamicImage::ImageRgba16)
        }
    };
    let image = image.unwrap_or_default();
    // Alpha that says nothing is left out.
    let image = match image {
        DynamicImage::ImageRgba8(ref pixels) if pixels.pixels().all(|p| p[3] == u8::MAX) => {
            DynamicImage::ImageRgb8(image.to_rgb8())
        }
        DynamicImage::ImageRgba16(ref pixels) if pixels.pixels().all(|p| p[3] == u16::MAX) => {
            DynamicImage::ImageRgb16(image.to_rgb16())
        }
        other => other,
    };
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    Ok((bytes.into_inner(), scale))
}

fn raster<S: image::Primitive>(
    texture: &Texture,
    samples: &[S],
) -> Option<ImageBuffer<image::Rgba<S>, Vec<S>>>
where
    image::Rgba<S>: image::Pixel<Subpixel = S>,
{
    ImageBuffer::from_raw(texture.width, texture.height, samples.to_vec())
}
