//! `lumigon fit polynomial`: a fitted table as polynomials, to stand in source code.

use std::path::PathBuf;

use clap::Args;
use lumigon_fit::Table;

use crate::Failure;

/// Seed of the lights that errors are measured on: the manifests'.
const TEST_SEED: u64 = 0x7E57;

/// Prints a fitted table as polynomials, which need no texture
#[derive(Debug, Args)]
#[command(after_help = "\
Prints a Rust array to standard output: by number of a texel, by power of y, by power of x, where x
and y run from -1 to 1 along the table's two axes. Errors on lights that neither was fitted to go to
standard error, the table's beside them.

Example:
  lumigon fit polynomial tables/ggx-32.json --degree 6 > ggx-polynomial-6.rs")]
pub(super) struct Polynomial {
    /// Manifest of the table, the .json file beside the raw one; of two axes
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Degree along both axes, 1 to 12
    #[arg(long, value_name = "N", default_value_t = 6)]
    degree: usize,
}

impl Polynomial {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let table = Table::read(&self.table)?;
        let polynomial = table.polynomial(self.degree)?;
        let name = table.settings().name();
        let (x, y) = (table.brdf().axes()[0], table.brdf().axes()[1]);
        println!(
            "// {name} as polynomials: lumigon fit polynomial tables/{name}.json --degree {}",
            self.degree
        );
        println!("// By number of a texel, by power of y, by power of x; from -1 to 1:");
        println!("// x = 2 u - 1, u = {x}");
        println!("// y = 2 v - 1, v = {y}");
        println!("{}", polynomial.to_rust());
        for range in [[0.1, 1.0], [0.02, 0.1]] {
            let (fitted, tabled) = (
                polynomial.errors(range, TEST_SEED, 256, 32),
                table.errors(range, TEST_SEED, 256, 32),
            );
            eprintln!(
                "first axis {} to {}: RMSE {:.4} (the table's {:.4}), median relative error {:.2} % ({:.2} %)",
                range[0],
                range[1],
                fitted.rmse,
                tabled.rmse,
                100.0 * fitted.median_relative,
                100.0 * tabled.median_relative,
            );
        }
        Ok(())
    }
}
