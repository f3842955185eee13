//! `lumigon completions`: completion scripts for shells.

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::{Arguments, Failure};

/// Prints a completion script for a shell
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lumigon completions bash > ~/.local/share/bash-completion/completions/lumigon
  lumigon completions zsh > ~/.zfunc/_lumigon
  lumigon completions fish > ~/.config/fish/completions/lumigon.fish")]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(
            self.shell,
            &mut Arguments::command(),
            "lumigon",
            &mut script,
        );
        std::io::stdout().write_all(&script)?;
        Ok(())
    }
}
