use std::io::Write;
use std::path::{Path, PathBuf};

use crate::description::Description;
use crate::error::TableError;
use crate::image::TableImage;
use crate::{dds, json, ktx2, open_exr, raw, rust_source};

/// A file format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Raw little-endian f32.
    F32,
    /// Raw little-endian binary16.
    F16,
    /// Khronos texture, version 2: an array of RGBA layers.
    Ktx2 {
        /// 16 bits a number instead of 32.
        half: bool,
    },
    /// Direct3D surface with the DX10 header: an array of RGBA layers.
    Dds {
        /// 16 bits a number instead of 32.
        half: bool,
    },
    /// EXR, 32 bits, channels by name; with four axes, one layer `slice-<i2>-<i3>` a slice.
    Exr,
    /// Rust source: a static array.
    Rust,
    /// JSON with everything in it.
    Json,
}

impl Format {
    /// The file's extension, without the leading dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Ktx2 { .. } => "ktx2",
            Self::Dds { .. } => "dds",
            Self::Exr => "exr",
            Self::Rust => "rs",
            // A manifest is called <name>.json already.
            Self::Json => "table.json",
        }
    }

    /// Whether the numbers have 16 bits.
    pub fn is_half(self) -> bool {
        matches!(
            self,
            Self::F16 | Self::Ktx2 { half: true } | Self::Dds { half: true }
        )
    }

    /// Whether the file has no room for words of its own.
    fn needs_description(self) -> bool {
        matches!(self, Self::F32 | Self::F16 | Self::Dds { .. })
    }
}

impl TableImage {
    /// The file's name.
    pub fn file_name(&self, format: Format) -> String {
        // Dashes would have to be escaped where a module is named after the file.
        let stem = match format {
            Format::Rust => self.name().replace('-', "_"),
            _ => self.name().to_owned(),
        };
        format!("{stem}.{}", format.extension())
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// Where the format cannot hold the table: a number beyond 16 bits, too many texels.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>, TableError> {
        if format.is_half() {
            self.check_half()?;
        }
        match format {
            Format::F32 | Format::F16 => Ok(raw::bytes(self.values(), format.is_half())),
            Format::Ktx2 { half } => ktx2::encode(self, half),
            Format::Dds { half } => dds::encode(self, half),
            Format::Exr => open_exr::encode(self),
            Format::Rust => Ok(rust_source::encode(self).into_bytes()),
            Format::Json => json::encode(self),
        }
    }

    /// Writes the table in these formats into an existing folder, each file whole or not at all,
    /// and none where a format cannot hold the table. The paths written.
    ///
    /// # Errors
    /// Where a format cannot hold the table, or a file cannot be written.
    pub fn write(&self, formats: &[Format], folder: &Path) -> Result<Vec<PathBuf>, TableError> {
        let mut files = Vec::new();
        for &format in formats {
            let name = self.file_name(format);
            let bytes = self.encode(format)?;
            if format.needs_description() {
                let description = Description::new(self, format, &name, &bytes);
                files.push((format!("{name}.json"), json::pretty(self, &description)?));
            }
            files.push((name, bytes));
        }
        files.sort();
        files.dedup();
        let write = |(name, bytes): (String, Vec<u8>)| {
            let path = folder.join(name);
            match write_whole(&path, &bytes) {
                Ok(()) => Ok(path),
                Err(source) => Err(TableError::Io { path, source }),
            }
        };
        files.into_iter().map(write).collect()
    }
}

/// Writes beside the target, then renames: a reader sees the old file or the new one.
fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    // A temporary file is private; a table is not.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let open = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(open)?;
    }
    file.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::tests::example;

    const ALL: [Format; 9] = [
        Format::F32,
        Format::F16,
        Format::Ktx2 { half: false },
        Format::Ktx2 { half: true },
        Format::Dds { half: false },
        Format::Dds { half: true },
        Format::Exr,
        Format::Rust,
        Format::Json,
    ];

    #[test]
    fn every_file_is_written_and_none_left_over() {
        let folder = tempfile::tempdir().unwrap();
        let formats = [
            Format::F32,
            Format::F16,
            Format::Ktx2 { half: true },
            Format::Dds { half: false },
            Format::Exr,
            Format::Rust,
            Format::Json,
            Format::Json,
        ];
        let mut written = example(&[3, 2]).write(&formats, folder.path()).unwrap();
        written.sort();
        let entries = std::fs::read_dir(folder.path()).unwrap();
        let mut found: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        found.sort();
        assert_eq!(found, written);
        assert_eq!(found.len(), 10);
    }

    #[test]
    fn a_number_beyond_half_is_named_and_nothing_written() {
        let channels = ["a", "b", "c", "d"].map(String::from);
        let values = vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 65520.0, 7.0];
        let image = TableImage::new("big", &[2, 1], &channels, values, Vec::new()).unwrap();
        for format in ALL.into_iter().filter(|format| format.is_half()) {
            let message = image.encode(format).unwrap_err().to_string();
            assert!(
                message.contains("\"c\" is 65520 at texel [1, 0]"),
                "{message}"
            );
        }
        let folder = tempfile::tempdir().unwrap();
        let error = image.write(&[Format::Exr, Format::F16], folder.path());
        assert!(matches!(error, Err(TableError::BeyondHalf { .. })));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let missing = image.write(&[Format::Exr], &folder.path().join("no"));
        let message = missing.unwrap_err().to_string();
        assert!(message.contains("big.exr"), "{message}");
    }
}
