//! Pictures for the window: at once while something moves, better ones from the background after.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec2;
use lumigon_renderer::{
    BounceCenters, BounceSettings, Camera, CpuRenderer, DisplaySettings, Gpu, GpuRenderer,
    PickedSurface, PictureError, PictureFormat, Pixels, Probe, ReferenceSettings, RenderError,
    RenderSettings, Scene, ToneMap, VirtualLights, Watch, srgb8, write_exr, write_png,
};

use super::Surroundings;
use super::false_color::{self, Scale};
use super::settings::{Content, Look, Settings};
use crate::options::BackendChoice;
use crate::workers::{
    self, Background, BackgroundState, Job, ReferenceJob, ReferenceState, RefineJob, Update,
};

/// What a picture may take while something moves, in seconds, where the processor makes it.
const PACE: f64 = 0.040;

/// The least share of the window's pixels that is drawn while something moves.
const LEAST_SHARE: f64 = 1.0 / 100.0;

/// How long nothing moves before the background begins.
const STILL: Duration = Duration::from_millis(150);

/// Samples a pixel that a hardware GPU takes, moving or not.
const GPU_SAMPLES: u32 = 4;

/// The noise, relative, that the truth is followed to, and the paths a pixel at most.
const TARGET_NOISE: f64 = 0.005;
const MOST_PATHS: u64 = 1 << 14;

/// Camera rays a pixel of the truth, at the places of a refined picture's.
const REFERENCE_SAMPLES: u32 = 16;

/// What a frame wants to see.
#[derive(Clone, Copy)]
pub(super) struct Wish<'a> {
    pub(super) scene: &'a Arc<Scene>,
    pub(super) camera: &'a Camera,
    /// Of the picture, in pixels of the display.
    pub(super) size: [u32; 2],
    pub(super) settings: &'a Settings,
    /// Whether the next frame may want something else.
    pub(super) is_moving: bool,
}

/// What pictures depend on.
#[derive(Clone, PartialEq)]
struct Key {
    camera: Camera,
    size: [u32; 2],
    sides: Vec<(Content, Look)>,
    reference_shadows: bool,
}

/// What one picture took, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrameTimes {
    /// Bringing edits to the renderer.
    pub(super) edits: f64,
    /// Finding what pixels see.
    pub(super) visibility: f64,
    /// The scene's lights.
    pub(super) lights: f64,
    /// Bounce light: making virtual lights, and lighting by them.
    pub(super) bounce: f64,
    /// All of it, by the clock on the wall.
    pub(super) picture: f64,
    /// Of the picture, in pixels.
    pub(super) size: [u32; 2],
}

/// What a side shows.
#[derive(Default)]
pub(super) struct Shot {
    size: [u32; 2],
    /// Of the picture on screen, in pixels.
    wanted: [u32; 2],
    /// Linear radiance of the side's own methods; empty where the GPU keeps it.
    picture: Arc<Pixels>,
    texture: Option<egui::TextureHandle>,
    /// What the GPU draws into.
    native: Option<(wgpu::Texture, egui::TextureId)>,
    uses_native: bool,
    /// What colours mean, where they are not light.
    pub(super) scale: Option<Scale>,
}

impl Shot {
    pub(super) fn texture(&self) -> Option<egui::TextureId> {
        match &self.native {
            Some((_, id)) if self.uses_native => Some(*id),
            _ => self.texture.as_ref().map(egui::TextureHandle::id),
        }
    }

    fn show(&mut self, context: &egui::Context, side: usize, size: [u32; 2], rgb: &[u8]) {
        let image = egui::ColorImage::from_rgb(size.map(|side| side as usize), rgb);
        self.set(context, side, size, image);
    }

