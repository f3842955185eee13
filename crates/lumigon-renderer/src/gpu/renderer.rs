//! A scene on a device, and pictures of it.

use std::sync::{Mutex, OnceLock};

use lumigon_wgpu::{ImageColors, ReplaceImageError};

use super::AdapterKind;
use super::clock::Clock;
use super::cube_faces::{FaceCanvas, FaceRaster};
use super::device::{Gpu, Waited, lock};
use super::display::Display;
use super::equipment::Equipment;
use super::error::GpuError;
use super::frame::View;
use super::light_set::{LightSet, VirtualLighting};
use super::lighting::Lighting;
use super::methods::Methods;
use super::parts::{Effort, Part};
use super::rays::Rays;
use super::scene_buffers::{self, FRAME_STRIDE, FRAMES, SceneBuffers};
use super::shading::{self, PIXEL, Pass, Shading, ShadingRecord};
use super::stopwatch::Stopwatch;
use super::tile::{Tile, tile_size, tiles};
use super::visibility::Visibility;
use crate::bounce::{Facets, VirtualLights};
use crate::cpu::{check_size, pixel_samples};
use crate::render::{RenderError, RenderSettings, Rendering, Watch};
use crate::scene::{Camera, EmissivePolygon, Scene, Texture};

/// Longest side of a tile, in pixels: what every device can raster.
const LONGEST_SIDE: u32 = 2048;

/// Most pixels of a tile: its memory stays below 200 MB.
const MOST_PIXELS: u64 = 1 << 21;

/// Most edges times pixels of one submission. Drivers take a device for hung after some two seconds;
/// fast devices are fast where they have much to do.
fn most_work(kind: AdapterKind) -> u64 {
    match kind {
        AdapterKind::Discrete | AdapterKind::Virtual => 1 << 34,
        AdapterKind::Integrated | AdapterKind::Other => 1 << 31,
        AdapterKind::Software => 1 << 28,
    }
}

/// Rounds of all loops of a shader's invocation, after which Mesa's llvmpipe ends them and goes on as if
/// they were done: 65,535, less what a surface needs.
const SOFTWARE_ROUNDS: u64 = 60_000;

/// Edges of the lights that are left of many where those that add little are left out, about.
const MOST_COUNTING_EDGES: u64 = 1000;

/// How long the device worked on the last picture, and on the last virtual lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpuTimings {
    /// Milliseconds of finding what each pixel sees, over all tiles and samples.
    pub visibility: f64,
    /// Milliseconds of lighting it.
    pub shading: f64,
    /// Milliseconds of the last virtual lights' cube maps: of finding what they see, and of lighting it.
    pub bounce: f64,
}

/// A scene on a device, ready to be rendered.
///
/// Cameras and lights may change from picture to picture: nothing is built anew for them.
pub struct GpuRenderer {
    pub(super) gpu: Gpu,
    pub(super) scene: SceneBuffers,
    pub(super) visibility: Visibility,
    pub(super) shading: Shading,
    pub(super) display: Display,
    pub(super) lighting: Lighting,
    pub(super) scene_layout: wgpu::BindGroupLayout,
    /// What lights' pictures are made of.
    pub(super) textures: Vec<Texture>,
    /// What bounce light needs of the scene: triangles, and lights without extent.
    pub(super) shapes: Scene,
    pub(super) facets: OnceLock<Facets>,
    /// Made when surfaces are first to block light.
    pub(super) rays: OnceLock<Rays>,
    pub(super) face_raster: OnceLock<FaceRaster>,
    pub(super) clock: Option<Clock>,
    /// One picture or cube map at a time.
    pub(super) kept: Mutex<Kept>,
    timings: Mutex<Option<GpuTimings>>,
    /// Milliseconds.
    pub(super) bounce_time: Mutex<f64>,
    largest_tile: Option<[u32; 2]>,
}

/// What pictures and cube maps leave to the next ones.
#[derive(Default)]
pub(super) struct Kept {
    pub(super) picture: Option<Equipment>,
    /// For light on cube maps.
    pub(super) face: Option<Equipment>,
    pub(super) faces: Option<FaceCanvas>,
    pub(super) virtual_lighting: Option<VirtualLighting>,
    pub(super) stopwatch: Stopwatch,
}

