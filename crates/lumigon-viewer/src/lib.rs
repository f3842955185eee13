//! A window on a glTF scene lit by its emissive polygons, which can be moved and reshaped there.
//!
//! [`run`] opens it. What a frame does, in order: input becomes commands and edits of the document,
//! the renderer takes what they changed, and the picture is made: a drag is on screen in the frame
//! that got it. Whatever takes longer than a frame works in the background and wakes the window.

mod app;
pub mod document;
mod loading;
mod navigation;
mod options;
mod recovery;
mod replay;
mod window;
mod workers;

pub use options::{BackendChoice, Options};
pub use window::{ViewerError, run};
