//! `lumigon render`: a picture of a scene.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use lumigon::{
    DiffuseMethod, DistanceFieldError, DistanceFieldSettings, DistanceFieldSmoothness, LtcLobes,
    SpecularMethod,
};
use lumigon_renderer::{
    BounceSettings, Camera, CpuRenderer, Limits, PictureFormat, Pixels, ReferenceSettings,
    RenderError, RenderSettings, Rendering, Scene, ToneMap, Watch, check_writable, read_image,
    write_exr, write_png,
};

use crate::Failure;
use crate::bounce_light::{Bounce, BounceLight};
use crate::camera::choose_camera;
use crate::gpu::{Backend, BackendChoice};
use crate::interrupt::Interrupt;
use crate::method::{Basis, Diffuse, Images, Inclusion, Occlusion, Specular};
use crate::progress::Progress;
use crate::size::Size;

/// Renders a glTF scene, lit by its emissive polygons
#[derive(Debug, Args)]
#[command(after_help = "\
Without --reference the picture is computed in closed form: exact, without noise and without
shadows, on a GPU where there is one (`lumigon gpu info`); --bounce adds what surfaces reflect. With it the same pixels are path traced,
always on the CPU.

Examples:
  lumigon render scene.glb -o scene.png
  lumigon render scene.glb -o scene.exr --size 1920x1080 --samples 16
  lumigon render scene.glb -o area.png --diffuse projected-area --basis weighted --specular none
  lumigon render scene.glb -o scene.png --light-image screen=frame.exr --image-method 4x4
  lumigon render scene.glb -o scene.png --backend cpu
  lumigon render scene.glb -o bounced.png --bounce 1 --bounce-visibility traced --bounce-shadows
  lumigon render scene.glb -o lights.png --bounce 1 --show-virtual-lights
  lumigon render scene.glb -o truth.exr --reference --spp 1024 --bounces 3
  lumigon render scene.glb -o bounce.exr --reference --bounces 2 --indirect")]
pub struct Render {
    /// glTF file, .gltf or .glb
    scene: PathBuf,
    /// Picture to write: .png (sRGB, 8 bits) or .exr (linear radiance in float channels R, G, B)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value_t = default_size())]
    size: Size,
    /// Camera rays a pixel: 1 through its centre, more stratified
    #[arg(long, value_name = "N", default_value_t = RenderSettings::default().samples,
        value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Camera by name or by number from 0 [default: the first; one that sees everything where the
    /// file has none]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    #[command(flatten)]
    pictures: Pictures,
    #[command(flatten)]
    display: Display,
    #[command(flatten)]
    method: Method,
    #[command(flatten)]
    bounce: BounceLight,
    /// Draw the virtual lights themselves over dark surfaces, to see what they are
    #[arg(long, help_heading = "Bounce light", conflicts_with = "bounce_only")]
    show_virtual_lights: bool,
    #[command(flatten)]
    reference: Reference,
}

/// What lights show.
#[derive(Debug, Args)]
#[command(next_help_heading = "Pictures on lights")]
struct Pictures {
    /// Show an image (.png, .jpg, .hdr or .exr) on the lights of a mesh or node, as often as there are
    /// lights to name
    #[arg(long, value_name = "LIGHT=FILE", value_parser = light_image)]
    light_image: Vec<(String, PathBuf)>,
    /// Memory that the prefiltered pictures of all lights may take [default: 1024]
    #[arg(long, value_name = "MIB")]
    image_budget: Option<u32>,
}

impl Pictures {
    fn limits(&self) -> Limits {
        let mut limits = Limits::default();
        if let Some(budget) = self.image_budget {
            limits.light_image_bytes = u64::from(budget) << 20;
        }
        limits
    }