/// How a picture is divided.
pub(super) struct Plan {
    /// Most pixels across and down of a tile.
    pub(super) tile: [u32; 2],
    /// Most samples of a submission.
    pub(super) at_once: usize,
}

impl GpuRenderer {
    /// Brings the scene to the device.
    ///
    /// # Errors
    /// Where the scene is larger than the device's memory or buffers.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, GpuError> {
        gpu.guarded("the scene", || Self::build(gpu, scene))
    }

    fn build(gpu: &Gpu, scene: &Scene) -> Result<Self, GpuError> {
        let textures = scene.textures.clone();
        let (polygons, punctual) = (&scene.polygon_lights, &scene.punctual_lights);
        let lighting = Lighting::new(gpu, polygons, &textures, punctual)?;
        let shapes = Scene {
            meshes: scene.meshes.clone(),
            punctual_lights: punctual.clone(),
            ..Scene::default()
        };
        let scene_layout = scene_buffers::layout(gpu);
        let scene = SceneBuffers::new(gpu, &scene_layout, scene)?;
        Ok(Self {
            gpu: gpu.clone(),
            visibility: Visibility::new(gpu, &scene_layout, &scene)?,
            shading: Shading::new(gpu, lighting.layout(), &scene_layout, scene.features)?,
            scene,
            scene_layout,
            display: Display::default(),
            lighting,
            textures,
            shapes,
            facets: OnceLock::new(),
            rays: OnceLock::new(),
            face_raster: OnceLock::new(),
            clock: Clock::new(gpu),
            kept: Mutex::default(),
            timings: Mutex::default(),
            bounce_time: Mutex::default(),
            largest_tile: None,
        })
    }

    /// Lights whose outlines cannot be evaluated, and why: they light nothing.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.lighting.warnings
    }

    /// Replaces the lights; the scene's emissive faces stay where they are. Pictures are of the textures
    /// of the scene that the renderer was made for.
    ///
    /// # Errors
    /// Where they are more than the device's buffers hold; they stay as they were.
    pub fn set_lights(&mut self, lights: &[EmissivePolygon]) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        let (textures, punctual) = (&self.textures, &self.shapes.punctual_lights);
        let staged = gpu.guarded("lights", || {
            self.lighting.stage(&gpu, lights, textures, punctual)
        })?;
        gpu.guarded("lights", || {
            self.lighting.commit(&gpu, staged, lights, textures)
        })
    }

    /// Shows another picture on the light `light` of [`Scene::polygon_lights`], in place: one colour for
    /// each of its [`EmissiveImage::size`](crate::EmissiveImage::size) cells, row by row. The device filters
    /// it, so that each frame of a video may. What is seen of the light's own faces stays; see
    /// [`CpuRenderer::replace_light_image`](crate::CpuRenderer::replace_light_image).
    ///
    /// # Errors
    /// Where there is no such light or it shows no picture, where the colours are not one a cell, finite
    /// and not negative, and where the device fails; the light then shows what it did.
    pub fn replace_light_image(
        &mut self,
        light: usize,
        colors: ImageColors<'_>,
    ) -> Result<(), RenderError> {
        let (gpu, lighting) = (self.gpu.clone(), &mut self.lighting);
        let mut replaced = Ok(());
        gpu.guarded("a light's picture", || {
            replaced = lighting.replace_image(&gpu, light, colors);
            Ok(())
        })?;
        replaced.map_err(|fault| match fault {
            ReplaceImageError::NoImage { .. } => RenderError::NoPicture { light },
            ReplaceImageError::Colors(fault) => RenderError::Picture(fault),
            ReplaceImageError::TooLarge(fault) => RenderError::Gpu(GpuError::Lights(fault.into())),
        })
    }

    /// Renders with closed forms, as [`CpuRenderer::render`](crate::CpuRenderer::render) does.
    ///
    /// # Errors
    /// Where a setting is out of range, when distance fields are over their budget, when cancelled, and
    /// where the device fails.
    pub fn render(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        self.render_with_bounce(camera, settings, &VirtualLights::default(), watch)
    }

    /// The same, lit by virtual lights too. They stay on the device for the next pictures that are lit by
    /// equal ones.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`], and where there are more virtual lights than the device's buffers hold.
    pub fn render_with_bounce(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        virtual_lights: &VirtualLights,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        check_size(settings.width, settings.height, settings.samples)?;
        let (width, height) = (settings.width, settings.height);
        let mut picture = Rendering::black(width, height)?;
        let Some(view) = View::new(camera, [width, height], self.scene.bounds) else {
            return Ok(picture);
        };
        let mut kept = lock(&self.kept);
        *lock(&self.timings) = None;
        let Kept {
            picture: equipment,
            virtual_lighting,
            ..
        } = &mut *kept;
        let mut sets = Vec::new();
        if settings.direct {
            sets.push(self.lighting.set(&self.gpu, settings)?);
        }
        if !virtual_lights.is_empty() {
            sets.push(self.virtual_light_set(virtual_lighting, virtual_lights)?);
        }
        let done = self.gpu.guarded("a picture", || {
            self.render_into(&mut picture, &view, settings, &sets, watch, equipment)
        });
        match done {
            Ok(Some([visibility, shading])) => {
                if self.clock.is_some() {
                    self.set_times(visibility, shading);
                }
                Ok(picture)
            }
            Ok(None) => Err(RenderError::Cancelled),
            Err(fault) => {
                *equipment = None;
                Err(fault.into())
            }
        }
    }

    /// How long the device worked on the last picture; `None` before one, and where it has no clock. For
    /// pictures that were drawn, the newest that is known: it comes one or more pictures later.
    #[must_use]
    pub fn timings(&self) -> Option<GpuTimings> {
        // Whoever holds it looks himself.
        if let Ok(mut kept) = self.kept.try_lock() {
            self.newest_times(&mut kept);
        }
        *lock(&self.timings)
    }

    pub(super) fn set_times(&self, visibility: f64, shading: f64) {
        *lock(&self.timings) = Some(GpuTimings {
            visibility,
            shading,
            bounce: *lock(&self.bounce_time),
        });
    }

    /// Rays through the scene, for lights that surfaces block.
    pub(super) fn rays(&self) -> Result<&Rays, GpuError> {
        if let Some(rays) = self.rays.get() {
            return Ok(rays);
        }
        let rays = self.gpu.guarded("the hierarchy of triangles", || {
            Rays::new(&self.gpu, &self.shapes, &self.scene.order)
        })?;
        Ok(self.rays.get_or_init(|| rays))
    }

    /// The virtual lights on the device: those that were kept, if they are the same.
    pub(super) fn virtual_light_set<'a>(
        &'a self,
        kept: &'a mut Option<VirtualLighting>,
        lights: &VirtualLights,
    ) -> Result<LightSet<'a>, GpuError> {
        let found = match kept.take() {
            Some(same) if same.is(lights) => same,
            // Not both at once in memory.
            other => {
                drop(other);
                let (layout, tables) = (self.lighting.layout(), self.lighting.tables());
                self.gpu.guarded("virtual lights", || {
                    VirtualLighting::new(&self.gpu, layout, tables, lights)
                })?
            }
        };
        let lighting = kept.insert(found);
        let rays = lighting.is_traced().then(|| self.rays()).transpose()?;
        Ok(lighting.set(rays))
    }

    /// Milliseconds of visibility and of shading, 0 without a clock; `None` when cancelled.
    pub(super) fn render_into(
        &self,
        picture: &mut Rendering,
        view: &View,
        settings: &RenderSettings,
        sets: &[LightSet<'_>],
        watch: Watch<'_>,
        equipment: &mut Option<Equipment>,
    ) -> Result<Option<[f64; 2]>, GpuError> {
        let samples = pixel_samples(settings.samples);
        let share = 1.0 / samples.len() as f32;
        let Plan { tile, at_once } = self.plan([picture.width, picture.height], sets, settings);
        let equipment = Equipment::at_least(equipment, &self.gpu, &self.shading, tile);
        let passes = self.passes(sets, settings, equipment)?;
        let tiles = tiles(0..picture.width, 0..picture.height, tile);
        let total = (tiles.len() * samples.len().div_ceil(at_once)) as u64;
        let mut done = 0;
        let mut spent = [0.0; 2];
        for tile in tiles {
            let mut batches = samples.chunks(at_once).peekable();
            let mut is_first = true;
            while let Some(batch) = batches.next() {
                if watch.is_cancelled() {
                    return Ok(None);
                }
                self.write_frames(view, tile, batch, share);
                let mut encoder = self
                    .gpu
                    .device()
                    .create_command_encoder(&Default::default());
                if is_first {
                    equipment.sums.clear(&mut encoder, tile);
                }
                for frame in 0..batch.len() {
                    self.encode(&mut encoder, equipment, &passes, tile, frame);
                }
                let is_last = batches.peek().is_none();
                let mut reads = Vec::new();
                if is_last {
                    reads.push(equipment.copy_out(&self.gpu, &mut encoder, tile));
                }
                if let Some(clock) = &self.clock {
                    reads.push(clock.finish(&mut encoder, batch.len()));
                }
                let submission = self.gpu.queue().submit([encoder.finish()]);
                let cancelled = || watch.is_cancelled();
                let waited = self.gpu.read(&submission, &reads, cancelled, |i, bytes| {
                    if is_last && i == 0 {
                        tile.write(bytes, picture);
                    } else if let Some(clock) = &self.clock {
                        let frames = clock.frames(bytes);
                        spent = [0, 1].map(|pass| spent[pass] + frames[pass]);
                    }
                })?;
                if waited == Waited::Cancelled {
                    return Ok(None);
                }
                is_first = false;
                done += 1;
                (watch.progress)(done, total);
            }
        }
        Ok(Some(spent))
    }

    /// The tiles of a picture that is lit by these, and how many samples go at once.
    pub(super) fn plan(
        &self,
        size: [u32; 2],
        sets: &[LightSet<'_>],
        settings: &RenderSettings,
    ) -> Plan {
        let edges = sets
            .iter()
            .map(|set| self.edges(set, settings))
            .sum::<u64>();
        let edges = edges.max(1);
        let most_work = most_work(self.gpu.adapter().kind);
        let tile = self.largest_tile.unwrap_or_else(|| {
            let adapter = self.gpu.adapter();
            let longest = LONGEST_SIDE.min(adapter.largest_texture_side);
            let most = MOST_PIXELS
                .min(adapter.largest_storage() / (3 * PIXEL))
                .min(most_work / edges);
            tile_size(size, longest, most)
        });
        let pixels = u64::from(tile[0]) * u64::from(tile[1]);
        let work = pixels.saturating_mul(edges);
        Plan {
            tile,
            at_once: (most_work / work).clamp(1, FRAMES as u64) as usize,
        }
    }

    /// What the next submission's frames are of.
    pub(super) fn write_frames(&self, view: &View, tile: Tile, offsets: &[[f64; 2]], share: f32) {
        let mut bytes = vec![0; offsets.len() * FRAME_STRIDE];
        for (slot, &offset) in bytes.chunks_mut(FRAME_STRIDE).zip(offsets) {
            let frame = view.frame(tile, offset, share);
            slot[..size_of_val(&frame)].copy_from_slice(bytemuck::bytes_of(&frame));
        }
        self.gpu.queue().write_buffer(&self.scene.frames, 0, &bytes);
    }

    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        equipment: &Equipment,
        passes: &[Pass],
        tile: Tile,
        frame: usize,
    ) {
        let offset = (frame * FRAME_STRIDE) as u32;
        let stamps = self.clock.as_ref().map(|clock| clock.visibility(frame));
        self.visibility.encode(
            encoder,
            &self.scene,
            &equipment.canvas,
            tile.size,
            offset,
            stamps,
        );
        let groups = [&self.scene.bind_group, &equipment.ids];
        let stamps = self.clock.as_ref().map(|clock| clock.shading(frame));
        shading::encode(encoder, passes, groups, offset, tile.size, stamps);
    }

    /// What adds the sets of lights to a tile, in their parts, which are on the device from now on.
    pub(super) fn passes(
        &self,
        sets: &[LightSet<'_>],
        settings: &RenderSettings,
        equipment: &Equipment,
    ) -> Result<Vec<Pass>, GpuError> {
        let mut records = Vec::new();
        let mut passes = Vec::new();
        for set in sets {
            let methods = Methods::new(settings, set.has_images, set.traced.is_some());
            let first = records.len();
            let parts = self.parts(set, methods, settings.image_method.taps());
            records.extend((0..).zip(&parts).map(|(i, part)| {
                ShadingRecord::new(settings, part, set.with_emission && i == 0, set.traced)
            }));
            passes.push(Pass {
                pipeline: self.shading.pipeline(&self.gpu, methods)?,
                lights: set.bind_group.clone(),
                sums: self.shading.bind_group(&self.gpu, set, &equipment.sums)?,
                parts: first..records.len(),
            });
        }
        self.shading.set(&self.gpu, &records);
        Ok(passes)
    }

    /// The lights in parts that one dispatch each adds.
    fn parts(&self, set: &LightSet<'_>, methods: Methods, taps: u32) -> Vec<Part> {
        let effort = Effort {
            walks: methods.walks(self.scene.features),
            means: methods.image_means(self.scene.features),
            taps,
            rays: 0,
            rounds_a_ray: 0,
            culls_lights: methods.culls_lights(),
        };
        let most_rounds = if self.gpu.adapter().is_software() {
            SOFTWARE_ROUNDS
        } else {
            u64::MAX
        };
        set.parts(effort, most_rounds)
    }

    /// Edges that a pixel goes through, about.
    fn edges(&self, set: &LightSet<'_>, settings: &RenderSettings) -> u64 {
        let methods = Methods::new(settings, set.has_images, set.traced.is_some());
        let most = if methods.culls_lights() {
            MOST_COUNTING_EDGES
        } else {
            u64::MAX
        };
        set.edges(settings.image_method.taps(), most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::GpuPreference;

    fn cornell() -> Scene {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        Scene::load(folder.join("../../scenes/cornell.glb")).unwrap()
    }

    #[test]
    fn tiles_make_the_same_picture() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let scene = cornell();
        let settings = RenderSettings {
            width: 61,
            height: 40,
            samples: 3,
            ..RenderSettings::default()
        };
        let mut renderer = GpuRenderer::new(&gpu, &scene).unwrap();
        let render = |renderer: &GpuRenderer| {
            let picture = renderer.render(&scene.cameras[0], &settings, Watch::none());
            picture.unwrap().radiance()
        };
        let whole = render(&renderer);
        for tile in [[13, 7], [61, 1], [1, 40], [64, 64]] {
            renderer.largest_tile = Some(tile);
            let tiled = render(&renderer);
            let differs = |(a, b): (&[f32; 3], &[f32; 3])| {
                let pairs = a.iter().zip(b);
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) > 1e-3
            };
            let differing = whole.iter().zip(&tiled).filter(|&pair| differs(pair));
            let count = differing.count();
            assert!(count <= 6, "tiles of {tile:?}: {count} pixels differ");
        }
    }

    #[test]
    fn the_longest_pictures() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let scene = cornell();
        let renderer = GpuRenderer::new(&gpu, &scene).unwrap();
        for (width, height) in [(32_768, 2), (2, 32_768)] {
            let settings = RenderSettings {
                width,
                height,
                samples: 1,
                ..RenderSettings::default()
            };
            let picture = renderer.render(&scene.cameras[0], &settings, Watch::none());
            let radiance = picture.unwrap().radiance();
            assert_eq!(radiance.len(), 65_536);
            assert!(radiance.iter().any(|pixel| *pixel != [0.0; 3]));
        }
    }

    #[test]
    fn a_lost_device_is_an_error() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let scene = cornell();
        let mut renderer = GpuRenderer::new(&gpu, &scene).unwrap();
        let settings = RenderSettings {
            width: 16,
            height: 16,
            ..RenderSettings::default()
        };
        let render =
            |renderer: &GpuRenderer| renderer.render(&scene.cameras[0], &settings, Watch::none());
        render(&renderer).unwrap();
        gpu.device().destroy();
        let fault = render(&renderer).unwrap_err();
        assert!(
            matches!(fault, RenderError::Gpu(GpuError::Lost { .. })),
            "{fault}"
        );
        let fault = renderer.set_lights(&scene.polygon_lights).unwrap_err();
        assert!(matches!(fault, GpuError::Lost { .. }), "{fault}");
        let fault = GpuRenderer::new(&gpu, &scene).err().unwrap();
        assert!(matches!(fault, GpuError::Lost { .. }), "{fault}");
    }
}
