use std::path::Path;

use crate::{
    fit::FitError, kind::BrdfKind, layout::Layout, ltc::Ltc, manifest::Manifest, settings::Settings,
};

/// A fitted table: numbers on a regular grid over a BRDF's axes ([`BrdfKind::axes`]).
///
/// Texel centres lie on the ends of each axis: a coordinate u in `[0,1]` is texel position
/// `u (size - 1)`, with linear interpolation between. The first axis is the fastest. What a texel's
/// numbers are is the [`Layout`]'s business.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub(crate) settings: Settings,
    pub(crate) texels: Vec<f32>,
}

impl Table {
    /// The BRDF.
    pub fn brdf(&self) -> BrdfKind {
        self.settings.brdf
    }

    /// Texels along each axis.
    pub fn sizes(&self) -> Vec<usize> {
        self.settings.brdf.sizes(self.settings.size)
    }

    /// What the numbers of a texel are.
    pub fn layout(&self) -> Layout {
        Layout::new(&self.settings)
    }

    /// What the table was fitted with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// All texels' numbers, the first axis fastest.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// Numbers a texel.
    pub fn channel_count(&self) -> usize {
        self.layout().channels().len()
    }

    /// The lobes at a place, multilinear between texels; coordinates outside `[0,1]` are clamped,
    /// NaN counts as 0. One coordinate an axis.
    ///
    /// # Panics
    /// If there are fewer coordinates than axes.
    pub fn lookup_at(&self, place: &[f64]) -> Vec<Ltc> {
        let sizes = self.sizes();
        let place: Vec<f64> = place[..sizes.len()]
            .iter()
            .map(|&u| if u.is_nan() { 0.0 } else { u.clamp(0.0, 1.0) })
            .collect();
        let channels = self.channel_count();
        let mut numbers = vec![0.0; channels];
        for corner in 0..(1_usize << sizes.len()) {
            let (mut index, mut stride, mut weight) = (0, 1, 1.0);
            for (axis, (&size, &u)) in sizes.iter().zip(&place).enumerate() {
                let at = u * (size - 1) as f64;
                let low = (at as usize).min(size - 2);
                let fraction = at - low as f64;
                let high = (corner >> axis) & 1;
                index += (low + high) * stride;
                stride *= size;
                weight *= if high == 1 { fraction } else { 1.0 - fraction };
            }
            if weight > 0.0 {
                let texel = &self.texels[channels * index..][..channels];
                for (number, &x) in numbers.iter_mut().zip(texel) {
                    *number += weight * f64::from(x);
                }
            }
        }
        let (brdf, view) = self.settings.brdf.at(&place);
        self.layout().unpack(&brdf.limit(view), &numbers)
    }

    /// The lobes of a table of two axes for a perceptual roughness (the first axis) and the cosine
    /// of the view angle; arguments outside `[0,1]` are clamped, NaN counts as 0.
    ///
    /// # Panics
    /// If the table has more axes.
    pub fn lookup(&self, perceptual_roughness: f64, cos_theta_view: f64) -> Vec<Ltc> {
        assert_eq!(self.sizes().len(), 2, "use lookup_at");
        let cosine = if cos_theta_view.is_nan() {
            0.0
        } else {
            cos_theta_view.clamp(0.0, 1.0)
        };
        self.lookup_at(&[perceptual_roughness, (1.0 - cosine).sqrt()])
    }

    /// Writes `<name>.f32` (raw little-endian) and `<name>.json` (the [`Manifest`]) into an existing
    /// folder, each whole or not at all, where name is [`Settings::name`], for instance `ggx-32`.
    /// `command` is the command that makes the table again; the errors that the manifest states are
    /// measured here.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookup_hits_nodes_and_interpolates() {
        let settings = Settings {
            size: 3,
            ..Settings::default()
        };
        let texels: Vec<f32> = (0..9)
            .flat_map(|i| {
                let mut texel = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
                texel[4] = i as f32;
                texel
            })
            .collect();
        let table = Table {
            settings,
            texels: texels[..9 * 8].to_vec(),
        };
        assert_eq!(table.channel_count(), 8);
        assert_eq!(table.lookup(0.5, 0.75)[0].amplitude, 4.0);
        assert_eq!(table.lookup(1.0, 0.0)[0].amplitude, 8.0);
        assert_eq!(table.lookup(-3.0, f64::NAN)[0].amplitude, 6.0);
        assert!((table.lookup(0.25, 1.0)[0].amplitude - 0.5).abs() < 1e-12);
    }
}
