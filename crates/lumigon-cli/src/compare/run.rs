//! From a scene to its report's files.

use std::fs;
use std::path::Path;
use std::time::Instant;

use image::RgbImage;
use lumigon::SpecularMethod;
use lumigon_renderer::{
    Camera, EmissivePolygon, Pixels, ReferenceRendering, ReferenceSettings, RenderError,
    RenderSettings, Scene, Watch, srgb8, write_exr,
};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};

use super::contact_sheet::{COLUMNS, Cell, Section, contact_sheet, legend, thumbnail};
use super::error::CompareError;
use super::false_color::FalseColor;
use super::machine::Machine;
use super::method::{EXACT, Method, Part, default_bias, methods};
use super::metrics::{Difference, Noise, ZScores};
use super::quantity::{duration, percent, scene_name};
use super::record::{
    Against, MethodRecord, PartPicture, Record, ReferenceRecord, SceneRecord, SettingsRecord,
};
use super::stopwatch::Stopwatch;
use super::{Compare, bounce, report};
use crate::gpu::Backend;
use crate::interrupt::Interrupt;
use crate::progress::Progress;
use crate::report_folder::{METRICS, ReportFolder};

/// What [`METRICS`] says of its maker.
pub(super) const GENERATOR: &str = "lumigon compare";

/// Renders the scene by every method and writes the report's files into the folder.
///
/// # Errors
/// Where the scene cannot be rendered or a file not be written, or when interrupted.
pub(super) fn fill(
    command: &Compare,
    folder: &ReportFolder,
    mut scene: Scene,
    camera: &Camera,
    interrupt: &Interrupt,
) -> Result<(), CompareError> {
    let bias = command.bias.unwrap_or_else(|| default_bias(&scene));
    let shows = |light: &&EmissivePolygon| light.image.is_some();
    let light_images = scene.polygon_lights.iter().filter(shows).count();
    let methods = methods(bias, light_images > 0);
    let lights = std::mem::take(&mut scene.polygon_lights);
    let unlit = scene.clone();
    scene.polygon_lights = lights;
    let session = Session {
        command,
        folder: folder.path(),
        renderer: Backend::new(command.backend, &scene)?,
        unlit_renderer: Backend::new(command.backend, &unlit)?,
        camera,
        interrupt,
    };

    for warning in session.renderer.warnings() {
        eprintln!("warning: {warning}");
    }
    let mut comparison = Comparison::begin(&session)?;
    let mut stopwatches = vec![Stopwatch::default(); methods.len()];
    for (method, stopwatch) in methods.iter().zip(&mut stopwatches) {
        comparison.measure(method, stopwatch)?;
    }
    let without_lights = session.repeat(&methods, &mut stopwatches)?;
    let (bounce, bounce_sections) = match command.bounce.is_wanted() {
        true => {
            let (record, sections) = bounce::compare(&session, &mut comparison.files)?;
            (Some(record), sections)
        }
        false => (None, Vec::new()),
    };

    let Comparison {
        references,
        z_scores,
        sections,
        mut files,
        ..
    } = comparison;
    let records = comparison.records.into_iter().zip(&stopwatches);
    let records = timed(records, without_lights.seconds());
    let machine = Machine::this(session.renderer.describe());
    let sheet = contact_sheet(
        &format!(
            "{}: every method beside the truth",
            scene_name(&command.scene)
        ),
        &facts(command, &machine),
        &[
            with_numbers(sections, &records).as_slice(),
            &bounce_sections,
        ]
        .concat(),
    )?;
    write_png(session.folder, report::CONTACT_SHEET, &sheet)?;
    files.extend([report::CONTACT_SHEET, report::INDEX, METRICS].map(str::to_owned));
    files.sort();

    let record = Record {
        generator: GENERATOR,
        version: env!("CARGO_PKG_VERSION"),
        scene: SceneRecord {
            path: command.scene.display().to_string(),
            triangles: scene.meshes.iter().map(|m| m.triangles.len()).sum(),
            polygon_lights: scene.polygon_lights.len(),
            light_images,
            punctual_lights: scene.punctual_lights.len(),
            warnings: scene.warnings.clone(),
        },
        settings: SettingsRecord {
            width: command.size.width,
            height: command.size.height,
            camera: camera.name.clone(),
            samples: command.samples,
            spp: command.spp,
            bounces: command.bounces,
            seed: command.seed,
            exposure: command.exposure,
            tonemap: command.tonemap.name(),
            bias,
            pixels_per_degree: DEFAULT_PIXELS_PER_DEGREE,
        },
        machine,
        seconds_without_polygon_lights: without_lights.seconds(),
        references,
        methods: records,
        bounce,
        exact_diffuse_z_scores: z_scores,
        files,
    };
    let scales = comparison.truths.each_ref().map(|truth| truth.scale);
    write(
        session.folder,
        report::INDEX,
        &report::html(&record, scales)?,
    )?;
    let json = serde_json::to_string_pretty(&record)?;
    write(session.folder, METRICS, &(json + "\n"))
}

