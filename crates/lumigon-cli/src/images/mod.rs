//! `lumigon images`: how far the methods for images on lights are from cubature.

mod floor;
mod light;
mod measure;
mod page;
mod place;
mod plot;
mod record;
mod statistics;
mod texture;
mod timing;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::Failure;
use crate::compare::contact_sheet::contact_sheet;
use crate::fit::theme::THEMES;
use crate::interrupt::Interrupt;
use crate::progress::Progress;
use crate::report_folder::{METRICS, ReportFolder};
use light::StudyLight;
use measure::METHODS;
use page::Figure;
use record::{Nanoseconds, Record};
use statistics::Table;
use texture::Kind;

/// What `metrics.json` says of its maker.
const GENERATOR: &str = "lumigon images";

/// Reports how far each method for images on lights is from cubature, and what it costs
#[derive(Debug, Args)]
#[command(after_help = "\
The folder gets
  index.html    a report that opens from disk
  metrics.json  all of its numbers
  tables.md     its tables as Markdown
  errors.csv    every sample
  pictures/     its figures

Places are random: lights near, mid, far and across the horizon, on diffuse and on specular
surfaces, with gradients, checkerboards, noise and single bright texels on convex, concave and
pierced outlines.

Examples:
  lumigon images -o report
  lumigon images --lights 20 --texels 32 --picture-side 16 -o quick")]
pub struct Images {
    /// Folder for the report: new, empty, or an earlier report, which is replaced
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Random places for each of 4 distances and 2 surfaces
    #[arg(long, value_name = "N", default_value_t = 400,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    lights: u32,
    /// Texels a side of every image, a power of two
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = power_of_two)]
    texels: usize,
    /// Pixels a side of each picture of a floor
    #[arg(long, value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u32).range(8..=1024))]
    picture_side: u32,
    /// Seed of lights, images and places
    #[arg(long, value_name = "S", default_value_t = 0x1A6E5)]
    seed: u64,
}

fn power_of_two(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(size @ 4..=1024) if usize::is_power_of_two(size) => Ok(size),
        _ => Err("give a power of two from 4 to 1024".to_owned()),
    }
}

impl Images {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        // Before anything slow: whether the report has a place.
        ReportFolder::check(&self.output, GENERATOR)?;
        // From here on Ctrl-C leaves past the end of the folder, which removes it.
        interrupt.watch();
        let folder = ReportFolder::create(&self.output, GENERATOR)?;
        let tables = self.fill(folder.path(), &interrupt)?;
        interrupt.check()?;
        folder.commit()?;
        let all = tables.first().and_then(|table| table.rows.first());
        for (method, (name, _)) in METHODS.iter().enumerate() {
            if let Some(row) = all {
                println!(
                    "{name:8} RMS {:5.2} %, 95th percentile {:5.2} %, {:.3} of the lookup's RMS",
                    100.0 * row.rms[method],
                    100.0 * row.percentile_95[method],
                    row.ratio(method)
                );
            }
        }
        println!("{}", self.output.join(page::INDEX).display());
        Ok(())
    }

    /// Measures and writes the report's files.
    fn fill(&self, folder: &Path, interrupt: &Interrupt) -> Result<Vec<Table>, Failure> {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let lights: Result<Vec<StudyLight>, Failure> = (0..StudyLight::COUNT)
            .map(|index| StudyLight::new(index, self.texels, &Kind::ALL, &mut rng))
            .collect();
        let lights = lights?;
        let tasks = measure::draw(&lights, self.lights, self.seed ^ 0x5EED, interrupt)?;
        let samples = {
            let progress = Progress::new("measuring");
            let report = |done, total| progress.set(done, total);
            measure::measure(&lights, &tasks, &report, interrupt)?
        };
        let tables = statistics::tables(&samples);
        let [diffuse, specular] = timing::nanoseconds(&lights, &tasks, interrupt)?;
        let figures = self.figures(folder, &tables, interrupt)?;
        let pictures = figures.iter().flat_map(|figure| figure.files.clone());
        let mut files: Vec<String> = pictures.collect();
        files.extend([page::INDEX, METRICS, "tables.md", "errors.csv"].map(str::to_owned));
        files.sort();
        files.dedup();
        let record = Record {
            generator: GENERATOR,
            version: env!("CARGO_PKG_VERSION"),
            command: format!(
                "lumigon images --lights {} --texels {} --picture-side {} --seed {} -o report",
                self.lights, self.texels, self.picture_side, self.seed
            ),
            seed: self.seed,
            lights: self.lights,
            texels: self.texels,
            methods: METHODS.map(|(name, _)| name),
            tables,
            nanoseconds: Nanoseconds { diffuse, specular },
            files,
        };
        write(folder, page::INDEX, &page::html(&record, &figures)?)?;
        write(folder, "errors.csv", &record::csv(&samples))?;
        let ratios = [diffuse, specular].map(|ns| ns.map(|n| n / ns[0]));
        let markdown = statistics::markdown(&record.tables, &ratios);
        write(folder, "tables.md", &markdown)?;
        let json = serde_json::to_string_pretty(&record)?;
        write(folder, METRICS, &(json + "\n"))?;
        Ok(record.tables)
    }

    fn figures(
        &self,
        folder: &Path,
        tables: &[Table],
        interrupt: &Interrupt,
    ) -> Result<Vec<Figure>, Failure> {
        let pictures = folder.join("pictures");
        fs::create_dir_all(&pictures).map_err(|e| format!("{}: {e}", pictures.display()))?;
        let mut figures = Vec::new();
        let charts = [
            (1, "classes", "Errors by distance and surface"),
            (4, "roughness", "Errors by roughness"),
        ];
        for (table, id, title) in charts {
            let mut files = [String::new(), String::new()];
            let size = (1600, 620);
            for (theme, file) in THEMES.iter().zip(&mut files) {
                interrupt.check()?;
                *file = format!("pictures/{id}-{}.png", theme.name);
                let image = theme.paint(size, &|area, theme| {
                    plot::bars(area, theme, &tables[table].rows)
                })?;
                save(&image, &folder.join(&*file))?;
            }
            figures.push(Figure {
                title,
                words: "Root mean square errors of the mean colour, in percent of the image’s mean.",
                files,
                width: size.0,
                height: size.1,
            });
        }
        let sections = {
            let progress = Progress::new("painting");
            let report = |done, total| progress.set(done, total);
            floor::sections(self.picture_side, self.seed, &report, interrupt)?
        };
        let facts =
            "light falls in at the top edge; below each picture its difference from cubature";
        let sheet = contact_sheet("A floor before a textured light", facts, &sections)?;
        let file = "pictures/floor.png".to_owned();
        save(&sheet, &folder.join(&file))?;
        figures.push(Figure {
            title: "A floor before a textured light",
            words: "What each method makes of the same light, and how it differs from cubature.",
            files: [file.clone(), file],
            width: sheet.width(),
            height: sheet.height(),
        });
        Ok(figures)
    }
}

fn save(image: &image::RgbImage, path: &Path) -> Result<(), Failure> {
    image
        .save(path)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(())
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), Failure> {
    let path = folder.join(name);
    fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(())
}
