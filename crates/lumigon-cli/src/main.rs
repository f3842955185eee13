//! The `lumigon` command.

mod compare;

use clap::Parser;
use lumigon_renderer::Watch;

/// Light from polygons.
#[derive(Parser)]
enum Command {
    Compare(compare::Args),
}

fn main() -> std::process::ExitCode {
    let Command::Compare(args) = Command::parse();
    match compare::run(&args, &|stage| eprintln!("{stage}"), Watch::none()) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lumigon: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