    fn set(
        &mut self,
        context: &egui::Context,
        side: usize,
        size: [u32; 2],
        image: egui::ColorImage,
    ) {
        let is_whole = size == self.wanted;
        // Where texels are pixels, reading one is enough.
        let options = match is_whole {
            true => egui::TextureOptions::NEAREST,
            false => egui::TextureOptions::LINEAR,
        };
        match &mut self.texture {
            Some(texture) => texture.set(image, options),
            None => {
                let name = ["left", "right"][side];
                self.texture = Some(context.load_texture(name, image, options));
            }
        }
        self.size = size;
        self.uses_native = false;
    }
}

/// How far the truth has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Convergence {
    pub(super) paths: u64,
    /// Mean standard error over mean radiance.
    pub(super) noise: f64,
    is_done: bool,
}

impl Convergence {
    /// From 0 to 1: noise falls with the square root of the paths.
    pub(super) fn progress(&self) -> f32 {
        if self.is_done {
            return 1.0;
        }
        if self.noise > 0.0 {
            ((TARGET_NOISE / self.noise).powi(2) as f32).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}

/// What has been done for what is on screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// A quick picture.
    #[default]
    Quick,
    /// The best picture.
    Refined,
    /// The truth, too, if that was wanted.
    Done,
}

/// Makes pictures.
pub(super) struct Display {
    cpu: Arc<CpuRenderer<'static>>,
    gpu: Option<Box<GpuRenderer>>,
    /// Whether the GPU is none but the processor.
    is_software: bool,
    /// The device that `gpu` was made on is gone.
    device: Option<Gpu>,
    choice: Option<BackendChoice>,
    scene: Arc<Scene>,
    key: Option<Key>,
    /// Stops and tone map of what is on screen.
    tone: (f32, ToneMap),
    pub(super) shots: [Shot; 2],
    /// Seconds that a pixel of a side took lately.
    seconds_a_pixel: f64,
    /// Since when nothing has moved.
    still_since: Instant,
    background: Option<Background>,
    /// Its newest result that is on screen.
    seen: Option<Arc<Update>>,
    /// Where cube maps look from that were chosen in the scene.
    centers: Option<(BounceCenters, Vec<[f32; 3]>)>,
    stage: Stage,
    reference: Option<ReferenceState>,
    wake: Arc<dyn Fn() + Send + Sync>,
    pub(super) times: FrameTimes,
    /// A picture was made in this frame.
    pub(super) has_drawn: bool,
    /// What the user is to be told.
    pub(super) fault: Option<String>,
}

impl Display {
    /// `renderer` is of the scene.
    pub(super) fn new(
        renderer: CpuRenderer<'static>,
        scene: &Arc<Scene>,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Self {
        Self {
            cpu: Arc::new(renderer),
            gpu: None,
            is_software: false,
            device: None,
            choice: None,
            scene: Arc::clone(scene),
            key: None,
            tone: (0.0, ToneMap::default()),
            shots: Default::default(),
            seconds_a_pixel: 2e-7,
            still_since: Instant::now(),
            background: None,
            seen: None,
            centers: None,
            stage: Stage::Quick,
            reference: None,
            wake,
            times: FrameTimes::default(),
            has_drawn: false,
            fault: None,
        }
    }

    /// Decides once for each device what computes pictures, and says so where that needs saying.
    pub(super) fn choose(&mut self, gpu: &Gpu, choice: BackendChoice) -> Option<String> {
        if self.choice == Some(choice) && self.device.is_some() {
            return None;
        }
        self.choice = Some(choice);
        self.device = Some(gpu.clone());
        self.gpu = None;
        self.key = None;
        self.is_software = gpu.adapter().is_software();
        let wants_gpu = match choice {
            BackendChoice::Cpu => false,
            BackendChoice::Gpu => true,
            BackendChoice::Auto => !self.is_software,
        };
        if wants_gpu {
            match GpuRenderer::new(gpu, &self.scene) {
                Ok(renderer) => self.gpu = Some(Box::new(renderer)),
                Err(fault) => return Some(format!("{fault}: the CPU renders instead")),
            }
        }
        match (choice, self.is_software) {
            (BackendChoice::Auto, true) => Some(
                "This machine has no hardware GPU: the CPU renders, coarsely while something moves, in full \
                 when nothing does"
                    .to_owned(),
            ),
            (BackendChoice::Gpu, true) => Some(
                "This machine has no hardware GPU: software Vulkan renders, slowly".to_owned(),
            ),
            _ => None,
        }
    }

    /// Renders what is on screen.
    pub(super) fn renderer(&self) -> Arc<CpuRenderer<'static>> {
        Arc::clone(&self.cpu)
    }

