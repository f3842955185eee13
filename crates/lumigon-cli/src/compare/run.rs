//! From a scene to its report.

use std::fs;
use std::path::Path;

use image::RgbImage;
use lumigon::{DiffuseMethod, SpecularMethod};
use lumigon_renderer::{
    Camera, CpuRenderer, Mesh, Pixels, ReferenceRendering, ReferenceSettings, RenderSettings, Scene,
    Watch,
};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};

use super::contact_sheet::{Cell, Section, contact_sheet, legend, thumbnail};
use super::display::Display;
use super::false_color::FalseColor;
use super::folder::{GENERATOR, METRICS, ReportFolder};
use super::machine::Machine;
use super::method::{EXACT, Method, Part, default_bias, methods};
use super::metrics::{Difference, Noise, ZScores};
use super::picture::{write_exr, write_png};
use super::record::{
    Against, MethodRecord, PartPicture, Record, ReferenceRecord, SceneRecord, SettingsRecord,
};
use super::stopwatch::Timing;
use super::quantity::{duration, percent, scene_name};
use super::{Args, CompareError, report};

/// Renders the scene by every method and writes the report. `stage` is told what comes next.
///
/// # Errors
/// Where the scene cannot be read or rendered or the report not be written; the report's folder
/// is then as it was before.
pub fn run(args: &Args, stage: &dyn Fn(&str), watch: Watch<'_>) -> Result<(), CompareError> {
    // Before anything slow: whether the report has a place.
    let folder = ReportFolder::create(&args.output)?;
    let mut scene = Scene::load(&args.scene)?;
    let camera = choose_camera(&scene, args.camera.as_deref())?;
    let bias = args.bias.unwrap_or_else(|| default_bias(&scene));
    if !(bias >= 0.0 && bias.is_finite()) {
        return Err(CompareError::Bias(bias));
    }
    let methods = methods(bias);

    stage("without polygon lights");
    let lights = std::mem::take(&mut scene.polygon_lights);
    let settings = args.render_settings(DiffuseMethod::default(), SpecularMethod::None);
    let (_, without_lights) = {
        let renderer = CpuRenderer::new(&scene)?;
        Timing::of(|| renderer.render(&camera, &settings, watch))?
    };
    scene.polygon_lights = lights;
    let renderer = CpuRenderer::new(&scene)?;

    let mut comparison = Comparison::begin(args, &folder, &renderer, &camera, stage, watch)?;
    for method in &methods {
        stage(method.title);
        comparison.measure(method)?;
    }
    stage("the report");
    let Comparison {
        references,
        records,
        z_scores,
        sections,
        mut files,
        ..
    } = comparison;
    let records = with_ratios(records, without_lights.seconds());
    let title = format!("How {} is lit, by every method", scene_name(&args.scene));
    let facts = format!(
        "{}×{}, {} camera rays a pixel; references with {} paths a pixel; {} threads of {}. \
         Below each picture: its difference from the reference without shadows.",
        args.size.0,
        args.size.1,
        args.samples,
        args.spp,
        rayon::current_num_threads(),
        Machine::this().cpu.as_deref().unwrap_or("an unnamed CPU"),
    );
    let sheet = contact_sheet(&title, &facts, &sections)?;
    write_png(&folder.path().join(report::CONTACT_SHEET), &sheet)?;
    files.extend([report::CONTACT_SHEET, report::INDEX, METRICS].map(str::to_owned));
    files.sort();

    let record = Record {
        generator: GENERATOR,
        version: env!("CARGO_PKG_VERSION"),
        scene: SceneRecord {
            path: args.scene.display().to_string(),
            triangles: scene.meshes.iter().map(|m: &Mesh| m.triangles.len()).sum(),
            polygon_lights: scene.polygon_lights.len(),
            punctual_lights: scene.punctual_lights.len(),
            warnings: scene.warnings.clone(),
        },
        settings: SettingsRecord {
            width: args.size.0,
            height: args.size.1,
            camera: camera.name.clone(),
            samples: args.samples,
            spp: args.spp,
            bounces: args.bounces,
            seed: args.seed,
            exposure: args.exposure,
            tonemap: format!("{:?}", args.tonemap).to_lowercase(),
            bias,
            pixels_per_degree: DEFAULT_PIXELS_PER_DEGREE,
        },
        machine: Machine::this(),
        seconds_without_polygon_lights: without_lights.seconds(),
        references,
        methods: records,
        exact_diffuse_z_scores: z_scores,
        files,
    };
    let scales: Vec<_> = sections.iter().map(|section| section.scale).collect();
    write(folder.path(), report::INDEX, &report::html(&record, &scales)?)?;
    let json = serde_json::to_string_pretty(&record)?;
    write(folder.path(), METRICS, &(json + "\n"))?;
    folder.commit()
}

impl Args {
    fn render_settings(&self, diffuse: DiffuseMethod, specular: SpecularMethod) -> RenderSettings {
        RenderSettings {
            width: self.size.0,
            height: self.size.1,
            samples: self.samples,
            diffuse,
            specular,
        }
    }
}

