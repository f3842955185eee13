//! The window: events in, frames out, and what happens where either fails.

mod painter;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::accesskit;
use lumigon_renderer::{GpuError, write_whole};
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use crate::app::{App, Surroundings};
use crate::options::Options;
use crate::replay::{Demand, FRAME, Recording, Replay, ReplayError, Standing};
use painter::{Drawn, Painter};

/// How often recorded input looks whether all is settled, where nothing wakes it.
const GLANCE: Duration = Duration::from_millis(200);

/// Attempts at a device that fails right after it was made.
const ATTEMPTS: u32 = 3;

/// Why there is no window, or why it closed.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// There is no display, or it went away.
    #[error(
        "no window: {reason}; give a display (on a machine without one, run under xvfb-run), or use \
         `lumigon render`"
    )]
    NoDisplay {
        /// What the system says.
        reason: String,
    },
    /// Nothing can draw to the window.
    #[error("no device draws to the window: {0}")]
    Device(#[from] GpuError),
    /// Recorded input cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// What the window shows cannot be written.
    #[error("{path}: {reason}: choose a place that can be written", path = path.display())]
    Unwritable {
        /// Where.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

/// Shows a scene in a window until that is closed.
///
/// # Errors
/// Where there is no display or no device, and where input cannot be replayed or the screenshot not be
/// written. All else is told in the window.
pub fn run(options: Options) -> Result<(), ViewerError> {
    let replay = options.replay.as_deref().map(Replay::read).transpose()?;
    let event_loop = EventLoop::<Wake>::with_user_event()
        .build()
        .map_err(|fault| ViewerError::NoDisplay {
            reason: fault.to_string(),
        })?;
    event_loop.set_control_flow(ControlFlow::Wait);
    let proxy = event_loop.create_proxy();
    let recording = options.record.is_some().then(Recording::default);
    let mut viewer = Viewer {
        app: App::new(&options, wake(&proxy)),
        options,
        shown: None,
        replay,
        recording,
        dropped: Vec::new(),
        frame: 0,
        time: 0.0,
        next_frame: None,
        names: Vec::new(),
        result: Ok(()),
    };
    let run = event_loop.run_app(&mut viewer);
    viewer.app.leave();
    viewer.result?;
    if let (Some(path), Some(recording)) = (&viewer.options.record, &viewer.recording) {
        recording
            .save(path)
            .map_err(|fault| unwritable(path, &fault))?;
    }
    run.map_err(|fault| ViewerError::NoDisplay {
        reason: fault.to_string(),
    })
}

fn unwritable(path: &Path, reason: &dyn std::fmt::Display) -> ViewerError {
    ViewerError::Unwritable {
        path: path.to_owned(),
        reason: reason.to_string(),
    }
}

/// Something in the background has news.
#[derive(Debug)]
struct Wake;

/// A way to wake the window from any thread.
fn wake(proxy: &EventLoopProxy<Wake>) -> Arc<dyn Fn() + Send + Sync> {
    let proxy = proxy.clone();
    Arc::new(move || _ = proxy.send_event(Wake))
}

struct Viewer {
    options: Options,
    app: App,
    shown: Option<Shown>,
    replay: Option<Replay>,
    recording: Option<Recording>,
    /// Files dropped since the last frame.
    dropped: Vec<PathBuf>,
    frame: u64,
    /// Seconds, of what is replayed.
    time: f64,
    /// When something on screen wants to move on.
    next_frame: Option<Instant>,
    /// What carries which name, and where: for what is replayed.
    names: Vec<(String, egui::Pos2)>,
    result: Result<(), ViewerError>,
}

/// A window that is open.
struct Shown {
    window: Arc<Window>,
    context: egui::Context,
    input: egui_winit::State,
    /// None while a lost device is replaced.
    painter: Option<Painter>,
    /// Devices in a row that failed before they showed anything.
    failures: u32,
}

impl Shown {
    fn open(event_loop: &ActiveEventLoop, options: &Options) -> Result<Self, ViewerError> {
        let [width, height] = options.size.map(f64::from);
        let attributes = Window::default_attributes()
            .with_title("lumigon")
            .with_inner_size(winit::dpi::LogicalSize::new(width, height));
        let window =
            event_loop
                .create_window(attributes)
                .map_err(|fault| ViewerError::NoDisplay {
                    reason: fault.to_string(),
                })?;
        let window = Arc::new(window);
        let painter = Painter::new(&window)?;
        let context = egui::Context::default();
        let input = egui_input(&context, &window, &painter);
        if options.replay.is_some() {
            context.enable_accesskit();
        }
        crate::app::style(&context);
        Ok(Self {
            window,
            context,
            input,
            painter: Some(painter),
            failures: 0,
        })
    }

    /// A new device after the old one is lost; what the interface remembers is kept.
    fn restore(&mut self, options: &Options) -> Result<(), GpuError> {
        // A window bears one surface at a time.
        self.painter = None;
        // The textures are gone: a new context gives them anew.
        let context = egui::Context::default();
        let memory = self.context.memory(Clone::clone);
        context.memory_mut(|new| *new = memory);
        if options.replay.is_some() {
            context.enable_accesskit();
        }
        crate::app::style(&context);
        let painter = Painter::new(&self.window)?;
        self.input = egui_input(&context, &self.window, &painter);
        self.painter = Some(painter);
        self.context = context;
        Ok(())
    }
}

fn egui_input(
    context: &egui::Context,
    window: &Arc<Window>,
    painter: &Painter,
) -> egui_winit::State {
    let largest = painter.gpu.device().limits().max_texture_dimension_2d;
    egui_winit::State::new(
        context.clone(),
        egui::ViewportId::ROOT,
        window,
        Some(window.scale_factor() as f32),
        window.theme(),
        Some(largest as usize),
    )
}

impl ApplicationHandler<Wake> for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        match Shown::open(event_loop, &self.options) {
            Ok(shown) => {
                shown.window.request_redraw();
                self.shown = Some(shown);
            }
            Err(fault) => self.stop(event_loop, Err(fault)),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: Wake) {
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(shown) = &self.shown else {
            return;
        };
        // What is replayed, or counted, waits for nothing but the background.
        let is_waiting = self.replay.as_ref().is_some_and(Replay::is_waiting);
        if is_waiting && self.frame > 1 {
            let soon = Instant::now() + GLANCE;
            let next = self.next_frame.get_or_insert(soon);
            *next = soon.min(*next);
        } else if self.replay.is_some() || self.options.frames.is_some() {
            shown.window.request_redraw();
            return;
        }
        match self.next_frame {
            Some(at) if at <= Instant::now() => {
                self.next_frame = None;
                shown.window.request_redraw();
                event_loop.set_control_flow(ControlFlow::Wait);
            }
            Some(at) => event_loop.set_control_flow(ControlFlow::WaitUntil(at)),
            None => event_loop.set_control_flow(ControlFlow::Wait),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else {
            return;
        };
        match &event {
            WindowEvent::RedrawRequested => return self.redraw(event_loop),
            WindowEvent::CloseRequested => {
                if self.app.may_close() {
                    return self.stop(event_loop, Ok(()));
                }
                shown.window.request_redraw();
            }
            WindowEvent::Resized(size) => {
                if let Some(painter) = &mut shown.painter {
                    painter.resize([size.width, size.height]);
                }
            }
            WindowEvent::DroppedFile(path) => self.dropped.push(path.clone()),
            WindowEvent::HoveredFile(_) => self.app.set_hovered_file(true),
            WindowEvent::HoveredFileCancelled => self.app.set_hovered_file(false),
            _ => {}
        }
        // What is replayed is not disturbed from outside.
        let is_deaf = self.replay.is_some()
            && !matches!(
                event,
                WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. }
            );
        if !is_deaf && shown.input.on_window_event(&shown.window, &event).repaint {
            shown.window.request_redraw();
        }
    }
}

impl Viewer {
    fn stop(&mut self, event_loop: &ActiveEventLoop, result: Result<(), ViewerError>) {
        if self.result.is_ok() {
            self.result = result;
        }
        event_loop.exit();
    }

    fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        match self.draw() {
            Ok(true) => {}
            Ok(false) => self.stop(event_loop, Ok(())),
            Err(fault) => self.stop(event_loop, Err(fault)),
        }
    }

    /// One frame. False where it was the last.
    fn draw(&mut self) -> Result<bool, ViewerError> {
        let Some(shown) = &mut self.shown else {
            return Ok(true);
        };
        let Some(painter) = &mut shown.painter else {
            return Ok(true);
        };
        let start = Instant::now();
        let mut raw = shown.input.take_egui_input(&shown.window);
        // Files come by their paths.
        raw.dropped_files.clear();
        let mut demand = None;
        if let Some(replay) = &mut self.replay {
            let names = &self.names;
            let standing = Standing {
                is_settled: self.app.is_settled(),
                find: &|wanted| {
                    let found = names.iter().find(|(name, _)| name == wanted);
                    found.map(|(_, at)| *at)
                },
            };
            let (events, asked) = replay.frame(&standing)?;
            raw.events = events;
            raw.focused = true;
            self.time += FRAME;
            raw.time = Some(self.time);
            demand = asked;
        }
        if let Some(Demand::Drop(path)) = &demand {
            self.dropped.push(path.clone());
        }
        if let Some(recording) = &mut self.recording {
            recording.frame(&raw.events, &self.dropped);
        }
        if let Some(Demand::LoseDevice) = &demand {
            painter.gpu.device().destroy();
        }
        if let Some(Demand::Resize(size)) = &demand {
            let size = winit::dpi::LogicalSize::new(size.x, size.y);
            _ = shown.window.request_inner_size(size);
        }
        self.app.drop_files(std::mem::take(&mut self.dropped));

        let context = shown.context.clone();
        let mut surroundings = Surroundings {
            gpu: painter.gpu.clone(),
            interface: &mut painter.renderer,
        };
        let app = &mut self.app;
        let output = context.run_ui(raw, |ui| app.frame(ui, &mut surroundings));
        if let Some(update) = &output.platform_output.accesskit_update {
            self.names = names(update);
        }
        let delay = output
            .viewport_output
            .get(&egui::ViewportId::ROOT)
            .map_or(Duration::MAX, |viewport| viewport.repaint_delay);
        self.next_frame = Instant::now().checked_add(delay);
        if delay.is_zero() {
            shown.window.request_redraw();
            self.next_frame = None;
        }
        shown.window.set_title(&self.app.title());
        shown
            .input
            .handle_platform_output(&shown.window, output.platform_output);
        let interface = start.elapsed();
        let mut drawn = Drawn {
            primitives: context.tessellate(output.shapes, output.pixels_per_point),
            textures: output.textures_delta,
            pixels_per_point: output.pixels_per_point,
            background: background(&context),
        };
        self.frame += 1;
        let is_over = match (self.options.frames, &self.replay) {
            (Some(frames), _) => self.frame >= frames,
            (None, Some(replay)) => replay.is_over() && self.app.is_settled(),
            (None, None) => false,
        } || self.app.wants_to_close();
        let screenshot = match &demand {
            Some(Demand::Screenshot(path)) => Some(path.clone()),
            _ if is_over => self.options.screenshot.clone(),
            _ => None,
        };
        let painted = painter.paint(&drawn, screenshot.is_some());
        // What a lost device did not take, the next one gets anew.
        drawn.textures.clear();
        match painted {
            Ok(image) => {
                shown.failures = 0;
                if let (Some(path), Some(image)) = (screenshot, image) {
                    save(&path, &image)?;
                }
            }
            Err(fault) => {
                shown.failures += 1;
                if shown.failures > ATTEMPTS {
                    return Err(fault.into());
                }
                shown.restore(&self.options)?;
                self.app.device_is_new(&fault);
                shown.window.request_redraw();
            }
        }
        if let Some(Demand::Picture(path)) = &demand {
            self.app.save_picture(path);
        }
        if self.options.timings {
            let whole = start.elapsed();
            let [interface, rest] = [interface, whole - interface].map(|d| d.as_secs_f64() * 1e3);
            println!(
                "frame {}: {interface:.2} ms to make, {rest:.2} ms to show",
                self.frame
            );
        }
        Ok(!is_over)
    }
}

