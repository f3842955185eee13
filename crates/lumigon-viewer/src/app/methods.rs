//! The panel of methods.

use egui::{RichText, Slider, Ui};
use lumigon::{
    DiffuseMethod, DistanceFieldSettings, DistanceFieldSmoothness, ImageMethod, InclusionRule,
    LocalOcclusion, LtcLobes, ProjectionBasis, SpecularMethod,
};
use lumigon_renderer::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, MAXIMUM_BOUNCES, ToneMap,
    VirtualLightKind,
};

use super::App;
use super::settings::{Content, Look, Settings, Side};

/// Virtual lights where bounce light begins: few enough to follow the pointer.
const VIRTUAL_LIGHTS: u32 = 256;

impl App {
    pub(super) fn methods(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else {
            return;
        };
        let before = open.document.settings().clone();
        let mut settings = before.clone();
        ui.heading("Picture");
        ui.add(
            Slider::new(&mut settings.exposure, -10.0..=10.0)
                .text("stops")
                .step_by(0.05),
        )
        .on_hover_text("Exposure: one stop more doubles the brightness ( [ and ] )");
        let tone_maps = ToneMap::ALL.map(|map| (map, map.name(), tone_map_help(map)));
        choice(ui, "Tone map", &mut settings.tone_map, &tone_maps);
        ui.checkbox(&mut settings.is_split, "Split view")
            .on_hover_text("Two sides with methods of their own, and a divider to drag (S)");
        ui.checkbox(&mut settings.reference_shadows, "Shadows in the reference").on_hover_text(
            "The methods' light passes through surfaces. Without shadows the reference shows what they \
             stand for, with shadows what is true",
        );
        let count = settings.shown().len();
        for (i, side) in settings.sides.iter_mut().take(count).enumerate() {
            ui.separator();
            let name = match (count, i) {
                (1, _) => "Methods",
                (_, 0) => "Left side",
                _ => "Right side",
            };
            ui.push_id(i, |ui| {
                ui.heading(name);
                side_controls(ui, side);
            });
        }
        ui.separator();
        ui.heading("Cameras");
        if ui
            .button("Show all")
            .on_hover_text("Move back until the whole scene is in view (Home)")
            .clicked()
        {
            self.run(super::Command::FrameAll, ui.ctx());
        }
        let Some(open) = &mut self.open else {
            return;
        };
        let names: Vec<String> = open
            .document
            .scene()
            .cameras
            .iter()
            .map(|camera| camera.name.clone())
            .collect();
        for (i, name) in names.into_iter().enumerate() {
            let name = if name.is_empty() {
                format!("camera {}", i + 1)
            } else {
                name
            };
            if ui.selectable_label(open.camera == i, name).clicked() {
                open.look_through(i);
            }
        }
        if settings != before {
            let name = change(&before, &settings);
            open.set_settings(name, settings, ui.input(|input| input.pointer.any_down()));
        } else if !ui.input(|input| input.pointer.any_down()) {
            open.end_settings();
        }
    }
}

/// What a step of changing settings is called.
fn change(before: &Settings, after: &Settings) -> &'static str {
    if before.exposure != after.exposure {
        "exposure"
    } else if before.tone_map != after.tone_map {
        "tone map"
    } else if before.is_split != after.is_split {
        "split view"
    } else {
        "methods"
    }
}

fn tone_map_help(map: ToneMap) -> &'static str {
    match map {
        ToneMap::None => "True colours up to white, nothing beyond",
        ToneMap::Reinhard => "Bright things are pressed together, white is never reached",
        ToneMap::Aces => "As films look: contrast, and soft highlights",
        ToneMap::KhronosPbrNeutral => "Base colours keep hue and saturation",
    }
}

fn side_controls(ui: &mut Ui, side: &mut Side) {
    let contents = Content::ALL.map(|content| (content, content.name(), content.help()));
    choice(ui, "Shows", &mut side.content, &contents);
    look_controls(ui, &mut side.look);
}

fn look_controls(ui: &mut Ui, look: &mut Look) {
    diffuse_controls(ui, &mut look.diffuse);
    specular_controls(ui, &mut look.specular);
    let taps = |taps| ImageMethod::Quadrature { taps };
    choice(
        ui,
        "Images",
        &mut look.images,
        &[
            (taps(1), "1 tap", "One tap where the weight is"),
            (taps(2), "2 x 2 taps", "Four taps"),
            (taps(3), "3 x 3 taps", "Nine taps"),
            (taps(4), "4 x 4 taps", "Sixteen taps"),
            (
                ImageMethod::Lookup,
                "one lookup",
                "Gaussian levels along the light vector: common practice",
            ),
        ],
    );
    ui.add(
        Slider::new(&mut look.light_bound, 0.0..=1.0)
            .logarithmic(true)
            .smallest_positive(1e-6)
            .text("light bound"),
    )
    .on_hover_text(
        "A GPU may leave out lights that add less radiance than this to a pixel; 0 leaves out none",
    );
    bounce_controls(ui, &mut look.bounce);
}

