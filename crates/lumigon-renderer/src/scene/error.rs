//! Why a scene could not be read.

/// Why a scene could not be read: which file, where in it, what is wrong, and what mends it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {place}: {what}; {mend}")]
pub struct SceneError {
    /// The scene's file.
    pub path: String,
    /// The place in it, as a path through the JSON such as `meshes[0].primitives[1]`,
    /// or the part of the file where there is no JSON yet.
    pub place: String,
    /// What is wrong there.
    pub what: String,
    /// What would mend it.
    pub mend: String,
}

/// A [`SceneError`] that does not know its file yet.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    pub(super) place: String,
    pub(super) what: String,
    pub(super) mend: String,
}

impl Fault {
    pub(super) fn new(
        place: impl Into<String>,
        what: impl Into<String>,
        mend: impl Into<String>,
    ) -> Self {
        Self {
            place: place.into(),
            what: what.into(),
            mend: mend.into(),
        }
    }

    pub(super) fn in_file(self, path: &str) -> SceneError {
        SceneError {
            path: path.to_owned(),
            place: self.place,
            what: self.what,
            mend: self.mend,
        }
    }
}