/// What is gathered while the methods are rendered one by one.
struct Comparison<'a> {
    args: &'a Args,
    folder: &'a Path,
    renderer: &'a CpuRenderer<'a>,
    camera: &'a Camera,
    watch: Watch<'a>,
    display: Display,
    /// The unshadowed reference's parts, in the order of [`Part::ALL`].
    truths: [Truth; 3],
    references: [ReferenceRecord; 2],
    records: Vec<MethodRecord>,
    z_scores: ZScores,
    sections: Vec<Section>,
    files: Vec<String>,
}

/// One part of the unshadowed reference.
struct Truth {
    pixels: Pixels,
    standard_error: Pixels,
    noise: Noise,
    scale: FalseColor,
    shown: RgbImage,
}

impl<'a> Comparison<'a> {
    /// Renders the references.
    fn begin(
        args: &'a Args,
        folder: &'a ReportFolder,
        renderer: &'a CpuRenderer<'a>,
        camera: &'a Camera,
        stage: &dyn Fn(&str),
        watch: Watch<'a>,
    ) -> Result<Self, CompareError> {
        let pictures = folder.path().join("pictures");
        fs::create_dir(&pictures).map_err(|source| CompareError::io(&pictures, source))?;
        let display = Display {
            exposure: args.exposure,
            tonemap: args.tonemap,
        };
        let reference = |shadows, bounces| {
            let settings = ReferenceSettings {
                width: args.size.0,
                height: args.size.1,
                samples: args.samples,
                paths: args.spp,
                bounces,
                shadows,
                seed: args.seed,
            };
            let start = std::time::Instant::now();
            let rendering = renderer.reference(camera, &settings, watch)?;
            Ok::<_, CompareError>((rendering, start.elapsed().as_secs_f64()))
        };
        stage("the reference without shadows");
        let (unshadowed, seconds) = reference(false, 1)?;
        let first = reference_record(&unshadowed, false, 1, seconds);
        let ReferenceRendering {
            mean,
            diffuse_error,
            specular_error,
            radiance_error,
        } = unshadowed;
        let truth = |pixels: Pixels, standard_error: Pixels| Truth {
            noise: Noise::new(&pixels, &standard_error),
            scale: FalseColor::for_reference(&pixels),
            shown: display.image(args.size, &pixels),
            pixels,
            standard_error,
        };
        let truths = [
            truth(mean.radiance(), radiance_error),
            truth(mean.diffuse, diffuse_error),
            truth(mean.specular, specular_error),
        ];
        stage("the reference with shadows");
        let (shadowed, seconds) = reference(true, args.bounces)?;
        let second = reference_record(&shadowed, true, args.bounces, seconds);

        let mut this = Self {
            args,
            folder: folder.path(),
            renderer,
            camera,
            watch,
            display,
            z_scores: ZScores::new(&[], &[], &[]),
            truths,
            references: [first, second],
            records: Vec::new(),
            sections: Vec::new(),
            files: Vec::new(),
        };
        for part in Part::ALL {
            let truth = &this.truths[part as usize];
            let cell = Cell {
                title: format!("Reference without shadows{}", part.suffix()),
                picture: thumbnail(&truth.shown),
                difference: None,
                numbers: format!("noise {}", percent(truth.noise.relative)),
            };
            let (shown, pixels) = (truth.shown.clone(), truth.pixels.clone());
            let scale = truth.scale;
            let name = format!("reference-unshadowed-{}", part.id());
            let picture = this.save(&name, &shown, &pixels)?;
            this.references[0].pictures.push(PartPicture { part, picture });
            this.sections.push(Section {
                title: part.title().to_owned(),
                scale,
                cells: vec![Some(cell)],
            });
            let bar = legend(512, 16, scale);
            let name = format!("pictures/scale-{}.png", part.id());
            write_png(&this.folder.join(&name), &bar)?;
            this.files.push(name);
        }
        let pixels = shadowed.mean.radiance();
        let (against, mut cell) =
            this.compare("reference-shadowed", Part::Radiance, &pixels)?;
        cell.title = "Reference with shadows".to_owned();
        cell.numbers = format!("shadows take {}", percent(against.difference.relative_bias.map(|b| -b)));
        this.references[1].pictures.push(PartPicture {
            part: Part::Radiance,
            picture: against.picture.clone(),
        });
        this.references[1].against_unshadowed = Some(against);
        this.sections[Part::Radiance as usize].cells.push(Some(cell));
        Ok(this)
    }

