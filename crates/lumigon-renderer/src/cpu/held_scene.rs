//! A scene that is borrowed, or shared.

use std::ops::Deref;
use std::sync::Arc;

use crate::scene::Scene;

/// The scene that a renderer shows.
pub(super) enum HeldScene<'a> {
    Borrowed(&'a Scene),
    Shared(Arc<Scene>),
}

impl Deref for HeldScene<'_> {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        match self {
            Self::Borrowed(scene) => scene,
            Self::Shared(scene) => scene,
        }
    }
}
