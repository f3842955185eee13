//! Pictures straight into a texture: for windows.

use std::ops::Range;

use super::clock::Clock;
use super::device::lock;
use super::display::DisplaySettings;
use super::equipment::Equipment;
use super::error::GpuError;
use super::frame::View;
use super::renderer::{GpuRenderer, Kept};
use super::tile::tiles;
use crate::bounce::VirtualLights;
use crate::cpu::{check_size, pixel_samples};
use crate::render::{RenderError, RenderSettings};
use crate::scene::Camera;

impl GpuRenderer {
    /// Draws what [`GpuRenderer::render_with_bounce`] renders into a texture, as [`srgb8`](crate::srgb8)
    /// shows it: encoded for displays, opaque.
    ///
    /// Nothing is read back or waited for: the work is submitted, in as many submissions as the driver
    /// bears, and whatever is submitted afterwards sees the picture. Where another thread renders with this
    /// renderer, its picture comes first.
    ///
    /// `target` has the size of `settings`, one sample and one mip level, can be rendered to
    /// (`RENDER_ATTACHMENT`), and its format has 8 bits or a half a channel and does not encode by itself:
    /// `Rgba8Unorm`, `Bgra8Unorm` or `Rgba16Float`.
    ///
    /// # Errors
    /// Where a setting is out of range or the texture will not do, when distance fields are over their
    /// budget, where there are more virtual lights than the device's buffers hold, and where the device
    /// fails. A device that is lost meanwhile may tell so only when the next picture is drawn, or by
    /// [`Gpu::is_lost`](crate::Gpu::is_lost).
    pub fn draw(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        virtual_lights: &VirtualLights,
        display: DisplaySettings,
        target: &wgpu::Texture,
    ) -> Result<(), RenderError> {
        let all = 0..settings.width;
        self.draw_part(camera, settings, virtual_lights, display, target, all)
    }

    /// Draws some of the picture's columns, and leaves the others of the texture as they were: pictures
    /// that share a texture cost no more than one.
    ///
    /// # Errors
    /// As [`GpuRenderer::draw`]. Columns beyond the picture are not there.
    pub fn draw_part(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        virtual_lights: &VirtualLights,
        display: DisplaySettings,
        target: &wgpu::Texture,
        columns: Range<u32>,
    ) -> Result<(), RenderError> {
        let size = [settings.width, settings.height];
        check_size(size[0], size[1], settings.samples)?;
        check_target(target, size)?;
        self.check_not_lost()?;
        let columns = columns.start..columns.end.min(size[0]);
        if columns.is_empty() {
            return Ok(());
        }
        let mut kept = lock(&self.kept);
        self.newest_times(&mut kept);
        let view = View::new(camera, size, self.scene.bounds);
        let picture = Drawing {
            view,
            size,
            columns,
            samples: pixel_samples(settings.samples),
            display,
            target,
        };
        let drawn = self.draw_sets(&picture, settings, virtual_lights, &mut kept);
        if drawn.is_err() {
            kept.picture = None;
        }
        // A lost device refuses everything else, too: that is the reason to name.
        self.check_not_lost()?;
        drawn
    }

    fn draw_sets(
        &self,
        picture: &Drawing<'_>,
        settings: &RenderSettings,
        virtual_lights: &VirtualLights,
        kept: &mut Kept,
    ) -> Result<(), RenderError> {
        let Kept {
            picture: equipment,
            virtual_lighting,
            stopwatch,
            ..
        } = kept;
        let mut sets = Vec::new();
        if settings.direct {
            sets.push(self.lighting.set(&self.gpu, settings)?);
        }
        if !virtual_lights.is_empty() {
            sets.push(self.virtual_light_set(virtual_lighting, virtual_lights)?);
        }
        self.gpu.guarded("a picture", || {
            let plan = self.plan(picture.size, &sets, settings);
            let tiles = tiles(picture.columns.clone(), 0..picture.size[1], plan.tile);
            let submissions = tiles.len() * picture.samples.len().div_ceil(plan.at_once);
            let bytes = Clock::bytes(plan.at_once) * submissions as u64;
            let reading = match self.clock {
                Some(_) => stopwatch.start(&self.gpu, bytes),
                None => None,
            };
            let mut times = reading;
            let equipment = Equipment::at_least(equipment, &self.gpu, &self.shading, plan.tile);
            let passes = self.passes(&sets, settings, equipment)?;
            let shown = self
                .display
                .pass(&self.gpu, &equipment.sums, picture.target)?;
            for tile in tiles {
                let samples = match &picture.view {
                    Some(_) => &*picture.samples,
                    // Its rays meet nothing.
                    None => &picture.samples[..1],
                };
                let mut batches = samples.chunks(plan.at_once).peekable();
                let mut is_first = true;
                while let Some(batch) = batches.next() {
                    let device = self.gpu.device();
                    let mut encoder = device.create_command_encoder(&Default::default());
                    if is_first {
                        equipment.sums.clear(&mut encoder, tile);
                    }
                    if let Some(view) = &picture.view {
                        let share = 1.0 / samples.len() as f32;
                        self.write_frames(view, tile, batch, share);
                        for frame in 0..batch.len() {
                            self.encode(&mut encoder, equipment, &passes, tile, frame);
                        }
                        if let (Some(clock), Some(times)) = (&self.clock, &mut times) {
                            clock.append(&mut encoder, batch.len(), times);
                        }
                    }
                    if batches.peek().is_none() {
                        shown.encode(&self.gpu, &mut encoder, tile, picture.display);
                    }
                    self.gpu.queue().submit([encoder.finish()]);
                    is_first = false;
                }
            }
            if let Some(times) = times {
                stopwatch.finish(times);
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Takes over the times of drawn pictures that have come.
    pub(super) fn newest_times(&self, kept: &mut Kept) {
        let Some(clock) = &self.clock else {
            return;
        };
        if let Some([visibility, shading]) = kept.stopwatch.newest(&self.gpu, clock) {
            self.set_times(visibility, shading);
        }
    }

    fn check_not_lost(&self) -> Result<(), GpuError> {
        match self.gpu.is_lost() {
            Some(reason) => Err(GpuError::Lost { reason }),
            None => Ok(()),
        }
    }
}

/// What is drawn where.
struct Drawing<'a> {
    view: Option<View>,
    size: [u32; 2],
    columns: Range<u32>,
    samples: Vec<[f64; 2]>,
    display: DisplaySettings,
    target: &'a wgpu::Texture,
}

/// Whether a picture of this size can be drawn into a texture.
fn check_target(target: &wgpu::Texture, [width, height]: [u32; 2]) -> Result<(), RenderError> {
    let formats = [
        wgpu::TextureFormat::Rgba8Unorm,
        wgpu::TextureFormat::Bgra8Unorm,
        wgpu::TextureFormat::Rgba16Float,
    ];
    let size = target.size();
    let is_flat = target.dimension() == wgpu::TextureDimension::D2
        && size.depth_or_array_layers == 1
        && target.mip_level_count() == 1
        && target.sample_count() == 1;
    let fault = if [size.width, size.height] != [width, height] {
        format!("has {} x {} pixels", size.width, size.height)
    } else if !formats.contains(&target.format()) {
        format!("has the format {:?}", target.format())
    } else if !target
        .usage()
        .contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
    {
        "cannot be rendered to".to_owned()
    } else if !is_flat {
        "has several layers, mip levels or samples".to_owned()
    } else {
        return Ok(());
    };
    Err(RenderError::Target {
        fault,
        width,
        height,
    })
}
