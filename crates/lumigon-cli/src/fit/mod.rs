//! `lumigon fit`: tables of linearly transformed cosines.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, Subcommand, ValueEnum};
use lumigon_fit::{FitError, ObjectiveKind, Settings};

use crate::Failure;
use crate::interrupt::Interrupt;
use crate::progress::Progress;

mod export;
mod report;

/// Fits a table of linearly transformed cosines to a BRDF
#[derive(Debug, Args)]
pub struct Fit {
    #[command(subcommand)]
    brdf: Brdf,
}

#[derive(Debug, Subcommand)]
enum Brdf {
    Ggx(Ggx),
    Export(export::Export),
    Report(report::Report),
}

/// Isotropic GGX with height-correlated Smith shadowing
#[derive(Debug, Args)]
#[command(after_help = "\
Writes ggx-SIZE.f32, the raw table, and ggx-SIZE.json, its manifest with the errors measured on
lights that it was not fitted to. The same arguments give the same table on any number of threads.

Examples:
  lumigon fit ggx -o tables
  lumigon fit ggx --size 32 --objective density -o /tmp/published")]
struct Ggx {
    /// Texels a side, 2 to 512
    #[arg(long, default_value_t = Settings::default().size, value_parser = clap::value_parser!(u32).range(2..=512))]
    size: u32,
    /// What the fit minimises
    #[arg(long, value_enum, default_value_t)]
    objective: Objective,
    /// Seed of the training lights
    #[arg(long, default_value_t = Settings::default().seed)]
    seed: u64,
    /// Folder to write to; it is made where it is missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Objective {
    /// The published recipe: the density of the lobe, point by point
    Density,
    /// The lobe's integrals over polygons, which is what a table is for
    #[default]
    Integral,
}

impl Fit {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        match &self.brdf {
            Brdf::Ggx(ggx) => ggx.run(),
            Brdf::Export(export) => export.run(),
            Brdf::Report(report) => report.run(),
        }
    }
}

impl Ggx {
    fn settings(&self) -> Settings {
        let recipe = match self.objective {
            Objective::Density => Settings::published(),
            Objective::Integral => Settings {
                objective: ObjectiveKind::Integral,
                ..Settings::default()
            },
        };
        Settings {
            size: self.size,
            seed: self.seed,
            ..recipe
        }
    }

    /// The command that makes the table again, wherever it is written.
    fn command(&self) -> String {
        let objective = match self.objective {
            Objective::Density => "density",
            Objective::Integral => "integral",
        };
        format!(
            "lumigon fit ggx --size {} --objective {objective} --seed {} -o tables",
            self.size, self.seed
        )
    }

    fn run(&self) -> Result<(), Failure> {
        // Before the minutes of fitting, not after.
        std::fs::create_dir_all(&self.output)
            .map_err(|error| format!("{}: {error}", self.output.display()))?;
        let start = Instant::now();
        let interrupt = Interrupt::catch()?;
        interrupt.watch();
        let table = {
            let progress = Progress::new("fitting");
            let report = |done: usize, total: usize| progress.set(done as u64, total as u64);
            lumigon_fit::fit(&self.settings(), &report, interrupt.flag())
        };
        let table = match table {
            Err(FitError::Cancelled) => return Err(Failure::Interrupted),
            table => table?,
        };
        interrupt.check()?;
        let manifest = table.write(&self.output, &self.command())?;
        println!(
            "{}: {} x {} texels in {:.1} s",
            self.output.join(&manifest.file).display(),
            self.size,
            self.size,
            start.elapsed().as_secs_f64(),
        );
        for errors in [manifest.errors, manifest.errors_smooth] {
            println!(
                "perceptual roughness {} to {}: RMSE {:.4} (Schlick-weighted {:.4}), furnace {:.3} to {:.3}",
                errors.perceptual_roughness[0],
                errors.perceptual_roughness[1],
                errors.rmse,
                errors.secondary_rmse,
                errors.furnace[0],
                errors.furnace[1],
            );
        }
        Ok(())
    }
}