/// What every rendering shares.
pub(super) struct Session<'a> {
    pub(super) command: &'a Compare,
    folder: &'a Path,
    pub(super) renderer: Backend<'a>,
    /// Of the same scene without its polygon lights.
    unlit_renderer: Backend<'a>,
    pub(super) camera: &'a Camera,
    pub(super) interrupt: &'a Interrupt,
}

impl Session<'_> {
    pub(super) fn watched<T>(
        &self,
        what: &'static str,
        render: impl FnOnce(Watch<'_>) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let progress = Progress::new(what);
        render(Watch {
            progress: &|done, total| progress.set(done, total),
            cancelled: self.interrupt.flag(),
        })
    }

    fn settings(&self, method: &Method) -> RenderSettings {
        RenderSettings {
            diffuse: method.diffuse,
            specular: method.specular,
            image_method: method.images,
            ..self.unlit_settings()
        }
    }

    /// Without lights nothing is diffuse or specular; the picture is as large.
    pub(super) fn unlit_settings(&self) -> RenderSettings {
        RenderSettings {
            width: self.command.size.width,
            height: self.command.size.height,
            samples: self.command.samples,
            specular: SpecularMethod::None,
            ..RenderSettings::default()
        }
    }

    /// A path-traced picture, and how long it took.
    fn reference(
        &self,
        shadows: bool,
        bounces: u32,
    ) -> Result<(ReferenceRendering, f64), RenderError> {
        let settings = ReferenceSettings {
            width: self.command.size.width,
            height: self.command.size.height,
            samples: self.command.samples,
            paths: self.command.spp,
            bounces,
            shadows,
            seed: self.command.seed,
            ..ReferenceSettings::default()
        };
        let start = Instant::now();
        let rendering = self.watched(Reference::title(shadows), |watch| {
            self.renderer.cpu().reference(self.camera, &settings, watch)
        })?;
        Ok((rendering, start.elapsed().as_secs_f64()))
    }

    /// Renders the methods in turns until each has been timed often or long enough; the time
    /// without polygon lights.
    fn repeat(
        &self,
        methods: &[Method],
        stopwatches: &mut [Stopwatch],
    ) -> Result<Stopwatch, RenderError> {
        let progress = Progress::new("timing");
        let watch = Watch {
            progress: &|_, _| {},
            cancelled: self.interrupt.flag(),
        };
        let unlit_settings = self.unlit_settings();
        let mut unlit = Stopwatch::default();
        let mut round = 0;
        while unlit.wants_more() || stopwatches.iter().any(Stopwatch::wants_more) {
            if unlit.wants_more() {
                unlit.measure(|| {
                    self.unlit_renderer
                        .render(self.camera, &unlit_settings, watch)
                })?;
            }
            for (method, stopwatch) in methods.iter().zip(&mut *stopwatches) {
                if stopwatch.wants_more() {
                    let settings = self.settings(method);
                    stopwatch.measure(|| self.renderer.render(self.camera, &settings, watch))?;
                }
            }
            round += 1;
            progress.set(round, Stopwatch::REPEATS as u64);
        }
        Ok(unlit)
    }
}

