//! What a GPU can do at most.

use super::kernel::{Binding, bind, filled, layout, pipeline, written};
use super::timer::Timer;
use crate::Failure;
use crate::bench::median;

/// Enough to fill every lane of the greatest devices several times.
const INVOCATIONS: u32 = 1 << 20;
const INVOCATIONS_ON_CPU: u32 = 1 << 13;
const GROUP: u32 = 64;

/// Multiply-adds of an invocation in each round of the shader's loop.
const STEPS_A_ROUND: u32 = 256;

/// Beyond the caches of any device so far.
const COPIED_BYTES: u64 = 512 << 20;
const COPIED_BYTES_ON_CPU: u64 = 128 << 20;

/// A measurement takes at least as long.
const LEAST_SECONDS: f64 = 0.01;

const REPETITIONS: usize = 9;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Settings {
    factor: f32,
    term: f32,
    rounds: u32,
    padding: u32,
}

/// Multiply-adds of f32 a second, all lanes together: the greater figure of fused ones and of
/// products and sums that the compiler may fuse.
///
/// The timer takes timestamps from here on, where they are right: those of software are not always,
/// and nothing is between it and the wall clock.
pub(super) fn multiply_adds_per_second(
    timer: &mut Timer<'_>,
    is_cpu: bool,
) -> Result<f64, Failure> {
    let device = timer.device;
    let invocations = if is_cpu {
        INVOCATIONS_ON_CPU
    } else {
        INVOCATIONS
    };
    let layout = layout(device, &[Binding::Settings, Binding::Write]);
    let results = written(device, "sums", u64::from(invocations) * 4);
    let mut greatest: f64 = 0.0;
    for fused in [1.0, 0.0] {
        let pipeline = pipeline(
            device,
            "multiply-adds",
            include_str!("../shaders/multiply_add.wesl"),
            &[],
            &[("FUSED", fused)],
            &[&layout],
        )?;
        let mut rounds = 1;
        loop {
            let settings = Settings {
                factor: 0.999,
                term: 0.001,
                rounds,
                padding: 0,
            };
            let settings = filled(device, "settings", &[settings]);
            let group = bind(
                device,
                &layout,
                &[settings.as_entire_binding(), results.as_entire_binding()],
            );
            let mut work = |pass: &mut wgpu::ComputePass<'_>| {
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[0]);
                pass.dispatch_workgroups(invocations / GROUP, 1, 1);
            };
            // The first run of a pipeline may compile it.
            timer.seconds(&mut work)?;
            let once = timer.seconds(&mut work)?;
            if once < LEAST_SECONDS && rounds < 1 << 20 {
                let growth = (1.5 * LEAST_SECONDS / once).ceil().clamp(2.0, 16.0);
                rounds *= growth as u32;
                continue;
            }
            if !is_cpu {
                timer.try_timestamps(&mut work)?;
            }
            let mut samples = (0..REPETITIONS)
                .map(|_| timer.seconds(&mut work))
                .collect::<Result<Vec<_>, _>>()?;
            let done = f64::from(invocations) * f64::from(rounds) * f64::from(STEPS_A_ROUND);
            greatest = greatest.max(done / median(&mut samples));
            break;
        }
    }
    Ok(greatest)
}

/// Bytes read and written a second by a shader that copies a buffer.
pub(super) fn bytes_per_second(timer: &Timer<'_>, is_cpu: bool) -> Result<f64, Failure> {
    let device = timer.device;
    let limits = device.limits();
    let wanted = if is_cpu {
        COPIED_BYTES_ON_CPU
    } else {
        COPIED_BYTES
    };
    let size = wanted
        .min(limits.max_buffer_size)
        .min(limits.max_storage_buffer_binding_size)
        & !0xffff;
    let layout = layout(device, &[Binding::Read, Binding::Write]);
    let source = written(device, "source", size);
    let destination = written(device, "destination", size);
    let pipeline = pipeline(
        device,
        "copy",
        include_str!("../shaders/copy.wesl"),
        &[],
        &[],
        &[&layout],
    )?;
    let group = bind(
        device,
        &layout,
        &[source.as_entire_binding(), destination.as_entire_binding()],
    );
    // A dispatch has at most 65,535 groups along an axis.
    let groups = (size / 16).div_ceil(GROUP.into());
    let columns = groups.min(1 << 15);
    let rows = groups.div_ceil(columns);
    let mut work = |pass: &mut wgpu::ComputePass<'_>| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(columns as u32, rows as u32, 1);
    };
    timer.seconds(&mut work)?;
    let mut samples = (0..REPETITIONS)
        .map(|_| timer.seconds(&mut work))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(2.0 * size as f64 / median(&mut samples))
}
