//! What the `lumigon` command does, as a library for its tests and fuzz targets.
//!
//! [`Arguments`] is the command line and runs itself; each subcommand is one module.
//! [`answer`] is `lumigon eval` for one line.

mod arguments;
mod bench;
mod bounce;
mod bounce_light;
mod camera;
mod compare;
mod completions;
mod eval;
mod failure;
mod fit;
mod gpu;
mod images;
mod interrupt;
mod man;
mod method;
mod progress;
mod render;
mod report_folder;
mod scene;
mod shaders;
mod size;
mod view;

pub use arguments::{Arguments, Command};
pub use eval::{Answer, Number, Precision, QuestionError, Value, answer};
pub use failure::Failure;
