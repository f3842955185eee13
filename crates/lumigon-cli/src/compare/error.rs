//! Why there is no report.

use std::io;
use std::path::{Path, PathBuf};

use lumigon_renderer::{PictureError, RenderError};

use crate::report_folder::FolderError;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CompareError {
    /// The scene could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The report has no folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
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
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }
}
