//! Fitted lobes, looked up by roughness and view angle.

use alloc::vec::Vec;

use crate::ltc::Ltc;

/// Numbers a texel holds: the four of [`Ltc::shading_to_cosine`], the amplitude, the
/// Schlick-weighted amplitude and two spare.
const TEXEL: usize = 8;

/// A square table of lobes for an isotropic BRDF.
///
/// Columns: perceptual roughness from 0 to 1. Rows: sqrt(1 - cos theta) of the view from 0 to 1.
/// Nodes lie on the ends: coordinate u is at u (size - 1). Lookup is bilinear.
#[derive(Clone, Debug, PartialEq)]
pub struct LtcTable {
    size: usize,
    texels: Vec<[f32; TEXEL]>,
}

/// Why bytes are not a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LtcTableError {
    /// The length is not that of a square table of at least 2 x 2 texels of 8 f32.
    #[error("a table of {length} bytes is not square: 32 size^2 bytes are wanted, size at least 2")]
    Length {
        /// Number of bytes.
        length: usize,
    },
    /// A texel is not a lobe.
    #[error("the texel at column {column}, row {row} is not a lobe: refit the table")]
    Texel {
        /// Which column, from 0.
        column: usize,
        /// Which row, from 0.
        row: usize,
    },
}

impl LtcTable {
    /// The table for GGX with height-correlated Smith shadowing that ships with the library:
    /// `tables/ggx-64.f32`, whose manifest tells how it was fitted and how far it errs.
    pub fn ggx() -> Self {
        Self::from_bytes(include_bytes!("../../../tables/ggx-64.f32"))
            .expect("the shipped table is checked by a test")
    }

    /// A table from little-endian f32, rows one after the other, 8 numbers a texel.
    ///
    /// # Errors
    /// Where the length is wrong or a texel is not a lobe: not finite, or M^-1 not orientation
    /// preserving.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LtcTableError> {
        let count = bytes.len() / (4 * TEXEL);
        let size = libm::sqrt(count as f64) as usize;
        if size < 2 || size * size * 4 * TEXEL != bytes.len() {
            return Err(LtcTableError::Length {
                length: bytes.len(),
            });
        }
        let texels: Vec<[f32; TEXEL]> = bytes
            .chunks_exact(4 * TEXEL)
            .map(|texel| {
                core::array::from_fn(|i| {
                    let number = [
                        texel[4 * i],
                        texel[4 * i + 1],
                        texel[4 * i + 2],
                        texel[4 * i + 3],
                    ];
                    f32::from_le_bytes(number)
                })
            })
            .collect();
        for (i, &[m11, m13, m31, m33, amplitude, schlick, ..]) in texels.iter().enumerate() {
            let numbers = [m11, m13, m31, m33, amplitude, schlick];
            let is_lobe = numbers.iter().all(|x| x.is_finite())
                && m11 > 0.0
                && m11 * m33 - m13 * m31 > 0.0
                && amplitude >= 0.0;
            if !is_lobe {
                return Err(LtcTableError::Texel {
                    column: i % size,
                    row: i / size,
                });
            }
        }
        Ok(Self { size, texels })
    }

    /// Texels along each side.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The lobe for a perceptual roughness in \[0, 1\] and the cosine of the view angle in
    /// \[0, 1\]; arguments outside are clamped, NaN is taken for 0.
    #[inline]
    pub fn lookup(&self, perceptual_roughness: f32, cos_view: f32) -> Ltc<f32> {
        let last = (self.size - 1) as f32;
        let place = |u: f32| {
            let u = (if u > 0.0 { u.min(1.0) } else { 0.0 }) * last;
            let cell = (u as usize).min(self.size - 2);
            (cell, u - cell as f32)
        };
        let cos_view = if cos_view > 0.0 {
            cos_view.min(1.0)
        } else {
            0.0
        };
        let (column, s) = place(perceptual_roughness);
        let (row, t) = place(crate::real::Real::sqrt(1.0 - cos_view));
        let first = row * self.size + column;
        let corners = [
            &self.texels[first],
            &self.texels[first + 1],
            &self.texels[first + self.size],
            &self.texels[first + self.size + 1],
        ];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        let value = |i: usize| {
            weights[0] * corners[0][i]
                + weights[1] * corners[1][i]
                + weights[2] * corners[2][i]
                + weights[3] * corners[3][i]
        };
        Ltc {
            shading_to_cosine: [value(0), value(1), value(2), value(3)],
            amplitude: value(4),
            schlick: value(5),
        }
    }
}