/// What is gathered while the methods are rendered one by one.
struct Comparison<'a> {
    session: &'a Session<'a>,
    /// The unshadowed reference's parts, in the order of [`Part::ALL`].
    truths: [Truth; 3],
    references: [ReferenceRecord; 2],
    records: Vec<MethodRecord>,
    z_scores: ZScores,
    sections: [Section; 3],
    files: Vec<String>,
}

/// One part of a reference.
pub(super) struct Truth {
    pub(super) pixels: Pixels,
    standard_error: Pixels,
    pub(super) noise: Noise,
    pub(super) scale: FalseColor,
    pub(super) shown: RgbImage,
}

impl<'a> Comparison<'a> {
    /// Renders the references.
    fn begin(session: &'a Session<'a>) -> Result<Self, CompareError> {
        let pictures = session.folder.join("pictures");
        fs::create_dir(&pictures).map_err(|source| CompareError::io(&pictures, source))?;
        let (unshadowed, seconds) = session.reference(false, 1)?;
        let mut first = Reference::record(&unshadowed, false, 1, seconds);
        let truths = session.truths(unshadowed);
        let mut files = Vec::new();
        for (part, truth) in Part::ALL.into_iter().zip(&truths) {
            let name = format!("{}-{}", first.id, part.id());
            let picture = session.save(&mut files, &name, &truth.shown, &truth.pixels)?;
            first.pictures.push(PartPicture { part, picture });
            session.save_scale(&mut files, part.id(), truth.scale)?;
        }
        let bounces = session.command.bounces;
        let (shadowed, seconds) = session.reference(true, bounces)?;
        let second = Reference::record(&shadowed, true, bounces, seconds);
        let sections = Part::ALL.map(|part| section(part, &truths[part as usize]));
        let mut this = Self {
            session,
            truths,
            references: [first, second],
            records: Vec::new(),
            z_scores: ZScores::new(&[], &[], &[]),
            sections,
            files,
        };
        let pixels = shadowed.mean.radiance();
        let (against, mut cell) = this.compare(this.references[1].id, Part::Radiance, &pixels)?;
        let darker = against.difference.relative_bias.map(|bias| -bias);
        cell.title = this.references[1].title.to_owned();
        cell.numbers = format!("{} darker than without", percent(darker));
        this.sections[0].cells.push(Some(cell));
        this.references[1].pictures.push(PartPicture {
            part: Part::Radiance,
            picture: against.picture.clone(),
        });
        this.references[1].against_unshadowed = Some(against);
        Ok(this)
    }

    /// Renders one method, and compares it.
    fn measure(&mut self, method: &Method, stopwatch: &mut Stopwatch) -> Result<(), CompareError> {
        let session = self.session;
        let settings = session.settings(method);
        let rendering = session.watched(method.title, |watch| {
            stopwatch.measure(|| session.renderer.render(session.camera, &settings, watch))
        })?;
        let pixels = method.part.of(rendering);
        if method.id == EXACT {
            let truth = &self.truths[method.part as usize];
            self.z_scores = ZScores::new(&pixels, &truth.pixels, &truth.standard_error);
        }
        let (against, mut cell) = self.compare(method.id, method.part, &pixels)?;
        cell.title = method.title.to_owned();
        let cells = &mut self.sections[method.part as usize].cells;
        // The first column is the references'.
        if cells.len().is_multiple_of(COLUMNS as usize) {
            cells.push(None);
        }
        cells.push(Some(cell));
        self.records.push(MethodRecord {
            id: method.id,
            title: method.title,
            part: method.part,
            diffuse: format!("{:?}", method.diffuse),
            specular: format!("{:?}", method.specular),
            words: method.words,
            source: method.source,
            against,
            seconds: 0.0,
            seconds_range: [0.0; 2],
            repeats: 0,
            ratio_to_exact: None,
            lighting_ratio_to_exact: None,
        });
        Ok(())
    }

