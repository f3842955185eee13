//! What commands do.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use glam::{DVec2, Vec3};
use lumigon_renderer::{CpuRenderer, Limits, ToneMap};

use super::commands::Command;
use super::dialogs::Dialog;
use super::hands::Tool;
use super::settings::{Content, Settings};
use super::{App, Open};
use crate::document::{
    EditError, FinishedImages, Light, LightId, PictureFile, PictureFit, Preset, outline,
    plane_frame,
};
use crate::recovery::Edits;

/// Of a new light to the picture's height.
const NEW_SIZE: f64 = 0.25;

/// Pictures of lights that are being finished.
pub(super) struct ImagesAtWork {
    finished: Receiver<(FinishedImages, CpuRenderer<'static>)>,
}

impl App {
    /// Whether a command makes sense now.
    pub(super) fn can(&self, command: Command) -> bool {
        let Some(open) = &self.open else {
            return matches!(
                command,
                Command::Open | Command::Help | Command::Quit | Command::Deselect
            );
        };
        match command {
            Command::Undo => open.document.can_undo().is_some(),
            Command::Redo => open.document.can_redo().is_some(),
            Command::NextCamera => !open.document.scene().cameras.is_empty(),
            Command::SwapSides => open.document.settings().is_split,
            Command::FrameLight
            | Command::Shape
            | Command::Move
            | Command::Turn
            | Command::Scale
            | Command::InsertVertex
            | Command::AddHole
            | Command::Delete
            | Command::Duplicate
            | Command::TwoSided => open.selected.is_some(),
            _ => true,
        }
    }

    pub(super) fn run(&mut self, command: Command, context: &egui::Context) {
        if !self.can(command) {
            return;
        }
        let aspect = self.picture_rect.width() / self.picture_rect.height().max(1.0);
        match command {
            Command::Open => {
                let folder = self
                    .open
                    .as_ref()
                    .and_then(|open| open.path.as_deref()?.parent());
                let text =
                    folder.map_or_else(String::new, |folder| format!("{}/", folder.display()));
                self.dialog = Some(Dialog::Open(text));
            }
            Command::Save => match self.open.as_ref().and_then(|open| open.path.clone()) {
                Some(path) => self.save(path),
                None => self.run(Command::SaveAs, context),
            },
            Command::SaveAs => {
                let name = self.file_name("edited", "glb");
                self.dialog = Some(Dialog::SaveAs(name));
            }
            Command::SavePicture => {
                let name = self.file_name("picture", "png");
                self.dialog = Some(Dialog::SavePicture(name));
            }
            Command::Quit => {
                self.is_leaving = true;
                self.wants_to_close |= self.may_close();
            }
            Command::Help => {
                self.dialog = match self.dialog {
                    Some(Dialog::Keys) => None,
                    _ => Some(Dialog::Keys),
                }
            }
            Command::Panels => self.has_panels = !self.has_panels,
            Command::Timings => self.numbers.has_graph = !self.numbers.has_graph,
            Command::Probe => self.numbers.has_probe = !self.numbers.has_probe,
            Command::Undo | Command::Redo => {
                // What is being dragged is part of what is taken back.
                self.hands.give_up();
                self.hands.vertex = None;
                if let Some(open) = &mut self.open {
                    _ = match command {
                        Command::Undo => open.document.undo(),
                        _ => open.document.redo(),
                    };
                }
            }
            Command::Deselect => self.let_go(),
            Command::Shape => self.hands.tool = Tool::Shape,
            Command::Move => self.hands.tool = Tool::Move,
            Command::Turn => self.hands.tool = Tool::Turn,
            Command::Scale => self.hands.tool = Tool::Scale,
            Command::InsertVertex => {
                let pointer = context.input(|input| input.pointer.hover_pos());
                let mut hands = std::mem::take(&mut self.hands);
                let is_done = pointer.is_some_and(|at| hands.insert_vertex(self, at, aspect));
                self.hands = hands;
                if !is_done {
                    self.messages
                        .notice("Point at an edge of the selected light to insert a vertex there");
                }
            }
            Command::AddHole => {
                let pointer = context.input(|input| input.pointer.hover_pos());
                self.add_hole(pointer, aspect);
            }
            Command::Delete => self.delete(),
            Command::Duplicate => self.duplicate(aspect),
            Command::TwoSided => {
                if let Some((id, mut light)) = self.selected_light() {
                    light.two_sided = !light.two_sided;
                    self.change("two-sided", id, light);
                }
            }
            Command::AddRectangle => {
                let preset = |size| Preset::Rectangle {
                    width: 1.6 * size,
                    height: size,
                };
                self.add(preset, aspect);
            }
            Command::AddDisk => self.add(|diameter| Preset::Disk { diameter }, aspect),
            Command::AddStar => {
                let preset = |diameter| Preset::Star {
                    points: 5,
                    diameter,
                };
                self.add(preset, aspect);
            }
            Command::AddRing => {
                let preset = |diameter| Preset::Ring {
                    diameter,
                    hole: 0.6 * diameter,
                };
                self.add(preset, aspect);
            }
            Command::AddLetter => {
                let character = self.letter;
                self.add(|height| Preset::Letter { character, height }, aspect);
            }
            _ => self.run_view(command, aspect),
        }
        context.request_repaint();
    }

