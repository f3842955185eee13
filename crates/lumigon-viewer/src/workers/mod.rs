//! What goes on in the background while nothing moves.

mod accumulation;
mod background;
mod job;
mod reference;
mod refine;

pub(crate) use background::{Background, BackgroundState};
pub(crate) use job::{Job, Update};
pub(crate) use reference::{ReferenceJob, ReferenceState};
pub(crate) use refine::{Look, RefineJob};