fn diffuse_controls(ui: &mut Ui, method: &mut DiffuseMethod) {
    let (mut basis, mut occlusion) = match *method {
        DiffuseMethod::ProjectedArea { basis, occlusion } => (basis, occlusion),
        DiffuseMethod::Exact { occlusion } | DiffuseMethod::LightVector { occlusion } => {
            (ProjectionBasis::Optimal, occlusion)
        }
    };
    let mut kind = match method {
        DiffuseMethod::Exact { .. } => 0,
        DiffuseMethod::LightVector { .. } => 1,
        DiffuseMethod::ProjectedArea { .. } => 2,
    };
    choice(
        ui,
        "Diffuse",
        &mut kind,
        &[
            (0, "exact", "The integral itself, by Lambert's formula"),
            (
                1,
                "light vector",
                "As if all light came along the light vector",
            ),
            (2, "projected area", "The area in a perspective projection"),
        ],
    );
    if kind == 2 {
        let bias = match basis {
            ProjectionBasis::Biased { bias } => bias,
            _ => 0.5,
        };
        choice(
            ui,
            "Axis",
            &mut basis,
            &[
                (
                    ProjectionBasis::Centroid,
                    "centroid",
                    "Towards the light's centroid",
                ),
                (
                    ProjectionBasis::Weighted,
                    "weighted",
                    "Towards the mean of the vertices, weighted by inverse distance",
                ),
                (
                    ProjectionBasis::Biased { bias },
                    "biased",
                    "Towards the centroid, from a point behind",
                ),
                (
                    ProjectionBasis::Optimal,
                    "optimal",
                    "The axis of the right pyramid",
                ),
            ],
        );
    }
    choice(
        ui,
        "Horizon",
        &mut occlusion,
        &[
            (
                LocalOcclusion::Exact,
                "exact",
                "Lights are cut where they cross the surface's horizon",
            ),
            (
                LocalOcclusion::Circle,
                "circle",
                "A ramp over the height of the light's circle: common practice",
            ),
        ],
    );
    *method = match kind {
        0 => DiffuseMethod::Exact { occlusion },
        1 => DiffuseMethod::LightVector { occlusion },
        _ => DiffuseMethod::ProjectedArea { basis, occlusion },
    };
}

fn specular_controls(ui: &mut Ui, method: &mut SpecularMethod) {
    let field = match *method {
        SpecularMethod::ReflectedDistanceField { .. } => *method,
        _ => SpecularMethod::ReflectedDistanceField {
            field: DistanceFieldSettings::default(),
            smoothness: DistanceFieldSmoothness::default(),
        },
    };
    let ltc = |lobes| SpecularMethod::Ltc { lobes };
    choice(
        ui,
        "Specular",
        method,
        &[
            (
                ltc(LtcLobes::One),
                "LTC, one lobe",
                "A linearly transformed cosine from the fitted table",
            ),
            (
                ltc(LtcLobes::Two),
                "LTC, two lobes",
                "Two of them: more exact, about twice the cost",
            ),
            (
                SpecularMethod::ReflectedInclusion(InclusionRule::CrossingNumber),
                "mirror (crossing)",
                "Whether the mirrored view ray meets the light, by crossings of its outline",
            ),
            (
                SpecularMethod::ReflectedInclusion(InclusionRule::WindingNumber),
                "mirror (winding)",
                "Whether the mirrored view ray meets the light, by how the outline winds",
            ),
            (
                field,
                "distance field",
                "The mirrored ray's distance from the light, baked once",
            ),
            (
                SpecularMethod::LightVector,
                "light vector",
                "The BRDF along the light vector",
            ),
            (SpecularMethod::None, "none", "No specular light"),
        ],
    );
    if let SpecularMethod::ReflectedDistanceField { field, smoothness } = method {
        let mut resolution = field.resolution();
        let sizes = [32, 64, 128, 256, 512].map(|size| {
            (
                size,
                SIZES[u32::ilog2(size) as usize - 5],
                "Texels along a side",
            )
        });
        choice(ui, "Field", &mut resolution, &sizes);
        let mut is_signed = field.is_signed();
        ui.checkbox(&mut is_signed, "signed")
            .on_hover_text("Distances inside the outline too");
        if let Ok(new) = DistanceFieldSettings::new(resolution, field.phi(), is_signed) {
            *field = new;
        }
        let [mut factor, _] = smoothness.factor_and_constant();
        let slider = Slider::new(&mut factor, 0.1..=10.0)
            .logarithmic(true)
            .text("smoothness");
        let slider = ui.add(slider);
        if slider
            .on_hover_text("How fast reflections fade with the distance")
            .changed()
            && let Ok(new) = DistanceFieldSmoothness::of_material(factor)
        {
            *smoothness = new;
        }
    }
}

