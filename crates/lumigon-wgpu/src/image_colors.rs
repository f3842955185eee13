//! The colours that replace a light's image.

use std::sync::LazyLock;

use lumigon::LightImageError;

/// Colours for each texel of an image, row by row from its upper left.
#[derive(Clone, Copy, Debug)]
pub enum ImageColors<'a> {
    /// Red, green, blue and a fourth that does not count, encoded with the transfer function of IEC
    /// 61966-2-1, as video frames are.
    Srgb(&'a [[u8; 4]]),
    /// Linear red, green and blue, finite and at least 0.
    Linear(&'a [[f32; 3]]),
}

/// What a byte of sRGB stands for, in \[0, 1\].
pub(crate) static DECODED: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 {
            encoded / 12.92
        } else {
            ((encoded + 0.055) / 1.055).powf(2.4)
        };
        linear as f32
    })
});

impl ImageColors<'_> {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Srgb(colors) => colors.len(),
            Self::Linear(colors) => colors.len(),
        }
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The same as linear numbers.
    #[must_use]
    pub fn to_linear(&self) -> Vec<[f32; 3]> {
        match self {
            Self::Srgb(colors) => {
                let decoded = &*DECODED;
                let linear = |&[r, g, b, _]: &[u8; 4]| [r, g, b].map(|x| decoded[usize::from(x)]);
                colors.iter().map(linear).collect()
            }
            Self::Linear(colors) => colors.to_vec(),
        }
    }

    pub(crate) fn is_srgb(&self) -> bool {
        matches!(self, Self::Srgb(_))
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Srgb(colors) => bytemuck::cast_slice(colors),
            Self::Linear(colors) => bytemuck::cast_slice(colors),
        }
    }

    /// The greatest, channel by channel, where these are colours of an image of this size.
    pub(crate) fn greatest(&self, [width, height]: [u32; 2]) -> Result<[f32; 3], LightImageError> {
        let expected = width as usize * height as usize;
        if self.len() != expected {
            return Err(LightImageError::Count {
                count: self.len(),
                expected,
            });
        }
        match self {
            Self::Srgb(colors) => {
                let mut greatest = [0; 3];
                for color in *colors {
                    for (greatest, channel) in greatest.iter_mut().zip(color) {
                        *greatest = (*greatest).max(*channel);
                    }
                }
                Ok(greatest.map(|x| DECODED[usize::from(x)]))
            }
            Self::Linear(colors) => {
                // Finite sums of texels, as `lumigon::LightImage::replace` has it.
                let most = f32::MAX / 16.0 / expected as f32;
                let mut greatest = [0.0_f32; 3];
                for (i, color) in colors.iter().enumerate() {
                    for (greatest, &value) in greatest.iter_mut().zip(color) {
                        if !(0.0..=most).contains(&value) {
                            let (x, y) = (i % width as usize, i / width as usize);
                            return Err(LightImageError::Value { x, y, value });
                        }
                        *greatest = greatest.max(value);
                    }
                }
                Ok(greatest)
            }
        }
    }
}
