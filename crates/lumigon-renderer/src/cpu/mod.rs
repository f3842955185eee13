//! The CPU backend: rays through a bounding volume hierarchy, tiles in parallel, SIMD over pixels.

mod batch;
mod bounce;
mod distance_fields;
mod edited;
mod fitted_lobes;
mod geometry;
mod held_scene;
mod hits;
mod layer;
mod light_counts;
mod lobes;
mod material;
mod pick;
mod pixel_samples;
mod probe;
mod reference;
mod shade;
mod timings;
mod visible;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Instant;

use lumigon::{
    DistanceFields, ImageMethod, LightImage, PlacedDistanceField, SpecularMethod, Vec3 as LightVec3,
};
use lumigon_wgpu::Light;
use rayon::prelude::*;

use crate::bounce::{Facets, LightTargets, VirtualLights};
use crate::render::{
    MAXIMUM_SIDE, Pixels, ReferenceRendering, ReferenceSettings, RenderError, RenderSettings,
    Rendering, Watch,
};
use crate::scene::{Camera, Scene};

use distance_fields::FieldCache;
use fitted_lobes::FittedLobes;
pub(crate) use geometry::{Geometry, ray_epsilon};
use held_scene::HeldScene;
use hits::{Hits, Wanted};
use lobes::Scattered;
pub use pick::PickedSurface;
pub(crate) use pixel_samples::pixel_samples;
pub use probe::{Probe, ProbedLight, ProbedRadiance, STRONGEST_LIGHTS};
use shade::Visibility;
pub use timings::CpuTimings;
use timings::Spent;

/// Side of the square of pixels that one task renders: large enough to fill SIMD lanes with
/// neighbours, small enough to keep every thread busy to the end.
const TILE: u32 = 16;

/// Camera rays a pixel that are shaded together ...
const SAMPLES_AT_ONCE: usize = 16;

/// ... where there are no more lights than this. More lights take fewer, for work is stopped in between.
const FEW_LIGHTS: usize = 64;

/// Lights without a picture that take as long as one with.
const IMAGE_COST: usize = 16;

/// Most camera rays a pixel.
const MAXIMUM_SAMPLES: u32 = 65_536;

/// A scene prepared for rendering on the CPU.
pub struct CpuRenderer<'a> {
    scene: HeldScene<'a>,
    geometry: Geometry,
    lights: Vec<Light>,
    /// Their indices in the scene.
    sources: Vec<usize>,
    /// The same lights, where images have the levels of the one lookup.
    lookup_lights: OnceLock<Vec<Light>>,
    warnings: Vec<String>,
    fitted: Arc<FittedLobes>,
    fields: FieldCache,
    /// The flat parts of the surfaces, for bounce light.
    facets: OnceLock<Arc<Facets>>,
    /// Those before the scene was edited.
    earlier_facets: Option<Arc<Facets>>,
    /// Where rays to the lights go, for bounce light.
    targets: OnceLock<LightTargets>,
    /// Of the last picture.
    timings: Mutex<Option<CpuTimings>>,
}

