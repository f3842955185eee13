//! The picture, and the pointer on it.

use egui::{Align2, Color32, CursorIcon, FontId, Pos2, Rect, Response, Sense, Stroke, Ui};
use glam::{Vec2, Vec3};

use super::App;
use super::display::Wish;
use super::false_color::Scale;
use super::settings::Content;

/// Heights of the picture that one line of the wheel zooms by, as a factor.
const ZOOM_A_LINE: f32 = 1.12;

/// Width of the strip that takes hold of the divider, in points.
const DIVIDER: f32 = 10.0;

impl App {
    /// The middle of the window.
    pub(super) fn viewport(&mut self, ui: &mut Ui, surroundings: &mut super::Surroundings<'_>) {
        let rect = ui.max_rect();
        if rect.width() < 2.0 || rect.height() < 2.0 {
            return;
        }
        let response = ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Picture"));
        self.picture_rect = rect;
        let aspect = rect.width() / rect.height();
        self.navigate(ui, &response, aspect);
        let mut hands = std::mem::take(&mut self.hands);
        hands.handle(self, ui, &response, aspect);
        self.hands = hands;

        let pixels_per_point = ui.pixels_per_point();
        let size = [rect.width(), rect.height()]
            .map(|side| ((side * pixels_per_point).round() as u32).max(1));
        let is_moving = ui.input(|input| input.pointer.any_down()) || self.is_flying;
        if let Some(open) = &mut self.open {
            let wish = Wish {
                scene: open.document.scene(),
                camera: open.navigation.camera(),
                size,
                settings: open.document.settings(),
                is_moving,
            };
            open.display.frame(ui.ctx(), surroundings, &wish);
        }
        self.paint(ui, rect);
        self.divider(ui, rect);
        let hands = std::mem::take(&mut self.hands);
        hands.paint(self, ui, aspect);
        self.hands = hands;
        self.probe_at_pointer(ui, &response, aspect);
    }

    /// From points of the window to the picture's, 0 to 1 each way.
    pub(super) fn to_picture(&self, at: Pos2) -> Vec2 {
        let rect = self.picture_rect;
        Vec2::new(
            (at.x - rect.min.x) / rect.width(),
            (at.y - rect.min.y) / rect.height(),
        )
    }

    /// Where a point of the world is in the window.
    pub(super) fn to_window(&self, point: Vec3, aspect: f32) -> Option<Pos2> {
        let open = self.open.as_ref()?;
        let (place, _) = open.navigation.project(point, aspect)?;
        let rect = self.picture_rect;
        let at = rect.min + egui::vec2(place.x * rect.width(), place.y * rect.height());
        // Far outside of the window sums lose their digits.
        (at.x.abs() < 1e5 && at.y.abs() < 1e5).then_some(at)
    }

    fn navigate(&mut self, ui: &Ui, response: &Response, aspect: f32) {
        let pointer = response.hover_pos().map(|at| self.to_picture(at));
        self.is_flying = false;
        let height = self.picture_rect.height();
        let Some(open) = &mut self.open else {
            return;
        };
        let view = &mut open.navigation;
        let drag = response.drag_delta();
        let by = Vec2::new(drag.x, drag.y) / height;
        let modifiers = ui.input(|input| input.modifiers);
        if response.dragged_by(egui::PointerButton::Primary) {
            match (modifiers.shift, modifiers.command) {
                (true, _) => view.pan(by, aspect),
                (_, true) => view.look(by),
                _ => view.orbit(by),
            }
        } else if response.dragged_by(egui::PointerButton::Middle) {
            view.pan(by, aspect);
        } else if response.dragged_by(egui::PointerButton::Secondary) {
            view.look(by);
        }
        if response.is_pointer_button_down_on() && ui.input(|i| i.pointer.secondary_down()) {
            let (direction, seconds, fast) = ui.input(|input| {
                let axis = |more, less| {
                    let down = |key| f32::from(u8::from(input.key_down(key)));
                    down(more) - down(less)
                };
                use egui::Key;
                let direction = Vec3::new(
                    axis(Key::D, Key::A),
                    axis(Key::E, Key::Q),
                    axis(Key::W, Key::S),
                );
                (direction, input.stable_dt, input.modifiers.shift)
            });
            if direction != Vec3::ZERO {
                view.fly(direction, seconds, fast);
                self.is_flying = true;
                ui.ctx().request_repaint();
            }
        }
        if let Some(at) = pointer {
            let lines: f32 = ui.input(|input| {
                let of = |event: &egui::Event| match event {
                    egui::Event::MouseWheel { unit, delta, .. } => match unit {
                        egui::MouseWheelUnit::Point => delta.y / 40.0,
                        egui::MouseWheelUnit::Line => delta.y,
                        egui::MouseWheelUnit::Page => delta.y * 10.0,
                    },
                    egui::Event::Zoom(factor) => factor.ln() / ZOOM_A_LINE.ln(),
                    _ => 0.0,
                };
                input.events.iter().map(of).sum()
            });
            if lines != 0.0 {
                view.zoom(ZOOM_A_LINE.powf(lines.clamp(-20.0, 20.0)), at, aspect);
            }
        }
    }

