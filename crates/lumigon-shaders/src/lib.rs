//! lumigon's functions as shaders: one WESL library, linked to WGSL and translated.
//!
//! The library is the folder `shaders/`: pure functions without bindings, entry points or storage
//! pointers, with the names of the crate `lumigon`. [`link`] puts them behind a shader of yours.

mod export;
mod link;

pub use export::{ExportError, Library, Target};
pub use link::{LinkError, MODULES, library, library_with, link};