    /// Commands of the view and of the methods.
    fn run_view(&mut self, command: Command, aspect: f32) {
        let Some(open) = &mut self.open else {
            return;
        };
        let mut settings = open.document.settings().clone();
        let mut show = |content| {
            let side = usize::from(settings.is_split);
            let shown = &mut settings.sides[side].content;
            *shown = if *shown == content {
                Content::Picture
            } else {
                content
            };
        };
        let name = match command {
            Command::FrameAll => {
                if let Some((low, high)) = open.document.scene().bounds() {
                    open.navigation.frame([low, high], aspect);
                }
                return;
            }
            Command::FrameLight => {
                if let Some(light) = open.selected.and_then(|id| open.document.light(id)) {
                    let points = light
                        .loops
                        .iter()
                        .flatten()
                        .map(|&p| light.to_world(p).as_vec3());
                    let (low, high) = points
                        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| {
                            (l.min(p), h.max(p))
                        });
                    open.navigation.frame([low, high], aspect);
                }
                return;
            }
            Command::NextCamera => {
                let count = open.document.scene().cameras.len();
                open.look_through((open.camera + 1) % count);
                return;
            }
            Command::FirstView => {
                open.look_through(0);
                return;
            }
            Command::Split => {
                settings.is_split = !settings.is_split;
                "split view"
            }
            Command::SwapSides => {
                settings.sides.swap(0, 1);
                "swap sides"
            }
            Command::ShowPicture => {
                show(Content::Picture);
                "picture"
            }
            Command::ShowReference => {
                show(Content::Reference);
                "reference"
            }
            Command::ShowError => {
                show(Content::Error);
                "error"
            }
            Command::ShowNoise => {
                show(Content::Noise);
                "noise"
            }
            Command::ShowLightCounts => {
                show(Content::LightCounts);
                "lights per pixel"
            }
            Command::Brighter | Command::Darker => {
                let step = if command == Command::Brighter {
                    1.0
                } else {
                    -1.0
                };
                settings.exposure = (settings.exposure + step / 3.0).clamp(-10.0, 10.0);
                "exposure"
            }
            Command::NextToneMap => {
                let place = ToneMap::ALL
                    .iter()
                    .position(|&map| map == settings.tone_map);
                settings.tone_map = ToneMap::ALL[(place.unwrap_or(0) + 1) % ToneMap::ALL.len()];
                "tone map"
            }
            _ => return,
        };
        open.set_settings(name, settings, false);
    }

    /// Escape: what is being dragged, then what is open, then the selection.
    fn let_go(&mut self) {
        if self.hands.give_up() {
            if let Some(open) = &mut self.open {
                open.document.cancel();
            }
        } else if self.dialog.take().is_some() {
            self.next = None;
            self.is_leaving = false;
        } else if !self.messages.close()
            && let Some(open) = &mut self.open
        {
            open.selected = None;
        }
    }

    fn file_name(&self, suffix: &str, extension: &str) -> String {
        let path = self.open.as_ref().and_then(|open| open.path.clone());
        let path = path.unwrap_or_else(|| PathBuf::from("gallery.glb"));
        let stem = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let name = format!("{stem}-{suffix}.{extension}");
        path.with_file_name(name).display().to_string()
    }

    pub(super) fn begin(&mut self, step: &str) {
        if let Some(open) = &mut self.open {
            open.document.begin(step);
        }
    }

    pub(super) fn end(&mut self) {
        if let Some(open) = &mut self.open {
            open.document.end();
        }
    }

    pub(super) fn try_light(&mut self, id: LightId, light: Light) -> Result<(), EditError> {
        match &mut self.open {
            Some(open) => open.document.set_light(id, light),
            None => Ok(()),
        }
    }

    /// One step of its own. False where it was refused, which is told.
    pub(super) fn change(&mut self, step: &str, id: LightId, light: Light) -> bool {
        let Some(open) = &mut self.open else {
            return false;
        };
        let was_in_gesture = open.document.in_gesture();
        if !was_in_gesture {
            open.document.begin(step);
        }
        let result = open.document.set_light(id, light);
        if !was_in_gesture {
            open.document.end();
        }
        if let Err(fault) = &result {
            self.messages.error(fault.to_string());
        }
        result.is_ok()
    }

