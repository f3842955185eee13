use std::path::PathBuf;

use lumigon_fit::FitError;

/// Why a table cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The fitted table cannot be read.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The numbers don't make a table.
    #[error("table {name:?}: {problem}")]
    Malformed {
        /// Its name.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// A number doesn't fit into 16 bits.
    #[error(
        "table {name:?}: channel {channel:?} is {value} at texel {texel:?}, beyond what 16 bits \
         hold (65504); write it in 32 bits"
    )]
    BeyondHalf {
        /// The table's name.
        name: String,
        /// The channel's name.
        channel: String,
        /// The indices of its texel, fastest axis first.
        texel: Vec<usize>,
        /// The number.
        value: f32,
    },
    /// A file format cannot hold the table.
    #[error("table {name:?} cannot become {format}: {problem}")]
    Format {
        /// The table's name.
        name: String,
        /// The format's name.
        format: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// A file cannot be written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}
