//! Why a light is none.

use super::OutlineFault;

/// Why an edit was refused. The document is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// It was removed, or never there.
    #[error("there is no such light")]
    NoSuchLight,
    /// Its outline would be none.
    #[error("{0}")]
    Outline(#[from] OutlineFault),
    /// Its outline cannot change.
    #[error("this light keeps its outline: {0}")]
    Fixed(&'static str),
    /// The frame is not rotation and translation, or out of range.
    #[error("the light would be out of reach or out of shape: move or scale it less")]
    Frame,
    /// The radiance is negative or not finite.
    #[error("radiance is a finite number, at least 0, for red, green and blue")]
    Radiance,
    /// The picture's texture is not the scene's, or it lies nowhere.
    #[error("the picture has no place on the light: put it on again")]
    Picture,
    /// The outline has no area in single precision, which scenes are kept in.
    #[error("the light is too small for its distance from the origin: make it larger")]
    Vanishes,
    /// There are no identities left.
    #[error("there are too many lights")]
    TooMany,
}
