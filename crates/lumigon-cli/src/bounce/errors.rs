//! Bounce light beside the path tracer's, over the number of virtual lights and over the cube map's size.

use std::time::Instant;

use lumigon::SpecularMethod;
use lumigon_renderer::{
    BounceSettings, Camera, Pixels, ReferenceSettings, RenderSettings, Scene, Watch,
};
use serde::Serialize;

use super::difference::Truth;
use super::variant::{VARIANTS, Variant};
use super::{Study, rendered};
use crate::Failure;
use crate::bounce_light::Blocking;
use crate::compare::bounce::relative_flux_error;
use crate::gpu::Backend;
use crate::progress::Progress;

/// A scene as it is studied.
pub(super) struct StudyScene {
    pub(super) name: String,
    pub(super) scene: Scene,
    pub(super) camera: Camera,
}

/// One picture of bounce light, in numbers.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ErrorRow {
    pub(super) scene: String,
    /// [`Variant::id`].
    pub(super) variant: &'static str,
    /// Asked for, at most.
    pub(super) virtual_lights: u32,
    pub(super) cube_size: u32,
    /// How many there are.
    pub(super) lights: usize,
    /// From how many texels.
    pub(super) texels: usize,
    /// Wall milliseconds of making the lights, once.
    pub(super) gather_milliseconds: f64,
    /// Wall milliseconds of lighting the picture with them, once.
    pub(super) light_milliseconds: f64,
    /// |flux of the lights - flux gathered| over the flux gathered, in the worst channel.
    pub(super) flux_error: Option<f64>,
    /// Relative RMSE against each of [`Blocking::ALL`].
    pub(super) rmse: [Option<f64>; 3],
    /// Relative difference of the means against each of [`Blocking::ALL`].
    pub(super) bias: [Option<f64>; 3],
}

/// All of one scene.
pub(super) struct Errors {
    pub(super) rows: Vec<ErrorRow>,
    /// In the order of [`Blocking::ALL`].
    pub(super) truths: [Truth; 3],
    /// What variants look like at the default number and size.
    pub(super) pictures: Vec<(Variant, Pixels)>,
    pub(super) warnings: Vec<String>,
}

impl Study<'_> {
    /// Bounce light alone, diffuse.
    pub(super) fn render_settings(&self) -> RenderSettings {
        RenderSettings {
            width: self.command.size().width,
            height: self.command.size().height,
            samples: 1,
            specular: SpecularMethod::None,
            direct: false,
            ..RenderSettings::default()
        }
    }

    /// Cannot be followed, can be stopped.
    pub(super) fn watch(&self) -> Watch<'_> {
        Watch {
            progress: &|_, _| {},
            cancelled: self.interrupt.flag(),
        }
    }

    /// A path-traced single bounce.
    pub(super) fn truth(
        &self,
        backend: &Backend<'_>,
        camera: &Camera,
        blocking: Blocking,
    ) -> Result<Truth, Failure> {
        let progress = Progress::new("path tracing");
        let watch = Watch {
            progress: &|done, total| progress.set(done, total),
            ..self.watch()
        };
        let settings = blocking.single_bounce(ReferenceSettings {
            width: self.command.size().width,
            height: self.command.size().height,
            samples: 1,
            paths: self.command.spp(),
            seed: self.command.seed,
            ..ReferenceSettings::default()
        });
        let traced = backend.cpu().reference(camera, &settings, watch);
        Ok(Truth::new(rendered(traced)?))
    }

    /// Measures all variants in one scene.
    pub(super) fn errors(&self, scene: &StudyScene) -> Result<Errors, Failure> {
        let backend = rendered(Backend::new(self.command.backend, &scene.scene))?;
        let [nothing, bounces, all] = Blocking::ALL;
        let truth = |blocking| self.truth(&backend, &scene.camera, blocking);
        let truths = [truth(nothing)?, truth(bounces)?, truth(all)?];
        let mut errors = Errors {
            rows: Vec::new(),
            truths,
            pictures: Vec::new(),
            warnings: backend.warnings(),
        };
        let sweep = self.command.sweep();
        let points: Vec<_> = VARIANTS
            .into_iter()
            .flat_map(|variant| {
                let counts = sweep.counts.iter().map(|&count| (count, sweep.size));
                let sizes = sweep.sizes.iter().map(|&size| (sweep.count, size));
                let sizes = sizes.filter(|&(_, size)| variant.over_sizes && size != sweep.size);
                let points = counts.chain(sizes);
                let most = self.command.most_traced();
                points
                    .filter(|&(count, _)| !variant.traces() || count <= most)
                    .map(|(count, size)| (variant, count, size))
                    .collect::<Vec<_>>()
            })
            .collect();
        let progress = Progress::new("measuring errors");
        for (done, &(variant, count, size)) in points.iter().enumerate() {
            progress.set(done as u64, points.len() as u64);
            let settings = variant.settings(count, size);
            let (row, picture) = self.measure(scene, &backend, &variant, &settings, &mut errors)?;
            errors.rows.push(row);
            if (count, size) == (sweep.count, sweep.size) {
                errors.pictures.push((variant, picture));
            }
        }
        Ok(errors)
    }

    fn measure(
        &self,
        scene: &StudyScene,
        backend: &Backend<'_>,
        variant: &Variant,
        settings: &BounceSettings,
        errors: &mut Errors,
    ) -> Result<(ErrorRow, Pixels), Failure> {
        let (camera, watch) = (&scene.camera, self.watch());
        let start = Instant::now();
        let lights = rendered(backend.virtual_lights(camera, settings, watch))?;
        let gathered = start.elapsed();
        let start = Instant::now();
        let picture = backend.render_with_bounce(camera, &self.render_settings(), &lights, watch);
        let picture = rendered(picture)?.diffuse;
        let lit = start.elapsed();
        for warning in lights.warnings() {
            let warning = format!("{}: {warning}", variant.title);
            if !errors.warnings.contains(&warning) {
                errors.warnings.push(warning);
            }
        }
        let differences = errors
            .truths
            .each_ref()
            .map(|truth| truth.difference(&picture));
        let row = ErrorRow {
            scene: scene.name.clone(),
            variant: variant.id,
            virtual_lights: settings.virtual_lights,
            cube_size: settings.face_size,
            lights: lights.len(),
            texels: lights.texels(),
            gather_milliseconds: 1e3 * gathered.as_secs_f64(),
            light_milliseconds: 1e3 * lit.as_secs_f64(),
            flux_error: relative_flux_error(&lights),
            rmse: differences.map(|difference| difference.rmse),
            bias: differences.map(|difference| difference.bias),
        };
        Ok((row, picture))
    }
}

/// Every row, one a line.
pub(super) fn csv(rows: &[ErrorRow]) -> String {
    let mut text = "scene,variant,virtual_lights,cube_size,lights,texels,gather_milliseconds,\
        light_milliseconds,flux_error,rmse_unblocked,rmse_blocked,rmse_shadowed,bias_unblocked,\
        bias_blocked,bias_shadowed\n"
        .to_owned();
    let number = |number: Option<f64>| number.map_or(String::new(), |n| format!("{n:.6e}"));
    for row in rows {
        let name = row.scene.replace([',', '\n', '"'], "_");
        text += &format!(
            "{name},{},{},{},{},{},{:.3},{:.3},{},{},{}\n",
            row.variant,
            row.virtual_lights,
            row.cube_size,
            row.lights,
            row.texels,
            row.gather_milliseconds,
            row.light_milliseconds,
            number(row.flux_error),
            row.rmse.map(number).join(","),
            row.bias.map(number).join(","),
        );
    }
    text
}
