//! Prefiltered images: each level half the size of the one before.
//!
//! After Williams, "Pyramidal Parametrics", SIGGRAPH 1983, with a wider kernel: `[1 5 10 10 5 1] / 32`
//! along both axes. It keeps the mean exactly, since borders are mirrored, and shows no blocks when
//! magnified.

use alloc::vec;
use alloc::vec::Vec;

/// Red, green, blue and weight.
pub type Texel = [f32; 4];

/// Weights of three texels on either side of the middle of two.
const KERNEL: [f32; 6] = [
    1.0 / 32.0,
    5.0 / 32.0,
    10.0 / 32.0,
    10.0 / 32.0,
    5.0 / 32.0,
    1.0 / 32.0,
];

/// An image of W x H texels, both powers of two, and its smaller levels down to one texel.
#[derive(Clone, Debug, PartialEq)]
pub struct ImagePyramid {
    size: [u32; 2],
    /// Index of each level's first texel in `texels`, and their number at the end.
    starts: Vec<usize>,
    /// Level after level, row by row.
    texels: Vec<Texel>,
}

impl ImagePyramid {
    /// All black.
    ///
    /// # Panics
    /// Unless both sizes are powers of two.
    #[must_use]
    pub fn new([width, height]: [u32; 2]) -> Self {
        assert!(
            width.is_power_of_two() && height.is_power_of_two(),
            "the sizes of an image pyramid are powers of two"
        );
        let mut starts = vec![0];
        let count = width.max(height).trailing_zeros() + 1;
        for level in 0..count {
            let [w, h] = level_size([width, height], level);
            starts.push(starts[level as usize] + w as usize * h as usize);
        }
        let length = starts[count as usize];
        Self {
            size: [width, height],
            starts,
            texels: vec![[0.0; 4]; length],
        }
    }

    /// Bytes that the texels of all levels take.
    #[must_use]
    pub fn bytes([width, height]: [u32; 2]) -> u64 {
        let mut sum = 0;
        for level in 0..=width.max(height).max(1).ilog2() {
            let [w, h] = level_size([width, height], level);
            sum += u64::from(w) * u64::from(h);
        }
        sum * size_of::<Texel>() as u64
    }

    /// Texels across and down of the largest level.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of levels, at least one.
    #[must_use]
    pub fn level_count(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// Texels across and down of a level.
    #[must_use]
    pub fn level_size(&self, level: u32) -> [u32; 2] {
        level_size(self.size, level)
    }

    /// A level's texels, row by row.
    ///
    /// # Panics
    /// Beyond the last level.
    #[must_use]
    pub fn level(&self, level: u32) -> &[Texel] {
        &self.texels[self.starts[level as usize]..self.starts[level as usize + 1]]
    }

    /// All levels, the largest first.
    #[must_use]
    pub fn texels(&self) -> &[Texel] {
        &self.texels
    }

    /// The mean of all texels.
    #[inline(always)]
    #[must_use]
    pub fn mean(&self) -> Texel {
        self.texels[self.texels.len() - 1]
    }

    /// The largest level, to be written before [`ImagePyramid::filter`].
    pub(crate) fn base(&mut self) -> &mut [Texel] {
        &mut self.texels[..self.starts[1]]
    }

    /// Filters the smaller levels from the largest.
    pub(crate) fn filter(&mut self) {
        for level in 1..self.level_count() {
            let [width, height] = self.level_size(level - 1);
            let [half_width, _] = self.level_size(level);
            let (larger, smaller) = self.texels.split_at_mut(self.starts[level as usize]);
            let larger = &larger[self.starts[level as usize - 1]..];
            let length = self.starts[level as usize + 1] - self.starts[level as usize];
            for_each_row(&mut smaller[..length], half_width as usize, |y, row| {
                halve_row(larger, [width as usize, height as usize], y, row);
            });
        }
    }

    /// Trilinear: coordinates in \[0, 1\] from the upper left corner, the level in
    /// \[0, [`level_count`](Self::level_count) - 1\]; what is beyond is moved to the border.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: f32, v: f32, level: f32) -> Texel {
        let last = (self.starts.len() - 2) as f32;
        // NaN becomes 0.
        let level = if level > 0.0 { level.min(last) } else { 0.0 };
        let whole = level as u32;
        let fraction = level - whole as f32;
        let finer = self.bilinear(u, v, whole);
        if fraction > 0.0 {
            lerp(finer, self.bilinear(u, v, whole + 1), fraction)
        } else {
            finer
        }
    }

    #[inline(always)]
    fn bilinear(&self, u: f32, v: f32, level: u32) -> Texel {
        let texels = &self.texels[self.starts[level as usize]..];
        bilinear(texels, self.level_size(level), u, v)
    }
}

/// Between the centres of the four nearest texels; coordinates in \[0, 1\] from the upper left corner,
/// what is beyond is moved to the border.
#[inline(always)]
pub(crate) fn bilinear(texels: &[Texel], [width, height]: [u32; 2], u: f32, v: f32) -> Texel {
    let (x0, x1, fx) = neighbours(u, width);
    let (y0, y1, fy) = neighbours(v, height);
    let (upper, lower) = (y0 * width as usize, y1 * width as usize);
    lerp(
        lerp(texels[upper + x0], texels[upper + x1], fx),
        lerp(texels[lower + x0], texels[lower + x1], fx),
        fy,
    )
}