    /// Goes on from another renderer of the scene, or of one that is almost the same.
    pub(super) fn take_renderer(&mut self, renderer: CpuRenderer<'static>) {
        self.cpu = Arc::new(renderer);
    }

    /// The device is gone, and all that was on it.
    pub(super) fn forget_device(&mut self) {
        self.device = None;
        self.gpu = None;
        self.key = None;
        self.shots = Default::default();
        self.stop();
    }

    /// In a few words, what renders.
    pub(super) fn status(&self) -> String {
        let [width, height] = self.times.size;
        let what = match (&self.gpu, &self.device) {
            (Some(_), Some(device)) => device.adapter().name.clone(),
            _ => "CPU".to_owned(),
        };
        let state = match (self.stage, &self.background) {
            (Stage::Done, _) => ", finished".to_owned(),
            (_, Some(background)) => {
                let percent = background.progress() * 100.0;
                let what = match self.stage {
                    Stage::Quick => "refining",
                    _ => "path tracing",
                };
                format!(", {what}: {percent:.0} % of a pass")
            }
            (Stage::Refined, None) => ", refined".to_owned(),
            (Stage::Quick, None) => String::new(),
        };
        format!("{what}, {width} x {height}{state}")
    }

    pub(super) fn convergence(&self) -> Option<Convergence> {
        let reference = self.reference.as_ref()?;
        Some(Convergence {
            paths: reference.paths,
            noise: reference.relative_noise,
            is_done: self.stage == Stage::Done,
        })
    }

    /// Whether what is on screen will stay as it is.
    pub(super) fn is_settled(&self) -> bool {
        self.key.is_some() && self.background.is_none() && self.stage == Stage::Done
    }

    pub(super) fn pick(&self, camera: &Camera, at: Vec2, aspect: f32) -> Option<PickedSurface> {
        self.cpu.pick(camera, at.x, at.y, aspect)
    }

    pub(super) fn probe(
        &self,
        camera: &Camera,
        at: [f32; 2],
        aspect: f32,
        settings: &[RenderSettings],
    ) -> Option<Probe> {
        self.cpu.probe(camera, at, aspect, settings)
    }

    fn stop(&mut self) {
        self.background = None;
        self.seen = None;
        self.stage = Stage::Quick;
        self.reference = None;
    }

    /// Brings the pictures to what is wanted, as far as that can be done at once.
    pub(super) fn frame(
        &mut self,
        context: &egui::Context,
        surroundings: &mut Surroundings<'_>,
        wish: &Wish<'_>,
    ) {
        self.has_drawn = false;
        for shot in &mut self.shots {
            shot.wanted = wish.size;
        }
        let start = Instant::now();
        let is_edited = !Arc::ptr_eq(&self.scene, wish.scene);
        if is_edited {
            self.stop();
            self.take_edits(wish.scene);
        }
        let edits = start.elapsed().as_secs_f64() * 1e3;
        let settings = wish.settings;
        let sides = settings
            .shown()
            .iter()
            .map(|side| (side.content, side.look.clone()));
        let key = Key {
            camera: wish.camera.clone(),
            size: wish.size,
            sides: sides.collect(),
            reference_shadows: settings.reference_shadows,
        };
        let tone = (settings.exposure, settings.tone_map);
        if is_edited || self.key.as_ref() != Some(&key) {
            self.stop();
            self.key = Some(key);
            self.tone = tone;
            self.still_since = Instant::now();
            let drawn = self.draw(context, surroundings, wish);
            self.times.edits = edits;
            self.times.picture = start.elapsed().as_secs_f64() * 1e3;
            self.has_drawn = true;
            if let Err(fault) = drawn {
                self.fault = Some(fault.to_string());
            }
            context.request_repaint_after(STILL);
            return;
        }
        self.poll(context, wish);
        if self.tone != tone {
            self.tone = tone;
            self.show_again(context, surroundings, wish);
        }
        self.go_on(context, surroundings, wish);
    }

