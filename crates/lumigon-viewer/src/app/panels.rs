//! The panels around the picture.

use egui::{Align, Layout, RichText, Ui};

use super::App;
use super::commands::{COMMANDS, Command, Group};
use super::viewport::label;

/// Of panels: what is behind has their colour already, and filling takes software Vulkan long.
fn unfilled(ui: &Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).fill(egui::Color32::TRANSPARENT)
}

impl App {
    pub(super) fn panels(&mut self, ui: &mut Ui) {
        let mut run = Vec::new();
        egui::Panel::top("menu").frame(unfilled(ui)).show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                for group in Group::ALL {
                    ui.menu_button(group.name(), |ui| {
                        for entry in COMMANDS.iter().filter(|entry| entry.group == group) {
                            let key = ui.ctx().format_shortcut(&entry.shortcut);
                            let button = egui::Button::new(entry.name).shortcut_text(key);
                            let button = ui.add_enabled(self.can(entry.command), button);
                            if button.on_hover_text(entry.help).clicked() {
                                run.push(entry.command);
                                ui.close();
                            }
                        }
                    });
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let keys = ui
                        .button("?")
                        .on_hover_text("Every command and its key (F1)");
                    if keys.clicked() {
                        run.push(Command::Help);
                    }
                });
            });
        });
        if self.has_panels {
            egui::Panel::bottom("status")
                .frame(unfilled(ui))
                .show(ui, |ui| self.status(ui));
            egui::Panel::left("methods")
                .frame(unfilled(ui))
                .default_size(230.0)
                .size_range(160.0..=420.0)
                .show(ui, |ui| {
                    egui::ScrollArea::vertical().show(ui, |ui| self.methods(ui));
                });
            egui::Panel::right("light")
                .frame(unfilled(ui))
                .default_size(250.0)
                .size_range(180.0..=460.0)
                .show(ui, |ui| {
                    egui::ScrollArea::vertical().show(ui, |ui| self.light_panel(ui, &mut run));
                });
        }
        for command in run {
            self.run(command, ui.ctx());
        }
    }

    fn status(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let Some(open) = &self.open else {
                ui.label("No scene is open: drop a .glb or .gltf file here");
                return;
            };
            ui.label(open.display.status());
            ui.separator();
            let lights = open.document.scene().polygon_lights.len();
            ui.label(if lights == 1 {
                "1 light".to_owned()
            } else {
                format!("{lights} lights")
            });
            if let Some(convergence) = open.display.convergence() {
                ui.separator();
                let share = convergence.progress();
                ui.add(egui::ProgressBar::new(share).desired_width(90.0));
                let text = format!(
                    "reference: {} paths a pixel, {:.2} % noise",
                    convergence.paths,
                    convergence.noise * 100.0
                );
                ui.label(text).on_hover_text(
                    "How far the path-traced truth has come, and its mean relative standard error",
                );
            }
        });
    }

    /// What lies over the picture.
    pub(super) fn overlays(&mut self, ui: &mut Ui) {
        let rect = self.picture_rect;
        if let Some((loading, path)) = &self.loading {
            let what = path.as_ref().map_or_else(
                || "the gallery".to_owned(),
                |path| path.display().to_string(),
            );
            let percent = loading.fraction().map_or_else(String::new, |fraction| {
                format!(" ({:.0} %)", fraction * 100.0)
            });
            let text = format!("Loading {what}: {}{percent}", loading.phase());
            let painter = ui.ctx().layer_painter(egui::LayerId::new(
                egui::Order::Foreground,
                egui::Id::unique("loading"),
            ));
            label(&painter, rect.center(), egui::Align2::CENTER_CENTER, &text);
        }
        if self.has_hovered_file {
            let painter = ui.ctx().layer_painter(egui::LayerId::new(
                egui::Order::Foreground,
                egui::Id::unique("drop"),
            ));
            let text = "Drop a scene to open it, or an image onto a light";
            label(
                &painter,
                rect.center_bottom() - egui::vec2(0.0, 40.0),
                egui::Align2::CENTER_CENTER,
                text,
            );
        }
        self.messages.show(ui, rect);
        self.show_numbers(ui);
    }

    /// Every command and its key.
    pub(super) fn keys(ui: &mut Ui) {
        egui::ScrollArea::vertical()
            .max_height(520.0)
            .show(ui, |ui| {
                for group in Group::ALL {
                    ui.label(RichText::new(group.name()).strong());
                    egui::Grid::new(group.name())
                        .num_columns(3)
                        .striped(true)
                        .show(ui, |ui| {
                            for entry in COMMANDS.iter().filter(|entry| entry.group == group) {
                                ui.label(
                                    RichText::new(ui.ctx().format_shortcut(&entry.shortcut))
                                        .monospace(),
                                );
                                ui.label(entry.name);
                                ui.label(RichText::new(entry.help).weak());
                                ui.end_row();
                            }
                        });
                    ui.add_space(6.0);
                }
                ui.label(RichText::new("With the pointer").strong());
                for (what, does) in [
                    ("Drag", "turn around the scene"),
                    ("Shift+drag, middle drag", "move along the picture"),
                    (
                        "Right drag, Ctrl+drag",
                        "look around; with W A S D Q E fly, Shift faster",
                    ),
                    ("Wheel", "closer and farther"),
                    ("Click on a light", "select it"),
                    ("Drag a vertex", "move it in the light's plane"),
                    ("Double-click on an edge", "insert a vertex"),
                ] {
                    ui.horizontal(|ui| {
                        ui.label(RichText::new(what).monospace());
                        ui.label(RichText::new(does).weak());
                    });
                }
            });
    }
}