    fn paint(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        let Some(open) = &self.open else {
            return;
        };
        let settings = open.document.settings();
        let middle = rect.min.x + rect.width() * self.divider;
        for (i, shot) in open.display.shots.iter().enumerate() {
            let part = match (i, settings.is_split) {
                (0, false) => rect,
                (0, true) => rect.with_max_x(middle),
                (_, true) => rect.with_min_x(middle),
                _ => continue,
            };
            let Some(texture) = shot.texture() else {
                continue;
            };
            let share = |x: f32| (x - rect.min.x) / rect.width();
            let uv = Rect::from_min_max(
                Pos2::new(share(part.min.x), 0.0),
                Pos2::new(share(part.max.x), 1.0),
            );
            painter.image(texture, part, uv, Color32::WHITE);
            if let Some(scale) = &shot.scale {
                legend(&painter.with_clip_rect(part), part, scale);
            }
            let content = settings.sides[i].content;
            if settings.is_split || content != Content::Picture {
                let text = match content {
                    Content::Reference | Content::Noise => content.name().to_owned(),
                    _ => {
                        let methods = super::methods::summary(&settings.sides[i].look);
                        format!("{}: {methods}", content.name())
                    }
                };
                let at = part.min + egui::vec2(8.0, 6.0);
                label(&painter.with_clip_rect(part), at, Align2::LEFT_TOP, &text);
            }
        }
    }

    fn divider(&mut self, ui: &Ui, rect: Rect) {
        let is_split = self
            .open
            .as_ref()
            .is_some_and(|open| open.document.settings().is_split);
        if !is_split {
            return;
        }
        let x = rect.min.x + rect.width() * self.divider;
        let strip = Rect::from_center_size(
            Pos2::new(x, rect.center().y),
            egui::vec2(DIVIDER, rect.height()),
        );
        let response = ui.interact(strip, ui.scope_id().with("divider"), Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, "Divider"));
        if response.dragged() {
            let x = (x + response.drag_delta().x - rect.min.x) / rect.width();
            self.divider = x.clamp(0.02, 0.98);
        }
        let is_held = response.hovered() || response.dragged();
        if is_held {
            ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        let width = if is_held { 3.0 } else { 1.5 };
        let x = rect.min.x + rect.width() * self.divider;
        let stroke = Stroke::new(width, Color32::from_white_alpha(220));
        ui.painter_at(rect).vline(x, rect.y_range(), stroke);
    }
}

/// Text that can be read over any picture.
pub(super) fn label(painter: &egui::Painter, at: Pos2, anchor: Align2, text: &str) -> Rect {
    let galley =
        painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let rect = anchor.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(170));
    painter.galley(rect.min, galley, Color32::WHITE);
    rect
}

/// What colours mean, at the foot of a side.
fn legend(painter: &egui::Painter, part: Rect, scale: &Scale) {
    let width = (part.width() * 0.6).min(320.0);
    let bar = Rect::from_min_size(
        Pos2::new(part.center().x - width * 0.5, part.max.y - 44.0),
        egui::vec2(width, 12.0),
    );
    painter.rect_filled(
        bar.expand2(egui::vec2(28.0, 26.0)),
        4.0,
        Color32::from_black_alpha(170),
    );
    let steps = 64;
    for i in 0..steps {
        let place = (i as f32 + 0.5) / steps as f32;
        let x = |i: usize| bar.min.x + bar.width() * i as f32 / steps as f32;
        let cell = Rect::from_x_y_ranges(x(i)..=x(i + 1), bar.y_range());
        painter.rect_filled(cell, 0.0, scale.color(place));
    }
    let font = FontId::proportional(12.0);
    for (place, text) in &scale.ticks {
        let at = Pos2::new(bar.min.x + bar.width() * place, bar.max.y + 3.0);
        painter.text(at, Align2::CENTER_TOP, text, font.clone(), Color32::WHITE);
    }
    let at = Pos2::new(bar.center().x, bar.min.y - 4.0);
    painter.text(at, Align2::CENTER_BOTTOM, scale.title, font, Color32::WHITE);
}
