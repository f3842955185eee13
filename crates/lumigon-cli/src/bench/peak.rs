//! What the processor can do at most.

use std::hint::black_box;

use fearless_simd::{Level, Simd, dispatch};
use lumigon::{Lanes, Real};

use super::kernels::median_seconds;

/// Fused multiply-adds a second in each chain's loop.
const STEPS: usize = 1_000;

/// Independent chains: more than latency times issue width on any processor so far.
const CHAINS: usize = 16;

/// Fused multiply-adds a second (one for each lane) on the calling thread.
pub(super) fn fused_multiply_adds_per_second() -> f64 {
    let seconds = median_seconds(|| dispatch!(Level::new(), simd => chains(simd)));
    (STEPS * CHAINS) as f64 * lanes() as f64 / seconds
}

/// Lanes of one register.
pub(super) fn lanes() -> usize {
    dispatch!(Level::new(), simd => count(simd))
}

#[inline(always)]
fn count<S: Simd>(_: S) -> usize {
    Lanes::<S>::COUNT
}

#[inline(always)]
fn chains<S: Simd>(simd: S) {
    let factor = black_box(Lanes::splat(simd, 0.999));
    let term = black_box(Lanes::splat(simd, 0.001));
    let mut sums = [factor; CHAINS];
    for _ in 0..STEPS {
        for sum in &mut sums {
            *sum = sum.mul_add(factor, term);
        }
    }
    black_box(sums);
}
