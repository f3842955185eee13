//! The panel of the selected light, and of all lights.

use egui::{DragValue, RichText, Ui};
use glam::{DVec3, Vec3};

use super::App;
use super::commands::Command;
use super::hands::Tool;
use crate::document::{Light, LightPicture, PictureImage, flux};

/// Lights that the list shows.
const LISTED: usize = 300;

impl App {
    pub(super) fn light_panel(&mut self, ui: &mut Ui, run: &mut Vec<Command>) {
        if self.open.is_none() {
            return;
        }
        ui.heading("New light");
        ui.horizontal_wrapped(|ui| {
            for (command, name) in [
                (Command::AddRectangle, "rectangle"),
                (Command::AddDisk, "disk"),
                (Command::AddStar, "star"),
                (Command::AddRing, "ring"),
                (Command::AddLetter, "letter"),
            ] {
                if ui
                    .button(name)
                    .on_hover_text(command.entry().help)
                    .clicked()
                {
                    run.push(command);
                }
            }
            let mut text = self.letter.to_string();
            let edit = egui::TextEdit::singleline(&mut text).desired_width(22.0);
            if ui.add(edit).on_hover_text("The letter").changed()
                && let Some(letter) = text.chars().next_back().filter(|c| !c.is_whitespace())
            {
                self.letter = letter;
            }
        });
        ui.separator();
        self.selected_panel(ui, run);
        ui.separator();
        self.list(ui);
    }

    fn list(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else {
            return;
        };
        ui.heading("Lights");
        let ids: Vec<_> = open.document.ids().take(LISTED + 1).collect();
        for &id in ids.iter().take(LISTED) {
            let polygon = open.document.polygons_of(id).next();
            let polygon = polygon.and_then(|i| open.document.scene().polygon_lights.get(i));
            let name = polygon.map_or("", |polygon| polygon.name.as_str());
            let name = if name.is_empty() { "light" } else { name }.to_owned();
            let response = ui.selectable_label(open.selected == Some(id), name);
            if response.clicked() {
                open.selected = Some(id);
                self.hands.vertex = None;
            }
        }
        if ids.len() > LISTED {
            ui.label(RichText::new("and more: click on them in the picture").weak());
        }
    }

    fn selected_panel(&mut self, ui: &mut Ui, run: &mut Vec<Command>) {
        let Some((id, light)) = self.selected_light() else {
            ui.label("Click on a light to take hold of it.");
            return;
        };
        let mut new = light.clone();
        ui.heading(if light.name.is_empty() {
            "Light"
        } else {
            &light.name
        });
        ui.horizontal_wrapped(|ui| {
            for (tool, command) in [
                (Tool::Shape, Command::Shape),
                (Tool::Move, Command::Move),
                (Tool::Turn, Command::Turn),
                (Tool::Scale, Command::Scale),
            ] {
                let entry = command.entry();
                let label = ui.selectable_label(self.hands.tool == tool, entry.name);
                if label.on_hover_text(entry.help).clicked() {
                    run.push(command);
                }
            }
        });
        if let Err(reason) = light.can_reshape() {
            ui.label(RichText::new(reason).weak());
        }
        egui::Grid::new("light").num_columns(2).show(ui, |ui| {
            ui.label("Name");
            ui.add(egui::TextEdit::singleline(&mut new.name).desired_width(150.0));
            ui.end_row();
            strength(ui, &mut new);
            ui.label("Two-sided");
            ui.checkbox(&mut new.two_sided, "")
                .on_hover_text("It emits from its back too (B)");
            ui.end_row();
            place(ui, &mut new);
            ui.label("Area");
            ui.label(format!("{} m²", number(light.area())));
            ui.end_row();
            ui.label("Vertices");
            let count: usize = light.loops.iter().map(Vec::len).sum();
            let holes = light.loops.len() - 1;
            ui.label(match holes {
                0 => format!("{count}"),
                _ => format!("{count}, {} loops", light.loops.len()),
            });
            ui.end_row();
            ui.label("Image");
            ui.horizontal(|ui| match &light.picture {
                Some(picture) => {
                    ui.label(picture_name(picture));
                    if ui
                        .button("Remove")
                        .on_hover_text("One colour instead of the image")
                        .clicked()
                    {
                        new = light.without_picture();
                    }
                }
                None => {
                    ui.label(RichText::new("drop one here").weak());
                }
            });
            ui.end_row();
        });
        ui.horizontal_wrapped(|ui| {
            for command in [
                Command::FrameLight,
                Command::InsertVertex,
                Command::AddHole,
                Command::Duplicate,
                Command::Delete,
            ] {
                let entry = command.entry();
                let button = ui.add_enabled(self.can(command), egui::Button::new(entry.name));
                if button.on_hover_text(entry.help).clicked() {
                    run.push(command);
                }
            }
        });
        // A drag of a number is one step, like a drag of a handle.
        let is_held = ui.input(|input| input.pointer.any_down());
        if new != light {
            if !self.holds_value {
                self.begin("change light");
                self.holds_value = true;
            }
            if let Err(fault) = self.try_light(id, new) {
                self.messages.error(fault.to_string());
            }
        }
        if self.holds_value && !is_held {
            self.holds_value = false;
            self.end();
        }
    }
}

