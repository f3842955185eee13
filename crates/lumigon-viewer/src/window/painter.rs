//! egui on a window's surface.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use lumigon_renderer::{Gpu, GpuError, GpuPreference};
use winit::window::Window;

/// A device that presents to a window, and the interface's pipelines on it.
pub(super) struct Painter {
    surface: wgpu::Surface<'static>,
    pub(super) gpu: Gpu,
    config: wgpu::SurfaceConfiguration,
    pub(super) renderer: egui_wgpu::Renderer,
}

/// One frame of the interface.
pub(super) struct Drawn {
    pub(super) primitives: Vec<egui::ClippedPrimitive>,
    pub(super) textures: egui::TexturesDelta,
    pub(super) pixels_per_point: f32,
    /// Behind everything: panels need not be filled.
    pub(super) background: wgpu::Color,
}

impl Painter {
    /// On hardware where there is some: the window wants a device whatever computes the picture.
    pub(super) fn new(window: &Arc<Window>) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle(
            Box::new(Arc::clone(window)),
        ));
        let surface = instance
            .create_surface(Arc::clone(window))
            .map_err(|fault| GpuError::Refused {
                what: "a window's surface",
                reason: fault.to_string(),
            })?;
        let gpu = Gpu::for_surface(&instance, &surface, GpuPreference::Any)?;
        let size = window.inner_size();
        let capabilities = surface.get_capabilities(gpu.wgpu_adapter());
        // The interface mixes colours as they are displayed.
        let format = capabilities
            .formats
            .iter()
            .copied()
            .find(|format| {
                matches!(
                    format,
                    wgpu::TextureFormat::Rgba8Unorm | wgpu::TextureFormat::Bgra8Unorm
                )
            })
            .or(capabilities.formats.first().copied())
            .ok_or(GpuError::Refused {
                what: "a window's surface",
                reason: "it has no format".to_owned(),
            })?;
        let mut config = surface
            .get_default_config(gpu.wgpu_adapter(), size.width.max(1), size.height.max(1))
            .ok_or(GpuError::Refused {
                what: "a window's surface",
                reason: "the device cannot present to it".to_owned(),
            })?;
        config.format = format;
        config.present_mode = wgpu::PresentMode::AutoVsync;
        config.desired_maximum_frame_latency = 1;
        surface.configure(gpu.device(), &config);
        let renderer = egui_wgpu::Renderer::new(gpu.device(), format, options());
        Ok(Self {
            surface,
            gpu,
            config,
            renderer,
        })
    }

    pub(super) fn resize(&mut self, [width, height]: [u32; 2]) {
        let largest = self.gpu.device().limits().max_texture_dimension_2d;
        let size = [width, height].map(|side| side.clamp(1, largest));
        if size != [self.config.width, self.config.height] {
            [self.config.width, self.config.height] = size;
            self.surface.configure(self.gpu.device(), &self.config);
        }
    }

    /// Shows a frame; nothing where the window is hidden. Also gives its pixels, if asked for.
    ///
    /// Pixels are drawn a second time, to a texture that can be read on every system.
    pub(super) fn paint(
        &mut self,
        drawn: &Drawn,
        capture: bool,
    ) -> Result<Option<egui::ColorImage>, GpuError> {
        let lost = |reason| Err(GpuError::Lost { reason });
        if let Some(reason) = self.gpu.is_lost() {
            return lost(reason);
        }
        // The interface's renderer takes a buffer that a lost device refuses for a fault of ours.
        let painted = catch_unwind(AssertUnwindSafe(|| self.paint_now(drawn, capture)));
        painted.unwrap_or_else(|panic| match self.gpu.is_lost() {
            Some(reason) => lost(reason),
            None => resume_unwind(panic),
        })
    }

    fn paint_now(
        &mut self,
        drawn: &Drawn,
        capture: bool,
    ) -> Result<Option<egui::ColorImage>, GpuError> {
        self.gpu.check()?;
        let (device, queue) = (self.gpu.device().clone(), self.gpu.queue().clone());
        let size = [self.config.width, self.config.height];
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: size,
            pixels_per_point: drawn.pixels_per_point,
        };
        for (id, deltas) in &drawn.textures.set {
            for delta in deltas {
                self.renderer.update_texture(&device, &queue, *id, delta);
            }
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut commands =
            self.renderer
                .update_buffers(&device, &queue, &mut encoder, &drawn.primitives, &screen);
        let frame = self.next_texture();
        if let Some(frame) = &frame {
            let view = frame.texture.create_view(&Default::default());
            draw(&self.renderer, &mut encoder, &view, drawn, &screen);
        }
        let captured = capture.then(|| {
            let target = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("screenshot"),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: self.config.format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let view = target.create_view(&Default::default());
            draw(&self.renderer, &mut encoder, &view, drawn, &screen);
            let row = (size[0] * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("screenshot"),
                size: u64::from(row) * u64::from(size[1]),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            encoder.copy_texture_to_buffer(
                target.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row),
                        rows_per_image: None,
                    },
                },
                target.size(),
            );
            (buffer, row)
        });
        commands.push(encoder.finish());
        queue.submit(commands);
        if let Some(frame) = frame {
            queue.present(frame);
        }
        for id in &drawn.textures.free {
            self.renderer.free_texture(id);
        }
        self.gpu.check()?;
        captured
            .map(|(buffer, row)| self.read(&buffer, row, size))
            .transpose()
    }

    /// None where there is nothing to draw to for now.
    fn next_texture(&mut self) -> Option<wgpu::SurfaceTexture> {
        use wgpu::CurrentSurfaceTexture as Current;
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                Current::Success(frame) => return Some(frame),
                Current::Suboptimal(frame) => drop(frame),
                Current::Outdated | Current::Lost => {}
                Current::Timeout | Current::Occluded | Current::Validation => return None,
            }
            self.surface.configure(self.gpu.device(), &self.config);
        }
        None
    }

    fn read(
        &self,
        buffer: &wgpu::Buffer,
        row: u32,
        [width, height]: [u32; 2],
    ) -> Result<egui::ColorImage, GpuError> {
        let refused = |reason: String| GpuError::Refused {
            what: "a screenshot",
            reason,
        };
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        let polled = self.gpu.device().poll(wgpu::PollType::wait_indefinitely());
        polled.map_err(|fault| refused(fault.to_string()))?;
        let view = buffer
            .get_mapped_range(..)
            .map_err(|fault| refused(fault.to_string()))?;
        let is_bgra = self.config.format == wgpu::TextureFormat::Bgra8Unorm;
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for line in view.chunks(row as usize) {
            for texel in line[..width as usize * 4].chunks(4) {
                let [r, b] = if is_bgra { [2, 0] } else { [0, 2] };
                pixels.push(egui::Color32::from_rgb(texel[r], texel[1], texel[b]));
            }
        }
        Ok(egui::ColorImage::new(
            [width as usize, height as usize],
            pixels,
        ))
    }
}

fn options() -> egui_wgpu::RendererOptions {
    egui_wgpu::RendererOptions {
        // Screenshots of the same frame are the same.
        dithering: false,
        ..Default::default()
    }
}

fn draw(
    renderer: &egui_wgpu::Renderer,
    encoder: &mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    drawn: &Drawn,
    screen: &egui_wgpu::ScreenDescriptor,
) {
    let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("interface"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(drawn.background),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    renderer.render(&mut pass.forget_lifetime(), &drawn.primitives, screen);
}
