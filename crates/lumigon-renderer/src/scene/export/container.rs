//! The two kinds of glTF file.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use base64::{Engine, prelude::BASE64_STANDARD};
use serde_json::Value;

use super::SaveError;

/// The two kinds of glTF file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// Binary: the JSON, then the first buffer.
    Glb,
    /// The JSON alone, all else in data URIs.
    Gltf,
}

impl Format {
    /// What the name's ending asks for; upper case counts.
    pub(super) fn from_path(path: &Path) -> Result<Self, SaveError> {
        let extension = path.extension().unwrap_or_default();
        if extension.eq_ignore_ascii_case("glb") {
            Ok(Self::Glb)
        } else if extension.eq_ignore_ascii_case("gltf") {
            Ok(Self::Gltf)
        } else {
            let path = path.to_owned();
            Err(SaveError::Format { path })
        }
    }
}

/// A file ready to be written.
pub(super) struct Written<'a> {
    format: Format,
    json: Vec<u8>,
    binary: Vec<Cow<'a, [u8]>>,
}

impl<'a> Written<'a> {
    pub(super) fn new(format: Format, json: &Value, binary: Vec<Cow<'a, [u8]>>) -> Self {
        let mut json = json.to_string().into_bytes();
        if format == Format::Glb {
            json.resize(json.len().next_multiple_of(4), b' ');
        }
        Self {
            format,
            json,
            binary,
        }
    }

    /// Refuses what the container cannot count.
    pub(super) fn check_length(&self, path: &Path) -> Result<(), SaveError> {
        let bytes = self.length();
        if self.format == Format::Glb && u32::try_from(bytes).is_err() {
            let path = path.to_owned();
            return Err(SaveError::TooLarge { path, bytes });
        }
        Ok(())
    }

    fn binary_length(&self) -> u64 {
        self.binary.iter().map(|part| part.len() as u64).sum()
    }

    fn length(&self) -> u64 {
        let chunk = |length: u64| 8 + length.next_multiple_of(4);
        let json = self.json.len() as u64;
        match (self.format, self.binary_length()) {
            (Format::Gltf, _) => json,
            (Format::Glb, 0) => 12 + chunk(json),
            (Format::Glb, binary) => 12 + chunk(json) + chunk(binary),
        }
    }

    /// Writes it; its length was checked.
    pub(super) fn write(&self, file: &mut impl Write) -> io::Result<()> {
        if self.format == Format::Gltf {
            return file.write_all(&self.json);
        }
        let word = |n: u64| (n as u32).to_le_bytes();
        file.write_all(b"glTF\x02\0\0\0")?;
        file.write_all(&word(self.length()))?;
        file.write_all(&word(self.json.len() as u64))?;
        file.write_all(b"JSON")?;
        file.write_all(&self.json)?;
        let length = self.binary_length();
        if length > 0 {
            let padded = length.next_multiple_of(4);
            file.write_all(&word(padded))?;
            file.write_all(b"BIN\0")?;
            for part in &self.binary {
                file.write_all(part)?;
            }
            file.write_all(&[0; 4][..(padded - length) as usize])?;
        }
        Ok(())
    }
}

/// A data URI of all parts, one after the other.
pub(super) fn data_uri(kind: &str, parts: &[&[u8]]) -> String {
    let mut uri = format!("data:{kind};base64,");
    match parts {
        [bytes] => BASE64_STANDARD.encode_string(bytes, &mut uri),
        parts => BASE64_STANDARD.encode_string(parts.concat(), &mut uri),
    }
    uri
}
