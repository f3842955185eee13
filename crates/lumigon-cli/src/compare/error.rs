//! Why there is no report.

use std::io;
use std::path::{Path, PathBuf};

use lumigon_renderer::{PictureError, RenderError};

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub(super) enum CompareError {
    /// The scene could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The folder belongs to something else.
    #[error("{}: {what}; name a new or an empty folder, or an earlier report", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
        /// What is there.
        what: String,
    },
    /// The folder has nowhere to be.
    #[error("{}: there is no folder {}; make it first", path.display(), parent.display())]
    NoParent {
        /// The folder.
        path: PathBuf,
        /// The folder it would be in.
        parent: PathBuf,
    },
    /// A file or a folder could not be written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A picture could not be written as PNG.
    #[error("{}: {source}", path.display())]
    Png {
        /// Which.
        path: PathBuf,
        /// Why.
        source: image::ImageError,
    },
    /// A picture could not be written as EXR.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The report's template failed.
    #[error("the report: {0}")]
    Template(#[from] askama::Error),
    /// The numbers could not be written as JSON.
    #[error("metrics.json: {0}")]
    Json(#[from] serde_json::Error),
    /// The built-in font is broken.
    #[error("the built-in font cannot be read")]
    Font,
}

impl CompareError {
    pub(super) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }
}
