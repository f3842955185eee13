//! `lumigon render`: a picture of a scene.

use clap::Args;

use crate::Failure;

/// Renders a glTF scene, lit by its emissive polygons
#[derive(Debug, Args)]
pub struct Render {}

impl Render {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        Err("not yet".into())
    }
}