    /// Writes a picture and its difference from the reference's part, and measures it.
    fn compare(
        &mut self,
        id: &'static str,
        part: Part,
        pixels: &[[f32; 3]],
    ) -> Result<(Against, Cell), CompareError> {
        let truth = &self.truths[part as usize];
        self.session.against(&mut self.files, truth, id, pixels)
    }
}

impl Session<'_> {
    fn shown(&self, pixels: &[[f32; 3]]) -> RgbImage {
        let bytes = srgb8(pixels, self.command.exposure, self.command.tonemap);
        let size = self.command.size;
        let mut bytes = bytes.into_iter();
        let mut image = RgbImage::new(size.width, size.height);
        image
            .iter_mut()
            .zip(&mut bytes)
            .for_each(|(to, from)| *to = from);
        image
    }

    /// Writes a picture and its difference from a reference, and measures it.
    pub(super) fn against(
        &self,
        files: &mut Vec<String>,
        truth: &Truth,
        id: &'static str,
        pixels: &[[f32; 3]],
    ) -> Result<(Against, Cell), CompareError> {
        let shown = self.shown(pixels);
        let colored = truth.scale.image(shown.dimensions(), pixels, &truth.pixels);
        let signed: Pixels = pixels
            .iter()
            .zip(&truth.pixels)
            .map(|(p, r)| std::array::from_fn(|i| p[i] - r[i]))
            .collect();
        let cell = Cell {
            id,
            title: String::new(),
            picture: thumbnail(&shown),
            difference: Some(thumbnail(&colored)),
            numbers: String::new(),
        };
        let difference_name = format!("{id}-difference");
        let against = Against {
            picture: self.save(files, id, &shown, pixels)?,
            difference_picture: self.save(files, &difference_name, &colored, &signed)?,
            difference: Difference::new(pixels, &truth.pixels, truth.noise),
            flip: mean_flip(&truth.shown, &shown),
        };
        Ok((against, cell))
    }

    /// Writes the bar of a scale.
    pub(super) fn save_scale(
        &self,
        files: &mut Vec<String>,
        id: &str,
        scale: FalseColor,
    ) -> Result<(), CompareError> {
        let name = format!("pictures/scale-{id}.png");
        write_png(self.folder, &name, &legend(512, 16, scale))?;
        files.push(name);
        Ok(())
    }

    /// Pixels as something to compare with.
    pub(super) fn truth(&self, pixels: Pixels, standard_error: Pixels) -> Truth {
        Truth {
            noise: Noise::new(&pixels, &standard_error),
            scale: FalseColor::for_reference(&pixels),
            shown: self.shown(&pixels),
            pixels,
            standard_error,
        }
    }

    fn truths(&self, reference: ReferenceRendering) -> [Truth; 3] {
        let mean = reference.mean;
        let parts = [
            (mean.radiance(), reference.radiance_error),
            (mean.diffuse, reference.diffuse_error),
            (mean.specular, reference.specular_error),
        ];
        parts.map(|(pixels, standard_error)| self.truth(pixels, standard_error))
    }

    /// Writes a picture as PNG and EXR; the PNG's path.
    pub(super) fn save(
        &self,
        files: &mut Vec<String>,
        name: &str,
        shown: &RgbImage,
        pixels: &[[f32; 3]],
    ) -> Result<String, CompareError> {
        let png = format!("pictures/{name}.png");
        let exr = format!("pictures/{name}.exr");
        let (width, height) = shown.dimensions();
        write_png(self.folder, &png, shown)?;
        write_exr(&self.folder.join(&exr), width, height, pixels)?;
        files.extend([png.clone(), exr]);
        Ok(png)
    }
}

struct Reference;

