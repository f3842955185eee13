//! All that is known about the light at one point.

use glam::Vec3;
use lumigon::{DiffuseMethod, ImageMethod, PolygonLight, Sides, Vec3 as LightVec3, form_factor};

use super::hits::Hits;
use super::pick::PickedSurface;
use super::timings::Spent;
use super::{CpuRenderer, Frame, Tile, vector};
use crate::bounce::VirtualLights;
use crate::render::{RenderError, RenderSettings, Watch};
use crate::scene::{Camera, SurfaceSample};

/// Lights that a probe names, at most.
pub const STRONGEST_LIGHTS: usize = 8;

/// The light at one point of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Where it was measured.
    pub surface: PickedSurface,
    /// Linear RGB irradiance from all polygon lights, about the shading normal; nothing blocks them.
    /// Exact, but for the mean colour of lights that show a picture, which is as the picture is rendered.
    pub irradiance: [f64; 3],
    /// The sum of all polygon lights' form factors: the share of the hemisphere, weighted by the cosine,
    /// that they fill. Exact, in double precision.
    pub form_factor: f64,
    /// The lights that light the point most, at most [`STRONGEST_LIGHTS`], the strongest first. Lights that
    /// do not light it are not among them.
    pub lights: Vec<ProbedLight>,
    /// What each of the settings makes of it, in their order; or why it makes nothing.
    pub radiance: Vec<Result<ProbedRadiance, RenderError>>,
}

/// What one polygon light does at a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedLight {
    /// Index into [`Scene::polygon_lights`](crate::Scene::polygon_lights).
    pub light: usize,
    /// As [`Probe::irradiance`].
    pub irradiance: [f64; 3],
    /// As [`Probe::form_factor`].
    pub form_factor: f64,
    /// From the point to the light's centroid, in scene units.
    pub distance: f64,
}

/// What one way of lighting makes of a probe: linear RGB radiance towards the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProbedRadiance {
    /// That the surface emits itself.
    pub emitted: [f32; 3],
    /// That its diffuse lobe scatters.
    pub diffuse: [f32; 3],
    /// That its specular lobes scatter.
    pub specular: [f32; 3],
}

impl CpuRenderer<'_> {
    /// The light at the surface that is seen at (`x`, `y`) of the picture, each 0 to 1 from its upper left
    /// corner, y down, a pixel's centre as a rule; `aspect` is the picture's width over its height. Of the
    /// settings, sizes and samples are of no effect: a picture of one sample a pixel has the same radiance.
    ///
    /// None where the camera sees nothing there, and where a number makes no sense.
    #[must_use]
    pub fn probe(
        &self,
        camera: &Camera,
        place: [f32; 2],
        aspect: f32,
        settings: &[RenderSettings],
    ) -> Option<Probe> {
        let lights = VirtualLights::default();
        self.probe_with_bounce(camera, place, aspect, settings, &lights)
    }

    /// The same, with radiance lit by virtual lights too, whose irradiance is left out.
    #[must_use]
    pub fn probe_with_bounce(
        &self,
        camera: &Camera,
        place: [f32; 2],
        aspect: f32,
        settings: &[RenderSettings],
        virtual_lights: &VirtualLights,
    ) -> Option<Probe> {
        let ((sample, view), surface) = self.seen(camera, place, aspect)?;
        let mut lights = self.probed_lights(sample.position, sample.shading_normal);
        let mut probe = Probe {
            surface,
            irradiance: [0.0; 3],
            form_factor: 0.0,
            lights: Vec::new(),
            radiance: Vec::new(),
        };
        for light in &lights {
            probe.form_factor += light.form_factor;
            for (sum, part) in probe.irradiance.iter_mut().zip(light.irradiance) {
                *sum += part;
            }
        }
        let strength = |light: &ProbedLight| light.irradiance.iter().sum::<f64>();
        lights.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        lights.truncate(STRONGEST_LIGHTS);
        probe.lights = lights;
        let of_settings = settings.iter();
        probe.radiance = of_settings
            .map(|settings| self.radiance_at(camera, &sample, view, settings, virtual_lights))
            .collect();
        Some(probe)
    }

    /// Those that light a point, in their order.
    fn probed_lights(&self, position: Vec3, normal: Vec3) -> Vec<ProbedLight> {
        let double = |v: Vec3| LightVec3::from(v.as_dvec3().to_array());
        let point = double(position);
        let unit: LightVec3<f64> = normal.as_dvec3().normalize_or_zero().to_array().into();
        let mut probed = Vec::new();
        for (prepared, &source) in self.lights.iter().zip(&self.sources) {
            let light = &self.scene.polygon_lights[source];
            let sides = match light.two_sided {
                true => Sides::Both,
                false => Sides::Front,
            };
            // Those that cannot be evaluated are not among the prepared ones.
            let Ok(polygon) = PolygonLight::new(&light.loops, sides) else {
                continue;
            };
            let form_factor = form_factor(&polygon, point, unit);
            // Not where it is no number either.
            if form_factor.is_nan() || form_factor <= 0.0 {
                continue;
            }
            let color = prepared.image.as_ref().map_or([1.0; 3], |image| {
                DiffuseMethod::default().mean_image(
                    &prepared.polygon,
                    image,
                    vector(position),
                    vector(normal),
                    ImageMethod::default(),
                )
            });
            let channel = |i: usize| {
                let radiance = f64::from(prepared.radiance[i]) * f64::from(color[i]);
                std::f64::consts::PI * form_factor * radiance
            };
            probed.push(ProbedLight {
                light: source,
                irradiance: [0, 1, 2].map(channel),
                form_factor,
                distance: (polygon.centroid() - point).length(),
            });
        }
        probed
    }

    /// By the code that shades a tile.
    fn radiance_at(
        &self,
        camera: &Camera,
        sample: &SurfaceSample,
        view: Vec3,
        settings: &RenderSettings,
        virtual_lights: &VirtualLights,
    ) -> Result<ProbedRadiance, RenderError> {
        let fields = self.fields_for(settings)?;
        let fields: Vec<_> = fields.iter().flat_map(|fields| fields.iter()).collect();
        let frame = Frame {
            camera,
            settings,
            samples: &[[0.5; 2]],
            fields: &fields,
            virtual_lights,
            spent: &Spent::default(),
        };
        let mut hits = Hits::default();
        let wanted = self.wanted(settings, virtual_lights);
        hits.push(0, sample, view, &self.fitted, wanted);
        let mut tile = Tile::new([0, 0], 1, 1);
        self.shade(&hits, frame, 1.0, &mut tile, Watch::none());
        Ok(ProbedRadiance {
            emitted: tile.emitted[0],
            diffuse: tile.diffuse[0],
            specular: tile.specular[0],
        })
    }
}
