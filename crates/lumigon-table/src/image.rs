use std::path::Path;

use half::f16;
use lumigon_fit::{Manifest, Table};

use crate::error::TableError;

/// A table as plain numbers: 2 or 4 axes, channels by name, and what is to be known about them.
///
/// All numbers are finite, the sizes and channels are as many as the numbers, and the name can
/// name a file.
#[derive(Clone, Debug, PartialEq)]
pub struct TableImage {
    name: String,
    sizes: Vec<usize>,
    channels: Vec<String>,
    values: Vec<f32>,
    texts: Vec<(String, String)>,
}

impl TableImage {
    /// - `name`: the files' stem, letters, digits, `-` and `_`.
    /// - `sizes`: texels along each of 2 or 4 axes, the fastest first.
    /// - `channels`: names of the numbers of a texel, ASCII without spaces, a multiple of 4.
    /// - `values`: texel by texel, channels fastest.
    /// - `texts`: key and value, for those who read the file; keys without NUL.
    ///
    /// # Errors
    /// Where one of these is not so, or a number is not finite.
    pub fn new(
        name: &str,
        sizes: &[usize],
        channels: &[String],
        values: Vec<f32>,
        texts: Vec<(String, String)>,
    ) -> Result<Self, TableError> {
        let refuse = |problem: String| {
            Err(TableError::Malformed {
                name: name.to_owned(),
                problem,
            })
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || !name.chars().all(plain) {
            return refuse("a name consists of letters, digits, - and _".to_owned());
        }
        if !matches!(sizes.len(), 2 | 4) {
            return refuse(format!("it has {} axes; 2 or 4 are possible", sizes.len()));
        }
        if channels.is_empty() || !channels.len().is_multiple_of(4) {
            return refuse(format!(
                "it has {} channels; a multiple of 4 is possible",
                channels.len()
            ));
        }
        let graphic =
            |name: &String| !name.is_empty() && name.chars().all(|c| c.is_ascii_graphic());
        if let Some(channel) = channels.iter().find(|name| !graphic(name)) {
            return refuse(format!(
                "channel {channel:?} has characters other than ASCII letters, digits and signs"
            ));
        }
        let count = sizes
            .iter()
            .try_fold(channels.len(), |count, &size| count.checked_mul(size));
        if count == Some(0) || count != Some(values.len()) {
            return refuse(format!(
                "{} numbers are not {} channels of {sizes:?} texels",
                values.len(),
                channels.len()
            ));
        }
        if let Some((key, _)) = texts
            .iter()
            .find(|(key, value)| key.is_empty() || key.contains('\0') || value.contains('\0'))
        {
            return refuse(format!("the text {key:?} has no key, or a NUL in it"));
        }
        let image = Self {
            name: name.to_owned(),
            sizes: sizes.to_vec(),
            channels: channels.to_vec(),
            values,
            texts,
        };
        if let Some(at) = image.values.iter().position(|value| !value.is_finite()) {
            let (texel, channel) = image.place(at);
            let value = image.values[at];
            return refuse(format!("channel {channel:?} is {value} at texel {texel:?}"));
        }
        Ok(image)
    }

    /// Reads a fitted table from its manifest, `<name>.json`, and the raw file beside it.
    ///
    /// # Errors
    /// Where a file is missing or malformed, or the raw file's length or hash isn't the manifest's.
    pub fn read(manifest: &Path) -> Result<Self, TableError> {
        let table = Table::read(manifest)?;
        Self::from_table(&table, &Manifest::read(manifest)?)
    }

    /// A fitted table with its manifest.
    ///
    /// # Errors
    /// Where the manifest isn't the table's.
    pub fn from_table(table: &Table, manifest: &Manifest) -> Result<Self, TableError> {
        let name = Path::new(&manifest.file).file_stem();
        let settings = serde_json::to_string(&manifest.settings).unwrap_or_default();
        let text = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        let mut texts = vec![text("command", &manifest.command)];
        let axes = manifest.axes.iter().enumerate();
        texts.extend(axes.map(|(i, axis)| (format!("axis-{i}"), axis.clone())));
        texts.extend([
            text("texel-rule", &manifest.texel_rule),
            text("frame", &manifest.frame),
            text("normalisation", &manifest.normalisation),
            text("response", &manifest.response),
            text("settings", &settings),
            text("sha256", &manifest.sha256),
        ]);
        Self::new(
            &name.unwrap_or_default().to_string_lossy(),
            &table.sizes(),
            &manifest.channels,
            table.texels().to_vec(),
            texts,
        )
    }

    /// What its files are called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Texels along each axis, the fastest first.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Names of the numbers of a texel.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// All numbers, texel by texel.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Keys and values.
    pub fn texts(&self) -> &[(String, String)] {
        &self.texts
    }

    /// Texels along the third and the fourth axis: 1 where there are only two.
    pub(crate) fn slices(&self) -> [usize; 2] {
        [2, 3].map(|axis| self.sizes.get(axis).copied().unwrap_or(1))
    }

    /// RGBA layers of a texture array.
    pub(crate) fn layers(&self) -> usize {
        let [s2, s3] = self.slices();
        self.channels.len() / 4 * s2 * s3
    }

    /// All numbers, RGBA layer by layer (see the crate's page), row by row.
    pub(crate) fn layered(&self) -> Vec<f32> {
        let texels_a_slice = self.sizes[0] * self.sizes[1];
        let channels = self.channels.len();
        let mut layered = Vec::with_capacity(self.values.len());
        for group in 0..channels / 4 {
            for slice in self.values.chunks_exact(texels_a_slice * channels) {
                for texel in slice.chunks_exact(channels) {
                    layered.extend_from_slice(&texel[4 * group..4 * group + 4]);
                }
            }
        }
        layered
    }

    /// All numbers rounded to 16 bits, in order.
    pub(crate) fn check_half(&self) -> Result<(), TableError> {
        match self
            .values
            .iter()
            .position(|&value| f16::from_f32(value).is_infinite())
        {
            None => Ok(()),
            Some(at) => {
                let (texel, channel) = self.place(at);
                Err(TableError::BeyondHalf {
                    name: self.name.clone(),
                    channel: channel.to_owned(),
                    texel,
                    value: self.values[at],
                })
            }
        }
    }

    /// The texel and the channel of a number.
    fn place(&self, at: usize) -> (Vec<usize>, &str) {
        let mut texel = at / self.channels.len();
        let indices = self.sizes.iter().map(|size| {
            let index = texel % size;
            texel /= size;
            index
        });
        (indices.collect(), &self.channels[at % self.channels.len()])
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Sizes that all differ, and numbers that are hard to write: tiny, denormal, negative zero.
    pub(crate) fn example(sizes: &[usize]) -> TableImage {
        let channels: Vec<String> = [
            "m11",
            "m13",
            "m31",
            "m33",
            "amplitude",
            "schlick",
            "zero",
            "zero",
        ]
        .map(String::from)
        .into();
        let count = sizes.iter().product::<usize>() * channels.len();
        let values = (0..count)
            .map(|i| match i % 17 {
                3 => -0.0,
                5 => f32::MIN_POSITIVE * 0.37,
                11 => -65504.0,
                _ => (i as f32 - 0.5 * count as f32) * 0.7,
            })
            .collect();
        let texts = vec![
            ("command".to_owned(), "lumigon fit \"ggx\" */ \\".to_owned()),
            ("frame".to_owned(), "z = normal, \u{3b8}".to_owned()),
        ];
        TableImage::new("example-3", sizes, &channels, values, texts).unwrap()
    }

    pub(crate) fn bits(values: &[f32]) -> Vec<u32> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    /// The layer formula of the crate's page, number by number.
    #[test]
    fn layers_follow_the_formula() {
        let image = example(&[3, 2, 5, 4]);
        let [s0, s1, s2, s3] = [3, 2, 5, 4];
        let layered = image.layered();
        assert_eq!(layered.len(), image.values().len());
        for (at, value) in image.values().iter().enumerate() {
            let (texel, channel) = (at / 8, at % 8);
            let (i0, i1) = (texel % s0, texel / s0 % s1);
            let (i2, i3) = (texel / (s0 * s1) % s2, texel / (s0 * s1 * s2));
            let layer = channel / 4 * (s2 * s3) + i3 * s2 + i2;
            let place = ((layer * s1 + i1) * s0 + i0) * 4 + channel % 4;
            assert_eq!(layered[place].to_bits(), value.to_bits());
        }
        assert_eq!(image.layers(), 40);
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let channels = ["a", "b", "c", "d"].map(String::from);
        let refuse = |name: &str, sizes: &[usize], channels: &[String], values: Vec<f32>| {
            TableImage::new(name, sizes, channels, values, Vec::new())
                .unwrap_err()
                .to_string()
        };
        let four = || vec![0.0; 4];
        assert!(refuse("../a", &[1, 1], &channels, four()).contains("letters"));
        assert!(refuse("a", &[4], &channels, vec![0.0; 16]).contains("1 axes"));
        assert!(refuse("a", &[1, 1], &channels[..3], vec![0.0; 3]).contains("multiple of 4"));
        let unnamed = ["a", "b", "", "d"].map(String::from);
        assert!(refuse("a", &[1, 1], &unnamed, four()).contains("channel \"\""));
        assert!(refuse("a", &[1, 2], &channels, four()).contains("4 numbers"));
        assert!(refuse("a", &[0, 2], &channels, Vec::new()).contains("0 numbers"));
        assert!(refuse("a", &[usize::MAX, 2], &channels, four()).contains("4 numbers"));
        let message = refuse(
            "a",
            &[1, 2],
            &channels,
            vec![0., 0., 0., 0., 0., f32::NAN, 0., 0.],
        );
        assert!(
            message.contains("\"b\" is NaN at texel [0, 1]"),
            "{message}"
        );
    }
}
