//! Why there is no report.

use std::io;
use std::path::{Path, PathBuf};

use lumigon_renderer::{RenderError, SceneError};

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The scene could not be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// There is no such camera.
    #[error("there is no camera \"{wanted}\": {offered}")]
    Camera {
        /// What was asked for.
        wanted: String,
        /// What there is.
        offered: String,
    },
    /// A setting is no length.
    #[error("bias is {0}: give a length of at least 0, in scene units")]
    Bias(f64),
    /// The folder belongs to something else.
    #[error("{path}: {what}; name a new or an empty folder, or an earlier report", path = path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
        /// What is there.
        what: String,
    },
    /// The folder has nowhere to be.
    #[error("{path}: there is no folder {parent}; make it first", path = path.display(), parent = parent.display())]
    NoParent {
        /// The folder.
        path: PathBuf,
        /// The folder it would be in.
        parent: PathBuf,
    },
    /// A file or a folder could not be written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A picture could not be written as PNG.
    #[error("{path}: {source}", path = path.display())]
    Png {
        /// Which.
        path: PathBuf,
        /// Why.
        source: image::ImageError,
    },
    /// A picture could not be written as EXR.
    #[error("{path}: {source}", path = path.display())]
    Exr {
        /// Which.
        path: PathBuf,
        /// Why.
        source: exr::error::Error,
    },
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
