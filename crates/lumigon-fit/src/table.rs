use std::path::Path;

use crate::{fit::FitError, ltc::Ltc, manifest::Manifest, settings::Settings};

/// Numbers a texel.
pub(crate) const CHANNELS: usize = 8;

/// A fitted table of `size` x `size` texels.
///
/// - x, the fastest axis: perceptual roughness from 0 to 1 (`alpha` is its square, at least 1e-4).
/// - y: `sqrt(1 - cos theta_view)` from 0 to 1 (the angle at most 89.9 degrees).
/// - Texel centres lie on the ends: a coordinate u in `[0,1]` is texel position `u (size - 1)`;
///   bilinear between.
/// - A texel is 8 f32: the four of [`Ltc::matrix`], amplitude, Schlick amplitude, 0, 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub(crate) settings: Settings,
    pub(crate) texels: Vec<f32>,
}

impl Table {
    /// Texels a side.
    pub fn size(&self) -> usize {
        self.settings.size as usize
    }

    /// What the table was fitted with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// All texels, row by row, 8 numbers each.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// One texel.
    ///
    /// # Panics
    /// If `column` or `row` is not below [`Table::size`].
    pub fn texel(&self, column: usize, row: usize) -> Ltc {
        assert!(
            column < self.size() && row < self.size(),
            "texel ({column}, {row})"
        );
        let start = CHANNELS * (row * self.size() + column);
        let texel: [f64; 6] = std::array::from_fn(|i| f64::from(self.texels[start + i]));
        from_channels(texel)
    }

    /// Bilinear lookup; arguments outside `[0,1]` are clamped, NaN counts as 0.
    pub fn lookup(&self, perceptual_roughness: f64, cos_theta_view: f64) -> Ltc {
        let n = self.size();
        let unit = |u: f64| if u.is_nan() { 0.0 } else { u.clamp(0.0, 1.0) };
        let position = |u: f64| {
            let at = u * (n - 1) as f64;
            let low = (at as usize).min(n - 2);
            (low, at - low as f64)
        };
        let (column, fx) = position(unit(perceptual_roughness));
        let (row, fy) = position((1.0 - unit(cos_theta_view)).sqrt());
        from_channels(std::array::from_fn(|i| {
            let at = |dx: usize, dy: usize| {
                f64::from(self.texels[CHANNELS * ((row + dy) * n + column + dx) + i])
            };
            let low = at(0, 0) + fx * (at(1, 0) - at(0, 0));
            let high = at(0, 1) + fx * (at(1, 1) - at(0, 1));
            low + fy * (high - low)
        }))
    }

    /// Writes `<name>.f32` (raw little-endian) and `<name>.json` (the [`Manifest`]) into an existing
    /// folder, each whole or not at all, where name is for instance `ggx-64`. `command` is the
    /// command that makes the table again; the errors that the manifest states are measured here.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path, command: &str) -> Result<Manifest, FitError> {
        Manifest::write(self, folder, command)
    }

    /// Reads the table that a manifest (`<name>.json`) describes, from beside it.
    ///
    /// # Errors
    /// Where a file is missing or malformed, or the raw file's length or hash isn't the manifest's.
    pub fn read(manifest: &Path) -> Result<Self, FitError> {
        Manifest::read(manifest)?.table(manifest)
    }
}

fn from_channels([a, b, c, d, amplitude, schlick]: [f64; 6]) -> Ltc {
    Ltc {
        matrix: [a, b, c, d],
        amplitude,
        schlick,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookup_hits_nodes_and_interpolates() {
        let settings = Settings {
            size: 3,
            ..Settings::default()
        };
        let texels = (0..9 * CHANNELS).map(|i| i as f32).collect();
        let table = Table { settings, texels };
        assert_eq!(table.lookup(0.5, 0.75), table.texel(1, 1));
        assert_eq!(table.lookup(1.0, 0.0), table.texel(2, 2));
        assert_eq!(table.lookup(-3.0, f64::NAN), table.texel(0, 2));
        let between = table.lookup(0.25, 1.0).matrix[0];
        assert!((between - 4.0).abs() < 1e-12);
    }
}
