//! Fitted lobes, looked up by roughness and view angle.
//!
//! What a table stores is a lobe relative to what its BRDF tends to: GGX tends to a lobe about the
//! mirrored view whose width goes with alpha, so a GGX matrix is stored about that direction and
//! stretched by alpha. Both are known exactly at every point; interpolating them too would need
//! tables fine enough to resolve a mirror.

use alloc::vec::Vec;

use crate::anisotropic_ltc::AnisotropicLtc;
use crate::ggx::MINIMUM_ALPHA;
use crate::ltc::Ltc;
use crate::real::Real;
use crate::vec3::Vec3;

/// Cosine of 89.9 degrees, the last row of every table: at 90 degrees lobes degenerate.
const LEAST_COSINE: f32 = 0.001_745_328_4;

/// The lobes that stand for a BRDF at one point, seen from one direction: its response is their sum.
///
/// [`Ltc::schlick`] holds the second weight of the table's BRDF: Schlick's (1 - h.v)^5 for GGX, the
/// multiple scattering for EON, 0 for Charlie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LtcSum<const LOBES: usize> {
    /// Lobes of their own, in the shading frame.
    pub lobes: [Ltc<f32>; LOBES],
    /// One more lobe, [`Ltc::cosine`]: its form factor is the surface's own
    /// [`form_factor`](crate::form_factor), which diffuse light has at hand. Amplitudes of 0 where
    /// the table has none.
    pub cosine: Ltc<f32>,
}

impl<const LOBES: usize> LtcSum<LOBES> {
    /// Every lobe, the cosine last.
    pub fn iter(&self) -> impl Iterator<Item = &Ltc<f32>> {
        self.lobes.iter().chain([&self.cosine])
    }

    /// Directional albedo, F = 1.
    pub fn albedo(&self) -> f32 {
        self.iter()
            .map(|lobe| lobe.amplitude * lobe.share_above_horizon())
            .sum()
    }

    /// Directional albedo under the second weight.
    pub fn schlick_albedo(&self) -> f32 {
        self.iter()
            .map(|lobe| lobe.schlick * lobe.share_above_horizon())
            .sum()
    }
}

/// What a table's matrices are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Frame {
    /// About the mirrored view, directions across it in units of alpha.
    Mirror,
    /// About the normal.
    Normal,
}

/// A square table of lobes for an isotropic BRDF, `LOBES` of them a texel.
///
/// Columns: perceptual roughness from 0 to 1. Rows: sqrt(1 - cos theta) of the view from 0 to 1.
/// Nodes lie on the ends: coordinate u is at u (size - 1). Lookup is bilinear.
#[derive(Clone, Debug, PartialEq)]
pub struct LtcTable<const LOBES: usize> {
    size: usize,
    frame: Frame,
    texels: Vec<f32>,
}

/// A table of lobes for GGX with two widths.
///
/// Axes, each from 0 to 1 with nodes on the ends: square root of the greater width `alpha_x`; square
/// root of `alpha_y` / `alpha_x`; sqrt(1 - cos theta) of the view; its azimuth from x over pi/2. Lookup
/// is linear along each.
#[derive(Clone, Debug, PartialEq)]
pub struct AnisotropicLtcTable {
    sizes: [usize; 4],
    texels: Vec<f32>,
}

/// Why bytes are not a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LtcTableError {
    /// The length is not that of a table of this shape.
    #[error(
        "{length} bytes are not a table of {channels} f32 a texel with at least 2 texels a side: export the table again"
    )]
    Length {
        /// Number of bytes.
        length: usize,
        /// Numbers a texel.
        channels: usize,
    },
    /// A texel is not a lobe.
    #[error("the texel at index {index} is not a lobe: refit the table")]
    Texel {
        /// Which texel, from 0, the first axis fastest.
        index: usize,
    },
}

macro_rules! shipped {
    ($name:literal) => {
        include_bytes!(concat!("../../../tables/", $name, ".f32"))
    };
}

const SHIPPED: &str = "the shipped table is checked by a test";

impl LtcTable<1> {
    /// GGX with height-correlated Smith shadowing, one lobe and the cosine: `tables/ggx-32.f32`,
    /// whose manifest tells how it was fitted and how far it errs.
    pub fn ggx() -> Self {
        Self::new(shipped!("ggx-32"), Frame::Mirror).expect(SHIPPED)
    }

    /// The sheen of `KHR_materials_sheen`, one lobe: `tables/charlie-32.f32`.
    pub fn charlie() -> Self {
        Self::new(shipped!("charlie-32"), Frame::Normal).expect(SHIPPED)
    }

