//! `lumigon bounce`: how far virtual lights are from path-traced bounce light, what they cost, and how
//! they flicker.

mod cost;
mod difference;
mod errors;
mod figure;
mod flicker;
mod many_lights;
mod page;
mod plot;
mod record;
mod table;
mod variant;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use lumigon_renderer::{RenderError, Scene};

use crate::Failure;
use crate::camera::choose_camera;
use crate::compare::machine::Machine;
use crate::compare::quantity::scene_name;
use crate::gpu::BackendChoice;
use crate::interrupt::Interrupt;
use crate::report_folder::{METRICS, ReportFolder};
use crate::size::Size;
use errors::StudyScene;
use flicker::Moving;
use record::{Record, SceneRecord};
use table::Over;

/// What `metrics.json` says of its maker.
const GENERATOR: &str = "lumigon bounce";

/// Reports how far virtual lights are from path-traced bounce light, what they cost, how they flicker
#[derive(Debug, Args)]
#[command(after_help = "\
The folder gets
  index.html    a report that opens from disk
  metrics.json  all of its numbers
  tables.md     its tables as Markdown
  errors.csv    every picture's errors
  pictures/     its figures

Examples:
  lumigon bounce scenes/cornell.glb scenes/room.glb scenes/two-rooms.glb -o report
  lumigon bounce scene.glb -o report --quick")]
pub struct BounceStudy {
    /// glTF files, .gltf or .glb
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Folder for the report: new, empty, or an earlier report, which is replaced
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Width and height of the pictures in pixels [default: 128x96, with --quick 24x18]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Light paths a pixel of the path-traced references [default: 1024, with --quick 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    spp: Option<u32>,
    /// Frames whose changes are measured [default: 24, with --quick 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=10_000))]
    frames: Option<u32>,
    /// Virtual lights that are traced, at most: rays take long [default: 1024]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    most_traced: Option<u32>,
    /// What makes virtual lights and lights by them; references are always the CPU's
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = BackendChoice::Cpu)]
    backend: BackendChoice,
    /// Fewer and smaller pictures: seconds instead of minutes
    #[arg(long)]
    quick: bool,
    /// Seed of the references' random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
}

/// What is varied, each while the other is what it is by default.
struct Sweep {
    /// Virtual lights at most.
    counts: &'static [u32],
    /// Texels across a face.
    sizes: &'static [u32],
    /// The default number,
    count: u32,
    /// and the default size: one of each.
    size: u32,
}

impl BounceStudy {
    fn size(&self) -> Size {
        let (width, height) = if self.quick { (24, 18) } else { (128, 96) };
        self.size.unwrap_or(Size { width, height })
    }

    fn spp(&self) -> u32 {
        self.spp.unwrap_or(if self.quick { 64 } else { 1024 })
    }

    fn frames(&self) -> u32 {
        self.frames.unwrap_or(if self.quick { 3 } else { 24 })
    }

    fn most_traced(&self) -> u32 {
        self.most_traced.unwrap_or(1024)
    }

    fn sweep(&self) -> Sweep {
        match self.quick {
            true => Sweep {
                counts: &[16, 64],
                sizes: &[8, 16],
                count: 64,
                size: 16,
            },
            false => Sweep {
                counts: &[64, 256, 1024, 4096, 16_384],
                sizes: &[16, 32, 64, 128, 256],
                count: 1024,
                size: 64,
            },
        }
    }

