//! The `lumigon` command.

use std::process::ExitCode;

use clap::Parser;
use lumigon_cli::Arguments;

fn main() -> ExitCode {
    match Arguments::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
