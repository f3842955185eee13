//! Frames lit by many polygons, and the kernels that light them.

use lumigon_wgpu::{LightBuffers, TableFormat, Tables};

use super::kernel::{Binding, bind, filled, layout, pipeline, written};
use super::shading::Shading;
use super::timer::Timer;
use super::workload::{ExactLight, PixelRecord, pixels};
use crate::Failure;
use crate::bench::median;
use crate::interrupt::Interrupt;

/// The frame that times are for.
pub(super) const WIDTH: u32 = 1440;
pub(super) const HEIGHT: u32 = 900;

/// A frame may have one so many-th of the pixels along each axis.
const SCALES: [u32; 7] = [64, 32, 16, 8, 4, 2, 1];

/// A band is to take no longer: far below what makes a driver think that the device hangs.
const BAND_SECONDS: f64 = 0.2;

/// What is quicker is repeated within one submission.
const LEAST_SECONDS: f64 = 2e-3;
const MOST_REPETITIONS: u32 = 200;

const GROUP: u32 = 8;

/// Of more lights, so many are added at a time: the drivers of software GPUs end all loops of an
/// invocation after 65,535 rounds together, and a single band of few pixels is to be short too.
const LIGHTS_AT_ONCE: usize = 1024;

/// Bytes of a uniform at a dynamic offset, on any device.
const BAND_STRIDE: usize = 256;

/// Bytes of the shaders' `Band`.
const BAND_BYTES: u64 = 20;

/// Which functions light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// lumigon's.
    Exact,
    /// Clipping into an array.
    ArrayClip,
    /// A sphere that is clipped approximately.
    ClippedSphere,
}

impl Method {
    pub(super) const ALL: [Self; 3] = [Self::Exact, Self::ArrayClip, Self::ClippedSphere];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact (lumigon)",
            Self::ArrayClip => "array clip",
            Self::ClippedSphere => "clipped sphere",
        }
    }

    fn pipeline(
        self,
        stage: &Stage<'_>,
        vertices: usize,
        shading: Shading,
    ) -> Result<wgpu::ComputePipeline, Failure> {
        let size = format!(
            "const VERTICES: u32 = {vertices}u;\nconst CAPACITY: u32 = {}u;\n",
            vertices + 1
        );
        let mut modules = lumigon_wgpu::MODULES.to_vec();
        modules.extend([
            ("frame", include_str!("../shaders/frame.wesl")),
            ("edge", include_str!("../shaders/edge.wesl")),
            ("polygon_size", &size),
            (
                "horizon_clip",
                match vertices {
                    4 => include_str!("../shaders/quad_clip.wesl"),
                    _ => include_str!("../shaders/polygon_clip.wesl"),
                },
            ),
            (
                "form_factor",
                match self {
                    Self::ClippedSphere => include_str!("../shaders/clipped_sphere.wesl"),
                    _ => include_str!("../shaders/array_clip.wesl"),
                },
            ),
        ]);
        let root = match self {
            Self::Exact => include_str!("../shaders/exact.wesl"),
            _ => include_str!("../shaders/common_practice.wesl"),
        };
        pipeline(
            stage.timer.device,
            self.name(),
            root,
            &modules,
            &[("LOBES", f64::from(shading.lobes()))],
            &[&stage.light_layout, &stage.frame_layout],
        )
    }
}

/// What all frames share.
pub(super) struct Stage<'a> {
    timer: &'a Timer<'a>,
    interrupt: &'a Interrupt,
    tables: Tables,
    light_layout: wgpu::BindGroupLayout,
    frame_layout: wgpu::BindGroupLayout,
    frames: Vec<Frame>,
    /// A frame that takes longer is made smaller.
    budget: f64,
}

/// Surfaces on the device, and room for what they reflect.
struct Frame {
    width: u32,
    height: u32,
    pixels: wgpu::Buffer,
    output: wgpu::Buffer,
}

impl Frame {
    fn new(device: &wgpu::Device, scale: u32) -> Self {
        let (width, height) = size(scale);
        let output = u64::from(width * height) * 16;
        Self {
            width,
            height,
            pixels: filled(device, "surfaces", &pixels(width, height)),
            output: written(device, "frame", output),
        }
    }
}

fn size(scale: u32) -> (u32, u32) {
    (WIDTH.div_ceil(scale), HEIGHT.div_ceil(scale))
}

/// Lights on the device.
pub(super) struct LightGroup {
    buffers: LightBuffers,
    group: wgpu::BindGroup,
    world_vertices: wgpu::Buffer,
}

