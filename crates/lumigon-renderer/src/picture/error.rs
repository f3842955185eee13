//! Why a picture is not in its file.

use std::io;
use std::path::PathBuf;

/// Why a picture is not in its file. Whatever was there before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The name ends in neither `.png` nor `.exr`.
    #[error("{}: the name must end in .png or .exr", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The path is a folder.
    #[error("{}: this is a folder; give a file's name", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The system did not write it.
    #[error("{}: cannot write the picture: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The size is 0, or not that of the pixels.
    #[error("{}: {count} pixels do not make a picture of {width} x {height}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels that there are.
        count: usize,
    },
    /// A pixel is NaN or infinite: it would be a lie in any colour.
    #[error(
        "{}: {count} pixels are not finite, the first at column {column}, row {row}; nothing was \
         written",
        path.display()
    )]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Column of the first, from 0 at the left.
        column: usize,
        /// Row of the first, from 0 at the top.
        row: usize,
    },
}
