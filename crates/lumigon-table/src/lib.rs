//! Fitted tables in the file formats that renderers load.
//!
//! A [`TableImage`] is a table as plain numbers with names. Its [`Format`]s are
//!
//! | format | file | holds |
//! | --- | --- | --- |
//! | [`Format::F32`] | `.f32` | raw little-endian f32, texel by texel |
//! | [`Format::F16`] | `.f16` | raw little-endian IEEE 754 binary16, texel by texel |
//! | [`Format::Ktx2`] | `.ktx2` | a texture array of RGBA layers, f32 or f16 |
//! | [`Format::Dds`] | `.dds` | the same for Direct3D, with the DX10 header |
//! | [`Format::Exr`] | `.exr` | f32 channels by name |
//! | [`Format::Rust`] | `.rs` | a static array |
//! | [`Format::Json`] | `.table.json` | everything, readable |
//!
//! The formats that have no room for words come with a [`Description`] beside them,
//! `<file>.json`.
//!
//! ```no_run
//! use std::path::Path;
//! use lumigon_table::{Format, TableImage};
//!
//! let image = TableImage::read(Path::new("tables/ggx-32.json"))?;
//! image.write(&[Format::Ktx2 { half: true }, Format::Rust], Path::new("assets"))?;
//! # Ok::<(), lumigon_table::TableError>(())
//! ```
//!
//! # Where a number is
//! Sizes are `s0, s1` or `s0, s1, s2, s3`, indices `i0 ...` alike, the fastest axis first; there
//! are `c` channels. In the raw, Rust and JSON forms a number is at
//! `(((i3 * s2 + i2) * s1 + i1) * s0 + i0) * c + channel`. In texture arrays `i0` is the column,
//! `i1` the row, and the layer is `group * (s2 * s3) + i3 * s2 + i2`, where group is `channel / 4`
//! and RGBA are the group's four channels. Row 0 comes first in memory.

mod dds;
mod description;
mod error;
mod format;
mod image;
mod json;
mod ktx2;
mod open_exr;
mod raw;
mod rust_source;

pub use description::Description;
pub use error::TableError;
pub use format::Format;
pub use image::TableImage;