    /// Shows the images that were asked for.
    fn show(&self, scene: &mut Scene) -> Result<(), Failure> {
        let limits = self.limits();
        for (light, file) in &self.light_image {
            let image = read_image(file, &limits)?;
            scene.replace_light_image(light, &image, &limits)?;
        }
        Ok(())
    }
}

fn light_image(text: &str) -> Result<(String, PathBuf), String> {
    match text.rsplit_once('=') {
        Some((light, file)) if !light.is_empty() && !file.is_empty() => {
            Ok((light.to_owned(), PathBuf::from(file)))
        }
        _ => Err("give the light's name, =, and the image's file".to_owned()),
    }
}

/// How radiance becomes colour in a PNG.
#[derive(Debug, Args)]
#[command(next_help_heading = "PNG")]
struct Display {
    /// Exposure in stops: radiance is multiplied by 2^EV [default: 0]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = exposure)]
    exposure: Option<f32>,
    /// Tone mapping: how radiance beyond a display's white is shown [default: khronos-pbr-neutral]
    #[arg(long, value_name = "NAME", value_parser = tone_map())]
    tonemap: Option<ToneMap>,
}

/// How light is computed in closed form.
#[derive(Debug, Args)]
#[command(next_help_heading = "Closed form")]
struct Method {
    /// How diffuse light is computed [default: exact]
    #[arg(long, value_enum, conflicts_with = "reference", value_name = "METHOD")]
    diffuse: Option<Diffuse>,
    /// Axis of --diffuse projected-area [default: optimal]
    #[arg(long, value_enum, requires = "diffuse")]
    basis: Option<Basis>,
    /// How far behind the point --basis biased starts, in scene units [default: 0.5]
    #[arg(long, value_name = "DISTANCE", requires = "basis", value_parser = bias)]
    bias: Option<f64>,
    /// What counts of a light that crosses a surface's horizon [default: exact]
    #[arg(long, value_enum, conflicts_with = "reference")]
    occlusion: Option<Occlusion>,
    /// How specular light is computed [default: ltc]
    #[arg(long, value_enum, conflicts_with = "reference", value_name = "METHOD")]
    specular: Option<Specular>,
    /// How the images on lights are averaged [default: 2x2]
    #[arg(long, value_enum, conflicts_with = "reference", value_name = "METHOD")]
    image_method: Option<Images>,
    /// What computes
    #[arg(long, value_enum, value_name = "WHAT", default_value_t)]
    backend: BackendChoice,
    /// Leave out lights that add less than this radiance to a pixel, each of them; GPUs alone do
    /// so, and only for --diffuse exact and --specular ltc, ltc-2 or none [default: 0, none]
    #[arg(long, value_name = "RADIANCE", conflicts_with = "reference",
        allow_negative_numbers = true, value_parser = light_bound)]
    light_bound: Option<f32>,
    /// What --specular reflected takes for inside [default: crossing-number]
    #[arg(long, value_enum, value_name = "RULE", requires = "specular")]
    inclusion: Option<Inclusion>,
    #[command(flatten)]
    field: Field,
}

/// What --specular distance-field bakes and reads.
#[derive(Debug, Args)]
#[command(next_help_heading = "Distance fields, for --specular distance-field")]
struct Field {
    /// Texels along a side of a light's field, a power of two [default: 128]
    #[arg(long, value_name = "N", requires = "specular")]
    field_resolution: Option<u32>,
    /// Half the side of a field's square in the light's radii, 1 to 16 [default: 2]
    #[arg(long, value_name = "PHI", requires = "specular")]
    field_phi: Option<f32>,
    /// Bake distances inside too, negative: wide lobes see lights brighter in their middle
    #[arg(long, requires = "specular")]
    field_signed: bool,
    /// MiB that all fields may have together [default: 256]
    #[arg(long, value_name = "MIB", requires = "specular")]
    field_budget: Option<u32>,
    /// How fast reflections fade with the distance, the same for every surface: k of 1/(1 + d)^k
    /// [default: from the surface's roughness]
    #[arg(
        long,
        value_name = "K",
        requires = "specular",
        allow_negative_numbers = true
    )]
    smoothness: Option<f32>,
    /// Factor to the k that comes from the surface's roughness [default: 1]
    #[arg(
        long,
        value_name = "FACTOR",
        requires = "specular",
        conflicts_with = "smoothness",
        allow_negative_numbers = true
    )]
    smoothness_factor: Option<f32>,
}

impl Field {
    fn is_set(&self) -> bool {
        self.field_resolution.is_some()
            || self.field_phi.is_some()
            || self.field_signed
            || self.field_budget.is_some()
            || self.smoothness.is_some()
            || self.smoothness_factor.is_some()
    }

    fn method(&self) -> Result<SpecularMethod, Failure> {
        let default = DistanceFieldSettings::default();
        let refused = |fault: DistanceFieldError| Failure::usage("render", &fault.to_string());
        let field = DistanceFieldSettings::new(
            self.field_resolution.unwrap_or(default.resolution()),
            self.field_phi.unwrap_or(default.phi()),
            self.field_signed,
        );
        let smoothness = match self.smoothness {
            Some(smoothness) => DistanceFieldSmoothness::fixed(smoothness),
            None => DistanceFieldSmoothness::of_material(self.smoothness_factor.unwrap_or(1.0)),
        };
        Ok(SpecularMethod::ReflectedDistanceField {
            field: field.map_err(refused)?,
            smoothness: smoothness.map_err(refused)?,
        })
    }