/// A kernel ready to light.
pub(super) struct Kernel {
    pipeline: wgpu::ComputePipeline,
}

/// Median times of several kernels on the same work, measured in turns.
pub(super) struct Times {
    /// Seconds of a frame of [`WIDTH`] by [`HEIGHT`], a kernel each.
    pub(super) seconds: Vec<f64>,
    /// Of each, how long the first took over how long it took: medians over the turns.
    pub(super) first_over: Vec<f64>,
    /// Size of the frame that was measured.
    pub(super) measured: (u32, u32),
}

impl<'a> Stage<'a> {
    /// `budget` in seconds a frame.
    pub(super) fn new(timer: &'a Timer<'a>, interrupt: &'a Interrupt, budget: f64) -> Self {
        let device = timer.device;
        use Binding::{Read, Settings, Write};
        Self {
            timer,
            interrupt,
            tables: Tables::new(device, timer.queue, TableFormat::F32),
            light_layout: lumigon_wgpu::bind_group_layout(device, wgpu::ShaderStages::COMPUTE),
            frame_layout: layout(device, &[Settings, Read, Read, Write]),
            frames: Vec::new(),
            budget,
        }
    }

    pub(super) fn lights(&self, lights: &[ExactLight]) -> Result<LightGroup, Failure> {
        let device = self.timer.device;
        let rounded: Vec<_> = lights.iter().map(ExactLight::rounded).collect();
        let buffers = LightBuffers::new(device, self.timer.queue, &rounded)?;
        let world_vertices: Vec<_> = lights.iter().flat_map(ExactLight::world_vertices).collect();
        Ok(LightGroup {
            group: lumigon_wgpu::bind_group(device, &self.light_layout, &buffers, &self.tables),
            buffers,
            world_vertices: filled(device, "world-space vertices", &world_vertices),
        })
    }

    pub(super) fn kernel(
        &self,
        method: Method,
        vertices: usize,
        shading: Shading,
    ) -> Result<Kernel, Failure> {
        let pipeline = method.pipeline(self, vertices, shading)?;
        Ok(Kernel { pipeline })
    }

    /// How long kernels take to light a frame by the first `count` lights.
    pub(super) fn time(
        &mut self,
        kernels: &[&Kernel],
        lights: &LightGroup,
        count: usize,
    ) -> Result<Times, Failure> {
        let mut seconds = 0.0;
        let mut level = 0;
        loop {
            self.interrupt.check()?;
            // Warm, then for how long. A frame of four times the pixels takes at most four times as
            // long.
            seconds = kernels.iter().try_fold(0.0_f64, |most, kernel| {
                self.once(kernel, lights, count, level, 4.0 * seconds, 1)?;
                let once = self.once(kernel, lights, count, level, 4.0 * seconds, 1)?;
                Ok::<_, Failure>(most.max(once))
            })?;
            if level + 1 == SCALES.len() || 4.0 * seconds > self.budget {
                break;
            }
            level += 1;
        }
        let repetitions = (LEAST_SECONDS / seconds).ceil() as u32;
        let repetitions = repetitions.clamp(1, MOST_REPETITIONS);
        let turns = if seconds > 0.3 { 3 } else { 7 };
        let mut samples = vec![Vec::new(); kernels.len()];
        for _ in 0..turns {
            self.interrupt.check()?;
            for (kernel, samples) in kernels.iter().zip(&mut samples) {
                samples.push(self.once(kernel, lights, count, level, seconds, repetitions)?);
            }
        }
        let first = samples[0].clone();
        let first_over = samples
            .iter()
            .map(|own| {
                let mut ratios: Vec<_> = first.iter().zip(own).map(|(a, b)| a / b).collect();
                median(&mut ratios)
            })
            .collect();
        let (width, height) = size(SCALES[level]);
        let scale = f64::from(WIDTH * HEIGHT) / f64::from(width * height);
        Ok(Times {
            seconds: samples.iter_mut().map(|own| median(own) * scale).collect(),
            first_over,
            measured: (width, height),
        })
    }

    /// Seconds of one frame. `expected` decides into how many bands it is split.
    fn once(
        &mut self,
        kernel: &Kernel,
        lights: &LightGroup,
        count: usize,
        level: usize,
        expected: f64,
        repetitions: u32,
    ) -> Result<f64, Failure> {
        self.frame(level);
        let frame = &self.frames[level];
        let bands = (expected / BAND_SECONDS).ceil().clamp(1.0, 1e4) as u32;
        let rows = frame.height.div_ceil(bands).next_multiple_of(GROUP);
        let (group, offsets) = self.bind(frame, lights, count, rows);
        let mut seconds = 0.0;
        for offsets in offsets {
            seconds += self.timer.seconds(&mut |pass| {
                pass.set_pipeline(&kernel.pipeline);
                pass.set_bind_group(0, &lights.group, &[]);
                for _ in 0..repetitions {
                    for &offset in &offsets {
                        pass.set_bind_group(1, &group, &[offset]);
                        let columns = frame.width.div_ceil(GROUP);
                        pass.dispatch_workgroups(columns, rows.div_ceil(GROUP), 1);
                    }
                }
            })?;
        }
        Ok(seconds / f64::from(repetitions))
    }