/// The two texels whose centres are on either side of a coordinate, and how far from the first.
#[inline(always)]
fn neighbours(u: f32, size: u32) -> (usize, usize, f32) {
    let last = (size - 1) as f32;
    // NaN becomes 0.
    let x = u * size as f32 - 0.5;
    let x = if x > 0.0 { x.min(last) } else { 0.0 };
    let first = x as u32;
    (
        first as usize,
        (first + 1).min(size - 1) as usize,
        x - first as f32,
    )
}

#[inline(always)]
fn lerp(a: Texel, b: Texel, t: f32) -> Texel {
    core::array::from_fn(
        #[inline(always)]
        // Not by the difference: beside large numbers it would round small ones away.
        |i| a[i] * (1.0 - t) + b[i] * t,
    )
}

fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|side| (side >> level).max(1))
}

/// Row `y` of the image at half the size.
fn halve_row(image: &[Texel], [width, height]: [usize; 2], y: usize, row: &mut [Texel]) {
    let mut sums = vec![[0.0; 4]; width];
    if height == 1 {
        sums.copy_from_slice(image);
    } else {
        for (tap, weight) in KERNEL.into_iter().enumerate() {
            let from = mirrored(2 * y + tap, height) * width;
            for (sum, texel) in sums.iter_mut().zip(&image[from..from + width]) {
                add(sum, *texel, weight);
            }
        }
    }
    if width == 1 {
        row.copy_from_slice(&sums);
        return;
    }
    for (x, texel) in row.iter_mut().enumerate() {
        let mut sum = [0.0; 4];
        for (tap, weight) in KERNEL.into_iter().enumerate() {
            add(&mut sum, sums[mirrored(2 * x + tap, width)], weight);
        }
        *texel = sum;
    }
}

/// Index of what lies two before `i`, mirrored at the borders of a power of two, at least 2.
#[inline(always)]
fn mirrored(i: usize, size: usize) -> usize {
    let i = if i < 2 { 1 - i } else { i - 2 };
    i.min(2 * size - 1 - i)
}

#[inline(always)]
fn add(sum: &mut Texel, texel: Texel, weight: f32) {
    for (sum, texel) in sum.iter_mut().zip(texel) {
        *sum += texel * weight;
    }
}

/// Calls `each` with the number of every row and the row itself, on as many threads as there are
/// where the feature `parallel` is on.
pub(crate) fn for_each_row<T: Send>(
    rows: &mut [T],
    width: usize,
    each: impl Fn(usize, &mut [T]) + Sync,
) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        /// Smaller images take less time than handing rows to threads.
        const LEAST: usize = 4096;
        if rows.len() >= LEAST {
            rows.par_chunks_exact_mut(width)
                .with_min_len(8)
                .enumerate()
                .for_each(|(y, row)| each(y, row));
            return;
        }
    }
    for (y, row) in rows.chunks_exact_mut(width).enumerate() {
        each(y, row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(size: [u32; 2]) -> ImagePyramid {
        let mut pyramid = ImagePyramid::new(size);
        for (i, texel) in pyramid.base().iter_mut().enumerate() {
            let number = |k: usize| ((i * 7 + k) * 2_654_435_761 % 1000) as f32 / 1000.0;
            *texel = [number(0), number(1), number(2), 1.0];
        }
        pyramid.filter();
        pyramid
    }

    #[test]
    fn every_level_keeps_the_mean() {
        for size in [[1, 1], [2, 1], [1, 8], [8, 8], [64, 4], [128, 64]] {
            let pyramid = noise(size);
            let mean = |level| {
                let texels = pyramid.level(level);
                let sum = texels.iter().map(|t| f64::from(t[1])).sum::<f64>();
                sum / texels.len() as f64
            };
            for level in 0..pyramid.level_count() {
                assert!((mean(level) - mean(0)).abs() < 1e-6, "{size:?} {level}");
            }
            assert_eq!(pyramid.level(pyramid.level_count() - 1), [pyramid.mean()]);
            assert_eq!(
                ImagePyramid::bytes(size),
                (pyramid.texels().len() * 16) as u64
            );
        }
    }

    #[test]
    fn gradients_stay_gradients() {
        let mut pyramid = ImagePyramid::new([64, 64]);
        for (i, texel) in pyramid.base().iter_mut().enumerate() {
            *texel = [(i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5, 0.0, 1.0];
        }
        pyramid.filter();
        for level in [0.0, 0.5, 1.0, 1.7, 2.0] {
            for (u, v) in [(0.3, 0.4), (0.5, 0.5), (0.61, 0.27)] {
                let found = pyramid.sample(u, v, level);
                assert!((found[0] / 64.0 - u).abs() < 1e-5, "{level} {found:?}");
                assert!((found[1] / 64.0 - v).abs() < 1e-5, "{level} {found:?}");
            }
        }
    }

    #[test]
    fn hostile_coordinates_stay_inside() {
        let pyramid = noise([8, 4]);
        for hostile in [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            -1.0,
            2.0,
            1e30,
            f32::MAX,
        ] {
            for found in [
                pyramid.sample(hostile, 0.5, 0.5),
                pyramid.sample(0.5, hostile, 1.5),
                pyramid.sample(0.5, 0.5, hostile),
            ] {
                assert!(found.iter().all(|x| (0.0..=1.0).contains(x)), "{found:?}");
            }
        }
    }
}
