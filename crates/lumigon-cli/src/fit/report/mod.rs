//! `lumigon fit report`: a table against its BRDF and a baseline, in pictures and numbers.

mod continuity;
mod figure;
mod light;
mod measure;
mod page;
mod place;
mod plot;
mod record;
mod response;
mod scale;
pub(crate) mod theme;
mod truth;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use lumigon_fit::{FitError, Manifest, ObjectiveKind, Settings, Table};

use crate::Failure;
use crate::interrupt::Interrupt;
use crate::progress::Progress;
use crate::report_folder::{METRICS, ReportFolder};
use continuity::Strip;
use figure::Figures;
use measure::{COLUMNS, Measurement, ROWS};
use page::Section;
use record::{Cells, Record, SecondDifferences, TableRecord};

/// What `metrics.json` says of its maker.
const GENERATOR: &str = "lumigon fit report";

/// Reports how far a fitted table is from its BRDF, beside a baseline
#[derive(Debug, Args)]
#[command(after_help = "\
The folder gets
  index.html    a report that opens from disk
  metrics.json  all of its numbers
  pictures/     its figures, on light and on dark paper

The lights are random ones that no fit has seen; table and baseline see the same. Without
--baseline a table of the same size is fitted on the spot by the published recipe, which takes about
as long as `lumigon fit` does.

Examples:
  lumigon fit report tables/ggx-32.json -o report
  lumigon fit report new/ggx-32.json --baseline tables/ggx-32.json -o report")]
pub(super) struct Report {
    /// Manifest of the table, the .json file beside the raw one
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Manifest of the table to compare with [default: a density fit of the same size]
    #[arg(long, value_name = "TABLE")]
    baseline: Option<PathBuf>,
    /// Folder for the report: new, empty, or an earlier report, which is replaced
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Random lights for each of 20 x 18 cells of perceptual roughness and view angle
    #[arg(long, value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u32).range(2..=100_000))]
    lights: u32,
    /// Seed of the lights
    #[arg(long, value_name = "S", default_value_t = 0x7E57)]
    seed: u64,
}

impl Report {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        // Before anything slow: whether the report has a place, and the tables are there.
        ReportFolder::check(&self.output, GENERATOR)?;
        let (table, table_record) = read(&self.table)?;
        let given = self.baseline.as_deref().map(read).transpose()?;
        // From here on Ctrl-C leaves past the end of the folder, which removes it.
        interrupt.watch();
        let folder = ReportFolder::create(&self.output, GENERATOR)?;
        let (baseline, baseline_record) = match given {
            Some(given) => given,
            None => fit_baseline(&table, &interrupt)?,
        };
        if baseline.brdf() != table.brdf() {
            return Err(format!(
                "{}: it is of another BRDF than {}; choose a baseline of the same",
                baseline_record.name, table_record.name
            )
            .into());
        }
        self.fill(
            folder.path(),
            [&table, &baseline],
            [table_record, baseline_record],
            &interrupt,
        )?;
        interrupt.check()?;
        folder.commit()?;
        println!("{}", self.output.join(page::INDEX).display());
        Ok(())
    }

    /// Measures the tables and writes the report's files.
    fn fill(
        &self,
        folder: &Path,
        tables: [&Table; 2],
        [table, baseline]: [TableRecord; 2],
        interrupt: &Interrupt,
    ) -> Result<(), Failure> {
        let measurement = {
            let progress = Progress::new("measuring");
            let report = |done, total| progress.set(done, total);
            Measurement::new(tables, self.lights, self.seed, &report, interrupt)?
        };
        let strips = [
            Strip::new(tables[0], interrupt)?,
            Strip::new(tables[1], interrupt)?,
        ];
        let figures = Figures {
            folder,
            tables,
            names: [&table.name, &baseline.name],
            interrupt,
        };
        let sections = [
            Section {
                title: "Errors",
                figures: figures.measured(&measurement)?,
            },
            Section {
                title: "Lobes",
                figures: figures.lobes()?,
            },
            Section {
                title: "Continuity",
                figures: figures.continuity(&strips)?,
            },
        ];
        let pictures = sections.iter().flat_map(|section| &section.figures);
        let mut files: Vec<String> = pictures.flat_map(|figure| figure.files.clone()).collect();
        files.extend([page::INDEX, METRICS].map(str::to_owned));
        files.sort();
        let both = |of: &dyn Fn(usize) -> Vec<f64>| [of(0), of(1)];
        let record = Record {
            generator: GENERATOR,
            version: env!("CARGO_PKG_VERSION"),
            table,
            baseline,
            seed: self.seed,
            lights: self.lights,
            // Below a perceptual roughness of 0.1 lobes are narrow against the step between two
            // view angles of a table.
            bands: vec![
                measurement.band(COLUMNS / 10..COLUMNS),
                measurement.band(0..COLUMNS / 10),
            ],
            second_differences: SecondDifferences {
                table: strips[0].bounds(),
                baseline: strips[1].bounds(),
            },
            cells: Cells {
                columns: COLUMNS,
                rows: ROWS,
                rmse: both(&|which| measurement.rmse(which, 0)),
                secondary_rmse: both(&|which| measurement.rmse(which, 1)),
                furnace: both(&|which| measurement.furnace(which)),
                leaked: both(&|which| measurement.leaked(which)),
            },
            files,
        };
        write(folder, page::INDEX, &page::html(&record, &sections)?)?;
        let json = serde_json::to_string_pretty(&record)?;
        write(folder, METRICS, &(json + "\n"))
    }
}

/// A table from its manifest.
fn read(path: &Path) -> Result<(Table, TableRecord), Failure> {
    let table = Table::read(path)?;
    let manifest = Manifest::read(path)?;
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    let name = format!("{} ({})", stem.to_string_lossy(), recipe(&table));
    let read = Some((path.display().to_string(), manifest));
    let record = TableRecord::new(&table, &name, read);
    Ok((table, record))
}

/// A table of the same BRDF and size by the published recipe.
fn fit_baseline(table: &Table, interrupt: &Interrupt) -> Result<(Table, TableRecord), Failure> {
    let settings = Settings {
        brdf: table.brdf(),
        size: table.settings().size,
        ..Settings::published()
    };
    let progress = Progress::new("fitting the baseline");
    let report = |done: usize, total: usize| progress.set(done as u64, total as u64);
    let baseline = match lumigon_fit::fit(&settings, &report, interrupt.flag()) {
        Err(FitError::Cancelled) => return Err(Failure::Interrupted),
        baseline => baseline?,
    };
    let name = format!("baseline ({})", recipe(&baseline));
    let record = TableRecord::new(&baseline, &name, None);
    Ok((baseline, record))
}

/// How a table was fitted, in words.
fn recipe(table: &Table) -> String {
    let settings = table.settings();
    let objective = match settings.objective {
        ObjectiveKind::Density => "density",
        ObjectiveKind::Integral => "integral",
    };
    let lobes = match settings.lobes {
        1 => String::new(),
        lobes => format!(", {lobes} lobes"),
    };
    let cosine = if settings.cosine { ", with cosine" } else { "" };
    format!("{objective} fit{lobes}{cosine}")
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), Failure> {
    let path = folder.join(name);
    fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(())
}
