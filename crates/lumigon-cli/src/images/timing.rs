//! What a mean image costs.

use std::hint::black_box;
use std::time::Instant;

use super::light::StudyLight;
use super::measure::{METHODS, Numbers, Task, mean_image};
use super::place::Surface;
use crate::Failure;
use crate::interrupt::Interrupt;

/// Places a repetition goes through, so that no neighbour helps another.
const PLACES: usize = 512;

/// The methods take turns so often, and the fastest turn counts: what else the machine does slows
/// turns, and never speeds one up.
const TURNS: usize = 40;

/// Nanoseconds of one mean image by each method, for diffuse and for specular surfaces: scalars in
/// single precision, on one thread.
pub(super) fn nanoseconds(
    lights: &[StudyLight],
    tasks: &[Task],
    interrupt: &Interrupt,
) -> Result<[Numbers; 2], Failure> {
    let mut found = [[f64::INFINITY; METHODS.len()]; 2];
    for (surface, found) in Surface::ALL.iter().zip(&mut found) {
        let places: Vec<&Task> = tasks.iter().filter(|t| t.surface == *surface).collect();
        // From all over the classes.
        let step = places.len().div_ceil(PLACES).max(1);
        let places: Vec<&Task> = places.into_iter().step_by(step).collect();
        for _ in 0..TURNS {
            interrupt.check()?;
            for (nanoseconds, (_, method)) in found.iter_mut().zip(METHODS) {
                let start = Instant::now();
                for task in &places {
                    let light = &lights[task.light];
                    if let Some(shown) = light.images.first() {
                        black_box(mean_image(light, shown, &task.place, method));
                    }
                }
                let turn = 1e9 * start.elapsed().as_secs_f64() / places.len().max(1) as f64;
                *nanoseconds = nanoseconds.min(turn);
            }
        }
    }
    Ok(found)
}
