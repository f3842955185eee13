//! The path tracer's view of a scene.

use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use glam::{DVec3, Vec3};
use lumigon_reference::{
    Channel, Emitter, Material, Polygon, PunctualLight, Ray, Settings, Surface,
};

use super::geometry::Geometry;
use super::material::{LayeredMaterial, emitted};
use super::pixel_samples::pixel_samples;
use crate::render::{Pixels, ReferenceRendering, ReferenceSettings, RenderError, Rendering, Watch};
use crate::scene::{Camera, EmissiveImage, PunctualKind, Scene};

/// A scene as the path tracer asks for it.
struct TracedScene<'a> {
    scene: &'a Scene,
    geometry: &'a Geometry,
    emitters: Vec<Emitter>,
    /// What each of them shows.
    images: Vec<Option<&'a EmissiveImage>>,
    punctual_lights: Vec<PunctualLight>,
}

impl lumigon_reference::Scene for TracedScene<'_> {
    fn intersect(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<Surface> {
        let (origin, direction) = (single(origin), single(direction));
        let epsilon = self.geometry.epsilon;
        let hit = self.geometry.hit(self.scene, origin, direction, epsilon)?;
        let found = hit.surface(self.scene);
        let material = LayeredMaterial::new(&found);
        Some(Surface {
            position: double(found.position),
            geometric_normal: unit(found.geometric_normal),
            shading_normal: unit(found.shading_normal),
            material: Material {
                base_color: double(material.base_color),
                metallic: f64::from(material.metallic),
                dielectric_f0: double(material.dielectric_f0),
                dielectric_f90: f64::from(material.dielectric_f90),
                alpha: material.alpha.map(f64::from),
                tangent: double(found.tangent),
                diffuse_roughness: f64::from(material.diffuse_roughness),
                sheen_color: double(material.sheen_color),
                sheen_alpha: f64::from(material.sheen_alpha),
                clearcoat: f64::from(material.clearcoat),
                clearcoat_alpha: f64::from(material.clearcoat_alpha),
                clearcoat_normal: unit(found.clearcoat_normal),
            },
            emitted: double(emitted(&found)),
        })
    }

    fn occluded(&self, origin: [f64; 3], direction: [f64; 3], distance: f64) -> bool {
        let epsilon = self.geometry.epsilon;
        let farthest = distance as f32 - epsilon;
        self.geometry.occluded(
            self.scene,
            single(origin),
            single(direction),
            epsilon,
            farthest,
        )
    }

    fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    fn emitter_radiance(&self, emitter: usize, position: [f64; 3]) -> [f64; 3] {
        match self.images[emitter] {
            Some(image) => {
                // The texture as the camera sees it, not what the closed forms make of it.
                let color = image.color(&self.scene.textures, position);
                double(image.strength * Vec3::from(color))
            }
            None => self.emitters[emitter].radiance(),
        }
    }

    fn punctual_lights(&self) -> &[PunctualLight] {
        &self.punctual_lights
    }
}

/// Path traces the pixels that the closed forms render.
pub(super) fn render(
    scene: &Scene,
    geometry: &Geometry,
    camera: &Camera,
    settings: &ReferenceSettings,
    watch: Watch<'_>,
) -> Result<ReferenceRendering, RenderError> {
    let (emitters, images) = emitters(scene);
    let traced = TracedScene {
        scene,
        geometry,
        emitters,
        images,
        punctual_lights: scene.punctual_lights.iter().map(punctual).collect(),
    };
    let (width, height) = (settings.width, settings.height);
    let aspect = width as f32 / height as f32;
    let ray = |x: f64, y: f64| {
        let (u, v) = (x / f64::from(width), y / f64::from(height));
        let (origin, direction) = camera.ray(u as f32, v as f32, aspect);
        Ray {
            origin: double(origin),
            direction: double(direction),
        }
    };
    let samples = pixel_samples(settings.samples);
    let paths = settings.paths.max(2 * settings.samples);
    let path_settings = Settings {
        width: width as usize,
        height: height as usize,
        pixel_samples: &samples,
        samples_per_pixel: paths.next_multiple_of(settings.samples) as usize,
        bounces: settings.bounces,
        shadows: settings.shadows,
        direct: settings.direct,
        bounce_shadows: settings.bounce_shadows,
        seed: settings.seed,
    };
    let done = AtomicU64::new(0);
    let progress = |_, rows: usize| {
        (watch.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, rows as u64);
    };
    let estimate =
        lumigon_reference::render(&traced, &ray, &path_settings, &progress, watch.cancelled)
            .map_err(|error| match error {
                lumigon_reference::RenderError::Bounces => RenderError::OutOfRange {
                    what: "the number of bounces",
                    value: 0,
                    least: 1,
                    greatest: u64::from(u32::MAX),
                },
                lumigon_reference::RenderError::Size { .. } => RenderError::OutOfRange {
                    what: "the number of pixels",
                    value: u64::from(width) * u64::from(height),
                    least: 1,
                    greatest: 1 << 28,
                },
                _ => RenderError::Cancelled,
            })?;
    let Channel {
        mean: diffuse,
        standard_error: diffuse_error,
    } = estimate.diffuse;
    let Channel {
        mean: specular,
        standard_error: specular_error,
    } = estimate.specular;
    Ok(ReferenceRendering {
        mean: Rendering {
            width,
            height,
            emitted: pixels(&estimate.emitted),
            diffuse: pixels(&diffuse),
            specular: pixels(&specular),
        },
        diffuse_error: pixels(&diffuse_error),
        specular_error: pixels(&specular_error),
        radiance_error: pixels(&estimate.total.standard_error),
    })
}

fn emitters(scene: &Scene) -> (Vec<Emitter>, Vec<Option<&EmissiveImage>>) {
    // Outlines that the path tracer cannot triangulate were refused when the lights were prepared.
    scene
        .polygon_lights
        .iter()
        .filter_map(|light| {
            let polygon = Polygon::new(&light.loops, light.two_sided).ok()?;
            let mean = light.radiance.to_array().map(f64::from);
            Some((Emitter::new(polygon, mean), light.image.as_ref()))
        })
        .unzip()
}

fn punctual(light: &crate::scene::PunctualLight) -> PunctualLight {
    let (position, direction) = (double(light.position), unit(light.direction));
    let color = light.color.to_array().map(f64::from);
    let range = light.range.map(f64::from);
    match light.kind {
        PunctualKind::Directional => PunctualLight::Directional {
            direction,
            irradiance: color,
        },
        PunctualKind::Point => PunctualLight::Point {
            position,
            intensity: color,
            range,
        },
        PunctualKind::Spot {
            inner_cone_angle,
            outer_cone_angle,
        } => PunctualLight::Spot {
            position,
            direction,
            intensity: color,
            range,
            inner_cone_angle: f64::from(inner_cone_angle),
            outer_cone_angle: f64::from(outer_cone_angle),
        },
    }
}

fn pixels(values: &[[f64; 3]]) -> Pixels {
    values.iter().map(|v| v.map(|x| x as f32)).collect()
}

fn single(v: [f64; 3]) -> Vec3 {
    DVec3::from(v).as_vec3()
}

fn double(v: Vec3) -> [f64; 3] {
    v.as_dvec3().to_array()
}

fn unit(v: Vec3) -> [f64; 3] {
    v.as_dvec3().normalize_or_zero().to_array()
}