    fn add_hole(&mut self, pointer: Option<egui::Pos2>, aspect: f32) {
        let Some((id, mut light)) = self.selected_light() else {
            return;
        };
        if let Err(reason) = light.can_reshape() {
            self.messages.error(reason);
            return;
        }
        let at = pointer
            .and_then(|at| self.on_plane(&light, at, aspect))
            .filter(|&at| {
                light
                    .loops
                    .first()
                    .is_some_and(|outer| outline::contains(outer, at))
            })
            .unwrap_or_else(|| light.centroid());
        // As large as there is room, but for a rim.
        let Some((_, _, room)) = outline::nearest_edge(&light.loops, at) else {
            return;
        };
        let half = room * 0.5;
        let corner = |x: f64, y: f64| at + DVec2::new(x, y) * half;
        let hole = vec![
            corner(-1.0, -1.0),
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
        ];
        let hole = hole.into_iter().map(|p| at + (p - at) * 0.7).collect();
        if outline::add_hole(&mut light.loops, hole).is_some()
            && self.change("cut a hole", id, light)
        {
            self.hands.tool = Tool::Shape;
        }
    }

    fn delete(&mut self) {
        let Some((id, mut light)) = self.selected_light() else {
            return;
        };
        if let Some(corner) = self.hands.vertex.take() {
            let count = light.loops.get(corner.loop_index).map_or(0, Vec::len);
            let is_hole = corner.loop_index > 0;
            let is_done = match count {
                0 => false,
                1..=3 if is_hole => outline::delete_hole(&mut light.loops, corner.loop_index),
                _ => outline::delete_vertex(&mut light.loops, corner),
            };
            if is_done {
                self.change("delete vertex", id, light);
            } else {
                self.messages.error("A light keeps three vertices: let the vertex go (Escape) to delete the light itself");
            }
            return;
        }
        if let Some(open) = &mut self.open {
            open.document.remove_light(id);
            open.selected = None;
        }
    }

    fn duplicate(&mut self, aspect: f32) {
        let Some((id, light)) = self.selected_light() else {
            return;
        };
        let by = self.metres(light.world_from_plane.translation, 40.0, aspect);
        let Some(open) = &mut self.open else {
            return;
        };
        open.document.begin("duplicate light");
        let result = open.document.duplicate(id).and_then(|copy| {
            let moved = open
                .document
                .light(copy)
                .map(|light| light.moved(light.world_from_plane.matrix3.x_axis * by));
            match moved {
                Some(light) => open.document.set_light(copy, light).map(|()| copy),
                None => Ok(copy),
            }
        });
        open.document.end();
        match result {
            Ok(copy) => open.selected = Some(copy),
            Err(fault) => self.messages.error(fault.to_string()),
        }
    }

    /// A new light in the middle of the view, facing the camera, before what is seen there.
    fn add(&mut self, preset: impl FnOnce(f64) -> Preset, aspect: f32) {
        let Some(open) = &mut self.open else {
            return;
        };
        let camera = open.navigation.camera();
        let (origin, direction) = camera.ray(0.5, 0.5, aspect);
        let picked = open.display.pick(camera, glam::Vec2::splat(0.5), aspect);
        let bounds = open.document.scene().bounds();
        let extent = bounds.map_or(1.0, |(low, high)| (high - low).length());
        let distance = picked.map_or(extent * 0.5, |picked| picked.distance * 0.7);
        let center = (origin + direction * distance).as_dvec3();
        let height = self.metres(center, self.picture_rect.height(), aspect);
        let Some(open) = &mut self.open else {
            return;
        };
        let frame = plane_frame(center, -direction.as_dvec3());
        let mut light = match preset(height * NEW_SIZE).light(frame) {
            Ok(light) => light,
            Err(fault) => return self.messages.error(fault.to_string()),
        };
        light.radiance = typical_radiance(open);
        open.document.begin(&format!("new {}", light.name));
        let result = open.document.add_light(light);
        open.document.end();
        match result {
            Ok(id) => {
                open.selected = Some(id);
                self.hands.tool = Tool::Move;
            }
            Err(fault) => self.messages.error(fault.to_string()),
        }
    }

