//! Bounce light: virtual lights beside path-traced single bounces.

use std::time::Instant;

use clap::Args;
use lumigon::SpecularMethod;
use lumigon_renderer::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, MAXIMUM_FACE_SIZE,
    MAXIMUM_VIRTUAL_LIGHTS, ReferenceSettings, RenderSettings, VirtualLightKind, VirtualLights,
    Watch,
};
use serde::Serialize;

use super::contact_sheet::{COLUMNS, Cell, Section, thumbnail};
use super::error::CompareError;
use super::false_color::FalseColor;
use super::metrics::Noise;
use super::quantity::{duration, percent};
use super::record::Against;
use super::run::{Session, Truth};
use super::stopwatch::Stopwatch;
use crate::bounce_light::{Blocking, centers, clamp};

/// Whether and how bounce light is compared.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Bounce light")]
pub(super) struct BounceArguments {
    /// Compare a single bounce too: virtual lights beside path-traced bounce light
    #[arg(long)]
    bounce: bool,
    /// Virtual lights at most [default: 1024]
    #[arg(long, value_name = "K", requires = "bounce",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAXIMUM_VIRTUAL_LIGHTS)))]
    virtual_lights: Option<u32>,
    /// Distance below which virtual point lights do not grow brighter, in scene units [default: a
    /// twentieth of the scene's diagonal]
    #[arg(long, value_name = "DISTANCE", requires = "bounce", allow_negative_numbers = true,
        value_parser = clamp)]
    virtual_clamp: Option<f32>,
    /// Texels across each face of a cube map [default: 64]
    #[arg(long, value_name = "N", requires = "bounce",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAXIMUM_FACE_SIZE)))]
    cube_size: Option<u32>,
    /// Where cube maps look from, as for `lumigon render` [default: scene:4]
    #[arg(long, value_name = "camera|scene[:N]|X,Y,Z...", requires = "bounce",
        allow_hyphen_values = true, value_parser = centers)]
    bounce_from: Option<BounceCenters>,
}

/// What `metrics.json` says of bounce light.
#[derive(Clone, Debug, Serialize)]
pub(super) struct BounceRecord {
    /// Virtual lights at most.
    pub(super) virtual_lights: u32,
    /// Texels across a face of a cube map.
    pub(super) cube_size: u32,
    /// Where cube maps look from.
    pub(super) centers: String,
    /// What the methods are compared with, and the methods.
    pub(super) groups: Vec<BounceGroup>,
}

/// One path-traced single bounce, and the methods that are compared with it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct BounceGroup {
    /// Unique; its name in file names.
    pub(super) id: &'static str,
    /// Its name.
    pub(super) title: &'static str,
    /// What its surfaces block.
    pub(super) blocking: Blocking,
    /// The reference's picture.
    pub(super) picture: String,
    /// The reference's own noise, diffuse part.
    pub(super) noise: Noise,
    /// Wall seconds of the reference, once.
    pub(super) seconds: f64,
    /// The end of the scale of differences.
    #[serde(skip)]
    pub(super) scale: FalseColor,
    /// The methods.
    pub(super) methods: Vec<BounceMethodRecord>,
}

/// One way to virtual lights.
#[derive(Clone, Debug, Serialize)]
pub(super) struct BounceMethodRecord {
    /// Unique; its name in file names.
    pub(super) id: &'static str,
    /// Its name.
    pub(super) title: &'static str,
    /// What it does.
    #[serde(skip)]
    pub(super) words: &'static str,
    /// Where it was published.
    pub(super) source: &'static str,
    /// Against the reference's diffuse part.
    #[serde(flatten)]
    pub(super) against: Against,
    /// How many virtual lights there were.
    pub(super) virtual_lights: usize,
    /// From how many texels.
    pub(super) texels: usize,
    /// |flux of the lights - flux gathered| over the flux gathered; none where that is 0.
    pub(super) relative_flux_error: Option<f64>,
    /// Median wall seconds of making the virtual lights.
    pub(super) gather_seconds: f64,
    /// Median wall seconds of lighting the picture with them, rays and materials included.
    pub(super) seconds: f64,
}

/// What is rendered.
struct Method {
    id: &'static str,
    title: &'static str,
    truth: Blocking,
    method: BounceMethod,
    point: bool,
    traced: bool,
    shadows: bool,
    words: &'static str,
    source: &'static str,
}

const CUBE_MAP: &str = "C. Cooper, Thoughts on VPL Generation Using Cube Maps, 28 March 2013; \
    polygons and reduction: lumigon's own";
const POINTS: &str =
    "A. Keller, Instant Radiosity, SIGGRAPH 1997; from a cube map: C. Cooper, 2013";
const SHADOW_MAPS: &str =
    "C. Dachsbacher and M. Stamminger, Reflective Shadow Maps, I3D 2005; polygons: lumigon's own";

