//! Images on surfaces.

use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec4};

/// What a texture shows beyond [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored at each border.
    MirroredRepeat,
    /// Its border texels.
    ClampToEdge,
}

/// How a texture is read between texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Bilinear.
    #[default]
    Linear,
}

/// How a texture is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Across the width.
    pub wrap_s: Wrap,
    /// Down the height.
    pub wrap_t: Wrap,
    /// Between texel centres.
    pub filter: Filter,
}

/// Decoded texels, shared by the textures that show them. Row by row from the upper left.
#[derive(Debug, PartialEq)]
pub(crate) enum Texels {
    /// 8 bits a channel.
    U8(Vec<[u8; 4]>),
    /// 16 bits a channel.
    U16(Vec<[u16; 4]>),
    /// Linear, in single precision: finite and not negative, alpha at most 1.
    F32(Vec<[f32; 4]>),
}

/// An image with a sampler, read in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The name of the texture or its image, where the file has one.
    pub name: String,
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// How it is read.
    pub sampler: Sampler,
    /// Red, green and blue are stored with the sRGB transfer function; never in floating point.
    srgb: bool,
    texels: Arc<Texels>,
    /// Index among the file's textures of the one it was read from.
    source: Option<usize>,
    /// The PNG or JPEG file that the texels were decoded from, where it was kept.
    encoded: Option<Arc<[u8]>>,
}

impl Texture {
    pub(crate) fn new(
        name: String,
        [width, height]: [u32; 2],
        texels: Arc<Texels>,
        srgb: bool,
        sampler: Sampler,
    ) -> Self {
        let srgb = srgb && !matches!(*texels, Texels::F32(_));
        Self {
            name,
            width,
            height,
            sampler,
            srgb,
            texels,
            source: None,
            encoded: None,
        }
    }

    /// Says which of the file's textures it was read from.
    pub(crate) fn with_source(self, source: usize) -> Self {
        Self {
            source: Some(source),
            ..self
        }
    }

    /// Keeps the PNG or JPEG file that the texels were decoded from.
    pub(crate) fn with_encoded(self, encoded: Option<Arc<[u8]>>) -> Self {
        Self { encoded, ..self }
    }

    /// Index among the file's textures of the one it was read from.
    pub(crate) fn source(&self) -> Option<usize> {
        self.source
    }

    /// The PNG or JPEG file that the texels were decoded from, where it was kept.
    pub(crate) fn encoded(&self) -> Option<&Arc<[u8]>> {
        self.encoded.as_ref()
    }

    /// A texture of 8 bits a channel, row by row from the upper left. `srgb`: red, green and blue
    /// are stored with the sRGB transfer function (base colour and emission), else they are data.
    ///
    /// `None` unless there are `width * height` texels, at least one.
    #[must_use]
    pub fn from_rgba8(
        name: &str,
        [width, height]: [u32; 2],
        texels: Vec<[u8; 4]>,
        srgb: bool,
        sampler: Sampler,
    ) -> Option<Self> {
        let count = u64::from(width) * u64::from(height);
        (count > 0 && texels.len() as u64 == count).then(|| {
            let texels = Arc::new(Texels::U8(texels));
            Self::new(name.to_owned(), [width, height], texels, srgb, sampler)
        })
    }

    /// The texels as they are stored.
    pub(crate) fn texels(&self) -> &Arc<Texels> {
        &self.texels
    }

    /// Whether red, green and blue are stored with the sRGB transfer function.
    pub(crate) fn is_srgb(&self) -> bool {
        self.srgb
    }

    /// Whether both read the very same texels in the same way.
    pub(crate) fn is_same_as(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.texels, &other.texels)
            && [self.width, self.height] == [other.width, other.height]
            && (self.sampler, self.srgb) == (other.sampler, other.srgb)
    }

    /// One texel in linear light; `x < width`, `y < height`.
    ///
    /// # Panics
    /// May panic beyond the image.
    #[must_use]
    pub fn texel(&self, x: u32, y: u32) -> Vec4 {
        let i = y as usize * self.width as usize + x as usize;
        match (&*self.texels, self.srgb) {
            (Texels::U8(t), false) => Vec4::from(t[i].map(f32::from)) / 255.0,
            (Texels::U8(t), true) => {
                let [r, g, b, a] = t[i];
                let decode = |c: u8| SRGB_TO_LINEAR[usize::from(c)];
                Vec4::new(decode(r), decode(g), decode(b), f32::from(a) / 255.0)
            }
            (Texels::U16(t), false) => Vec4::from(t[i].map(f32::from)) / 65535.0,
            (Texels::U16(t), true) => {
                let [r, g, b, a] = t[i].map(|c| f32::from(c) / 65535.0);
                Vec4::new(srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), a)
            }
            (Texels::F32(t), _) => Vec4::from(t[i]),
        }
    }

    /// One texel in linear light, wrapped from any pair of integers.
    #[must_use]
    pub fn wrapped_texel(&self, x: i64, y: i64) -> Vec4 {
        self.texel(
            wrap_index(x, self.width, self.sampler.wrap_s),
            wrap_index(y, self.height, self.sampler.wrap_t),
        )
    }

    /// Linear light at `uv`, where (0, 0) is the image's upper left corner and (1, 1) its lower
    /// right one: bilinear between texel centres, or the nearest texel, as the sampler says.
    /// Coordinates that are not finite read as 0.
    #[must_use]
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        let x = wrap_coordinate(uv.x, self.sampler.wrap_s) * self.width as f32;
        let y = wrap_coordinate(uv.y, self.sampler.wrap_t) * self.height as f32;
        match self.sampler.filter {
            Filter::Nearest => self.wrapped_texel(x.floor() as i64, y.floor() as i64),
            Filter::Linear => {
                let (x, y) = (x - 0.5, y - 0.5);
                let (x0, y0) = (x.floor(), y.floor());
                let (fx, fy) = (x - x0, y - y0);
                let (x0, y0) = (x0 as i64, y0 as i64);
                let upper = self
                    .wrapped_texel(x0, y0)
                    .lerp(self.wrapped_texel(x0 + 1, y0), fx);
                let lower = self
                    .wrapped_texel(x0, y0 + 1)
                    .lerp(self.wrapped_texel(x0 + 1, y0 + 1), fx);
                upper.lerp(lower, fy)
            }
        }
    }
}

