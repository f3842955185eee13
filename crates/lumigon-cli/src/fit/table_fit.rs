//! `lumigon fit BRDF`: a table, fitted in one go or in several.

use std::path::PathBuf;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use lumigon_fit::{BrdfKind, Fit, FitError, Manifest, ObjectiveKind, Settings, Table};

use super::unfinished::Unfinished;
use crate::Failure;
use crate::interrupt::Interrupt;
use crate::progress::Progress;

pub(super) const AFTER_HELP: &str = "\
BRDFs:
  ggx              isotropic GGX with height-correlated Smith shadowing
  ggx-anisotropic  the same with two widths; its table has four axes
  charlie          the sheen of KHR_materials_sheen
  eon              rough diffuse reflection, the energy-preserving Oren-Nayar model

Writes NAME.f32, the raw table, and NAME.json, its manifest with the errors measured on lights that
it was not fitted to; NAME is BRDF-SIZE, or BRDF-2-SIZE with two lobes. The same arguments give the
same table on any number of threads.

Meanwhile NAME.unfinished.json keeps what is done, every ten seconds and on Ctrl-C: the same command
goes on from there, to the same table.

Examples:
  lumigon fit ggx -o tables
  lumigon fit ggx --lobes 2 -o tables
  lumigon fit ggx --objective density -o published";

/// How often an unfinished fit is saved.
const INTERVAL: Duration = Duration::from_secs(10);

/// One table from the command line.
#[derive(Debug, Args)]
pub(super) struct TableFit {
    /// BRDF to fit
    #[arg(value_name = "BRDF", value_parser = brdf())]
    brdf: BrdfKind,
    /// What the fit minimises
    #[arg(long, value_enum, default_value_t)]
    objective: Objective,
    /// Transformed cosines a texel, 1 or 2; anisotropic tables have 1
    #[arg(long, value_name = "N", default_value_t = Settings::default().lobes)]
    lobes: u32,
    /// Texels along the longest axes, 2 to 512, or to 64 for four axes [default: the shipped
    /// table's; 64 for density]
    #[arg(long, value_name = "N")]
    size: Option<u32>,
    /// Seed of the training lights
    #[arg(long, value_name = "S", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Begin anew, even where an unfinished fit could go on
    #[arg(long)]
    fresh: bool,
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

fn brdf() -> impl TypedValueParser<Value = BrdfKind> {
    PossibleValuesParser::new(BrdfKind::ALL.map(BrdfKind::name)).map(|name| {
        let mut kinds = BrdfKind::ALL.into_iter();
        let kind = kinds.find(|kind| kind.name() == name);
        kind.expect("the parser knows these names alone")
    })
}

impl TableFit {
    pub(super) fn settings(&self) -> Settings {
        let of_integrals = Settings::of(self.brdf, self.lobes);
        let recipe = match self.objective {
            Objective::Integral => of_integrals,
            Objective::Density => {
                let published = Settings::published();
                Settings {
                    brdf: self.brdf,
                    lobes: self.lobes,
                    // Four axes of the published size would take days.
                    size: match self.brdf.axes().len() {
                        2 => published.size,
                        _ => of_integrals.size,
                    },
                    ..published
                }
            }
        };
        Settings {
            size: self.size.unwrap_or(recipe.size),
            seed: self.seed,
            ..recipe
        }
    }

    pub(super) fn run(&self) -> Result<(), Failure> {
        let settings = self.settings();
        let mut fit = Fit::new(&settings).map_err(|error| match error {
            FitError::Settings(problem) => Failure::usage("fit", &problem),
            error => error.into(),
        })?;
        let interrupt = Interrupt::catch()?;
        // Before the minutes of fitting, not after.
        std::fs::create_dir_all(&self.output)
            .map_err(|error| format!("{}: {error}", self.output.display()))?;
        let unfinished = Unfinished::beside(&self.output, &settings);
        if !self.fresh
            && let Some(resumed) = unfinished.resume(&settings)?
        {
            eprintln!("{}: going on from there", unfinished.path().display());
            fit = resumed;
        }
        unfinished.save(&fit)?;
        let start = Instant::now();
        interrupt.watch();
        let table = fit_and_save(&fit, &unfinished, &interrupt);
        // Also a fit that has just ended: its errors are not measured yet.
        unfinished.save(&fit)?;
        let table = match table {
            Err(FitError::Cancelled) => Err(Failure::Interrupted),
            table => table.map_err(Failure::from),
        };
        let table = table.and_then(|table| interrupt.check().map(|()| table));
        if let Err(Failure::Interrupted) = table {
            let path = unfinished.path().display();
            eprintln!("{path}: the same command goes on from there");
        }
        let table = table?;
        // From here on Ctrl-C ends the process: every file is written whole or not at all.
        interrupt.unwatch();
        let manifest = table.write(&self.output, &command(&settings))?;
        unfinished.remove()?;
        self.print(&table, &manifest, start.elapsed());
        Ok(())
    }