fn methods() -> [Method; 9] {
    let rows = [
        (
            ["bounce-polygon", "Cube map, polygons"],
            (Blocking::Nothing, BounceMethod::CubeMap, false),
            "Virtual polygon lights with the surfaces' outlines, by the exact integral. Nothing \
             blocks them.",
            CUBE_MAP,
        ),
        (
            ["bounce-point", "Cube map, clamped points"],
            (Blocking::Nothing, BounceMethod::CubeMap, true),
            "The same clusters as points, whose light is cut off below a distance: the usual \
             practice. Nothing blocks them.",
            POINTS,
        ),
        (
            ["bounce-rsm", "Reflective shadow maps, polygons"],
            (Blocking::Nothing, BounceMethod::ReflectiveShadowMaps, false),
            "One cube map for each light, from where that light is, lit by it alone.",
            SHADOW_MAPS,
        ),
        (
            ["bounce-polygon-traced", "Cube map, polygons, traced"],
            (Blocking::Bounces, BounceMethod::CubeMap, false),
            "One ray from each point to each virtual light.",
            CUBE_MAP,
        ),
        (
            ["bounce-point-traced", "Cube map, clamped points, traced"],
            (Blocking::Bounces, BounceMethod::CubeMap, true),
            "One ray from each point to each virtual light.",
            POINTS,
        ),
        (
            ["bounce-rsm-traced", "Reflective shadow maps, traced"],
            (Blocking::Bounces, BounceMethod::ReflectiveShadowMaps, false),
            "One ray from each point to each virtual light.",
            SHADOW_MAPS,
        ),
        (
            ["bounce-polygon-leaking", "Cube map, polygons, no rays"],
            (Blocking::All, BounceMethod::CubeMap, false),
            "What is left wrong where no rays are to be had: the same picture as without blocking, \
             against the truth.",
            CUBE_MAP,
        ),
        (
            ["bounce-polygon-shadowed", "Cube map, polygons, all traced"],
            (Blocking::All, BounceMethod::CubeMap, false),
            "Rays to the lights before the bounce, and to each virtual light after it.",
            CUBE_MAP,
        ),
        (
            ["bounce-rsm-shadowed", "Reflective shadow maps, all traced"],
            (Blocking::All, BounceMethod::ReflectiveShadowMaps, false),
            "Rays to the lights before the bounce, and to each virtual light after it.",
            SHADOW_MAPS,
        ),
    ];
    rows.map(|([id, title], (truth, method, point), words, source)| {
        let leaks = id == "bounce-polygon-leaking";
        Method {
            id,
            title,
            truth,
            method,
            point,
            traced: truth != Blocking::Nothing && !leaks,
            shadows: truth == Blocking::All && !leaks,
            words,
            source,
        }
    })
}

impl BounceArguments {
    pub(super) fn is_wanted(&self) -> bool {
        self.bounce
    }

    fn settings(&self, method: &Method) -> BounceSettings {
        let default = BounceSettings::default();
        BounceSettings {
            method: method.method,
            centers: self.bounce_from.clone().unwrap_or_default(),
            face_size: self.cube_size.unwrap_or(default.face_size),
            virtual_lights: self.virtual_lights.unwrap_or(default.virtual_lights),
            kind: if method.point {
                VirtualLightKind::Point {
                    least_distance: self.virtual_clamp,
                }
            } else {
                VirtualLightKind::Polygon
            },
            visibility: if method.traced {
                BounceVisibility::Traced
            } else {
                BounceVisibility::None
            },
            shadows: method.shadows,
            ..default
        }
    }
}

/// Renders and compares all of it: the record, and the contact sheet's sections.
///
/// # Errors
/// Where the scene cannot be rendered or a file not be written, or when interrupted.
pub(super) fn compare(
    session: &Session<'_>,
    files: &mut Vec<String>,
) -> Result<(BounceRecord, Vec<Section>), CompareError> {
    let arguments = &session.command.bounce;
    let (mut groups, mut sections) = (Vec::new(), Vec::new());
    let mut said = Vec::new();
    for blocking in Blocking::ALL {
        let (truth, mut group) = reference(session, files, blocking)?;
        let mut cells = vec![Some(Cell {
            id: group.id,
            title: "Path traced".to_owned(),
            picture: thumbnail(&truth.shown),
            difference: None,
            numbers: format!("noise {} of its mean", percent(truth.noise.relative)),
        })];
        for method in methods().iter().filter(|m| m.truth == blocking) {
            let (record, mut cell) = measure(session, files, &truth, arguments, method, &mut said)?;
            if cells.len().is_multiple_of(COLUMNS as usize) {
                cells.push(None);
            }
            cell.title = method.title.to_owned();
            cell.numbers = format!(
                "RMSE {} · {} lights · {}",
                percent(record.against.difference.relative_rmse),
                record.virtual_lights,
                duration(record.gather_seconds + record.seconds),
            );
            cells.push(Some(cell));
            group.methods.push(record);
        }
        sections.push(Section {
            title: group.title.to_owned(),
            scale: truth.scale,
            cells,
        });
        groups.push(group);
    }
    for warning in said {
        eprintln!("warning: bounce light: {warning}");
    }
    let settings = arguments.settings(&methods()[0]);
    let record = BounceRecord {
        virtual_lights: settings.virtual_lights,
        cube_size: settings.face_size,
        centers: match settings.centers {
            BounceCenters::Camera => "the camera".to_owned(),
            BounceCenters::Scene(count) => format!("{count} points chosen in the scene"),
            BounceCenters::Points(points) => format!("{} given points", points.len()),
        },
        groups,
    };
    Ok((record, sections))
}

