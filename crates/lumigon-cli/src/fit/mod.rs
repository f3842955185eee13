//! `lumigon fit`: tables of linearly transformed cosines.

use clap::{Args, Subcommand};

use crate::Failure;

mod export;
mod polynomial;
mod report;
pub(crate) use report::theme;
mod table_fit;
mod unfinished;

/// Fits a table of linearly transformed cosines to a BRDF
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = table_fit::AFTER_HELP
)]
pub struct Fit {
    #[command(flatten)]
    table: Option<table_fit::TableFit>,
    #[command(subcommand)]
    tool: Option<Tool>,
}

/// What is done with a fitted table.
#[derive(Debug, Subcommand)]
enum Tool {
    Export(export::Export),
    Polynomial(polynomial::Polynomial),
    Report(report::Report),
}

impl Fit {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        match (&self.tool, &self.table) {
            (Some(Tool::Export(export)), _) => export.run(),
            (Some(Tool::Polynomial(polynomial)), _) => polynomial.run(),
            (Some(Tool::Report(report)), _) => report.run(),
            (None, Some(table)) => table.run(),
            (None, None) => Err(Failure::usage(
                "fit",
                "name a BRDF to fit, or one of export, polynomial and report",
            )),
        }
    }
}