    fn print(&self, table: &Table, manifest: &Manifest, elapsed: Duration) {
        let sizes: Vec<String> = table.sizes().iter().map(usize::to_string).collect();
        println!(
            "{}: {} texels in {:.1} s",
            self.output.join(&manifest.file).display(),
            sizes.join(" x "),
            elapsed.as_secs_f64(),
        );
        let secondary = table.brdf().secondary();
        for errors in [&manifest.errors, &manifest.errors_smooth] {
            let [low, high] = errors.perceptual_roughness;
            print!("roughness axis {low} to {high}: RMSE {:.4}", errors.rmse);
            if secondary != "zero" {
                print!(" ({secondary} {:.4})", errors.secondary_rmse);
            }
            let [least, most] = errors.furnace;
            println!(", furnace {least:.3} to {most:.3}");
        }
    }
}

/// The command that makes the table again, wherever it is written.
fn command(settings: &Settings) -> String {
    let objective = match settings.objective {
        ObjectiveKind::Density => "density",
        ObjectiveKind::Integral => "integral",
    };
    format!(
        "lumigon fit {} --lobes {} --size {} --objective {objective} --seed {} -o tables",
        settings.brdf.name(),
        settings.lobes,
        settings.size,
        settings.seed
    )
}

/// Runs a fit to its end or to Ctrl-C, and saves it now and then.
fn fit_and_save(
    fit: &Fit,
    unfinished: &Unfinished,
    interrupt: &Interrupt,
) -> Result<Table, FitError> {
    let progress = Progress::new("fitting");
    let report = |done: usize, total: usize| progress.set(done as u64, total as u64);
    let (end, ended) = mpsc::channel::<()>();
    thread::scope(|scope| {
        let progress = &progress;
        scope.spawn(move || {
            let mut interval = INTERVAL;
            while ended.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                let start = Instant::now();
                if let Err(error) = unfinished.save(fit) {
                    progress.warn(&error.to_string());
                }
                // Great tables take longer to write: a twentieth of the time at most.
                interval = INTERVAL.max(20 * start.elapsed());
            }
        });
        let table = fit.run(&report, interrupt.flag());
        drop(end);
        table
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Alone {
        #[command(flatten)]
        fit: TableFit,
    }

    fn parse(arguments: &str) -> TableFit {
        let words = "lumigon -o tables ".to_owned() + arguments;
        Alone::try_parse_from(words.split_whitespace()).unwrap().fit
    }

    #[test]
    fn command_gives_the_settings_back() {
        for brdf in BrdfKind::ALL {
            for options in ["", "--objective density", "--lobes 2 --seed 7 --size 9"] {
                let settings = parse(&format!("{} {options}", brdf.name())).settings();
                assert_eq!(settings.brdf, brdf);
                let command = command(&settings);
                let again = command.strip_prefix("lumigon fit ").unwrap();
                let again = again.strip_suffix(" -o tables").unwrap();
                assert_eq!(parse(again).settings(), settings, "{command}");
            }
        }
    }

    #[test]
    fn defaults_are_the_shipped_tables() {
        for brdf in BrdfKind::ALL {
            assert_eq!(parse(brdf.name()).settings(), Settings::of(brdf, 1));
        }
        let two = parse("ggx --lobes 2").settings();
        assert_eq!(two, Settings::of(BrdfKind::Ggx, 2));
        let density = parse("ggx --objective density").settings();
        assert_eq!(density, Settings::published());
    }
}