    fn take_edits(&mut self, scene: &Arc<Scene>) {
        self.cpu = Arc::new(self.cpu.edited(Arc::clone(scene)));
        if let Some(gpu) = &mut self.gpu
            && let Err(fault) = gpu.set_scene(scene)
        {
            self.fault = Some(format!("{fault}: the CPU renders instead"));
            self.gpu = None;
        }
        self.scene = Arc::clone(scene);
    }

    /// The size of a quick picture.
    fn quick_size(&self, wish: &Wish<'_>) -> [u32; 2] {
        let [width, height] = wish.size.map(f64::from);
        let sides = wish.settings.shown().len() as f64;
        let share = PACE / (self.seconds_a_pixel * width * height * sides);
        let scale = share.clamp(LEAST_SHARE, 1.0).sqrt();
        [width, height].map(|side| ((side * scale).round() as u32).max(1))
    }

    /// A picture at once.
    fn draw(
        &mut self,
        context: &egui::Context,
        surroundings: &mut Surroundings<'_>,
        wish: &Wish<'_>,
    ) -> Result<(), RenderError> {
        self.times = FrameTimes::default();
        let on_gpu = self.gpu.is_some();
        let is_fast = on_gpu && !self.is_software;
        let size = if is_fast {
            wish.size
        } else {
            self.quick_size(wish)
        };
        self.times.size = size;
        let start = Instant::now();
        for (i, side) in wish.settings.shown().iter().enumerate() {
            if side.content == Content::LightCounts {
                self.show_counts(context, wish, i, size)?;
                continue;
            }
            self.shots[i].scale = None;
            if on_gpu {
                let samples = if is_fast { GPU_SAMPLES } else { 1 };
                self.draw_native(surroundings, wish, i, size, samples)?;
            } else {
                self.render(context, wish, i, size)?;
            }
        }
        if on_gpu && self.is_software {
            // Its time is the processor's: wait, to know it.
            _ = surroundings
                .gpu
                .device()
                .poll(wgpu::PollType::wait_indefinitely());
        }
        if !is_fast {
            let pixels =
                f64::from(size[0]) * f64::from(size[1]) * wish.settings.shown().len() as f64;
            let measured = start.elapsed().as_secs_f64() / pixels;
            // Slow at once, fast again with care.
            let share = if measured > self.seconds_a_pixel {
                0.7
            } else {
                0.25
            };
            self.seconds_a_pixel += share * (measured - self.seconds_a_pixel);
        }
        Ok(())
    }

    /// Virtual lights for a look.
    fn virtual_lights(
        &mut self,
        camera: &Camera,
        look: &Look,
    ) -> Result<VirtualLights, RenderError> {
        let Some(bounce) = &look.bounce else {
            return Ok(VirtualLights::default());
        };
        let start = Instant::now();
        // Places in the scene are sought once: they stay while lights are moved.
        let settings = self.at_centers(bounce.clone());
        let lights = match &self.gpu {
            Some(gpu) => gpu.virtual_lights(camera, &settings, Watch::none()),
            None => self.cpu.virtual_lights(camera, &settings, Watch::none()),
        }?;
        if matches!(bounce.centers, BounceCenters::Scene(_)) {
            self.centers = Some((bounce.centers.clone(), lights.centers().to_vec()));
        }
        self.times.bounce += start.elapsed().as_secs_f64() * 1e3;
        Ok(lights)
    }

    /// Cube maps look from where they were chosen.
    fn at_centers(&self, mut bounce: BounceSettings) -> BounceSettings {
        if let Some((chosen, centers)) = &self.centers
            && *chosen == bounce.centers
        {
            bounce.centers = BounceCenters::Points(centers.clone());
        }
        bounce
    }

