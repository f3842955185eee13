//! What the window has to tell.

use egui::{Align2, Color32, Ui};

/// Lines that are kept.
const KEPT: usize = 200;
/// Seconds for which news stand over the picture; errors stay until they are clicked away.
const SECONDS: f64 = 6.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Notice,
    Warning,
    Error,
}

#[derive(Debug)]
struct Message {
    kind: Kind,
    text: String,
    /// When it was first on screen.
    since: Option<f64>,
}

/// Messages over the picture.
#[derive(Debug, Default)]
pub(super) struct Messages(Vec<Message>);

impl Messages {
    pub(super) fn notice(&mut self, text: impl Into<String>) {
        self.push(Kind::Notice, text.into());
    }

    pub(super) fn warning(&mut self, text: impl Into<String>) {
        self.push(Kind::Warning, text.into());
    }

    pub(super) fn error(&mut self, text: impl Into<String>) {
        self.push(Kind::Error, text.into());
    }

    fn push(&mut self, kind: Kind, text: String) {
        self.0.retain(|message| message.text != text);
        self.0.push(Message {
            kind,
            text,
            since: None,
        });
        let excess = self.0.len().saturating_sub(KEPT);
        self.0.drain(..excess);
    }

    /// Those of now, over the lower left of the picture.
    pub(super) fn show(&mut self, ui: &Ui, rect: egui::Rect) {
        let now = ui.input(|input| input.time);
        let mut closed = None;
        let mut next: Option<f64> = None;
        self.0.retain_mut(|message| {
            let since = *message.since.get_or_insert(now);
            if message.kind == Kind::Error {
                return true;
            }
            let left = since + SECONDS - now;
            next = Some(next.map_or(left, |next| next.min(left)));
            left > 0.0
        });
        if self.0.is_empty() {
            return;
        }
        if let Some(left) = next {
            ui.ctx().request_repaint_after_secs(left.max(0.01) as f32);
        }
        let corner = rect.left_bottom() + egui::vec2(10.0, -10.0);
        let area = egui::Area::new(egui::Id::unique("messages"))
            .pivot(Align2::LEFT_BOTTOM)
            .fixed_pos(corner)
            .show(ui.ctx(), |ui| {
                ui.set_max_width((rect.width() * 0.7).max(200.0));
                for (i, message) in self.0.iter().enumerate().rev().take(6).rev() {
                    let color = match message.kind {
                        Kind::Notice => Color32::from_gray(230),
                        Kind::Warning => Color32::from_rgb(255, 210, 120),
                        Kind::Error => Color32::from_rgb(255, 140, 130),
                    };
                    egui::Frame::popup(ui.style()).show(ui, |ui| {
                        ui.horizontal_top(|ui| {
                            let close = ui.small_button("x").on_hover_text("Close this message");
                            if close.clicked() {
                                closed = Some(i);
                            }
                            ui.add(
                                egui::Label::new(egui::RichText::new(&message.text).color(color))
                                    .wrap(),
                            );
                        });
                    });
                }
            });
        // It was placed by its height of the frame before.
        if area.response.rect.left_bottom().distance(corner) > 0.5 {
            ui.ctx().request_repaint();
        }
        if let Some(i) = closed {
            self.0.remove(i);
            ui.ctx().request_repaint();
        }
    }

    /// Closes the newest. False where there is none.
    pub(super) fn close(&mut self) -> bool {
        self.0.pop().is_some()
    }
}
