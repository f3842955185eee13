//! What the window shows and does.

mod commands;
mod dialogs;
mod display;
mod editing;
mod false_color;
mod hands;
mod light_panel;
mod messages;
mod methods;
mod numbers;
mod panels;
mod settings;
mod viewport;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Pos2, Rect, Ui};
use lumigon_renderer::{GltfSource, Gpu, GpuError, Scene};

use crate::document::{Document, LightId};
use crate::loading::{Loaded, Loading};
use crate::navigation::Navigation;
use crate::options::Options;
use crate::recovery::Recovery;
use commands::Command;
use dialogs::Dialog;
use display::Display;
use hands::Hands;
use messages::Messages;
use numbers::Numbers;
use settings::Settings;

/// What a frame may use of the window.
pub(crate) struct Surroundings<'a> {
    /// The window's device.
    pub(crate) gpu: Gpu,
    /// The interface's textures on it.
    pub(crate) interface: &'a mut egui_wgpu::Renderer,
}

/// A scene that is open.
pub(crate) struct Open {
    /// The file; none for the gallery.
    path: Option<PathBuf>,
    source: Arc<GltfSource>,
    /// As it was loaded, which saving compares with.
    original: Arc<Scene>,
    document: Document<Settings>,
    navigation: Navigation,
    /// Index of the file's camera that was last looked through.
    camera: usize,
    display: Display,
    recovery: Recovery,
    /// The document's version that recovery knows.
    kept_version: u64,
    selected: Option<LightId>,
    /// Settings are being changed, as one step.
    holds_settings: bool,
}

/// The window's state.
pub(crate) struct App {
    options: Options,
    wake: Arc<dyn Fn() + Send + Sync>,
    open: Option<Open>,
    loading: Option<(Loading, Option<PathBuf>)>,
    /// A scene that waits until the user has decided about what is not saved.
    next: Option<PathBuf>,
    dialog: Option<Dialog>,
    messages: Messages,
    hands: Hands,
    numbers: Numbers,
    /// Of the picture, in points.
    picture_rect: Rect,
    /// The share of the picture left of the divider.
    divider: f32,
    is_flying: bool,
    has_panels: bool,
    has_hovered_file: bool,
    /// The letter that a new letter light shows.
    letter: char,
    wants_to_close: bool,
    /// What is being loaded are edits that were kept.
    is_recovering: bool,
    /// The window is to close once nothing can be lost.
    is_leaving: bool,
    /// What is unsaved may be lost: the user said so.
    may_lose: bool,
    images: Option<editing::ImagesAtWork>,
    /// Where the pointer was on the picture.
    pointer: Option<Pos2>,
    /// A number of the selected light is being changed, as one step.
    holds_value: bool,
}

impl App {
    pub(crate) fn new(options: &Options, wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        let mut this = Self {
            options: options.clone(),
            wake,
            open: None,
            loading: None,
            next: None,
            dialog: None,
            messages: Messages::default(),
            hands: Hands::default(),
            numbers: Numbers::default(),
            picture_rect: Rect::ZERO,
            divider: 0.5,
            is_flying: false,
            has_panels: true,
            has_hovered_file: false,
            letter: 'A',
            wants_to_close: false,
            is_recovering: false,
            is_leaving: false,
            may_lose: false,
            images: None,
            pointer: None,
            holds_value: false,
        };
        this.load(options.scene.clone());
        this
    }

    /// Begins to load a scene, the gallery without a path. What is open stays until it is there.
    fn load(&mut self, path: Option<PathBuf>) {
        let wake = Arc::clone(&self.wake);
        let wake = Box::new(move || wake());
        let loading = match &path {
            Some(path) => Loading::start(path, wake),
            None => Loading::gallery(wake),
        };
        self.loading = Some((loading, path));
    }

    /// Loads what was kept of edits, in the place of what is open; it is not saved.
    fn recover(&mut self, file: &Path) {
        let path = self.open.as_ref().and_then(|open| open.path.clone());
        self.load(Some(file.to_owned()));
        if let Some((_, place)) = &mut self.loading {
            *place = path;
        }
        self.is_recovering = true;
    }

    fn poll_loading(&mut self) {
        let Some((loading, _)) = &mut self.loading else {
            return;
        };
        let Some(result) = loading.take() else {
            return;
        };
        let Some((_, path)) = self.loading.take() else {
            return;
        };
        match result {
            Ok(loaded) => self.show(loaded, path),
            Err(fault) => {
                self.is_recovering = false;
                self.messages.error(fault.to_string());
            }
        }
    }

    fn show(&mut self, loaded: Loaded, path: Option<PathBuf>) {
        let settings = match &self.open {
            // Methods stay as they are from scene to scene.
            Some(open) => open.document.settings().clone(),
            None => Settings {
                exposure: self.options.exposure,
                tone_map: self.options.tone_map,
                ..Settings::default()
            },
        };
        let limits = lumigon_renderer::Limits::default();
        let scene = Scene::clone(&loaded.scene);
        let mut document = Document::with_settings(scene, settings, limits);
        let is_recovered = std::mem::take(&mut self.is_recovering);
        if is_recovered {
            document.mark_unsaved();
        }
        for warning in &document.scene().warnings {
            self.messages.warning(warning.clone());
        }
        let camera = match path == self.options.scene {
            true => self.options.camera,
            false => 0,
        };
        let navigation = Navigation::new(document.scene(), camera);
        let display = Display::new(loaded.renderer, document.scene(), Arc::clone(&self.wake));
        if !is_recovered && let Some(found) = Recovery::found(path.as_deref()) {
            self.dialog = Some(Dialog::Recover(found));
        }
        let wake = Arc::clone(&self.wake);
        let recovery = Recovery::new(path.as_deref(), Box::new(move || wake()));
        self.hands = Hands::default();
        self.open = Some(Open {
            original: Arc::clone(document.scene()),
            kept_version: if is_recovered {
                u64::MAX
            } else {
                document.version()
            },
            source: loaded.source,
            path,
            document,
            navigation,
            camera,
            display,
            recovery,
            selected: None,
            holds_settings: false,
        });
    }

