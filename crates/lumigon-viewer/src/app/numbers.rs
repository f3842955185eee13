//! Figures over the picture: what frames take, and what arrives at a point.

use std::collections::VecDeque;

use egui::{Color32, Response, RichText, Ui};
use egui_plot::{Legend, Line, Plot, PlotPoints};
use lumigon::{DiffuseMethod, LocalOcclusion, LtcLobes, ProjectionBasis, SpecularMethod};
use lumigon_renderer::{Probe, RenderSettings};

use super::App;
use super::display::FrameTimes;
use super::light_panel::number;

/// Frames that the graph shows.
const FRAMES: usize = 240;

/// What figures are shown, and those of the last frames.
#[derive(Default)]
pub(super) struct Numbers {
    pub(super) has_graph: bool,
    pub(super) has_probe: bool,
    frames: VecDeque<FrameTimes>,
    probe: Option<Probe>,
}

impl Numbers {
    /// Takes down what a frame took that made a picture.
    pub(super) fn push(&mut self, times: FrameTimes) {
        if self.frames.len() >= FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(times);
    }
}

/// Every method that a probe evaluates.
fn methods() -> Vec<(&'static str, RenderSettings)> {
    let exact = DiffuseMethod::default();
    let of = |diffuse, specular| RenderSettings {
        diffuse,
        specular,
        ..RenderSettings::default()
    };
    let occlusion = LocalOcclusion::Exact;
    let area = |basis| DiffuseMethod::ProjectedArea { basis, occlusion };
    let none = SpecularMethod::None;
    vec![
        ("exact", of(exact, none)),
        (
            "exact, circle horizon",
            of(
                DiffuseMethod::Exact {
                    occlusion: LocalOcclusion::Circle,
                },
                none,
            ),
        ),
        (
            "light vector",
            of(DiffuseMethod::LightVector { occlusion }, none),
        ),
        (
            "projected area, centroid",
            of(area(ProjectionBasis::Centroid), none),
        ),
        (
            "projected area, optimal",
            of(area(ProjectionBasis::Optimal), none),
        ),
        (
            "LTC, one lobe",
            of(
                exact,
                SpecularMethod::Ltc {
                    lobes: LtcLobes::One,
                },
            ),
        ),
        (
            "LTC, two lobes",
            of(
                exact,
                SpecularMethod::Ltc {
                    lobes: LtcLobes::Two,
                },
            ),
        ),
        (
            "mirror",
            of(
                exact,
                SpecularMethod::ReflectedInclusion(Default::default()),
            ),
        ),
        (
            "specular light vector",
            of(exact, SpecularMethod::LightVector),
        ),
    ]
}

/// Diffuse methods come first in [`methods`].
const DIFFUSE: usize = 5;

impl App {
    /// Asks what arrives under the pointer.
    pub(super) fn probe_at_pointer(&mut self, ui: &Ui, picture: &Response, aspect: f32) {
        self.pointer = picture.hover_pos().or(self.pointer);
        if !self.numbers.has_probe {
            self.numbers.probe = None;
            return;
        }
        let Some(at) = super::pointer_on(ui, self.picture_rect) else {
            return;
        };
        let place = self.to_picture(at);
        if let Some(open) = &self.open {
            let settings: Vec<_> = methods()
                .into_iter()
                .map(|(_, settings)| settings)
                .collect();
            let camera = open.navigation.camera();
            self.numbers.probe = open
                .display
                .probe(camera, place.to_array(), aspect, &settings);
        }
    }

    pub(super) fn show_numbers(&mut self, ui: &mut Ui) {
        let corner = self.picture_rect.right_top();
        if self.numbers.has_probe {
            egui::Window::new("Probe")
                .default_pos(corner + egui::vec2(-430.0, 10.0))
                .resizable(false)
                .show(ui, |ui| self.probe_table(ui));
        }
        if self.numbers.has_graph {
            egui::Window::new("Frame times")
                .default_pos(self.picture_rect.left_top() + egui::vec2(10.0, 40.0))
                .default_size([360.0, 200.0])
                .show(ui, |ui| self.graph(ui));
        }
    }

    fn probe_table(&self, ui: &mut Ui) {
        let Some(probe) = &self.numbers.probe else {
            ui.label("Point at a surface.");
            return;
        };
        let rgb = |value: [f64; 3]| value.map(number).join("  ");
        let single = |value: [f32; 3]| rgb(value.map(f64::from));
        egui::Grid::new("probe")
            .num_columns(2)
            .striped(true)
            .show(ui, |ui| {
                let mut row = |name: &str, value: String| {
                    ui.label(RichText::new(name).weak());
                    ui.label(RichText::new(value).monospace());
                    ui.end_row();
                };
                let p = probe.surface.position;
                row("place", format!("{:.3}  {:.3}  {:.3} m", p.x, p.y, p.z));
                row("material", probe.surface.material.clone());
                row("irradiance", rgb(probe.irradiance));
                row("form factor", number(probe.form_factor));
                for ((name, _), radiance) in methods().iter().zip(&probe.radiance).take(DIFFUSE) {
                    let value = match radiance {
                        Ok(radiance) => single(radiance.diffuse),
                        Err(fault) => fault.to_string(),
                    };
                    row(&format!("diffuse, {name}"), value);
                }
                for ((name, _), radiance) in methods().iter().zip(&probe.radiance).skip(DIFFUSE) {
                    let value = match radiance {
                        Ok(radiance) => single(radiance.specular),
                        Err(fault) => fault.to_string(),
                    };
                    row(&format!("specular, {name}"), value);
                }
            });
        ui.separator();
        ui.label(RichText::new("Strongest lights: form factor, distance").weak());
        let Some(open) = &self.open else {
            return;
        };
        for light in &probe.lights {
            let name = &open.document.scene().polygon_lights[light
                .light
                .min(open.document.scene().polygon_lights.len().saturating_sub(1))]
            .name;
            ui.label(format!(
                "{name}: {}, {} m",
                number(light.form_factor),
                number(light.distance)
            ));
        }
    }

    fn graph(&self, ui: &mut Ui) {
        let frames = &self.numbers.frames;
        let Some(last) = frames.back() else {
            ui.label("Nothing has moved yet.");
            return;
        };
        type Part = fn(&FrameTimes) -> f64;
        let parts: [(&str, Color32, Part); 5] = [
            ("picture", Color32::WHITE, |t| t.picture),
            ("visibility", Color32::from_rgb(120, 190, 255), |t| {
                t.visibility
            }),
            ("lights", Color32::from_rgb(255, 190, 60), |t| t.lights),
            ("bounce", Color32::from_rgb(130, 220, 120), |t| t.bounce),
            ("edits", Color32::from_rgb(255, 120, 160), |t| t.edits),
        ];
        ui.label(format!(
            "{:.1} ms a picture at {} x {}; parts on the CPU are the time of all threads",
            last.picture, last.size[0], last.size[1]
        ));
        Plot::new("frame times")
            .legend(Legend::default())
            .include_y(0.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .y_axis_label("ms")
            .height(190.0)
            .show(ui, |plot| {
                for (name, color, part) in parts {
                    let points: PlotPoints<'_> = frames
                        .iter()
                        .enumerate()
                        .map(|(i, times)| [i as f64, part(times)])
                        .collect();
                    plot.line(Line::new(name, points).color(color));
                }
            });
    }
}
