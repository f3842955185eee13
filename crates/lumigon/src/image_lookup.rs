//! The mean of a light's image by one lookup: the conventional way, to be measured against.
//!
//! Heitz, Dupuy, Hill and Neubelt, "Real-Time Polygonal-Light Shading with Linearly Transformed
//! Cosines", ACM TOG 35(4), 2016, section "Textured lights", and the authors' published shaders: Gaussian
//! levels whose widths grow by 3, with a margin around the image and coverage renormalised, looked
//! up where the light vector meets the light's plane, by the plane's distance.

use alloc::vec;
use alloc::vec::Vec;

use crate::image_pyramid::{ImagePyramid, Texel, bilinear, for_each_row};
use crate::image_quadrature::{from_single, single};
use crate::light_image::ImageFrame;
use crate::real::Real;
use crate::vec3::Vec3;

/// Number of levels.
pub const GAUSSIAN_LEVELS: usize = 8;

/// Distance, in square roots of the area, that level 0 is for; each next is for 3 times as much.
const NEAREST: f64 = 1.0 / 2048.0;

/// Standard deviation over distance.
const WIDTH: f64 = 0.75;

/// Levels go beyond the image on all sides, as a share of its size.
const MARGIN: f64 = 1.0 / 6.0;

/// Gaussian-filtered copies of a light's image, with a margin of a sixth of its size all around.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianLevels {
    levels: Vec<GaussianLevel>,
}

/// One of [`GaussianLevels`].
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianLevel {
    /// Texels across and down.
    pub size: [u32; 2],
    /// Colour and 1, row by row; the first texel's corner is at (u, v) = (-1/6, -1/6).
    pub texels: Vec<Texel>,
}

impl GaussianLevels {
    /// Filters the largest level of weighted texels; `beyond` of every weight is not coverage.
    pub(crate) fn new(image: &ImagePyramid, beyond: f32) -> Self {
        let mut levels: Vec<GaussianLevel> = Vec::with_capacity(GAUSSIAN_LEVELS);
        // From the widest, which lends the others its colours where they have none.
        let mut sigma = (1..GAUSSIAN_LEVELS).fold(WIDTH * NEAREST, |sigma, _| sigma * 3.0);
        for _ in 0..GAUSSIAN_LEVELS {
            let level = GaussianLevel::new(image, beyond, sigma, levels.last());
            levels.push(level);
            sigma /= 3.0;
        }
        levels.reverse();
        Self { levels }
    }

    /// The levels, the sharpest first.
    #[must_use]
    pub fn levels(&self) -> &[GaussianLevel] {
        &self.levels
    }

    /// The image as `direction` and the distance of its plane have it; `frame` is relative to the
    /// shading point, in the same space.
    #[inline(always)]
    pub(crate) fn look_up<T: Real>(&self, frame: ImageFrame<T>, direction: Vec3<T>) -> [T; 3] {
        let like = direction.x;
        let (zero, one) = (like.constant(0.0), like.constant(1.0));
        let cross = frame.edge_u.cross(frame.edge_v);
        let squared_area = cross.dot(cross).max(like.constant(1e-30));
        let signed = cross.dot(frame.corner);
        let approach = cross.dot(direction);
        let meets = (signed * approach).gt(zero);
        let along = signed / T::select(meets, approach, one);
        let [u, v] = frame.coordinates(direction * along);
        // distance / sqrt(area) = signed / area^(3/2)
        let area = squared_area.sqrt();
        let distance = signed.abs() / (area * area.sqrt());
        T::lookup(
            [u, v, distance],
            #[inline(always)]
            |numbers| {
                let [u, v, distance] = numbers.map(single);
                self.sample(u, v, distance).map(from_single)
            },
        )
    }

    /// At (u, v) of the image, from this distance in square roots of the area.
    fn sample(&self, u: f32, v: f32, distance: f32) -> [f32; 3] {
        let last = (GAUSSIAN_LEVELS - 1) as f32;
        let level = libm::logf(distance / NEAREST as f32) / libm::logf(3.0);
        // NaN becomes 0.
        let level = if level > 0.0 { level.min(last) } else { 0.0 };
        let first = level as usize;
        let [a, b] =
            [first, (first + 1).min(GAUSSIAN_LEVELS - 1)].map(|i| self.levels[i].sample(u, v));
        let t = level - first as f32;
        core::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
    }
}

