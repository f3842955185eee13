//! `lumigon gpu`: the GPUs of this machine; and which backend renders.

mod backend;
mod check;
mod info;

use clap::{Args, Subcommand};

use crate::Failure;

pub(crate) use backend::{Backend, BackendChoice};

/// Tells about the GPUs of this machine
#[derive(Debug, Args)]
pub struct GpuCommand {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    Info(info::Info),
    Check(check::Check),
}

impl GpuCommand {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        match &self.action {
            Action::Info(info) => info.run(),
            Action::Check(check) => check.run(),
        }
    }
}