    fn render(
        &mut self,
        context: &egui::Context,
        wish: &Wish<'_>,
        i: usize,
        size: [u32; 2],
    ) -> Result<(), RenderError> {
        let look = &wish.settings.sides[i].look;
        let virtual_lights = self.virtual_lights(wish.camera, look)?;
        let settings = look.render_settings(size, 1);
        let picture =
            self.cpu
                .render_with_bounce(wish.camera, &settings, &virtual_lights, Watch::none())?;
        if let Some(times) = self.cpu.timings() {
            self.times.visibility += times.rays;
            self.times.lights += times.lights;
            self.times.bounce += times.virtual_lights;
        }
        let radiance = picture.radiance();
        let rgb = srgb8(&radiance, self.tone.0, self.tone.1);
        self.shots[i].show(context, i, size, &rgb);
        self.shots[i].picture = Arc::new(radiance);
        Ok(())
    }

    fn draw_native(
        &mut self,
        surroundings: &mut Surroundings<'_>,
        wish: &Wish<'_>,
        i: usize,
        size: [u32; 2],
        samples: u32,
    ) -> Result<(), RenderError> {
        let look = &wish.settings.sides[i].look;
        let virtual_lights = self.virtual_lights(wish.camera, look)?;
        let Some(gpu) = &self.gpu else {
            return Ok(());
        };
        let shot = &mut self.shots[i];
        let device = surroundings.gpu.device();
        let fits = |(texture, _): &(wgpu::Texture, egui::TextureId)| {
            [texture.width(), texture.height()] == size
        };
        if !shot.native.as_ref().is_some_and(fits) {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let view = texture.create_view(&Default::default());
            let filter = wgpu::FilterMode::Linear;
            let id = match shot.native.take() {
                Some((_, id)) => {
                    surroundings
                        .interface
                        .update_egui_texture_from_wgpu_texture(device, &view, filter, id);
                    id
                }
                None => surroundings
                    .interface
                    .register_native_texture(device, &view, filter),
            };
            shot.native = Some((texture, id));
        }
        let Some((texture, _)) = &shot.native else {
            return Ok(());
        };
        let settings = look.render_settings(size, samples);
        let display = DisplaySettings {
            exposure_ev: self.tone.0,
            tone_map: self.tone.1,
        };
        gpu.draw(wish.camera, &settings, &virtual_lights, display, texture)?;
        shot.uses_native = true;
        shot.size = size;
        shot.picture = Arc::default();
        if let Some(times) = gpu.timings() {
            self.times.visibility += times.visibility;
            self.times.lights += times.shading;
            self.times.bounce += times.bounce;
        }
        Ok(())
    }

    /// Takes what the background has found.
    fn poll(&mut self, context: &egui::Context, wish: &Wish<'_>) {
        let Some(background) = &self.background else {
            return;
        };
        let state = background.state();
        let latest = background.latest();
        let is_seen = match (&latest, &self.seen) {
            (Some(latest), Some(seen)) => Arc::ptr_eq(latest, seen),
            _ => false,
        };
        match latest.as_deref().filter(|_| !is_seen) {
            Some(Update::Refined(refined)) => {
                let mut pictures = refined.pictures.iter();
                for (i, side) in wish.settings.shown().iter().enumerate() {
                    if side.content == Content::LightCounts {
                        continue;
                    }
                    if let Some(picture) = pictures.next() {
                        let size = [picture.width, picture.height];
                        let radiance = picture.radiance();
                        let rgb = srgb8(&radiance, self.tone.0, self.tone.1);
                        self.shots[i].show(context, i, size, &rgb);
                        self.shots[i].picture = Arc::new(radiance);
                        self.times.size = size;
                    }
                }
            }
            Some(Update::Reference(reference)) => {
                self.reference = Some(reference.clone());
                self.show_reference(context, wish);
            }
            None => {}
        }
        self.seen = latest.or(self.seen.take());
        match state {
            BackgroundState::Running => {}
            BackgroundState::Failed(reason) => {
                self.fault = Some(reason);
                self.background = None;
                self.stage = Stage::Done;
            }
            BackgroundState::Finished | BackgroundState::Stopped => {
                self.background = None;
                self.stage = match self.stage {
                    Stage::Quick if wish.settings.needs_reference() => Stage::Refined,
                    _ => Stage::Done,
                };
            }
        }
    }

