//! Why a scene was not saved.

use std::io;
use std::path::PathBuf;

/// Why a scene was not saved. Whatever was there before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// The name ends in neither `.glb` nor `.gltf`.
    #[error("{}: the name must end in .glb or .gltf", path.display())]
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
    #[error("{}: cannot write the scene: {source}; save it elsewhere", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A `.glb` counts its bytes with 32 bits.
    #[error("{}: {bytes} bytes are more than a .glb can hold; save it as .gltf", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// How many it would take.
        bytes: u64,
    },
    /// The loaded file has something in a form that cannot be patched.
    #[error("{place} of the loaded file: {what}; nothing was saved")]
    File {
        /// Where in its JSON.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// A part of the scene cannot be said in glTF, or is not the source's.
    #[error("{part}: {what}; nothing was saved")]
    Scene {
        /// Which part, by name.
        part: String,
        /// What is wrong with it.
        what: String,
    },
}

impl SaveError {
    pub(super) fn scene(part: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Scene {
            part: part.into(),
            what: what.into(),
        }
    }
}