/// Brings a coordinate near the image, keeping the precision of its fraction: repeats fold into
/// [0, 1] or, mirrored, [0, 2]; clamped ones end one image beyond the border.
fn wrap_coordinate(u: f32, wrap: Wrap) -> f32 {
    if !u.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::MirroredRepeat => u - 2.0 * (u * 0.5).floor(),
        Wrap::ClampToEdge => u.clamp(-1.0, 2.0),
    }
}

pub(super) fn wrap_index(i: i64, size: u32, wrap: Wrap) -> u32 {
    let size = i64::from(size);
    let wrapped = match wrap {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::MirroredRepeat => {
            let i = i.rem_euclid(2 * size);
            i.min(2 * size - 1 - i)
        }
        Wrap::ClampToEdge => i.clamp(0, size - 1),
    };
    // In [0, size) and size came from a u32.
    wrapped as u32
}

/// The sRGB transfer function of IEC 61966-2-1, from [0, 1] to [0, 1].
fn srgb_to_linear(c: f32) -> f32 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

/// The inverse of [`srgb_to_linear`], from [0, 1] to [0, 1].
pub(super) fn linear_to_srgb(c: f32) -> f32 {
    if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    }
}

/// The sRGB transfer function of all bytes.
pub(crate) static SRGB_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|c| srgb_to_linear(c as f32 / 255.0)));

#[cfg(test)]
mod tests {
    use super::*;

    fn two_by_one(sampler: Sampler) -> Texture {
        let texels = vec![[0, 0, 0, 255], [255, 0, 255, 255]];
        Texture::from_rgba8("", [2, 1], texels, false, sampler).unwrap()
    }

    #[test]
    fn bilinear_meets_the_texels_at_their_centres() {
        let texture = two_by_one(Sampler::default());
        assert_eq!(texture.sample(Vec2::new(0.25, 0.5)).x, 0.0);
        assert_eq!(texture.sample(Vec2::new(0.75, 0.5)).x, 1.0);
        assert_eq!(texture.sample(Vec2::new(0.5, 0.3)).x, 0.5);
        assert_eq!(texture.sample(Vec2::new(0.0, 0.3)).x, 0.5); // wraps onto the last texel
    }

    #[test]
    fn wrap_modes_differ_beyond_the_border() {
        let at = |wrap_s, u| {
            let sampler = Sampler {
                wrap_s,
                filter: Filter::Nearest,
                ..Sampler::default()
            };
            two_by_one(sampler).sample(Vec2::new(u, 0.0)).x
        };
        for (u, expected) in [
            (1.1, [0.0, 1.0, 1.0]),
            (1.9, [1.0, 0.0, 1.0]),
            (-0.1, [1.0, 0.0, 0.0]),
        ] {
            let modes = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
            assert_eq!(modes.map(|wrap| at(wrap, u)), expected, "u = {u}");
        }
    }

    #[test]
    fn hostile_coordinates_stay_inside() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for filter in [Filter::Nearest, Filter::Linear] {
                let texture = two_by_one(Sampler {
                    wrap_s: wrap,
                    wrap_t: wrap,
                    filter,
                });
                for u in [
                    f32::NAN,
                    f32::INFINITY,
                    -f32::MAX,
                    f32::MAX,
                    -0.0,
                    -1e-30,
                    1.0,
                    1e9,
                ] {
                    let value = texture.sample(Vec2::splat(u));
                    assert!(
                        value.is_finite() && value.max_element() <= 1.0,
                        "{wrap:?} {u}"
                    );
                }
            }
        }
    }

    #[test]
    fn srgb_is_decoded_but_alpha_is_not() {
        let texels = vec![[188, 0, 255, 128]];
        let texture = Texture::from_rgba8("", [1, 1], texels, true, Sampler::default()).unwrap();
        let texel = texture.texel(0, 0);
        assert!((texel.x - 0.5029).abs() < 1e-4 && texel.y == 0.0 && texel.z == 1.0);
        assert!((texel.w - 128.0 / 255.0).abs() < 1e-7);
    }
}
