//! What the lights of the study show.

use rand::{Rng, RngExt};
use serde::Serialize;

/// A kind of texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Kind {
    /// Each channel rises in a direction of its own.
    Gradient,
    /// Two colours far apart, in rectangles, 2 to 14 a side.
    Checkerboard,
    /// Noise whose amplitude falls with frequency as that of photographs does.
    Noise,
    /// One texel a thousand times as bright as all the others together are on average.
    BrightTexel,
}

impl Kind {
    pub(super) const ALL: [Self; 4] = [
        Self::Gradient,
        Self::Checkerboard,
        Self::Noise,
        Self::BrightTexel,
    ];

    /// Kinds that the summaries count; the last stands apart.
    pub(super) const COUNTED: [Self; 3] = [Self::Gradient, Self::Checkerboard, Self::Noise];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Gradient => "gradients",
            Self::Checkerboard => "checkerboards",
            Self::Noise => "noise",
            Self::BrightTexel => "bright texel",
        }
    }

    /// Linear RGB of `size` x `size` texels, row by row. `bright` is where a bright texel may be.
    pub(super) fn texels(
        self,
        size: usize,
        bright: impl Fn(usize) -> bool,
        rng: &mut impl Rng,
    ) -> Vec<[f32; 3]> {
        match self {
            Self::Gradient => gradient(size, rng),
            Self::Checkerboard => checkerboard(size, rng),
            Self::Noise => noise(size, rng),
            Self::BrightTexel => {
                let candidates: Vec<usize> = (0..size * size).filter(|&i| bright(i)).collect();
                let mut texels = vec![[1.0; 3]; size * size];
                if let Some(&i) = candidates.get(rng.random_range(0..candidates.len().max(1))) {
                    texels[i] = [1000.0; 3];
                }
                texels
            }
        }
    }
}

fn by_texel(size: usize, color: impl Fn(f64, f64) -> [f64; 3]) -> Vec<[f32; 3]> {
    let at = |i: usize| (i as f64 + 0.5) / size as f64;
    (0..size * size)
        .map(|i| color(at(i % size), at(i / size)).map(|c| c.max(0.0) as f32))
        .collect()
}

fn gradient(size: usize, rng: &mut impl Rng) -> Vec<[f32; 3]> {
    let slopes = [(); 3].map(|()| {
        let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        let steepness = rng.random_range(0.4..0.8);
        [cos * steepness, sin * steepness]
    });
    by_texel(size, |u, v| {
        slopes.map(|[x, y]| 0.5 + x * (u - 0.5) + y * (v - 0.5))
    })
}

fn checkerboard(size: usize, rng: &mut impl Rng) -> Vec<[f32; 3]> {
    let shades = [(); 3].map(|()| {
        let (dark, light) = (rng.random_range(0.0..0.3), rng.random_range(0.7..1.0));
        if rng.random() {
            [dark, light]
        } else {
            [light, dark]
        }
    });
    let [a, b] = [0, 1].map(|i| shades.map(|channel| channel[i]));
    let [columns, rows] = [(); 2].map(|()| rng.random_range(2.0..14.0));
    let [x, y] = [(); 2].map(|()| rng.random::<f64>());
    by_texel(size, |u, v| {
        let square = (u * columns + x).floor() + (v * rows + y).floor();
        if square.rem_euclid(2.0) < 1.0 { a } else { b }
    })
}

/// Octaves of the same variance: amplitude falls as 1 / frequency (Field 1987).
fn noise(size: usize, rng: &mut impl Rng) -> Vec<[f32; 3]> {
    let mut texels = vec![[0.0; 3]; size * size];
    for channel in 0..3 {
        let mut sum = vec![0.0_f64; size * size];
        let mut cells = 2;
        while cells <= size {
            octave(&mut sum, size, cells, rng);
            cells *= 2;
        }
        let variance = sum.iter().map(|x| x * x).sum::<f64>() / sum.len() as f64;
        let scale = 0.3 / variance.sqrt().max(1e-9);
        for (texel, x) in texels.iter_mut().zip(sum) {
            texel[channel] = (0.5 + scale * x).max(0.0) as f32;
        }
    }
    texels
}

/// Adds smooth random bumps, `cells` a side.
fn octave(sum: &mut [f64], size: usize, cells: usize, rng: &mut impl Rng) {
    let nodes = cells + 2;
    let lattice: Vec<f64> = (0..nodes * nodes)
        .map(|_| rng.random_range(-1.0..1.0))
        .collect();
    let [shift_x, shift_y] = [(); 2].map(|()| rng.random::<f64>());
    let place = |i: usize, shift: f64| {
        let x = (i as f64 + 0.5) / size as f64 * cells as f64 + shift;
        let (cell, t) = (x.floor(), x.fract());
        (cell as usize, t * t * (3.0 - 2.0 * t))
    };
    for (i, sum) in sum.iter_mut().enumerate() {
        let (x, right) = place(i % size, shift_x);
        let (y, lower) = place(i / size, shift_y);
        let at = |dx: usize, dy: usize| lattice[(y + dy) * nodes + x + dx];
        let row = |dy: usize| at(0, dy) + (at(1, dy) - at(0, dy)) * right;
        *sum += row(0) + (row(1) - row(0)) * lower;
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg32;

    use super::*;

    #[test]
    fn textures_vary_and_are_light() {
        for kind in Kind::ALL {
            let texels = kind.texels(32, |i| i == 77, &mut Pcg32::seed_from_u64(1));
            assert_eq!(texels.len(), 32 * 32);
            let numbers = || texels.iter().flatten();
            assert!(numbers().all(|x| x.is_finite() && *x >= 0.0));
            let [least, greatest] = numbers().fold([f32::MAX, 0.0], |[low, high], x| {
                [low.min(*x), high.max(*x)]
            });
            assert!(greatest > least + 0.1, "{kind:?} {least} {greatest}");
            if kind == Kind::BrightTexel {
                assert_eq!(texels[77], [1000.0; 3]);
            }
        }
    }
}
