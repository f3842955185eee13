//! `lumigon man`: manual pages.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, CommandFactory};

use crate::{Arguments, Failure};

/// Prints the manual page, or writes one for each subcommand into a folder
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lumigon man | man -l -
  lumigon man ~/.local/share/man/man1")]
pub struct Man {
    /// Folder for all pages; it is made where it is missing
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

impl Man {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let command = Arguments::command();
        match &self.folder {
            None => {
                let mut page = Vec::new();
                clap_mangen::Man::new(command).render(&mut page)?;
                std::io::stdout().write_all(&page)?;
            }
            Some(folder) => std::fs::create_dir_all(folder)
                .and_then(|()| clap_mangen::generate_to(command, folder))
                .map_err(|error| format!("{}: {error}", folder.display()))?,
        }
        Ok(())
    }
}
