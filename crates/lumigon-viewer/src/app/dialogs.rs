//! Windows that ask.

use std::path::PathBuf;

use egui::{Align2, Ui};

use super::App;
use super::commands::Command;
use crate::recovery::Found;

/// Files that a dialog lists.
const LISTED: usize = 400;

/// A question, or the list of keys.
pub(super) enum Dialog {
    Keys,
    /// A path, as text.
    Open(String),
    SaveAs(String),
    SavePicture(String),
    /// Something is not saved, and would be lost.
    Unsaved,
    /// Edits from before that were not saved.
    Recover(Found),
}

/// What the user decided.
enum Answer {
    Close,
    Open(PathBuf),
    SaveAs(PathBuf),
    SavePicture(PathBuf),
    SaveAndGo,
    LoseAndGo,
    Recover(PathBuf),
    Forget,
}

impl App {
    pub(super) fn show_dialog(&mut self, ui: &mut Ui) {
        let Some(dialog) = &mut self.dialog else {
            return;
        };
        let mut answer = None;
        let title = match dialog {
            Dialog::Keys => "Keys",
            Dialog::Open(_) => "Open a scene",
            Dialog::SaveAs(_) => "Save the scene",
            Dialog::SavePicture(_) => "Save the picture",
            Dialog::Unsaved => "Not saved",
            Dialog::Recover(_) => "Edits from before",
        };
        let mut is_open = true;
        egui::Window::new(title)
            .open(&mut is_open)
            .collapsible(false)
            .resizable(matches!(dialog, Dialog::Keys))
            .pivot(Align2::CENTER_CENTER)
            .default_pos(self.picture_rect.center())
            .show(ui, |ui| {
                answer = match dialog {
                    Dialog::Keys => {
                        Self::keys(ui);
                        None
                    }
                    Dialog::Open(path) => {
                        path_row(ui, path, "Open", &["glb", "gltf"]).map(Answer::Open)
                    }
                    Dialog::SaveAs(path) => {
                        ui.label("A .glb holds everything in one file; .gltf is text.");
                        path_row(ui, path, "Save here", &["glb", "gltf"]).map(Answer::SaveAs)
                    }
                    Dialog::SavePicture(path) => {
                        ui.label("A .png is what you see; an .exr holds linear radiance.");
                        path_row(ui, path, "Save here", &["png", "exr"]).map(Answer::SavePicture)
                    }
                    Dialog::Unsaved => {
                        ui.label("The scene has changes that are not saved.");
                        ui.horizontal(|ui| {
                            let save = ui.button("Save").on_hover_text("Save, then go on");
                            let lose = ui.button("Do not save").on_hover_text("The changes are lost");
                            let stay = ui.button("Stay").on_hover_text("Back to the scene");
                            if save.clicked() {
                                Some(Answer::SaveAndGo)
                            } else if lose.clicked() {
                                Some(Answer::LoseAndGo)
                            } else if stay.clicked() {
                                Some(Answer::Close)
                            } else {
                                None
                            }
                        })
                        .inner
                    }
                    Dialog::Recover(found) => {
                        ui.label(format!(
                            "This scene was edited {} and not saved.",
                            found.when()
                        ));
                        ui.horizontal(|ui| {
                            if ui.button("Take the edits up").clicked() {
                                Some(Answer::Recover(found.file.clone()))
                            } else if ui.button("Forget them").clicked() {
                                Some(Answer::Forget)
                            } else {
                                None
                            }
                        })
                        .inner
                    }
                };
            });
        if !is_open {
            answer = Some(Answer::Close);
        }
        if let Some(answer) = answer {
            let dialog = self.dialog.take();
            self.decide(answer, dialog, ui.ctx());
        }
    }

    fn decide(&mut self, answer: Answer, dialog: Option<Dialog>, context: &egui::Context) {
        match answer {
            Answer::Close => self.next = None,
            Answer::Open(path) => self.open_scene(path),
            Answer::SaveAs(path) => {
                self.save(path);
                self.go_on();
            }
            Answer::SavePicture(path) => self.save_picture(&path),
            Answer::SaveAndGo => {
                self.run(Command::Save, context);
                self.go_on();
            }
            Answer::LoseAndGo => {
                self.may_lose = true;
                self.go_on();
            }
            Answer::Recover(file) => self.recover(&file),
            Answer::Forget => {
                if let Some(Dialog::Recover(found)) = dialog {
                    found.forget();
                }
            }
        }
    }

    /// Does what waited for the user's decision, once nothing can be lost.
    fn go_on(&mut self) {
        if !(self.is_saved() || self.may_lose) {
            return;
        }
        match self.next.take() {
            Some(path) => {
                self.load(Some(path));
                self.may_lose = false;
            }
            None => self.wants_to_close |= self.is_leaving,
        }
    }
}

/// A path to type, and the files beside it to choose from.
fn path_row(ui: &mut Ui, path: &mut String, verb: &str, extensions: &[&str]) -> Option<PathBuf> {
    let edit = egui::TextEdit::singleline(path).desired_width(420.0);
    let edit = ui.add(edit);
    if !ui.ctx().memory(|memory| memory.focused().is_some()) {
        edit.request_focus();
    }
    edit.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Path"));
    let typed = PathBuf::from(path.trim());
    let folder = match typed.is_dir() {
        true => Some(typed.as_path()),
        false => typed.parent(),
    };
    let folder = match folder {
        Some(folder) if folder.as_os_str().is_empty() => Some(std::path::Path::new(".")),
        other => other,
    };
    let mut entries: Vec<(bool, PathBuf)> = folder
        .and_then(|folder| std::fs::read_dir(folder).ok())
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .map(|path| (path.is_dir(), path))
        .filter(|(is_folder, path)| {
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            !hidden && (*is_folder || extensions.contains(&extension.to_ascii_lowercase().as_str()))
        })
        .take(LISTED)
        .collect();
    entries.sort_by(|(a, x), (b, y)| b.cmp(a).then_with(|| x.cmp(y)));
    egui::ScrollArea::vertical().max_height(220.0).show(ui, |ui| {
        if let Some(up) = folder.and_then(|folder| folder.canonicalize().ok()?.parent().map(PathBuf::from))
            && ui.selectable_label(false, "..").clicked()
        {
            *path = format!("{}/", up.display());
        }
        for (is_folder, entry) in &entries {
            let name = entry.file_name().unwrap_or_default().to_string_lossy();
            let name = if *is_folder { format!("{name}/") } else { name.into_owned() };
            if ui.selectable_label(false, name).clicked() {
                let end = if *is_folder { "/" } else { "" };
                *path = format!("{}{end}", entry.display());
            }
        }
    });
    let is_ready = !typed.as_os_str().is_empty() && !typed.is_dir();
    let entered = ui.input(|input| input.key_pressed(egui::Key::Enter));
    let button = ui.add_enabled(is_ready, egui::Button::new(verb));
    (is_ready && (entered || button.clicked())).then_some(typed)
}