/// The colour of panels, as it is displayed.
fn background(context: &egui::Context) -> wgpu::Color {
    let [r, g, b, _] = context.global_style().visuals.panel_fill.to_array();
    let [r, g, b] = [r, g, b].map(|channel| f64::from(channel) / 255.0);
    wgpu::Color { r, g, b, a: 1.0 }
}

/// What carries a name, with the middle of where it is, in points.
fn names(update: &accesskit::TreeUpdate) -> Vec<(String, egui::Pos2)> {
    let named = |(_, node): &(accesskit::NodeId, accesskit::Node)| {
        let name = node.label().or(node.value())?.to_owned();
        let bounds = node.bounds()?;
        let middle = [bounds.x0 + bounds.x1, bounds.y0 + bounds.y1].map(|sum| sum as f32 * 0.5);
        Some((name, egui::Pos2::from(middle)))
    };
    update.nodes.iter().filter_map(named).collect()
}

/// Writes a PNG, whole or not at all.
fn save(path: &Path, image: &egui::ColorImage) -> Result<(), ViewerError> {
    let fault = |fault: &dyn std::fmt::Display| unwritable(path, fault);
    let [width, height] = image.size.map(|side| side as u32);
    let rgb: Vec<u8> = image
        .pixels
        .iter()
        .flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()])
        .collect();
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_raw(width, height, rgb)
        .ok_or_else(|| fault(&"the window has no pixels"))?
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|e| fault(&e))?;
    write_whole(path, |file| file.write_all(png.get_ref())).map_err(|e| fault(&e))
}