/// Powers of two from 32.
const SIZES: [&str; 5] = ["32 x 32", "64 x 64", "128 x 128", "256 x 256", "512 x 512"];

fn bounce_controls(ui: &mut Ui, bounce: &mut Option<BounceSettings>) {
    let mut bounces = bounce.is_some();
    ui.checkbox(&mut bounces, "Bounce light")
        .on_hover_text("Light that surfaces reflect onto others, by virtual lights");
    if !bounces {
        *bounce = None;
        return;
    }
    let settings = bounce.get_or_insert_with(|| BounceSettings {
        virtual_lights: VIRTUAL_LIGHTS,
        face_size: 32,
        ..BounceSettings::default()
    });
    choice(
        ui,
        "Found by",
        &mut settings.method,
        &[
            (
                BounceMethod::CubeMap,
                "cube maps",
                "What cube maps see, lit by all lights",
            ),
            (
                BounceMethod::ReflectiveShadowMaps,
                "shadow maps",
                "What each light sees, lit by it alone",
            ),
        ],
    );
    let scene = match settings.centers {
        BounceCenters::Scene(count) => count,
        _ => 4,
    };
    choice(
        ui,
        "From",
        &mut settings.centers,
        &[
            (
                BounceCenters::Scene(scene),
                "the scene",
                "A few places that together see much of the surfaces",
            ),
            (
                BounceCenters::Camera,
                "the camera",
                "One cube map at the camera: sees little, and flickers",
            ),
        ],
    );
    choice(
        ui,
        "Lights are",
        &mut settings.kind,
        &[
            (
                VirtualLightKind::Polygon,
                "polygons",
                "By the exact integral",
            ),
            (
                VirtualLightKind::Point {
                    least_distance: None,
                },
                "points",
                "With clamped distance: common practice",
            ),
        ],
    );
    choice(
        ui,
        "Blocked",
        &mut settings.visibility,
        &[
            (BounceVisibility::None, "no", "Light leaks through walls"),
            (
                BounceVisibility::Traced,
                "by rays",
                "One ray a light and pixel: much slower",
            ),
        ],
    );
    let most = if settings.method == BounceMethod::ReflectiveShadowMaps {
        1
    } else {
        MAXIMUM_BOUNCES.min(5)
    };
    settings.bounces = settings.bounces.min(most);
    ui.add(Slider::new(&mut settings.bounces, 1..=most).text("bounces"));
    ui.add(
        Slider::new(&mut settings.virtual_lights, 1..=4096)
            .logarithmic(true)
            .text("virtual lights"),
    );
    ui.add(Slider::new(&mut settings.face_size, 8..=128).text("texels a face"));
    ui.checkbox(&mut settings.shadows, "Shadows before the bounce")
        .on_hover_text("Surfaces block the lights before their light bounces");
}

/// A box to choose from; values that are not in the list have no name.
fn choice<T: Clone + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    options: &[(T, &str, &str)],
) {
    ui.horizontal(|ui| {
        let found = options.iter().find(|(option, ..)| option == value);
        let (text, help) = found.map_or(("", ""), |&(_, text, help)| (text, help));
        let label = ui.label(RichText::new(name).weak());
        egui::ComboBox::from_id_salt(name)
            .selected_text(text)
            .width(ui.available_width().clamp(60.0, 160.0))
            .show_ui(ui, |ui| {
                for (option, text, help) in options {
                    ui.selectable_value(value, option.clone(), *text)
                        .on_hover_text(*help);
                }
            })
            .response
            .on_hover_text(help)
            .labelled_by(label.id);
    });
}

/// A look in a few words.
pub(super) fn summary(look: &Look) -> String {
    let diffuse = match look.diffuse {
        DiffuseMethod::Exact { .. } => "exact",
        DiffuseMethod::LightVector { .. } => "light vector",
        DiffuseMethod::ProjectedArea { .. } => "projected area",
    };
    let specular = match look.specular {
        SpecularMethod::Ltc {
            lobes: LtcLobes::One,
        } => "LTC",
        SpecularMethod::Ltc {
            lobes: LtcLobes::Two,
        } => "LTC, two lobes",
        SpecularMethod::ReflectedInclusion(_) => "mirror",
        SpecularMethod::ReflectedDistanceField { .. } => "distance field",
        SpecularMethod::LightVector => "light vector",
        SpecularMethod::None => "no specular",
    };
    let bounce = look.bounce.as_ref().map_or("", |_| ", bounce");
    format!("{diffuse} + {specular}{bounce}")
}