    fn light_counts(&self) -> &'static [usize] {
        match self.quick {
            true => &[1, 10],
            false => &[1, 3, 10, 30, 100, 300, 1000],
        }
    }

    /// Texels across a face where cost is measured.
    fn cost_size(&self) -> u32 {
        if self.quick { 8 } else { 32 }
    }

    /// What makes the report again.
    fn again(&self) -> String {
        let mut words = vec!["lumigon bounce".to_owned()];
        words.extend(self.scenes.iter().map(|scene| scene.display().to_string()));
        words.extend([
            format!("--size {} --spp {}", self.size(), self.spp()),
            format!("--frames {}", self.frames()),
            format!("--most-traced {} --seed {}", self.most_traced(), self.seed),
        ]);
        match self.backend {
            BackendChoice::Cpu => {}
            BackendChoice::Gpu => words.push("--backend gpu".to_owned()),
            BackendChoice::Auto => words.push("--backend auto".to_owned()),
        }
        if self.quick {
            words.push("--quick".to_owned());
        }
        words.join(" ") + " -o report"
    }

    pub(crate) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        // Before anything slow: whether the report has a place.
        ReportFolder::check(&self.output, GENERATOR)?;
        let mut scenes: Vec<StudyScene> = Vec::new();
        for path in &self.scenes {
            let scene = Scene::load(path)?;
            for warning in &scene.warnings {
                eprintln!("warning: {}: {warning}", path.display());
            }
            let name = scene_name(path);
            let equal = scenes.iter().filter(|other| other.name == name).count();
            scenes.push(StudyScene {
                name: match equal {
                    0 => name,
                    _ => path.display().to_string(),
                },
                camera: choose_camera(&scene, path, None)?,
                scene,
            });
        }
        // From here on Ctrl-C leaves past the end of the folder, which removes it.
        interrupt.watch();
        let folder = ReportFolder::create(&self.output, GENERATOR)?;
        let study = Study {
            command: self,
            folder: folder.path(),
            interrupt: &interrupt,
        };
        study.fill(&scenes)?;
        interrupt.check()?;
        folder.commit()?;
        println!("{}", self.output.join(page::INDEX).display());
        Ok(())
    }
}

/// A report on its way.
struct Study<'a> {
    command: &'a BounceStudy,
    folder: &'a Path,
    interrupt: &'a Interrupt,
}

impl Study<'_> {
    /// Measures, and writes the report's files.
    fn fill(&self, scenes: &[StudyScene]) -> Result<(), Failure> {
        let sweep = self.command.sweep();
        let (mut rows, mut frames) = (Vec::new(), Vec::new());
        let (mut records, mut warnings) = (Vec::new(), Vec::new());
        let mut sections = Vec::new();
        for (scene, path) in scenes.iter().zip(&self.command.scenes) {
            let errors = self.errors(scene)?;
            sections.extend(self.sections(scene, &errors));
            frames.extend(self.flicker(scene)?);
            records.push(SceneRecord {
                name: scene.name.clone(),
                path: path.display().to_string(),
                triangles: scene.scene.meshes.iter().map(|m| m.triangles.len()).sum(),
                lights: scene.scene.polygon_lights.len() + scene.scene.punctual_lights.len(),
                noise: errors.truths.each_ref().map(difference::Truth::noise),
            });
            let of_scene = errors.warnings.into_iter();
            warnings.extend(of_scene.map(|warning| format!("{}: {warning}", scene.name)));
            rows.extend(errors.rows);
        }
        let (cost, described) = self.cost()?;
        for warning in &warnings {
            eprintln!("warning: {warning}");
        }
        let fixed = [sweep.count, sweep.size];
        let mut tables = Vec::new();
        for StudyScene { name, .. } in scenes {
            tables.push(table::errors(name, &rows, Over::VirtualLights, fixed));
            tables.push(table::errors(name, &rows, Over::CubeSize, fixed));
            tables.push(table::details(name, &rows, fixed));
        }
        tables.push(table::cost(&cost));
        tables.extend([Moving::Camera, Moving::Light].map(|m| table::flicker(&frames, m)));
        let figures = self.figures(scenes, &rows, &cost, &sections)?;
        let pictures = figures.iter().flat_map(|figure| figure.files.clone());
        let mut files: Vec<String> = pictures.collect();
        files.extend([page::INDEX, METRICS, "tables.md", "errors.csv"].map(str::to_owned));
        files.sort();
        files.dedup();
        let record = Record {
            generator: GENERATOR,
            version: env!("CARGO_PKG_VERSION"),
            command: self.command.again(),
            machine: Machine::this(described),
            scenes: records,
            errors: rows,
            cost,
            flicker: frames,
            warnings,
            files,
        };
        self.write(page::INDEX, &page::html(&record, &tables, &figures)?)?;
        self.write("errors.csv", &errors::csv(&record.errors))?;
        self.write("tables.md", &table::markdown(&tables))?;
        let json = serde_json::to_string_pretty(&record)?;
        self.write(METRICS, &(json + "\n"))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.folder.join(name);
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(())
    }
}

/// What was rendered, or why not.
fn rendered<T>(result: Result<T, RenderError>) -> Result<T, Failure> {
    match result {
        Err(RenderError::Cancelled) => Err(Failure::Interrupted),
        other => Ok(other?),
    }
}