impl<'a> CpuRenderer<'a> {
    /// Builds the hierarchy and prepares the lights.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self::held(HeldScene::Borrowed(scene))
    }

    /// Shows another picture on the light `light` of [`Scene::polygon_lights`], in place: linear RGB of
    /// its [`EmissiveImage::size`](crate::EmissiveImage::size) cells, row by row, as
    /// [`EmissiveImage::cells`](crate::EmissiveImage::cells) makes them. For video: what the light does is
    /// replaced, not what is seen of its own faces, which
    /// [`Scene::replace_light_image`](Scene::replace_light_image) replaces too.
    ///
    /// # Errors
    /// Where there is no such light or it shows no picture, and where the colours are not one a cell,
    /// finite and not negative; the light then shows what it did.
    pub fn replace_light_image(
        &mut self,
        light: usize,
        colors: &[[f32; 3]],
    ) -> Result<(), RenderError> {
        let place = self.sources.iter().position(|&source| source == light);
        let image = place.and_then(|place| self.lights[place].image.as_mut());
        let image = image.ok_or(RenderError::NoPicture { light })?;
        image.replace(colors)?;
        self.lookup_lights = OnceLock::new();
        Ok(())
    }

    /// Lights whose outlines cannot be evaluated, and why: they light nothing.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Renders with closed forms: no noise, and no shadows.
    ///
    /// # Errors
    /// Where a setting is out of range, when distance fields are over their budget, or when cancelled.
    pub fn render(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        self.render_with_bounce(camera, settings, &VirtualLights::default(), watch)
    }

    /// The same, lit by virtual lights too.
    ///
    /// # Errors
    /// As [`CpuRenderer::render`].
    pub fn render_with_bounce(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        virtual_lights: &VirtualLights,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        check_size(settings.width, settings.height, settings.samples)?;
        let (width, height) = (settings.width, settings.height);
        let samples = pixel_samples(settings.samples);
        let fields = self.fields_for(settings)?;
        let fields: Vec<_> = fields.iter().flat_map(|fields| fields.iter()).collect();
        let spent = Spent::default();
        let frame = Frame {
            camera,
            settings,
            samples: &samples,
            fields: &fields,
            virtual_lights,
            spent: &spent,
        };
        // Before any tile: filtering shares out its work, and no tile may wait for one that waits for it.
        self.lights(settings.image_method);
        let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let total = u64::from(columns) * u64::from(rows);
        let done = AtomicU64::new(0);
        let tiles: Vec<Option<Tile>> = (0..total)
            .into_par_iter()
            .map_init(Hits::default, |hits, i| {
                if watch.is_cancelled() {
                    return None;
                }
                let (column, row) = (i % u64::from(columns), i / u64::from(columns));
                let (x, y) = (column as u32 * TILE, row as u32 * TILE);
                let tile = self.tile(frame, [x, y], hits, watch)?;
                (watch.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                Some(tile)
            })
            .collect();

        self.keep_timings(&spent);
        let mut picture = Rendering::black(width, height)?;
        for tile in tiles {
            let tile = tile.ok_or(RenderError::Cancelled)?;
            for row in 0..tile.height {
                let from = (row * tile.width) as usize..((row + 1) * tile.width) as usize;
                let start = (tile.y + row) as usize * width as usize + tile.x as usize;
                let to = start..start + tile.width as usize;
                picture.emitted[to.clone()].copy_from_slice(&tile.emitted[from.clone()]);
                picture.diffuse[to.clone()].copy_from_slice(&tile.diffuse[from.clone()]);
                picture.specular[to].copy_from_slice(&tile.specular[from]);
            }
        }
        Ok(picture)
    }

    /// Path traces the same scene through the same pixels.
    ///
    /// # Errors
    /// Where a setting is out of range, or when cancelled.
    pub fn reference(
        &self,
        camera: &Camera,
        settings: &ReferenceSettings,
        watch: Watch<'_>,
    ) -> Result<ReferenceRendering, RenderError> {
        check_size(settings.width, settings.height, settings.samples)?;
        reference::render(&self.scene, &self.geometry, camera, settings, watch)
    }

    /// The pixels from (x, y) to a tile's side beyond, or to the picture's edge; none where the
    /// work was cancelled. `hits` lends its memory.
    fn tile(
        &self,
        frame: Frame<'_>,
        [x, y]: [u32; 2],
        hits: &mut Hits,
        watch: Watch<'_>,
    ) -> Option<Tile> {
        let Frame {
            camera,
            settings,
            samples,
            ..
        } = frame;
        let mut tile = Tile::new(
            [x, y],
            TILE.min(settings.width - x),
            TILE.min(settings.height - y),
        );
        let aspect = settings.width as f32 / settings.height as f32;
        let share = 1.0 / samples.len() as f32;
        let wanted = self.wanted(settings, frame.virtual_lights);
        let scene: &Scene = &self.scene;
        // A few samples at a time: thousands of them would fill memory, and be slow to stop.
        let images = self.lights.iter().filter(|light| light.image.is_some());
        let cost = self.lights.len() + frame.virtual_lights.len() + IMAGE_COST * images.count();
        let at_once = (SAMPLES_AT_ONCE * FEW_LIGHTS / cost.max(FEW_LIGHTS)).max(1);
        for samples in samples.chunks(at_once) {
            if watch.is_cancelled() {
                return None;
            }
            let start = Instant::now();
            hits.clear();
            for pixel in 0..tile.emitted.len() as u32 {
                let (px, py) = (x + pixel % tile.width, y + pixel / tile.width);
                for offset in samples {
                    let u = (f64::from(px) + offset[0]) / f64::from(settings.width);
                    let v = (f64::from(py) + offset[1]) / f64::from(settings.height);
                    let (origin, direction) = camera.ray(u as f32, v as f32, aspect);
                    if let Some(hit) = self.geometry.hit(scene, origin, direction, 0.0) {
                        let surface = hit.surface(scene);
                        hits.push(pixel, &surface, -direction, &self.fitted, wanted);
                    }
                }
            }
            frame.spent.on_rays(start);
            self.shade(hits, frame, share, &mut tile, watch);
        }
        Some(tile)
    }

    /// What to keep of the surfaces that are seen.
    fn wanted(&self, settings: &RenderSettings, virtual_lights: &VirtualLights) -> Wanted {
        Wanted {
            diffuse: settings.diffuse,
            specular: settings.specular,
            lobes: !self.scene.punctual_lights.is_empty()
                || !virtual_lights.points.is_empty()
                || virtual_lights.targets.is_some(),
        }
    }

    /// The lights' distance fields, for the method that reads them.
    fn fields_for(
        &self,
        settings: &RenderSettings,
    ) -> Result<Option<Arc<DistanceFields<f32>>>, RenderError> {
        let SpecularMethod::ReflectedDistanceField { field, .. } = settings.specular else {
            return Ok(None);
        };
        let budget = settings.distance_field_budget;
        Ok(Some(self.fields.get(&self.lights, field, budget)?))
    }

    fn lights(&self, images: ImageMethod) -> &[Light] {
        if images != ImageMethod::Lookup || self.lights.iter().all(|light| light.image.is_none()) {
            return &self.lights;
        }
        self.lookup_lights.get_or_init(|| {
            let mut lights = self.lights.clone();
            lights
                .iter_mut()
                .filter_map(|light| light.image.as_mut())
                .filter(|image| image.gaussian_levels().is_none())
                .for_each(LightImage::filter_gaussian_levels);
            lights
        })
    }

    /// Adds what the lights do to the hits, `share` of it, to their pixels.
    fn shade(&self, hits: &Hits, frame: Frame<'_>, share: f32, tile: &mut Tile, watch: Watch<'_>) {
        let Frame {
            settings,
            fields,
            virtual_lights,
            ..
        } = frame;
        let methods = shade::Methods {
            diffuse: settings.diffuse,
            specular: settings.specular,
            images: settings.image_method,
        };
        let mut light = vec![Scattered::default(); hits.surfaces().len()];
        let start = Instant::now();
        if settings.direct {
            let lights = self.lights(settings.image_method);
            shade::add_polygons(&mut light, hits, lights, fields, methods, Visibility::Whole);
            for punctual in &self.scene.punctual_lights {
                let anywhere = |_, _, _| true;
                shade::add_punctual(&mut light, hits, punctual, settings.specular, anywhere);
            }
        }
        let start = frame.spent.on_lights(start);
        self.add_virtual_lights(&mut light, hits, virtual_lights, methods, watch);
        frame.spent.on_virtual_lights(start);
        for (hit, light) in hits.surfaces().iter().zip(light) {
            let pixel = hit.pixel as usize;
            for (to, part) in [
                (
                    &mut tile.emitted,
                    if settings.direct {
                        hit.emitted
                    } else {
                        glam::Vec3::ZERO
                    },
                ),
                (&mut tile.diffuse, light.diffuse),
                (&mut tile.specular, light.specular),
            ] {
                for (to, part) in to[pixel].iter_mut().zip(part.to_array()) {
                    *to += part * share;
                }
            }
        }
    }
}