    fn frame(&mut self, level: usize) {
        while self.frames.len() <= level {
            let scale = SCALES[self.frames.len()];
            self.frames.push(Frame::new(self.timer.device, scale));
        }
    }

    /// A bind group of bands of `rows`, and the bands' offsets: for each band of rows those of all
    /// lights, a part at a time.
    fn bind(
        &self,
        frame: &Frame,
        lights: &LightGroup,
        count: usize,
        rows: u32,
    ) -> (wgpu::BindGroup, Vec<Vec<u32>>) {
        let device = self.timer.device;
        let mut settings: Vec<u32> = Vec::new();
        let mut offsets = Vec::new();
        for first in (0..frame.height).step_by(rows as usize) {
            let end = (first + rows).min(frame.height);
            let mut parts = Vec::new();
            for first_light in (0..count).step_by(LIGHTS_AT_ONCE) {
                parts.push(size_of_val(&*settings) as u32);
                let end_light = (first_light + LIGHTS_AT_ONCE).min(count);
                settings.extend([
                    frame.width,
                    first,
                    end,
                    first_light as u32,
                    end_light as u32,
                ]);
                settings.resize(settings.len().next_multiple_of(BAND_STRIDE / 4), 0);
            }
            offsets.push(parts);
        }
        let settings = filled(device, "bands", &settings);
        let band = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &settings,
            offset: 0,
            size: wgpu::BufferSize::new(BAND_BYTES),
        });
        let group = bind(
            device,
            &self.frame_layout,
            &[
                band,
                frame.pixels.as_entire_binding(),
                lights.world_vertices.as_entire_binding(),
                frame.output.as_entire_binding(),
            ],
        );
        (group, offsets)
    }

    /// The green channel of the smallest frame's pixels, lit by all lights, and its surfaces.
    pub(super) fn small_frame(
        &mut self,
        kernel: &Kernel,
        lights: &LightGroup,
    ) -> Result<(Vec<PixelRecord>, Vec<f64>), Failure> {
        self.once(kernel, lights, lights.buffers.len(), 0, 0.0, 1)?;
        let frame = &self.frames[0];
        let bytes = self.timer.read(&frame.output)?;
        let numbers: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let green = numbers.iter().map(|rgba| f64::from(rgba[1])).collect();
        Ok((pixels(frame.width, frame.height), green))
    }
}

#[cfg(test)]
mod tests {
    use lumigon_renderer::{Gpu, GpuPreference};

    use super::*;
    use crate::bench::gpu::workload::{Lights, lights, truth};

    const MEND: &str = "install a Vulkan driver, such as Debian's mesa-vulkan-drivers";

    /// Whatever is timed must be the light of all lights on all pixels.
    #[test]
    fn bands_and_parts_make_one_frame() {
        let gpu = Gpu::new(GpuPreference::Any).expect(MEND);
        let timer = Timer::new(gpu.device(), gpu.queue()).unwrap();
        let interrupt = Interrupt::never();
        let mut stage = Stage::new(&timer, &interrupt, 1.0);
        let kernel = stage.kernel(Method::Exact, 0, Shading::Diffuse).unwrap();
        let count = 2 * LIGHTS_AT_ONCE + 1;
        let list = lights(count, 10, Lights::Mixed);
        let group = stage.lights(&list).unwrap();
        let (surfaces, whole) = stage.small_frame(&kernel, &group).unwrap();
        let exact = truth(&surfaces[..20], &list, Shading::Diffuse);
        for (found, exact) in whole.iter().zip(&exact) {
            assert!((found - exact).abs() < 2e-5 * exact, "{found} {exact}");
        }
        let in_bands = 3.0 * BAND_SECONDS;
        stage.once(&kernel, &group, count, 0, in_bands, 2).unwrap();
        let bytes = timer.read(&stage.frames[0].output).unwrap();
        let numbers: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let in_bands = numbers.iter().map(|rgba| f64::from(rgba[1]));
        assert!(in_bands.eq(whole));
    }
}
