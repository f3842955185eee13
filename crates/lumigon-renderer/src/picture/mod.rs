//! Pictures as files: PNG for eyes, EXR for measuring.

mod error;
mod file;
mod srgb;
mod tone_map;

pub use error::PictureError;
pub use file::{PictureFormat, check_writable, write_exr, write_png};
pub use srgb::srgb8;
pub use tone_map::ToneMap;