    /// EON rough diffuse reflection, one lobe and the cosine: `tables/eon-32.f32`. Columns are the
    /// model's roughness; for a reflectance rho, a lobe's response is
    /// `rho * amplitude + rho_ms * schlick` with [`eon_multiple_albedo`](crate::eon_multiple_albedo)
    /// `rho_ms`.
    pub fn eon() -> Self {
        Self::new(shipped!("eon-32"), Frame::Normal).expect(SHIPPED)
    }

    /// A GGX table from little-endian f32, rows one after the other, 8 numbers a texel: k11, k13,
    /// k31, k33, amplitude and Schlick amplitude of the lobe, then of the cosine.
    ///
    /// # Errors
    /// Where the length is wrong or a texel is not a lobe: not finite, or its map not orientation
    /// preserving.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LtcTableError> {
        Self::new(bytes, Frame::Mirror)
    }
}

impl LtcTable<2> {
    /// GGX with height-correlated Smith shadowing, two lobes: `tables/ggx-2-32.f32`. About a third
    /// of the error, for a second form factor.
    pub fn ggx_2() -> Self {
        Self::new(shipped!("ggx-2-32"), Frame::Mirror).expect(SHIPPED)
    }
}

impl<const LOBES: usize> LtcTable<LOBES> {
    /// Numbers a texel: four of a matrix and two amplitudes a lobe, in fours. What is left over
    /// holds the cosine's amplitudes.
    const CHANNELS: usize = (6 * LOBES).next_multiple_of(4);

    fn new(bytes: &[u8], frame: Frame) -> Result<Self, LtcTableError> {
        let channels = Self::CHANNELS;
        let size = libm::sqrt((bytes.len() / (4 * channels)) as f64) as usize;
        let texels = numbers(bytes, size * size, channels, size)?;
        for (index, texel) in texels.chunks_exact(channels).enumerate() {
            let is_lobe = (0..LOBES).all(|lobe| {
                let [k11, k13, k31, k33] = matrix(texel, lobe);
                k11 * k33 - k13 * k31 > 0.0
            });
            if !is_lobe || texel[4 * LOBES..].iter().any(|&amplitude| amplitude < 0.0) {
                return Err(LtcTableError::Texel { index });
            }
        }
        Ok(Self {
            size,
            frame,
            texels,
        })
    }

    /// Texels along each side.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The numbers of all texels, rows one after the other: `8 * size^2` of them for one lobe,
    /// `12 * size^2` for two.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// The lobes for a perceptual roughness in \[0, 1\] and the cosine of the view angle in
    /// \[0, 1\]; arguments outside are clamped, NaN is taken for 0.
    #[inline]
    pub fn lookup(&self, perceptual_roughness: f32, cos_view: f32) -> LtcSum<LOBES> {
        let perceptual_roughness = unit(perceptual_roughness);
        let cosine = unit(cos_view);
        let (column, s) = place(perceptual_roughness, self.size);
        let (row, t) = place(Real::sqrt(1.0 - cosine), self.size);
        let first = row * self.size + column;
        let corners = [first, first + 1, first + self.size, first + self.size + 1]
            .map(|i| &self.texels[i * Self::CHANNELS..][..Self::CHANNELS]);
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        let value = |i: usize| {
            weights[0] * corners[0][i]
                + weights[1] * corners[1][i]
                + weights[2] * corners[2][i]
                + weights[3] * corners[3][i]
        };
        let amplitude = 4 * LOBES;
        let lobes = core::array::from_fn(|lobe| Ltc {
            shading_to_cosine: self.frame.matrix(
                core::array::from_fn(|i| value(4 * lobe + i)),
                perceptual_roughness,
                cosine,
            ),
            amplitude: value(amplitude + 2 * lobe),
            schlick: value(amplitude + 2 * lobe + 1),
        });
        let mut term = Ltc::cosine(0.0);
        term.amplitude = 0.0;
        if Self::CHANNELS >= 6 * LOBES + 2 {
            term.amplitude = value(6 * LOBES);
            term.schlick = value(6 * LOBES + 1);
        }
        LtcSum {
            lobes,
            cosine: term,
        }
    }
}

impl Frame {
    /// From what is stored to the shading frame.
    #[inline]
    fn matrix(
        self,
        [k11, k13, k31, k33]: [f32; 4],
        perceptual_roughness: f32,
        cos_view: f32,
    ) -> [f32; 4] {
        if self == Self::Normal {
            return [k11, k13, k31, k33];
        }
        let alpha = (perceptual_roughness * perceptual_roughness).max(MINIMUM_ALPHA as f32);
        let (k13, k33) = (alpha * k13, alpha * k33);
        // The mirrored view becomes z.
        let cosine = cos_view.max(LEAST_COSINE);
        let sine = Real::sqrt((1.0 - cosine) * (1.0 + cosine));
        [
            k11 * cosine - k13 * sine,
            k11 * sine + k13 * cosine,
            k31 * cosine - k33 * sine,
            k31 * sine + k33 * cosine,
        ]
    }
}

