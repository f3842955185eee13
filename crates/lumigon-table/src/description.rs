use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::format::Format;
use crate::image::TableImage;

/// What a file without words of its own holds; lies beside it as `<file>.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// The file beside.
    pub file: String,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
    /// Its numbers: `f32` or `f16`, little-endian.
    pub number: String,
    /// Texels along each axis, the fastest first.
    pub sizes: Vec<usize>,
    /// Names of the numbers of a texel.
    pub channels: Vec<String>,
    /// Where in the file a number is.
    pub index: String,
    /// What the table's manifest says.
    pub about: BTreeMap<String, String>,
}

impl Description {
    pub(crate) fn new(image: &TableImage, format: Format, file: &str, bytes: &[u8]) -> Self {
        Self {
            file: file.to_owned(),
            sha256: Sha256::digest(bytes)
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect(),
            number: if format.is_half() { "f16" } else { "f32" }.to_owned(),
            sizes: image.sizes().to_vec(),
            channels: image.channels().to_vec(),
            index: match format {
                Format::Dds { .. } | Format::Ktx2 { .. } => layer_index(image),
                _ => value_index(image),
            },
            about: image.texts().iter().cloned().collect(),
        }
    }
}

/// Where a number is in raw, Rust and JSON forms.
pub(crate) fn value_index(image: &TableImage) -> String {
    let channels = image.channels().len();
    match *image.sizes() {
        [s0, _, s2, s3] if s2 * s3 > 0 => format!(
            "(((i3 * {s2} + i2) * {} + i1) * {s0} + i0) * {channels} + channel",
            image.sizes()[1]
        ),
        _ => format!("(i1 * {} + i0) * {channels} + channel", image.sizes()[0]),
    }
}

/// Where a number is in a texture array.
pub(crate) fn layer_index(image: &TableImage) -> String {
    let [s2, s3] = image.slices();
    let layer = match image.sizes().len() {
        2 => "channel / 4".to_owned(),
        _ => format!("(channel / 4) * {} + i3 * {s2} + i2", s2 * s3),
    };
    format!("layer = {layer}; column = i0; row = i1, row 0 first; RGBA = channel % 4")
}
