//! What can be done in the background.

use lumigon_renderer::RenderError;

use super::background::Reporter;
use super::reference::{ReferenceJob, ReferenceState};
use super::refine::{RefineJob, RefinedPictures};

/// Work for [`Background`](super::Background).
pub(crate) enum Job {
    /// Pictures by closed forms, with more and more samples a pixel.
    Refine(RefineJob),
    /// A path-traced picture that converges.
    Reference(ReferenceJob),
}

/// What comes of it, again and again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Update {
    /// Of [`Job::Refine`].
    Refined(RefinedPictures),
    /// Of [`Job::Reference`].
    Reference(ReferenceState),
}

impl Job {
    pub(super) fn run(&self, reporter: &Reporter) -> Result<(), RenderError> {
        match self {
            Self::Refine(job) => job.run(reporter),
            Self::Reference(job) => job.run(reporter),
        }
    }
}