/// What all tiles of a picture have in common.
#[derive(Clone, Copy)]
struct Frame<'a> {
    camera: &'a Camera,
    settings: &'a RenderSettings,
    /// Where in a pixel its rays go.
    samples: &'a [[f64; 2]],
    /// The lights' distance fields, for the method that reads them.
    fields: &'a [PlacedDistanceField<'a, f32>],
    virtual_lights: &'a VirtualLights,
    spent: &'a Spent,
}

/// A finished part of the picture.
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    emitted: Pixels,
    diffuse: Pixels,
    specular: Pixels,
}

impl Tile {
    fn new([x, y]: [u32; 2], width: u32, height: u32) -> Self {
        let black = vec![[0.0; 3]; (width * height) as usize];
        Self {
            x,
            y,
            width,
            height,
            emitted: black.clone(),
            diffuse: black.clone(),
            specular: black,
        }
    }
}

pub(crate) fn check_size(width: u32, height: u32, samples: u32) -> Result<(), RenderError> {
    for (what, value, greatest) in [
        ("the width", width, MAXIMUM_SIDE),
        ("the height", height, MAXIMUM_SIDE),
        ("the number of samples", samples, MAXIMUM_SAMPLES),
    ] {
        if !(1..=greatest).contains(&value) {
            return Err(RenderError::OutOfRange {
                what,
                value: value.into(),
                least: 1,
                greatest: greatest.into(),
            });
        }
    }
    Ok(())
}

/// From the scene's vectors to the mathematics'.
fn vector(v: glam::Vec3) -> LightVec3<f32> {
    LightVec3::new(v.x, v.y, v.z)
}
