//! What goes on in the background while nothing moves.

mod accumulation;
mod background;
mod job;
mod reference;
mod refine;

pub use background::{Background, BackgroundProgress, BackgroundState};
pub use job::{Job, Update};
pub use reference::{ReferenceJob, ReferenceState};
pub use refine::{Look, RefineJob, RefinedPictures};