    /// In bytes.
    fn budget(&self) -> u64 {
        let default = RenderSettings::default().distance_field_budget;
        self.field_budget
            .map_or(default, |mib| u64::from(mib) << 20)
    }
}

/// The path tracer.
#[derive(Debug, Args)]
#[command(next_help_heading = "Reference, and --bounce-method path")]
struct Reference {
    /// Path trace instead: shadows, and noise
    #[arg(long)]
    reference: bool,
    /// Light paths a pixel [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Surfaces a path may scatter at; 1 is direct light alone [default: 1]
    #[arg(long, value_name = "N", requires = "reference",
        value_parser = clap::value_parser!(u32).range(1..))]
    bounces: Option<u32>,
    /// Let light from lights through surfaces, as the closed forms always do
    #[arg(long)]
    no_shadows: bool,
    /// Only light that reaches what is seen from other surfaces, not from lights: with --bounces 2
    /// that of a single bounce
    #[arg(long, requires = "reference")]
    indirect: bool,
    /// Let light from surfaces through other surfaces: with --no-shadows, what virtual lights
    /// without visibility tend to
    #[arg(long, requires = "reference")]
    no_bounce_shadows: bool,
    /// Seed of the random numbers: equal seeds give equal pictures [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

fn default_size() -> Size {
    let RenderSettings { width, height, .. } = RenderSettings::default();
    Size { width, height }
}

/// An exposure that keeps its factor finite.
pub(crate) fn exposure(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(ev) if (-100.0..=100.0).contains(&ev) => Ok(ev),
        _ => Err("give stops from -100 to 100".to_owned()),
    }
}

fn tone_map() -> impl TypedValueParser<Value = ToneMap> {
    PossibleValuesParser::new(ToneMap::ALL.map(ToneMap::name))
        .try_map(|name| name.parse::<ToneMap>())
}

/// A bound of [`RenderSettings::light_bound`].
fn light_bound(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(bound) if (0.0..=f32::MAX).contains(&bound) => Ok(bound),
        _ => Err("give a radiance, not negative".to_owned()),
    }
}

/// A bias of [`lumigon::ProjectionBasis::Biased`].
pub(crate) fn bias(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(bias) if (0.0..1e30).contains(&bias) => Ok(bias),
        _ => Err("give a distance, not negative".to_owned()),
    }
}