/// Colour, and how strong: as radiance, or as lumens.
fn strength(ui: &mut Ui, light: &mut Light) {
    let (mut color, mut strength) = flux::color_and_strength(light.radiance);
    ui.label("Colour");
    let mut rgb = color.to_array();
    // Only what the user changed: on its way through the button a colour is rounded.
    let is_color_changed = ui
        .color_edit_button_rgb(&mut rgb)
        .on_hover_text("Linear red, green and blue, the largest 1")
        .changed();
    if is_color_changed {
        color = Vec3::from(rgb);
    }
    ui.end_row();
    ui.label("Radiance");
    let speed = f64::from(strength.max(0.01)) * 0.01;
    let drag = DragValue::new(&mut strength).speed(speed).range(0.0..=1e9);
    let is_strength_changed = ui
        .add(drag)
        .on_hover_text("Of the strongest channel: W m⁻² sr⁻¹, or nits, which glTF means by it")
        .changed();
    ui.end_row();
    if is_strength_changed || is_color_changed {
        light.radiance = color * strength;
    }
    ui.label("Luminance");
    ui.label(format!("{} nits", number(flux::luminance(light.radiance))));
    ui.end_row();
    ui.label("Lumens");
    let mut lumens = light.lumens();
    let speed = lumens.max(0.01) * 0.01;
    let drag = DragValue::new(&mut lumens).speed(speed).range(0.0..=1e12);
    let help = "All light that leaves it: π times area times luminance, twice that if two-sided";
    if ui.add(drag).on_hover_text(help).changed()
        && let Some(new) = light.with_lumens(lumens)
    {
        *light = new;
    }
    ui.end_row();
}

fn place(ui: &mut Ui, light: &mut Light) {
    ui.label("Place");
    let before = light.world_from_plane.translation;
    let mut place = before;
    ui.horizontal(|ui| {
        for value in [&mut place.x, &mut place.y, &mut place.z] {
            ui.add(DragValue::new(value).speed(0.01).max_decimals(3));
        }
    });
    ui.end_row();
    if place != before && place.is_finite() {
        *light = light.moved(place - before);
    }
    ui.label("Turn");
    let axes = light.world_from_plane.matrix3;
    ui.horizontal(|ui| {
        for (axis, name) in [(axes.x_axis, "x"), (axes.y_axis, "y"), (axes.z_axis, "n")] {
            let mut degrees = 0.0;
            let drag = DragValue::new(&mut degrees)
                .prefix(format!("{name} "))
                .suffix("°")
                .speed(0.5);
            if ui
                .add(drag)
                .on_hover_text("Drag to turn about this axis of the light")
                .changed()
            {
                *light = light.turned(
                    DVec3::normalize_or(axis, DVec3::Z),
                    f64::to_radians(degrees),
                );
            }
        }
    });
    ui.end_row();
}

fn picture_name(picture: &LightPicture) -> String {
    match &picture.image {
        PictureImage::Scene(_) => "of the scene".to_owned(),
        PictureImage::File(file) => file.name.clone(),
    }
}

/// Four digits.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let digits = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}