/// Degree of the embedded polynomials along both axes.
const DEGREE: usize = 6;

/// By number of a texel, by power of y, by power of x.
static GGX: [[[f32; DEGREE + 1]; DEGREE + 1]; 8] = include!("../../../tables/ggx-polynomial-6.rs");

/// What [`LtcTable::ggx`] looks up, from polynomials: nothing to load and nothing to bind, 392
/// numbers, for a tenth more error. Arguments as for [`LtcTable::lookup`].
///
/// Least squares over the table's texels; the file's first line tells how to make it again.
#[inline]
pub fn ggx_polynomial(perceptual_roughness: f32, cos_view: f32) -> LtcSum<1> {
    let perceptual_roughness = unit(perceptual_roughness);
    let cosine = unit(cos_view);
    let x = 2.0 * perceptual_roughness - 1.0;
    let y = 2.0 * Real::sqrt(1.0 - cosine) - 1.0;
    let horner = |terms: &[f32], x: f32| terms.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let value = |number: usize| {
        let of_x: [f32; DEGREE + 1] = core::array::from_fn(|j| horner(&GGX[number][j], x));
        horner(&of_x, y)
    };
    let lobe = |matrix, amplitude| Ltc {
        shading_to_cosine: matrix,
        amplitude: unit(value(amplitude)),
        schlick: unit(value(amplitude + 1)),
    };
    // At grazing views of mirrors the map nearly folds over; a polynomial's error must not do it.
    let [k11, k13, k31, k33] = core::array::from_fn(value);
    let k11 = k11.max(2e-3);
    let k33 = k33.max(k13 * k31 / k11 + 1e-3);
    let matrix = Frame::Mirror.matrix([k11, k13, k31, k33], perceptual_roughness, cosine);
    let (own, mut term) = (lobe(matrix, 4), lobe(Ltc::cosine(0.0).shading_to_cosine, 6));
    // No energy is made: a polynomial may pass what its texels keep to.
    term.amplitude = term.amplitude.min(1.0 - own.amplitude);
    LtcSum {
        lobes: [own],
        cosine: term,
    }
}

impl AnisotropicLtcTable {
    const CHANNELS: usize = 12;
    const SIZES: [usize; 4] = [8, 16, 16, 8];

    /// GGX with height-correlated Smith shadowing: `tables/ggx-anisotropic-16.f32`.
    pub fn ggx() -> Self {
        Self::from_bytes(shipped!("ggx-anisotropic-16"), Self::SIZES).expect(SHIPPED)
    }

    /// A table from little-endian f32, the first axis fastest, 12 numbers a texel: k11, k12, k13,
    /// k23, k31, k32, k33, amplitude, Schlick amplitude, three spare.
    ///
    /// # Errors
    /// Where the length is wrong or a texel is not a lobe.
    pub fn from_bytes(bytes: &[u8], sizes: [usize; 4]) -> Result<Self, LtcTableError> {
        let least = sizes.into_iter().min().unwrap_or(0);
        let count = sizes
            .into_iter()
            .try_fold(1_usize, usize::checked_mul)
            .unwrap_or(0);
        let texels = numbers(bytes, count, Self::CHANNELS, least)?;
        for (index, texel) in texels.chunks_exact(Self::CHANNELS).enumerate() {
            let amplitudes = texel[7] >= 0.0 && texel[8] >= 0.0;
            if !(amplitudes && determinant(symmetric(texel)) > 0.0) {
                return Err(LtcTableError::Texel { index });
            }
        }
        Ok(Self { sizes, texels })
    }

    /// Texels along each axis.
    pub fn sizes(&self) -> [usize; 4] {
        self.sizes
    }