impl Render {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        let (diffuse, specular) = self.method.resolve()?;
        self.reference.check()?;
        let bounce = self.bounce()?;
        let choice = match (self.reference.reference, self.method.backend) {
            (false, choice) => choice,
            (true, BackendChoice::Gpu) => {
                let message = "--reference runs on the CPU: leave --backend gpu out";
                return Err(Failure::usage("render", message));
            }
            (true, _) => BackendChoice::Cpu,
        };
        let format = PictureFormat::from_path(&self.output)
            .map_err(|error| Failure::usage("render", &error.to_string()))?;
        check_writable(&self.output)?;
        let start = Instant::now();
        let mut scene = Scene::load_within(&self.scene, &self.pictures.limits())?;
        self.pictures.show(&mut scene)?;
        for warning in &scene.warnings {
            eprintln!("warning: {}: {warning}", self.scene.display());
        }
        if format == PictureFormat::Exr && self.display.is_set() {
            eprintln!("warning: an EXR holds radiance as it is, without exposure and tone map");
        }
        let camera = choose_camera(&scene, &self.scene, self.camera.as_deref())?;
        interrupt.watch();
        let backend = Backend::new(choice, &scene)?;
        for warning in backend.warnings() {
            eprintln!("warning: {}: {warning}", self.scene.display());
        }
        let task = Task {
            render: self,
            scene: &scene,
            backend: &backend,
            camera: &camera,
            settings: RenderSettings {
                width: self.size.width,
                height: self.size.height,
                samples: self.samples,
                diffuse,
                specular,
                image_method: self.method.image_method.unwrap_or_default().into(),
                light_bound: self.method.light_bound.unwrap_or(0.0),
                distance_field_budget: self.method.field.budget(),
                direct: self.bounce.direct(),
            },
            interrupt: &interrupt,
        };
        let lit = match task.light(&bounce) {
            Ok(lit) => lit,
            Err(RenderError::Cancelled) => return Err(Failure::Interrupted),
            Err(error) => return Err(error.into()),
        };
        interrupt.check()?;
        let Size { width, height } = self.size;
        match format {
            PictureFormat::Png => write_png(
                &self.output,
                width,
                height,
                &lit.radiance,
                self.display.exposure.unwrap_or(0.0),
                self.display.tonemap.unwrap_or_default(),
            )?,
            PictureFormat::Exr => write_exr(&self.output, width, height, &lit.radiance)?,
        }
        println!(
            "{}: {} in {:.2} s {}, {} polygon lights, {} punctual lights{}",
            self.output.display(),
            self.size,
            start.elapsed().as_secs_f64(),
            backend.describe(),
            scene.polygon_lights.len(),
            scene.punctual_lights.len(),
            lit.bounce,
        );
        Ok(())
    }

    /// The bounce light that is asked for, or what is wrong with asking so.
    fn bounce(&self) -> Result<Bounce, Failure> {
        let bounce = self.bounce.resolve("render")?;
        let reference = &self.reference;
        let path_traced = reference.reference || matches!(bounce, Bounce::Path { .. });
        let contradiction = if reference.reference && bounce != Bounce::None {
            Some("--bounce adds to closed forms: --reference has --bounces")
        } else if self.show_virtual_lights && !matches!(bounce, Bounce::Virtual(_)) {
            Some("--show-virtual-lights is of use with --bounce 1 and virtual lights only")
        } else if reference.spp.is_some() && !path_traced {
            Some("--spp is of use with --reference or --bounce-method path only")
        } else if reference.seed.is_some() && !path_traced {
            Some("--seed is of use with --reference or --bounce-method path only")
        } else {
            None
        };
        match contradiction {
            Some(message) => Err(Failure::usage("render", message)),
            None => Ok(bounce),
        }
    }
}

/// A scene on what renders it.
struct Task<'a> {
    render: &'a Render,
    scene: &'a Scene,
    backend: &'a Backend<'a>,
    camera: &'a Camera,
    settings: RenderSettings,
    interrupt: &'a Interrupt,
}

/// A picture, and what is to be said of its bounce light.
struct Lit {
    radiance: Pixels,
    bounce: String,
}

impl Task<'_> {
    fn light(&self, bounce: &Bounce) -> Result<Lit, RenderError> {
        match bounce {
            _ if self.render.reference.reference => {
                let settings = self.reference();
                let rendering = self.path_traced("rendering", &settings)?;
                Ok(Lit::of(&rendering, String::new()))
            }
            Bounce::None => Ok(Lit::of(&self.direct()?, String::new())),
            Bounce::Virtual(settings) => self.by_virtual_lights(settings),
            &Bounce::Path {
                bounces,
                shadows,
                bounce_shadows,
            } => {
                let settings = ReferenceSettings {
                    bounces: bounces + 1,
                    shadows,
                    direct: false,
                    bounce_shadows,
                    ..self.reference()
                };
                let indirect = self.path_traced("tracing bounce light", &settings)?;
                let said = format!(", bounce light by {} paths a pixel", settings.paths);
                let mut lit = Lit::of(&indirect, said);
                if self.settings.direct {
                    let direct = self.direct()?.radiance();
                    for (sum, direct) in lit.radiance.iter_mut().zip(direct) {
                        *sum = std::array::from_fn(|i| sum[i] + direct[i]);
                    }
                }
                Ok(lit)
            }
        }
    }

    fn by_virtual_lights(&self, settings: &BounceSettings) -> Result<Lit, RenderError> {
        let lights = self.watched("gathering", |watch| {
            self.backend.virtual_lights(self.camera, settings, watch)
        })?;
        for warning in lights.warnings() {
            eprintln!("warning: {}: {warning}", self.render.scene.display());
        }
        let said = format!(
            ", {} virtual lights from {} texels",
            lights.len(),
            lights.texels()
        );
        if self.render.show_virtual_lights {
            let view = lights.to_scene(self.scene);
            let settings = RenderSettings {
                specular: SpecularMethod::None,
                ..self.settings
            };
            // Thousands of materials for one picture: no work for a GPU.
            let renderer = CpuRenderer::new(&view);
            let rendering = self.watched("rendering", |watch| {
                renderer.render(self.camera, &settings, watch)
            })?;
            return Ok(Lit::of(&rendering, said));
        }
        let rendering = self.watched("rendering", |watch| {
            self.backend
                .render_with_bounce(self.camera, &self.settings, &lights, watch)
        })?;
        Ok(Lit::of(&rendering, said))
    }

    /// By closed forms.
    fn direct(&self) -> Result<Rendering, RenderError> {
        self.watched("rendering", |watch| {
            self.backend.render(self.camera, &self.settings, watch)
        })
    }

    fn reference(&self) -> ReferenceSettings {
        let render = self.render;
        render.reference.settings(render.size, render.samples)
    }

    fn path_traced(
        &self,
        what: &'static str,
        settings: &ReferenceSettings,
    ) -> Result<Rendering, RenderError> {
        let traced = self.watched(what, |watch| {
            self.backend.cpu().reference(self.camera, settings, watch)
        })?;
        Ok(traced.mean)
    }

    fn watched<T>(
        &self,
        what: &'static str,
        work: impl FnOnce(Watch<'_>) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let progress = Progress::new(what);
        work(Watch {
            progress: &|done, total| progress.set(done, total),
            cancelled: self.interrupt.flag(),
        })
    }
}