    /// Sides that show the truth, or what comes of it.
    fn show_reference(&mut self, context: &egui::Context, wish: &Wish<'_>) {
        let Some(reference) = &self.reference else {
            return;
        };
        let size = [reference.width, reference.height];
        for (i, side) in wish.settings.shown().iter().enumerate() {
            let shot = &mut self.shots[i];
            let is_whole = shot.size == size && shot.picture.len() == reference.mean.len();
            let (colors, scale) = match side.content {
                Content::Reference => {
                    let rgb = srgb8(&reference.mean, self.tone.0, self.tone.1);
                    let picture = std::mem::take(&mut shot.picture);
                    shot.show(context, i, size, &rgb);
                    shot.picture = picture;
                    shot.scale = None;
                    continue;
                }
                Content::Noise => false_color::noise(&reference.error, &reference.mean),
                Content::Error if is_whole => false_color::error(&shot.picture, &reference.mean),
                _ => continue,
            };
            let image = egui::ColorImage::new(size.map(|side| side as usize), colors);
            shot.set(context, i, size, image);
            shot.scale = Some(scale);
        }
    }

    /// Shows what is there with another exposure or tone map.
    fn show_again(
        &mut self,
        context: &egui::Context,
        surroundings: &mut Surroundings<'_>,
        wish: &Wish<'_>,
    ) {
        for (i, side) in wish.settings.shown().iter().enumerate() {
            let shot = &mut self.shots[i];
            if shot.uses_native {
                let samples = if self.is_software { 1 } else { GPU_SAMPLES };
                let size = shot.size;
                if let Err(fault) = self.draw_native(surroundings, wish, i, size, samples) {
                    self.fault = Some(fault.to_string());
                }
            } else if side.content == Content::Picture {
                let size = shot.size;
                let rgb = srgb8(&shot.picture, self.tone.0, self.tone.1);
                if rgb.len() as u64 == 3 * u64::from(size[0]) * u64::from(size[1]) {
                    shot.show(context, i, size, &rgb);
                }
            }
        }
        self.show_reference(context, wish);
    }

    /// Once nothing moves: the best picture, then the truth.
    fn go_on(
        &mut self,
        context: &egui::Context,
        surroundings: &mut Surroundings<'_>,
        wish: &Wish<'_>,
    ) {
        if self.background.is_some() || self.stage == Stage::Done {
            return;
        }
        let still = self.still_since.elapsed();
        if wish.is_moving || still < STILL {
            if !wish.is_moving {
                context.request_repaint_after(STILL - still);
            }
            return;
        }
        let settings = wish.settings;
        let shown = settings.shown();
        if self.stage == Stage::Quick {
            let needs_radiance = shown.iter().any(|side| side.content == Content::Error);
            if self.gpu.is_some() && !needs_radiance {
                if self.is_software {
                    for (i, side) in shown.iter().enumerate() {
                        if side.content != Content::LightCounts
                            && let Err(fault) =
                                self.draw_native(surroundings, wish, i, wish.size, 1)
                        {
                            self.fault = Some(fault.to_string());
                        }
                    }
                    self.times.size = wish.size;
                    context.request_repaint();
                }
                self.stage = Stage::Refined;
            } else {
                let looks = shown
                    .iter()
                    .filter(|side| side.content != Content::LightCounts);
                let looks: Vec<_> = looks
                    .map(|side| workers::Look {
                        settings: side.look.render_settings(wish.size, 1),
                        bounce: side
                            .look
                            .bounce
                            .clone()
                            .map(|bounce| self.at_centers(bounce)),
                    })
                    .collect();
                self.counts_in_full(context, wish);
                if looks.is_empty() {
                    self.stage = Stage::Refined;
                } else {
                    self.start(Job::Refine(RefineJob {
                        renderer: Arc::clone(&self.cpu),
                        camera: wish.camera.clone(),
                        looks,
                    }));
                    return;
                }
            }
        }
        if settings.needs_reference() {
            self.start(Job::Reference(ReferenceJob {
                renderer: Arc::clone(&self.cpu),
                camera: wish.camera.clone(),
                settings: ReferenceSettings {
                    width: wish.size[0],
                    height: wish.size[1],
                    samples: REFERENCE_SAMPLES,
                    bounces: settings.reference_bounces(),
                    shadows: settings.reference_shadows,
                    bounce_shadows: settings.reference_shadows,
                    ..ReferenceSettings::default()
                },
                target_noise: TARGET_NOISE,
                most_paths: MOST_PATHS,
            }));
        } else {
            self.stage = Stage::Done;
        }
    }

