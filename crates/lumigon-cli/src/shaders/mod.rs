//! `lumigon shaders`: the shader library for other engines.

mod export;
mod folder;
mod readme;
mod tables;

use clap::{Args, Subcommand};

use crate::Failure;

/// Writes the shader library for any engine
#[derive(Debug, Args)]
pub struct Shaders {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    Export(export::Export),
}

impl Shaders {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        match &self.action {
            Action::Export(export) => export.run(),
        }
    }
}