/// A path-traced single bounce, diffuse part.
fn reference(
    session: &Session<'_>,
    files: &mut Vec<String>,
    blocking: Blocking,
) -> Result<(Truth, BounceGroup), CompareError> {
    let command = session.command;
    let settings = blocking.single_bounce(ReferenceSettings {
        width: command.size.width,
        height: command.size.height,
        samples: command.samples,
        paths: command.spp,
        seed: command.seed,
        ..ReferenceSettings::default()
    });
    let start = Instant::now();
    let traced = session.watched(blocking.title(), |watch| {
        let cpu = session.renderer.cpu();
        cpu.reference(session.camera, &settings, watch)
    })?;
    let seconds = start.elapsed().as_secs_f64();
    let truth = session.truth(traced.mean.diffuse, traced.diffuse_error);
    let name = format!("reference-{}", blocking.id());
    let picture = session.save(files, &name, &truth.shown, &truth.pixels)?;
    session.save_scale(files, blocking.id(), truth.scale)?;
    let group = BounceGroup {
        id: blocking.id(),
        title: blocking.title(),
        blocking,
        picture,
        noise: truth.noise,
        seconds,
        scale: truth.scale,
        methods: Vec::new(),
    };
    Ok((truth, group))
}

fn measure(
    session: &Session<'_>,
    files: &mut Vec<String>,
    truth: &Truth,
    arguments: &BounceArguments,
    method: &Method,
    said: &mut Vec<String>,
) -> Result<(BounceMethodRecord, Cell), CompareError> {
    let settings = arguments.settings(method);
    let render = RenderSettings {
        specular: SpecularMethod::None,
        direct: false,
        ..session.unlit_settings()
    };
    let (mut gathering, mut lighting) = (Stopwatch::default(), Stopwatch::default());
    let (lights, rendering) = session.watched(method.title, |watch| {
        let lights = gathering.measure(|| {
            let gather = Watch {
                progress: &|_, _| {},
                ..watch
            };
            session
                .renderer
                .virtual_lights(session.camera, &settings, gather)
        })?;
        let rendering = lighting.measure(|| {
            let renderer = &session.renderer;
            renderer.render_with_bounce(session.camera, &render, &lights, watch)
        })?;
        Ok((lights, rendering))
    })?;
    let quiet = Watch {
        progress: &|_, _| {},
        cancelled: session.interrupt.flag(),
    };
    while gathering.wants_more() {
        gathering.measure(|| {
            session
                .renderer
                .virtual_lights(session.camera, &settings, quiet)
        })?;
    }
    while lighting.wants_more() {
        lighting.measure(|| {
            let renderer = &session.renderer;
            renderer.render_with_bounce(session.camera, &render, &lights, quiet)
        })?;
    }
    for warning in lights.warnings() {
        if !said.contains(warning) {
            said.push(warning.clone());
        }
    }
    let (against, cell) = session.against(files, truth, method.id, &rendering.diffuse)?;
    let record = BounceMethodRecord {
        id: method.id,
        title: method.title,
        words: method.words,
        source: method.source,
        against,
        virtual_lights: lights.len(),
        texels: lights.texels(),
        relative_flux_error: relative_flux_error(&lights),
        gather_seconds: gathering.seconds(),
        seconds: lighting.seconds(),
    };
    Ok((record, cell))
}

/// |flux of the lights - flux gathered| over the flux gathered, in the worst channel.
pub(crate) fn relative_flux_error(lights: &VirtualLights) -> Option<f64> {
    let gathered = lights.gathered_flux();
    let all = gathered.iter().sum::<f64>();
    let errors = lights.flux().into_iter().zip(gathered);
    let worst = errors.map(|(flux, gathered)| (flux - gathered).abs());
    (all > 0.0).then(|| 3.0 * worst.fold(0.0, f64::max) / all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_method_is_its_own() {
        let ids: BTreeSet<_> = methods().iter().map(|m| m.id).collect();
        assert_eq!(ids.len(), methods().len());
        assert!(
            Blocking::ALL
                .iter()
                .all(|b| methods().iter().any(|m| m.truth == *b))
        );
        let none = relative_flux_error(&VirtualLights::default());
        assert_eq!(none, None);
    }
}