    /// An image onto the light under the pointer, or the selected one.
    pub(super) fn drop_image(&mut self, path: &Path) {
        let Some((id, light)) = self.drop_target() else {
            self.messages.error(format!(
                "{}: select a light to show an image on it, or drop a .glb or .gltf scene",
                path.display()
            ));
            return;
        };
        match PictureFile::read(path, &Limits::default()) {
            Ok(file) => {
                let light = light.with_picture(&file, PictureFit::Stretched);
                if self.change("image on light", id, light) {
                    self.messages
                        .notice(format!("{} shines from the light", path.display()));
                }
                if let Some(open) = &mut self.open {
                    open.selected = Some(id);
                }
            }
            Err(fault) => self.messages.error(fault.to_string()),
        }
    }

    fn drop_target(&self) -> Option<(LightId, Light)> {
        let aspect = self.picture_rect.width() / self.picture_rect.height().max(1.0);
        let under = self.pointer.and_then(|at| self.light_under(at, aspect));
        let open = self.open.as_ref()?;
        let id = under.or(open.selected)?;
        Some((id, open.document.light(id)?.clone()))
    }

    /// Writes the scene, and tells how it went.
    pub(super) fn save(&mut self, path: PathBuf) {
        let Some(open) = &mut self.open else {
            return;
        };
        match open.edits().save(&path) {
            Ok(()) => {
                self.messages.notice(format!("Saved {}", path.display()));
                open.document.mark_saved();
                open.recovery.forget();
                open.path = Some(path);
            }
            Err(fault) => self.messages.error(fault.to_string()),
        }
    }

    /// What edits leave to do: pictures to finish, and a copy for the case that all goes wrong.
    pub(super) fn after_edits(&mut self) {
        let Some(open) = &mut self.open else {
            return;
        };
        if self.images.is_none()
            && let Some(job) = open.document.finish_images()
        {
            let (send, finished) = channel();
            let wake = Arc::clone(&self.wake);
            let renderer = open.display.renderer();
            std::thread::spawn(move || {
                let finished = job.run();
                // Filters the pictures, so that no frame has to.
                let filtered = renderer.edited(Arc::new(finished.scene()));
                _ = send.send((finished, filtered));
                wake();
            });
            self.images = Some(ImagesAtWork { finished });
        }
        if !open.document.in_gesture() && open.document.version() != open.kept_version {
            open.kept_version = open.document.version();
            if open.document.is_saved() {
                open.recovery.forget();
            } else {
                open.recovery.keep(open.edits());
            }
        }
        if let Some(fault) = open.recovery.fault() {
            self.messages.warning(fault);
        }
        if let Some(fault) = open.display.fault.take() {
            self.messages.error(fault);
        }
    }

    pub(super) fn poll_images(&mut self) {
        let Some(work) = &self.images else {
            return;
        };
        match work.finished.try_recv() {
            Ok((finished, filtered)) => {
                if let Some(open) = &mut self.open
                    && open.document.apply_images(finished)
                {
                    open.display.take_renderer(filtered);
                }
                self.images = None;
            }
            Err(TryRecvError::Disconnected) => {
                self.messages
                    .error("An image could not be filtered: the light shows a coarse one");
                self.images = None;
            }
            Err(TryRecvError::Empty) => {}
        }
    }
}

impl Open {
    /// The scene as it is, for saving.
    fn edits(&self) -> Edits {
        let frame = |id| {
            let light = self.document.light(id)?;
            Some((self.document.own_mesh(id)?, light.world_from_plane))
        };
        Edits {
            source: Arc::clone(&self.source),
            original: Arc::clone(&self.original),
            edited: Arc::clone(self.document.scene()),
            frames: self.document.ids().filter_map(frame).collect(),
        }
    }

    pub(super) fn look_through(&mut self, camera: usize) {
        self.camera = camera;
        self.navigation = crate::navigation::Navigation::new(self.document.scene(), camera);
    }

    /// Changes settings: one step for as long as the pointer is held down.
    pub(super) fn set_settings(&mut self, name: &str, settings: Settings, is_held: bool) {
        if !self.document.in_gesture() {
            self.document.begin(name);
            self.holds_settings = true;
        }
        self.document.set_settings(settings);
        if !is_held {
            self.end_settings();
        }
    }

    pub(super) fn end_settings(&mut self) {
        if std::mem::take(&mut self.holds_settings) {
            self.document.end();
        }
    }
}

/// Radiance for a new light: what the others have in the middle, or 10.
fn typical_radiance(open: &Open) -> Vec3 {
    let lights = &open.document.scene().polygon_lights;
    let mut strengths: Vec<f32> = lights
        .iter()
        .map(|light| light.radiance.max_element())
        .collect();
    if strengths.is_empty() {
        return Vec3::splat(10.0);
    }
    let middle = strengths.len() / 2;
    let (_, &mut strength, _) = strengths.select_nth_unstable_by(middle, f32::total_cmp);
    Vec3::splat(strength)
}
