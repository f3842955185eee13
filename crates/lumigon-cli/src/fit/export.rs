//! `lumigon fit export`: a fitted table in the formats that renderers load.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use lumigon_table::{Format, TableImage};

use crate::Failure;

/// Writes a fitted table in the formats that renderers load
#[derive(Debug, Args)]
#[command(after_help = "\
Formats:
  f32, f16  raw little-endian numbers, texel by texel, with a description beside them
  ktx2      Khronos texture: an array of RGBA layers, f32 or with --half f16
  dds       the same for Direct3D (DX10 header), with a description beside it
  exr       f32 channels by name
  rust      a static array, as a module or for include!
  json      everything in one readable file, NAME.table.json

In texture arrays the column is the table's first axis, the row its second, and the layer
(channel / 4) * s2 * s3 + i3 * s2 + i2, where s2 and s3 are the sizes of the third and fourth axes
(1 where there are none) and i2, i3 the places along them; RGBA are the four channels of a group.
Row 0 is the first in memory, the top one of a PNG. Lookups are bilinear from texel centre to
texel centre: the coordinate u is at (u * (size - 1) + 0.5) / size of a texture.

Numbers beyond what 16 bits hold (65504) are refused for f16 and --half. Each file is written whole
or not at all; existing ones are replaced.

Examples:
  lumigon fit export tables/ggx-32.json --format ktx2 --half -o assets
  lumigon fit export tables/ggx-32.json --format rust,json,exr -o assets")]
pub(super) struct Export {
    /// Manifest of the table, the .json file beside the raw one
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// What to write: one format, or several with commas between
    #[arg(long, value_enum, required = true, value_delimiter = ',')]
    format: Vec<FormatName>,
    /// 16 bits a number in ktx2 and dds instead of 32
    #[arg(long)]
    half: bool,
    /// Folder to write to; it is made where it is missing [default: the current one]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormatName {
    F32,
    F16,
    Ktx2,
    Dds,
    Exr,
    Rust,
    Json,
}

impl FormatName {
    fn format(self, half: bool) -> Format {
        match self {
            Self::F32 => Format::F32,
            Self::F16 => Format::F16,
            Self::Ktx2 => Format::Ktx2 { half },
            Self::Dds => Format::Dds { half },
            Self::Exr => Format::Exr,
            Self::Rust => Format::Rust,
            Self::Json => Format::Json,
        }
    }
}

impl Export {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let image = TableImage::read(&self.table)?;
        let folder = self.output.as_deref().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("{}: {error}", folder.display()))?;
        let formats: Vec<Format> = self.format.iter().map(|f| f.format(self.half)).collect();
        for path in image.write(&formats, folder)? {
            println!("{}", path.display());
        }
        Ok(())
    }
}