impl Reference {
    fn title(shadows: bool) -> &'static str {
        if shadows {
            "Reference with shadows"
        } else {
            "Reference without shadows"
        }
    }

    fn record(
        rendering: &ReferenceRendering,
        shadows: bool,
        bounces: u32,
        seconds: f64,
    ) -> ReferenceRecord {
        let mean = &rendering.mean;
        ReferenceRecord {
            id: if shadows {
                "reference-shadowed"
            } else {
                "reference-unshadowed"
            },
            title: Self::title(shadows),
            shadows,
            bounces,
            seconds,
            radiance_noise: Noise::new(&mean.radiance(), &rendering.radiance_error),
            diffuse_noise: Noise::new(&mean.diffuse, &rendering.diffuse_error),
            specular_noise: Noise::new(&mean.specular, &rendering.specular_error),
            pictures: Vec::new(),
            against_unshadowed: None,
        }
    }
}

/// A section that begins with its reference.
fn section(part: Part, truth: &Truth) -> Section {
    let cell = Cell {
        id: part.id(),
        title: format!("Reference{}", part.suffix()),
        picture: thumbnail(&truth.shown),
        difference: None,
        numbers: format!("noise {} of its mean", percent(truth.noise.relative)),
    };
    Section {
        title: part.title().to_owned(),
        scale: truth.scale,
        cells: vec![Some(cell)],
    }
}

/// The records with their times.
fn timed<'a>(
    records: impl Iterator<Item = (MethodRecord, &'a Stopwatch)>,
    without_lights: f64,
) -> Vec<MethodRecord> {
    let mut records: Vec<_> = records
        .map(|(record, stopwatch)| MethodRecord {
            seconds: stopwatch.seconds(),
            seconds_range: stopwatch.range(),
            repeats: stopwatch.repeats(),
            ..record
        })
        .collect();
    let exact = records.iter().find(|record| record.id == EXACT);
    let exact = exact.map_or(0.0, |record| record.seconds);
    let lighting = exact - without_lights;
    for record in &mut records {
        record.ratio_to_exact = (exact > 0.0).then(|| record.seconds / exact);
        record.lighting_ratio_to_exact =
            (lighting > 0.0).then(|| (record.seconds - without_lights) / lighting);
    }
    records
}

/// The sections with the methods' numbers in their cells.
fn with_numbers(sections: [Section; 3], records: &[MethodRecord]) -> [Section; 3] {
    sections.map(|mut section| {
        for cell in section.cells.iter_mut().flatten() {
            if let Some(record) = records.iter().find(|record| record.id == cell.id) {
                cell.numbers = format!(
                    "RMSE {} · FLIP {:.3} · {}",
                    percent(record.against.difference.relative_rmse),
                    record.against.flip,
                    duration(record.seconds),
                );
            }
        }
        section
    })
}

fn facts(command: &Compare, machine: &Machine) -> String {
    format!(
        "{}, {} camera rays a pixel; references with {} paths a pixel; {} threads of {}; methods {}. \
         Below each picture: its difference from the reference without shadows, relative RMSE, \
         FLIP, time.",
        command.size,
        command.samples,
        command.spp,
        machine.threads,
        machine.cpu.as_deref().unwrap_or("an unnamed CPU"),
        machine.methods,
    )
}

/// Mean FLIP of two sRGB pictures of one size, at the viewing distance that FLIP assumes.
fn mean_flip(reference: &RgbImage, picture: &RgbImage) -> f64 {
    let (width, height) = reference.dimensions();
    let read = |image: &RgbImage| FlipImageRgb8::with_data(width, height, image.as_raw());
    let errors = nv_flip::flip(read(reference), read(picture), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    errors.iter().copied().map(f64::from).sum::<f64>() / errors.len().max(1) as f64
}

fn write_png(folder: &Path, name: &str, picture: &RgbImage) -> Result<(), CompareError> {
    let path = folder.join(name);
    picture
        .save(&path)
        .map_err(|source| CompareError::Png { path, source })
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), CompareError> {
    let path = folder.join(name);
    fs::write(&path, text).map_err(|source| CompareError::io(&path, source))
}