    /// The numbers of all texels, 12 each, the first axis fastest.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// The lobe for the widths along x and y, in \[0, 1\], and the unit vector to the viewer in the
    /// same frame, z the normal. Widths are clamped, to at least [`MINIMUM_ALPHA`]; views below the
    /// horizon count as grazing.
    #[inline]
    pub fn lookup(&self, alpha: [f32; 2], view: Vec3<f32>) -> AnisotropicLtc<f32> {
        let alpha = alpha.map(|alpha| unit(alpha).max(MINIMUM_ALPHA as f32));
        // The table has the greater width along x, and one quadrant of azimuths.
        let turned = alpha[1] > alpha[0];
        let (alpha, view) = if turned {
            ([alpha[1], alpha[0]], Vec3::new(view.y, -view.x, view.z))
        } else {
            (alpha, view)
        };
        let sign = |x: f32| if x < 0.0 { -1.0 } else { 1.0 };
        let (sx, sy) = (sign(view.x), sign(view.y));
        let azimuth = libm::atan2f(view.y.abs(), view.x.abs());
        let cosine = unit(view.z);
        let places = [
            Real::sqrt(alpha[0]),
            Real::sqrt(alpha[1] / alpha[0]),
            Real::sqrt(1.0 - cosine),
            azimuth * core::f32::consts::FRAC_2_PI,
        ];
        let mut numbers = [0.0; Self::CHANNELS];
        let cells: [(usize, f32); 4] =
            core::array::from_fn(|axis| place(unit(places[axis]), self.sizes[axis]));
        for corner in 0..16_usize {
            let (mut index, mut stride, mut weight) = (0, 1, 1.0);
            for (axis, (cell, fraction)) in cells.iter().enumerate() {
                let high = (corner >> axis) & 1;
                index += (cell + high) * stride;
                stride *= self.sizes[axis];
                weight *= if high == 1 { *fraction } else { 1.0 - fraction };
            }
            let texel = &self.texels[index * Self::CHANNELS..][..Self::CHANNELS];
            for (number, x) in numbers.iter_mut().zip(texel) {
                *number += weight * x;
            }
        }
        // A mirrored view mirrors the lobe, and microfacets stretch it by their widths.
        let mirror = [sx, sy, 1.0];
        let scale = 2.0 * alpha[0] * alpha[1] / (alpha[0] + alpha[1]);
        let stretch = [scale / alpha[0], scale / alpha[1], scale];
        let mut rows = symmetric(&numbers);
        for (row, flip) in rows.iter_mut().zip(mirror) {
            for ((entry, flop), by) in row.iter_mut().zip(mirror).zip(stretch) {
                *entry *= flip * flop * by;
            }
        }
        // The mirrored view becomes z, by a turn about the axis at right angles to both.
        let rows = rows.map(|row| about_mirror(row, view, cosine.max(LEAST_COSINE)));
        // A turned frame's x is y, its y is -x.
        let rows = if turned {
            rows.map(|[x, y, z]| [-y, x, z])
        } else {
            rows
        };
        AnisotropicLtc {
            shading_to_cosine: rows,
            amplitude: numbers[7],
            schlick: numbers[8],
        }
    }
}

/// A row vector times the rotation that turns the mirrored view into z.
#[inline]
fn about_mirror([x, y, z]: [f32; 3], view: Vec3<f32>, cosine: f32) -> [f32; 3] {
    let length = Real::sqrt(view.x * view.x + view.y * view.y);
    // Also where the view is not a number.
    if !length.is_normal() {
        return [x, y, z];
    }
    let (ux, uy) = (view.x / length, view.y / length);
    let sine = Real::sqrt((1.0 - cosine) * (1.0 + cosine));
    // In the plane of incidence, rows (cos, sin), (-sin, cos); across it nothing turns.
    let along = x * ux + y * uy;
    let turned = along * cosine - z * sine;
    [
        x + (turned - along) * ux,
        y + (turned - along) * uy,
        along * sine + z * cosine,
    ]
}

/// The matrix of an anisotropic texel, from unit space.
#[inline]
fn symmetric(texel: &[f32]) -> [[f32; 3]; 3] {
    let [k11, k12, k13, k23, k31, k32, k33] = core::array::from_fn(|i| texel[i]);
    [[k11, k12, k13], [k12, 2.0 - k11, k23], [k31, k32, k33]]
}

fn determinant([a, b, c]: [[f32; 3]; 3]) -> f32 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

fn matrix(texel: &[f32], lobe: usize) -> [f32; 4] {
    core::array::from_fn(|i| texel[4 * lobe + i])
}

/// Checked numbers of `count` texels; `least` is the shortest side.
fn numbers(
    bytes: &[u8],
    count: usize,
    channels: usize,
    least: usize,
) -> Result<Vec<f32>, LtcTableError> {
    let length = count.checked_mul(4 * channels);
    if least < 2 || length != Some(bytes.len()) {
        return Err(LtcTableError::Length {
            length: bytes.len(),
            channels,
        });
    }
    let texels: Vec<f32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|number| f32::from_le_bytes(*number))
        .collect();
    match texels.iter().position(|x| !x.is_finite()) {
        Some(bad) => Err(LtcTableError::Texel {
            index: bad / channels,
        }),
        None => Ok(texels),
    }
}

/// Clamped to \[0, 1\], NaN to 0.
#[inline]
fn unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

/// Cell and place in the cell of a coordinate in \[0, 1\].
#[inline]
fn place(u: f32, size: usize) -> (usize, f32) {
    let at = u * (size - 1) as f32;
    let cell = (at as usize).min(size - 2);
    (cell, at - cell as f32)
}