    /// One frame: input, edits, picture.
    pub(crate) fn frame(&mut self, ui: &mut Ui, surroundings: &mut Surroundings<'_>) {
        self.poll_loading();
        self.poll_images();
        self.choose_backend(surroundings);
        if !ui.ctx().text_edit_focused() && !self.is_flying_held(ui) {
            for command in commands::pressed(ui.ctx()) {
                self.run(command, ui.ctx());
            }
        }
        self.panels(ui);
        egui::CentralPanel::no_frame().show(ui, |ui| self.viewport(ui, surroundings));
        self.overlays(ui);
        self.show_dialog(ui);
        self.after_edits();
        if let Some(open) = &self.open
            && open.display.has_drawn
        {
            self.numbers.push(open.display.times);
        }
    }

    /// While the right button is held, letters fly.
    fn is_flying_held(&self, ui: &Ui) -> bool {
        ui.input(|input| {
            let at = input.pointer.press_origin();
            input.pointer.secondary_down() && at.is_some_and(|at| self.picture_rect.contains(at))
        })
    }

    fn choose_backend(&mut self, surroundings: &Surroundings<'_>) {
        if let Some(open) = &mut self.open
            && let Some(message) = open.display.choose(&surroundings.gpu, self.options.backend)
        {
            self.messages.notice(message);
        }
    }

    /// Whether nothing moves and nothing works in the background.
    pub(crate) fn is_settled(&self) -> bool {
        self.loading.is_none()
            && self.images.is_none()
            && self
                .open
                .as_ref()
                .is_none_or(|open| open.display.is_settled())
    }

    pub(crate) fn title(&self) -> String {
        let Some(open) = &self.open else {
            return "lumigon".to_owned();
        };
        let star = if open.document.is_saved() { "" } else { " *" };
        format!("{}{star} - lumigon", open.name())
    }

    pub(crate) fn set_hovered_file(&mut self, hovered: bool) {
        self.has_hovered_file = hovered;
    }

    /// Files that were dropped on the window: scenes are opened, images go onto a light.
    pub(crate) fn drop_files(&mut self, paths: Vec<PathBuf>) {
        for path in paths {
            self.has_hovered_file = false;
            let extension = path
                .extension()
                .and_then(|e| e.to_str())
                .unwrap_or_default();
            match extension.to_ascii_lowercase().as_str() {
                "glb" | "gltf" => self.open_scene(path),
                _ => self.drop_image(&path),
            }
        }
    }

    /// Opens a scene, after asking where something is not saved.
    fn open_scene(&mut self, path: PathBuf) {
        if self.is_saved() {
            self.load(Some(path));
        } else {
            self.next = Some(path);
            self.dialog = Some(Dialog::Unsaved);
        }
    }

    fn is_saved(&self) -> bool {
        self.open
            .as_ref()
            .is_none_or(|open| open.document.is_saved())
    }

    /// Whether the window may close; asks the user where something is not saved.
    pub(crate) fn may_close(&mut self) -> bool {
        if self.is_saved() || self.may_lose {
            return true;
        }
        self.next = None;
        self.is_leaving = true;
        self.dialog = Some(Dialog::Unsaved);
        false
    }

    pub(crate) fn wants_to_close(&self) -> bool {
        self.wants_to_close
    }

    /// The window is gone: what is unsaved is kept for the next time, unless the user gave it up.
    pub(crate) fn leave(&mut self) {
        if let Some(open) = &mut self.open {
            if open.document.is_saved() || self.may_lose {
                open.recovery.forget();
            } else if let Some(place) = open.recovery.finish() {
                eprintln!("lumigon: what was not saved is kept in {}", place.display());
            }
        }
    }

    /// The device was lost and replaced.
    pub(crate) fn device_is_new(&mut self, fault: &GpuError) {
        if let Some(open) = &mut self.open {
            open.display.forget_device();
        }
        let reason = match fault {
            GpuError::Lost { reason } if reason.is_empty() => "the GPU was lost".to_owned(),
            GpuError::Lost { reason } => format!("the GPU was lost: {reason}"),
            other => other.to_string(),
        };
        self.messages.error(format!(
            "{reason}. The window has a new one, and all edits are there."
        ));
    }

    /// Writes the picture without panels.
    pub(crate) fn save_picture(&mut self, path: &Path) {
        let Some(open) = &self.open else {
            return;
        };
        match open.display.save(path, open.document.settings()) {
            Ok(()) => self.messages.notice(format!("Saved {}", path.display())),
            Err(fault) => self.messages.error(fault.to_string()),
        }
    }
}

impl Open {
    fn name(&self) -> String {
        let name = self.path.as_deref().and_then(Path::file_name);
        name.map_or_else(
            || "gallery".to_owned(),
            |name| name.to_string_lossy().into_owned(),
        )
    }
}

/// How the window looks.
pub(crate) fn style(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        // Nothing moves by itself: an idle window is idle.
        style.animation_time = 0.0;
        style.interaction.tooltip_delay = 0.4;
    });
}

/// The pointer, where it is on the picture.
fn pointer_on(ui: &Ui, rect: Rect) -> Option<Pos2> {
    ui.input(|input| input.pointer.hover_pos())
        .filter(|at| rect.contains(*at))
}