impl Lit {
    fn of(rendering: &Rendering, bounce: String) -> Self {
        Self {
            radiance: rendering.radiance(),
            bounce,
        }
    }
}

impl Display {
    fn is_set(&self) -> bool {
        self.exposure.is_some() || self.tonemap.is_some()
    }
}

impl Method {
    /// The methods, or what is wrong with their combination.
    fn resolve(&self) -> Result<(DiffuseMethod, SpecularMethod), Failure> {
        let diffuse = self.diffuse.unwrap_or_default();
        let specular = self.specular.unwrap_or_default();
        let contradiction = if self.basis.is_some() && diffuse != Diffuse::ProjectedArea {
            Some("--basis is of use with --diffuse projected-area only")
        } else if self.bias.is_some() && self.basis != Some(Basis::Biased) {
            Some("--bias is of use with --basis biased only")
        } else if self.inclusion.is_some() && specular != Specular::Reflected {
            Some("--inclusion is of use with --specular reflected only")
        } else if self.field.is_set() && specular != Specular::DistanceField {
            Some("--field-* and --smoothness* are of use with --specular distance-field only")
        } else {
            None
        };
        if let Some(message) = contradiction {
            return Err(Failure::usage("render", message));
        }
        let occlusion = self.occlusion.unwrap_or_default().into();
        let diffuse = match diffuse {
            Diffuse::Exact => DiffuseMethod::Exact { occlusion },
            Diffuse::LightVector => DiffuseMethod::LightVector { occlusion },
            Diffuse::ProjectedArea => DiffuseMethod::ProjectedArea {
                basis: self.basis.unwrap_or(Basis::Optimal).with_bias(self.bias),
                occlusion,
            },
        };
        let specular = match specular {
            Specular::Ltc => SpecularMethod::default(),
            Specular::Ltc2 => SpecularMethod::Ltc {
                lobes: LtcLobes::Two,
            },
            Specular::Reflected => {
                SpecularMethod::ReflectedInclusion(self.inclusion.unwrap_or_default().into())
            }
            Specular::DistanceField => self.field.method()?,
            Specular::LightVector => SpecularMethod::LightVector,
            Specular::None => SpecularMethod::None,
        };
        Ok((diffuse, specular))
    }
}

impl Reference {
    /// Refuses what would render nothing, or the same.
    fn check(&self) -> Result<(), Failure> {
        let default = ReferenceSettings::default();
        let message = match self.bounces.unwrap_or(default.bounces) {
            2.. => return Ok(()),
            _ if self.indirect => {
                "--indirect leaves nothing of --bounces 1, which is direct light alone: give --bounces 2 or more"
            }
            _ if self.no_bounce_shadows => {
                "--no-bounce-shadows is of use with --bounces 2 or more only"
            }
            _ => return Ok(()),
        };
        Err(Failure::usage("render", message))
    }

    fn settings(&self, size: Size, samples: u32) -> ReferenceSettings {
        let default = ReferenceSettings::default();
        ReferenceSettings {
            width: size.width,
            height: size.height,
            samples,
            paths: self.spp.unwrap_or(default.paths),
            bounces: self.bounces.unwrap_or(default.bounces),
            shadows: !self.no_shadows,
            direct: !self.indirect,
            bounce_shadows: !self.no_bounce_shadows,
            seed: self.seed.unwrap_or(default.seed),
        }
    }
}