    /// Renders one method, and compares it.
    fn measure(&mut self, method: &Method) -> Result<(), CompareError> {
        let settings = self.args.render_settings(method.diffuse, method.specular);
        let (rendering, timing) =
            Timing::of(|| self.renderer.render(self.camera, &settings, self.watch))?;
        let pixels = method.part.of(rendering);
        if method.id == EXACT {
            let truth = &self.truths[method.part as usize];
            self.z_scores = ZScores::new(&pixels, &truth.pixels, &truth.standard_error);
        }
        let (against, mut cell) = self.compare(method.id, method.part, &pixels)?;
        cell.title = method.title.to_owned();
        cell.numbers = format!(
            "RMSE {} · FLIP {:.3} · {}",
            percent(against.difference.relative_rmse),
            against.flip,
            duration(timing.seconds()),
        );
        let cells = &mut self.sections[method.part as usize].cells;
        // The first column is the references'.
        if cells.len().is_multiple_of(5) {
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
            seconds: timing.seconds(),
            seconds_range: timing.range(),
            repeats: timing.repeats(),
            ratio_to_exact: 1.0,
            lighting_ratio_to_exact: None,
        });
        Ok(())
    }

    /// Writes a picture and its difference from the reference's part, and measures it.
    fn compare(
        &mut self,
        id: &str,
        part: Part,
        pixels: &[[f32; 3]],
    ) -> Result<(Against, Cell), CompareError> {
        let truth = &self.truths[part as usize];
        let size = self.args.size;
        let shown = self.display.image(size, pixels);
        let colored = truth.scale.image(size, pixels, &truth.pixels);
        let difference = Difference::new(pixels, &truth.pixels, truth.noise);
        let flip = mean_flip(&truth.shown, &shown);
        let signed: Pixels = pixels
            .iter()
            .zip(&truth.pixels)
            .map(|(p, r)| std::array::from_fn(|i| p[i] - r[i]))
            .collect();
        let cell = Cell {
            title: String::new(),
            picture: thumbnail(&shown),
            difference: Some(thumbnail(&colored)),
            numbers: String::new(),
        };
        let against = Against {
            picture: self.save(id, &shown, pixels)?,
            difference_picture: self.save(&format!("{id}-difference"), &colored, &signed)?,
            difference,
            flip,
        };
        Ok((against, cell))
    }

    /// Writes a picture as PNG and EXR; the PNG's path.
    fn save(
        &mut self,
        name: &str,
        shown: &RgbImage,
        pixels: &[[f32; 3]],
    ) -> Result<String, CompareError> {
        let png = format!("pictures/{name}.png");
        let exr = format!("pictures/{name}.exr");
        write_png(&self.folder.join(&png), shown)?;
        write_exr(&self.folder.join(&exr), self.args.size, pixels)?;
        self.files.extend([png.clone(), exr]);
        Ok(png)
    }
}

fn reference_record(
    rendering: &ReferenceRendering,
    shadows: bool,
    bounces: u32,
    seconds: f64,
) -> ReferenceRecord {
    let (id, title) = if shadows {
        ("reference-shadowed", "Reference with shadows")
    } else {
        ("reference-unshadowed", "Reference without shadows")
    };
    let mean = &rendering.mean;
    ReferenceRecord {
        id,
        title,
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

/// Compares every method's time with the exact one's.
fn with_ratios(mut records: Vec<MethodRecord>, without_lights: f64) -> Vec<MethodRecord> {
    let exact = records.iter().find(|record| record.id == EXACT);
    let Some(exact) = exact.map(|record| record.seconds) else {
        return records;
    };
    let lighting = exact - without_lights;
    for record in &mut records {
        record.ratio_to_exact = record.seconds / exact;
        record.lighting_ratio_to_exact =
            (lighting > 0.0).then(|| (record.seconds - without_lights) / lighting);
    }
    records
}

/// Mean FLIP of two sRGB pictures of one size, at the viewing distance that FLIP assumes.
fn mean_flip(reference: &RgbImage, picture: &RgbImage) -> f64 {
    let (width, height) = reference.dimensions();
    let read = |image: &RgbImage| FlipImageRgb8::with_data(width, height, image.as_raw());
    let errors = nv_flip::flip(read(reference), read(picture), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    errors.iter().copied().map(f64::from).sum::<f64>() / errors.len().max(1) as f64
}

/// The camera of this name or index; without a wish the first, or one that frames the scene.
fn choose_camera(scene: &Scene, wanted: Option<&str>) -> Result<Camera, CompareError> {
    let Some(wanted) = wanted else {
        let first = scene.cameras.first().cloned();
        return Ok(first.unwrap_or_else(|| Camera::framing(scene)));
    };
    let named = scene.cameras.iter().find(|camera| camera.name == wanted);
    let numbered = || scene.cameras.get(wanted.parse::<usize>().ok()?);
    named.or_else(numbered).cloned().ok_or_else(|| {
        let names = scene.cameras.iter().enumerate();
        let names: Vec<_> = names.map(|(i, c)| format!("{i} \"{}\"", c.name)).collect();
        CompareError::Camera {
            wanted: wanted.to_owned(),
            offered: if names.is_empty() {
                "the scene has none; leave --camera out to frame all of it".to_owned()
            } else {
                format!("give one of {}", names.join(", "))
            },
        }
    })
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), CompareError> {
    let path = folder.join(name);
    fs::write(&path, text).map_err(|source| CompareError::io(&path, source))
}