    /// The heat map at the window's size.
    fn counts_in_full(&mut self, context: &egui::Context, wish: &Wish<'_>) {
        for (i, side) in wish.settings.shown().iter().enumerate() {
            if side.content != Content::LightCounts || self.shots[i].size == wish.size {
                continue;
            }
            if let Err(fault) = self.show_counts(context, wish, i, wish.size) {
                self.fault = Some(fault.to_string());
            }
        }
    }

    /// The heat map of one side.
    fn show_counts(
        &mut self,
        context: &egui::Context,
        wish: &Wish<'_>,
        i: usize,
        size: [u32; 2],
    ) -> Result<(), RenderError> {
        let settings = wish.settings.sides[i].look.render_settings(size, 1);
        let counts = self
            .cpu
            .light_counts(wish.camera, &settings, Watch::none())?;
        let (colors, scale) = false_color::light_counts(&counts);
        let image = egui::ColorImage::new(size.map(|side| side as usize), colors);
        self.shots[i].set(context, i, size, image);
        self.shots[i].scale = Some(scale);
        Ok(())
    }

    fn start(&mut self, job: Job) {
        let wake = Arc::clone(&self.wake);
        self.background = Some(Background::start(job, Box::new(move || wake())));
    }

    /// Writes the picture of the left side, or of the only one, as large as the window shows it: PNG as it
    /// is displayed, EXR in linear radiance. Where the background has not finished it, it is made anew.
    pub(super) fn save(&self, path: &Path, settings: &Settings) -> Result<(), SaveFault> {
        let key = self.key.as_ref().ok_or(SaveFault::Nothing)?;
        let shot = &self.shots[0];
        let [width, height] = key.size;
        let look = &settings.sides[0].look;
        let is_there =
            self.stage > Stage::Quick && shot.size == key.size && !shot.picture.is_empty();
        let picture = if is_there {
            Arc::clone(&shot.picture)
        } else {
            let bounce = look.bounce.as_ref();
            let lights =
                bounce.map(|bounce| self.cpu.virtual_lights(&key.camera, bounce, Watch::none()));
            let lights = lights.transpose()?.unwrap_or_default();
            let settings = look.render_settings(key.size, 4);
            let picture =
                self.cpu
                    .render_with_bounce(&key.camera, &settings, &lights, Watch::none())?;
            Arc::new(picture.radiance())
        };
        match PictureFormat::from_path(path)? {
            PictureFormat::Png => {
                write_png(
                    path,
                    width,
                    height,
                    &picture,
                    settings.exposure,
                    settings.tone_map,
                )?;
            }
            PictureFormat::Exr => write_exr(path, width, height, &picture)?,
        }
        Ok(())
    }
}

/// Why a picture was not saved.
#[derive(Debug, thiserror::Error)]
pub(super) enum SaveFault {
    #[error("there is no picture yet: wait until the scene is there")]
    Nothing,
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Render(#[from] RenderError),
}