impl GaussianLevel {
    fn new(image: &ImagePyramid, beyond: f32, sigma: f64, coarser: Option<&Self>) -> Self {
        let from = image.size().map(|side| side as usize);
        let range = 1.0 + 2.0 * MARGIN;
        let size = from.map(|side| {
            let fine = 2.0 * range / sigma;
            (libm::ceil(fine.min(range * side as f64)) as usize).max(2)
        });
        // Rows first: as many as the image has.
        let across: Vec<_> = (0..size[0])
            .map(|i| kernel(i, size[0], from[0], sigma))
            .collect();
        let mut rows = vec![[0.0; 4]; size[0] * from[1]];
        let source = image.level(0);
        for_each_row(&mut rows, size[0], |y, row| {
            for (texel, (first, weights)) in row.iter_mut().zip(&across) {
                let start = y * from[0] + first;
                for (from, weight) in source[start..start + weights.len()].iter().zip(weights) {
                    // What is covered, premultiplied.
                    let covered = (from[3] - beyond).max(0.0);
                    let factor = weight * covered / from[3];
                    for channel in 0..3 {
                        texel[channel] += from[channel] * factor;
                    }
                    texel[3] += covered * weight;
                }
            }
        });
        let mut texels = vec![[0.0; 4]; size[0] * size[1]];
        for_each_row(&mut texels, size[0], |j, row| {
            let (first, weights) = kernel(j, size[1], from[1], sigma);
            for (i, texel) in row.iter_mut().enumerate() {
                for (y, weight) in weights.iter().enumerate() {
                    let from = rows[(first + y) * size[0] + i];
                    for (to, from) in texel.iter_mut().zip(from) {
                        *to += from * weight;
                    }
                }
                *texel = if texel[3] > 1e-4 {
                    let [r, g, b] = crate::light_image::color(*texel);
                    [r, g, b, 1.0]
                } else {
                    // Too far from the outline: as the next level has it.
                    let at = |i: usize, count: usize| {
                        (((i as f64 + 0.5) / count as f64) * range - MARGIN) as f32
                    };
                    let [r, g, b] = match coarser {
                        Some(level) => level.sample(at(i, size[0]), at(j, size[1])),
                        None => crate::light_image::color(image.mean()),
                    };
                    [r, g, b, 1.0]
                };
            }
        });
        Self {
            size: size.map(|side| side as u32),
            texels,
        }
    }

    /// Bilinear, at (u, v) of the image.
    fn sample(&self, u: f32, v: f32) -> [f32; 3] {
        let inside = |x: f32| (x + MARGIN as f32) / (1.0 + 2.0 * MARGIN) as f32;
        let [r, g, b, _] = bilinear(&self.texels, self.size, inside(u), inside(v));
        [r, g, b]
    }
}

/// Weights of a level's texel `i` of `count`, and the first of the image's `size` that they are for.
fn kernel(i: usize, count: usize, size: usize, sigma: f64) -> (usize, Vec<f32>) {
    let range = 1.0 + 2.0 * MARGIN;
    let center = ((i as f64 + 0.5) / count as f64 * range - MARGIN) * size as f64;
    let sigma = sigma * size as f64;
    let reach = (3.0 * sigma).max(1.0);
    let clamp = |x: f64| x.clamp(0.0, size as f64) as usize;
    let first = clamp(libm::floor(center - reach));
    let last = clamp(libm::ceil(center + reach));
    let weights: Vec<f64> = (first..last)
        .map(|x| {
            let offset = (x as f64 + 0.5 - center) / sigma;
            libm::exp(-0.5 * offset * offset)
        })
        .collect();
    // Together 1 far from the borders.
    let scale = 1.0 / (sigma * libm::sqrt(2.0 * core::f64::consts::PI)).max(0.5);
    (first, weights.iter().map(|w| (w * scale) as f32).collect())
}
