//! What is baked, and how it is read.

use super::smoothness::distance_field_smoothness;
use crate::real::Real;

/// Least texels along a side of a field.
pub const MINIMUM_FIELD_RESOLUTION: u32 = 4;
/// Most texels along a side of a field.
pub const MAXIMUM_FIELD_RESOLUTION: u32 = 2048;

/// How a light's distance field is baked.
///
/// The numbers are within their ranges, so that equal settings are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceFieldSettings {
    resolution: u32,
    phi: f32,
    signed: bool,
}

/// No NaN gets past [`DistanceFieldSettings::new`].
impl Eq for DistanceFieldSettings {}

impl Default for DistanceFieldSettings {
    fn default() -> Self {
        Self {
            resolution: 128,
            phi: 2.0,
            signed: false,
        }
    }
}

/// Why a distance field cannot be baked or read so.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DistanceFieldError {
    /// The resolution is no power of two, or out of range.
    #[error(
        "the distance field's resolution is {0}: give a power of two from \
         {MINIMUM_FIELD_RESOLUTION} to {MAXIMUM_FIELD_RESOLUTION}"
    )]
    Resolution(u32),
    /// Phi is out of range.
    #[error("the distance field's phi is {0}: give 1 to 16")]
    Phi(f32),
    /// The smoothness is out of range.
    #[error("the smoothness of reflected distances is {0}: give more than 0, at most 1e6")]
    Smoothness(f32),
    /// The fields together are larger than their budget.
    #[error(
        "the distance fields of {shapes} shapes need {needed} bytes, and their budget is {budget}: \
         give a lower resolution than {resolution}, or a larger budget"
    )]
    OverBudget {
        /// How many shapes differ.
        shapes: usize,
        /// Texels along a side.
        resolution: u32,
        /// Bytes of all fields.
        needed: u64,
        /// Bytes that they may have.
        budget: u64,
    },
}

impl DistanceFieldSettings {
    /// A field of `resolution` by `resolution` texels over the square that circumscribes the circle
    /// of `phi` of the light's radii about its centre (the source's Phi). With `signed`, distances
    /// inside are negative, and else 0.
    ///
    /// # Errors
    /// Where `resolution` is no power of two in \[4, 2048\], or `phi` outside \[1, 16\].
    pub fn new(resolution: u32, phi: f32, signed: bool) -> Result<Self, DistanceFieldError> {
        let range = MINIMUM_FIELD_RESOLUTION..=MAXIMUM_FIELD_RESOLUTION;
        if !resolution.is_power_of_two() || !range.contains(&resolution) {
            return Err(DistanceFieldError::Resolution(resolution));
        }
        if !(1.0..=16.0).contains(&phi) {
            return Err(DistanceFieldError::Phi(phi));
        }
        Ok(Self {
            resolution,
            phi,
            signed,
        })
    }

    /// Texels along a side of the finest level.
    pub fn resolution(self) -> u32 {
        self.resolution
    }

    /// Half the side of the square that the field covers, in the light's radii.
    pub fn phi(self) -> f32 {
        self.phi
    }

    /// Whether distances inside are negative, and not 0.
    pub fn is_signed(self) -> bool {
        self.signed
    }

    /// Levels from the finest to that of one texel.
    pub fn levels(self) -> u32 {
        self.resolution.ilog2() + 1
    }

    /// Texels of all levels.
    pub fn texel_count(self) -> usize {
        // 4^levels / 3, rounded down, is 1 + 4 + ... + resolution^2.
        ((1_usize << (2 * self.levels())) - 1) / 3
    }

    /// Which of a field's texels are those of a level.
    pub fn level_range(self, level: u32) -> core::ops::Range<usize> {
        let start = |level: u32| {
            let rest = self.levels().saturating_sub(level);
            self.texel_count() - ((1_usize << (2 * rest)) - 1) / 3
        };
        start(level)..start(level + 1)
    }
}

/// The source's `k_s`: how fast a reflection fades with the distance from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceFieldSmoothness(Choice);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Choice {
    Material { factor: f32 },
    Fixed(f32),
}

/// No NaN gets past the constructors.
impl Eq for DistanceFieldSmoothness {}

impl Default for DistanceFieldSmoothness {
    fn default() -> Self {
        Self(Choice::Material { factor: 1.0 })
    }
}

impl DistanceFieldSmoothness {
    /// That of the surface's own lobe, [`distance_field_smoothness`], times `factor`.
    ///
    /// # Errors
    /// Where `factor` is not in (0, 1e6].
    pub fn of_material(factor: f32) -> Result<Self, DistanceFieldError> {
        Ok(Self(Choice::Material {
            factor: checked(factor)?,
        }))
    }

    /// The same for every surface, as in the source.
    ///
    /// # Errors
    /// Where `smoothness` is not in (0, 1e6].
    pub fn fixed(smoothness: f32) -> Result<Self, DistanceFieldError> {
        Ok(Self(Choice::Fixed(checked(smoothness)?)))
    }

    /// `k_s` is the first number times [`distance_field_smoothness`], plus the second; one is 0.
    pub fn factor_and_constant(self) -> [f32; 2] {
        match self.0 {
            Choice::Material { factor } => [factor, 0.0],
            Choice::Fixed(smoothness) => [0.0, smoothness],
        }
    }

    /// `k_s` where a lobe's spread is `spread`, for a field of this `phi`; both as
    /// [`distance_field_smoothness`] has them.
    #[inline(always)]
    pub fn at<T: Real>(self, spread: T, phi: T) -> T {
        match self.0 {
            Choice::Material { factor } => {
                distance_field_smoothness(spread, phi) * spread.constant(factor.into())
            }
            Choice::Fixed(smoothness) => spread.constant(smoothness.into()),
        }
    }
}

fn checked(smoothness: f32) -> Result<f32, DistanceFieldError> {
    if smoothness > 0.0 && smoothness <= 1e6 {
        Ok(smoothness)
    } else {
        Err(DistanceFieldError::Smoothness(smoothness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_tile_the_texels() {
        for resolution in [4, 8, 128, 2048] {
            let settings = DistanceFieldSettings::new(resolution, 2.0, false).unwrap();
            let mut end = 0;
            for level in 0..settings.levels() {
                let side = (resolution >> level) as usize;
                let range = settings.level_range(level);
                assert_eq!((range.start, range.len()), (end, side * side));
                end = range.end;
            }
            assert_eq!(end, settings.texel_count());
        }
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        for resolution in [0, 1, 3, 100, 4096, u32::MAX] {
            assert!(DistanceFieldSettings::new(resolution, 2.0, false).is_err());
        }
        for phi in [0.0, 0.99, 17.0, f32::NAN, f32::INFINITY] {
            assert!(DistanceFieldSettings::new(64, phi, true).is_err());
        }
        for smoothness in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(DistanceFieldSmoothness::fixed(smoothness).is_err());
            assert!(DistanceFieldSmoothness::of_material(smoothness).is_err());
        }
    }
}
