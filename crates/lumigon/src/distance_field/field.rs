//! A baked field and its levels.

use alloc::vec;
use alloc::vec::Vec;

use super::bake::Outline;
use super::settings::DistanceFieldSettings;
use crate::polygon::PolygonLight;
use crate::real::Scalar;

/// Bands that a field is baked in, of as many rows each.
const BANDS: usize = 8;

/// The distance to a light's outline, over a square of its plane.
///
/// Texel (i, j) of a level with n texels a side is at ((2 i + 1) / n - 1, (2 j + 1) / n - 1) in the
/// field's coordinates, which are the light's radii along its plane's axes over Phi
/// ([`DistanceFieldSettings::phi`]). Its distance is in the same units: 0 or, where the field is
/// signed, negative inside by crossing number, and at most Phi. Coarser levels average four texels.
///
/// Petryaev, "Polygons as lights", the function `bake`. For a normal (x, y, z) his tangent is
/// (y, z, -x), at right angles only where x y + y z = x z: [`PolygonLight::plane_axes`] take its place.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    settings: DistanceFieldSettings,
    texels: Vec<f32>,
}

impl DistanceField {
    /// Bakes a light's field: every texel's distance to the outline itself, to rounding.
    ///
    /// With the feature `parallel` on all threads.
    pub fn new<S: Scalar>(light: &PolygonLight<S>, settings: DistanceFieldSettings) -> Self {
        let outline = Outline::new(light, settings.phi().into());
        let resolution = settings.resolution() as usize;
        let mut texels = vec![0.0; settings.texel_count()];
        let finest = &mut texels[..resolution * resolution];
        // Tiles that start small enough to share out, and large enough to drop edges together.
        let rows = (resolution / BANDS).max(resolution.min(BANDS));
        let bake = |(band, texels): (usize, &mut [f32])| {
            outline.bake_rows(settings, band * rows, texels);
        };
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            let bands = finest.par_chunks_mut(rows * resolution).enumerate();
            bands.for_each(bake);
        }
        #[cfg(not(feature = "parallel"))]
        finest
            .chunks_mut(rows * resolution)
            .enumerate()
            .for_each(bake);
        let mut field = Self { settings, texels };
        field.average();
        field
    }

    /// Makes every level from the one before.
    fn average(&mut self) {
        for level in 1..self.settings.levels() {
            let (from, to) = (
                self.settings.level_range(level - 1),
                self.settings.level_range(level),
            );
            let (finer, rest) = self.texels.split_at_mut(to.start);
            let finer = &finer[from];
            let side = (self.settings.resolution() >> level) as usize;
            for (i, texel) in rest[..side * side].iter_mut().enumerate() {
                let at = 4 * side * (i / side) + 2 * (i % side);
                let below = at + 2 * side;
                let sum = (finer[at] + finer[at + 1]) + (finer[below] + finer[below + 1]);
                *texel = 0.25 * sum;
            }
        }
    }

    /// How it was baked.
    pub fn settings(&self) -> DistanceFieldSettings {
        self.settings
    }

    /// The texels of all levels, from the finest on, each row by row.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// The texels of a level, row by row; none beyond the last.
    pub fn level(&self, level: u32) -> &[f32] {
        &self.texels[self.settings.level_range(level)]
    }

    /// The distance at (u, v) in the field's coordinates, smoothed over `width` texels of the finest
    /// level.
    ///
    /// Linear between texels, and between the two levels whose texels are next to `width`: with l the
    /// finer one, the coarser's share is width / 2^l - 1. Means over squares wider than the field grow
    /// with the square, as they do about any small shape. Beyond the outermost texels' centres the
    /// distance goes on along the ray from the middle, which leads nearly straight away from the light:
    /// never too near, and up to 3.5 % too far where Phi is 2.
    #[inline]
    pub fn fetch<S: Scalar>(&self, u: S, v: S, width: S) -> S {
        let resolution = self.settings.resolution() as f32;
        let width = width.to_f64() as f32;
        // Not a number is as fine as can be.
        let width = if width > 1.0 { width } else { 1.0 };
        let beyond = (width / resolution).max(1.0) - 1.0;
        let width = width.min(resolution);
        // The exponent and what is left of a float, without a logarithm.
        let level = (width.to_bits() >> 23) - 127;
        let share = width / (1_u32 << level) as f32 - 1.0;
        let fine = self.fetch_level(u, v, level);
        if share == 0.0 {
            let mean = self.texels[self.texels.len() - 1].max(0.0);
            return fine + S::from_f64((mean * beyond).into());
        }
        let coarse = self.fetch_level(u, v, level + 1);
        fine + (coarse - fine) * S::from_f64(share.into())
    }

    #[inline]
    fn fetch_level<S: Scalar>(&self, u: S, v: S, level: u32) -> S {
        let side = self.settings.resolution() >> level;
        let number = |x: u32| S::from_f64(x.into());
        let (zero, one) = (number(0), number(1));
        let most = one - one / number(side);
        let greatest = u.abs().max(v.abs());
        let scale = if greatest > most {
            most / greatest
        } else {
            one
        };
        let beyond = (u * u + v * v).sqrt() * (one - scale);
        let texels = self.level(level);
        let half = number(side) * S::from_f64(0.5);
        let cell = |x: S| {
            let place = ((x * scale + one) * half - S::from_f64(0.5)).max(zero);
            let texel = (place.to_f64() as u32).min(side.saturating_sub(2));
            (texel as usize, place - number(texel))
        };
        let ((i, x), (j, y)) = (cell(u), cell(v));
        let side = side as usize;
        let at = |i: usize, j: usize| {
            let texel = texels[j.min(side - 1) * side + i.min(side - 1)];
            S::from_f64(texel.into())
        };
        let low = at(i, j) + (at(i + 1, j) - at(i, j)) * x;
        let high = at(i, j + 1) + (at(i + 1, j + 1) - at(i, j + 1)) * x;
        low + (high - low) * y + beyond
    }
}
