//! Area averages of a texture on a grid along its own axes.
//!
//! What a bilinear texture shows is a product of hats, and what one of nearest texels shows a product
//! of boxes: averages over rectangles are averages along rows of averages along columns. Along a line
//! the integral from its start to any place is a sum and at most a parabola, so that each average is a
//! difference of two of them, however many texels it spans.

use glam::{DVec3, Vec3, Vec4Swizzles};
use rayon::prelude::*;

use crate::scene::{Filter, Texture, Wrap, texture::wrap_index};

/// Intervals or offsets this close to whole texels, in texels over all of the line, are whole.
const WHOLE: f64 = 1.0 / 16.0;

/// Averages over `size` equal cells of the texture's rectangle from `low` to `high`, row by row from
/// `low`. Where the cells are the texture's own texels they are copied.
pub(super) fn averages(
    texture: &Texture,
    low: [f64; 2],
    high: [f64; 2],
    size: [u32; 2],
) -> Vec<[f32; 3]> {
    let sampler = texture.sampler;
    let across = Line::new(
        (texture.width, sampler.wrap_s, sampler.filter),
        (low[0], high[0]),
        size[0],
    );
    let down = Line::new(
        (texture.height, sampler.wrap_t, sampler.filter),
        (low[1], high[1]),
        size[1],
    );
    if let (Cells::Copied, Cells::Copied) = (&across.cells, &down.cells) {
        let mut texels = vec![[0.0; 3]; across.texels.len() * down.texels.len()];
        let rows = texels.par_chunks_mut(across.texels.len());
        rows.zip(&down.texels).for_each(|(row, &y)| {
            for (texel, &x) in row.iter_mut().zip(&across.texels) {
                *texel = texture.texel(x, y).xyz().to_array();
            }
        });
        return texels;
    }
    between(texture, &across, &down)
}

/// The average over the whole rectangle, of what is shown even where texels could be copied.
pub(super) fn mean(texture: &Texture, low: [f64; 2], high: [f64; 2]) -> Vec3 {
    let sampler = texture.sampler;
    let across = Line::averaged(
        (texture.width, sampler.wrap_s, sampler.filter),
        (low[0], high[0]),
        1,
    );
    let down = Line::averaged(
        (texture.height, sampler.wrap_t, sampler.filter),
        (low[1], high[1]),
        1,
    );
    Vec3::from(between(texture, &across, &down)[0])
}

/// Along rows, then along columns.
fn between(texture: &Texture, across: &Line, down: &Line) -> Vec<[f32; 3]> {
    let rows = across.resampled(down.texels.len(), |row, place| {
        texture.texel(across.texels[place], down.texels[row]).xyz()
    });
    let width = across.count as usize;
    let columns = down.resampled(width, |column, place| {
        Vec3::from(rows[place * width + column])
    });
    let height = down.count as usize;
    let mut texels = vec![[0.0; 3]; width * height];
    texels
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, texel) in row.iter_mut().enumerate() {
                *texel = columns[x * height + y];
            }
        });
    texels
}

/// The cells along one axis of a texture.
struct Line {
    /// The texels that they touch, in order, wrapped.
    texels: Vec<u32>,
    cells: Cells,
    filter: Filter,
    count: u32,
}

enum Cells {
    /// The texels themselves.
    Copied,
    /// Intervals from `start` on, `step` long, where a bilinear texel's centre or a nearest texel's
    /// start is its place among [`Line::texels`].
    Averaged {
        start: f64,
        step: f64,
        /// After the last texel comes the first again.
        periodic: bool,
    },
}

impl Line {
    /// Whole texels are copied.
    fn new(axis: (u32, Wrap, Filter), ends: (f64, f64), count: u32) -> Self {
        let (size, wrap, filter) = axis;
        let (low, high) = near(axis, ends);
        let step = (high - low) / f64::from(count);
        let is_whole = |x: f64| (x - x.round()).abs() <= WHOLE;
        let off = (step.abs() - 1.0).abs() * f64::from(count);
        if off > WHOLE || !is_whole(low) {
            return Self::averaged(axis, ends, count);
        }
        let first = low.round() as i64;
        let texel = |k: u32| match step > 0.0 {
            true => first + i64::from(k),
            false => first - 1 - i64::from(k),
        };
        Self {
            texels: (0..count)
                .map(|k| wrap_index(texel(k), size, wrap))
                .collect(),
            cells: Cells::Copied,
            filter,
            count,
        }
    }

    fn averaged(axis: (u32, Wrap, Filter), ends: (f64, f64), count: u32) -> Self {
        let (size, wrap, filter) = axis;
        let (low, high) = near(axis, ends);
        let period = match wrap {
            Wrap::Repeat => 1.0,
            Wrap::MirroredRepeat => 2.0,
            Wrap::ClampToEdge => f64::INFINITY,
        };
        let texels = f64::from(size);
        let step = (high - low) / f64::from(count);
        let wrapped = |i: i64| wrap_index(i, size, wrap);
        let centre = match filter {
            Filter::Linear => 0.5,
            Filter::Nearest => 0.0,
        };
        let start = low - centre;
        let (first, last) = (low.min(high) - centre, low.max(high) - centre);
        let (first, last) = match wrap {
            // Beyond its borders the line goes on as it ends.
            Wrap::ClampToEdge => (first.clamp(-1.0, texels), last.clamp(-1.0, texels)),
            _ => (first, last),
        };
        let periodic = last - first + 2.0 >= period * texels;
        let (first, last) = if periodic {
            (0, (period * texels) as i64 - 1)
        } else {
            (first.floor() as i64, last.ceil() as i64)
        };
        Self {
            texels: (first..=last).map(wrapped).collect(),
            cells: Cells::Averaged {
                start: start - first as f64,
                step,
                periodic,
            },
            filter,
            count,
        }
    }

    /// The cells of each of `lines`, one line after the other. `texel` has a line's texels by their
    /// places in [`Line::texels`].
    fn resampled(
        &self,
        lines: usize,
        texel: impl Fn(usize, usize) -> Vec3 + Sync,
    ) -> Vec<[f32; 3]> {
        let mut cells = vec![[0.0; 3]; lines * self.count as usize];
        let chunks = cells.par_chunks_mut(self.count as usize).enumerate();
        let Cells::Averaged {
            start,
            step,
            periodic,
        } = self.cells
        else {
            chunks.for_each(|(line, cells)| {
                for (place, cell) in cells.iter_mut().enumerate() {
                    *cell = texel(line, place).to_array();
                }
            });
            return cells;
        };
        chunks.for_each_init(Integral::default, |integral, (line, cells)| {
            let texels = (0..self.texels.len()).map(|place| texel(line, place).as_dvec3());
            integral.set(texels, self.filter, periodic);
            let mut before = integral.upto(start);
            for (k, cell) in cells.iter_mut().enumerate() {
                let end = start + step * (k as f64 + 1.0);
                let after = integral.upto(end);
                let mean = if step.abs() > 1e-6 {
                    (after - before) / step
                } else {
                    // Differences of the integral no longer tell.
                    integral.at(end - 0.5 * step)
                };
                // Rounding may leave less than nothing.
                *cell = mean.max(DVec3::ZERO).as_vec3().to_array();
                before = after;
            }
        });
        cells
    }
}

/// The ends of a line in texels, moved by whole repeats to the first.
fn near((size, wrap, _): (u32, Wrap, Filter), (low, high): (f64, f64)) -> (f64, f64) {
    let shift = match wrap {
        Wrap::Repeat => low.min(high).floor(),
        Wrap::MirroredRepeat => 2.0 * (low.min(high) / 2.0).floor(),
        Wrap::ClampToEdge => 0.0,
    };
    let texels = f64::from(size);
    ((low - shift) * texels, (high - shift) * texels)
}

/// A line's integral from its first place.
#[derive(Default)]
struct Integral {
    texels: Vec<DVec3>,
    /// The integral up to each place.
    sums: Vec<DVec3>,
    is_linear: bool,
    periodic: bool,
}

impl Integral {
    fn set(&mut self, texels: impl Iterator<Item = DVec3>, filter: Filter, periodic: bool) {
        self.texels.clear();
        self.texels.extend(texels);
        self.is_linear = filter == Filter::Linear;
        self.periodic = periodic;
        let after = if periodic { 0 } else { self.texels.len() - 1 };
        self.texels.push(self.texels[after]);
        self.sums.clear();
        let mut sum = DVec3::ZERO;
        self.sums.push(sum);
        for pair in self.texels.windows(2) {
            sum += if self.is_linear {
                (pair[0] + pair[1]) * 0.5
            } else {
                pair[0]
            };
            self.sums.push(sum);
        }
    }

    /// The interval that holds a place, and how far into it; the whole periods before.
    fn locate(&self, x: f64) -> (usize, f64, f64) {
        let count = self.sums.len() - 1;
        let periods = if self.periodic {
            (x / count as f64).floor()
        } else {
            0.0
        };
        let x = x - periods * count as f64;
        // The cast saturates.
        let i = (x.floor() as usize).min(count - 1);
        (i, x - i as f64, periods)
    }

    fn upto(&self, x: f64) -> DVec3 {
        let (i, t, periods) = self.locate(x);
        let (value, last) = (self.texels[i], self.sums[self.sums.len() - 1]);
        let slope = if self.is_linear && (0.0..=1.0).contains(&t) {
            self.texels[i + 1] - value
        } else {
            DVec3::ZERO
        };
        // Beyond its ends a line goes on as it ends: `t` is negative before it.
        let beyond = t > 1.0 && self.is_linear;
        let (sum, value, t) = if beyond {
            (self.sums[i + 1], self.texels[i + 1], t - 1.0)
        } else {
            (self.sums[i], value, t)
        };
        last * periods + sum + value * t + slope * (0.5 * t * t)
    }

    fn at(&self, x: f64) -> DVec3 {
        let (i, t, _) = self.locate(x);
        if self.is_linear {
            self.texels[i].lerp(self.texels[i + 1], t.clamp(0.0, 1.0))
        } else {
            self.texels[i]
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, Vec2};
    use proptest::prelude::*;

    use super::*;
    use crate::scene::Sampler;

    fn noise_texture(width: u32, height: u32, sampler: Sampler) -> Texture {
        let texels = (0..width * height)
            .map(|i| {
                let hash = (i + 1).wrapping_mul(2_654_435_761);
                let [a, b, c, _] = (hash ^ (hash >> 15)).to_le_bytes();
                [a, b, c, 255]
            })
            .collect();
        Texture::from_rgba8("", [width, height], texels, true, sampler).unwrap()
    }

    fn sampled(texture: &Texture, low: DVec2, high: DVec2, steps: u32) -> Vec3 {
        let mut sum = DVec3::ZERO;
        for i in 0..steps {
            for j in 0..steps {
                let t = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(steps);
                let uv: Vec2 = (low + (high - low) * t).as_vec2();
                sum += texture.sample(uv).xyz().as_dvec3();
            }
        }
        (sum / f64::from(steps * steps)).as_vec3()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        /// Every cell is the mean of many samples, and all of them have the mean of the rectangle.
        #[test]
        fn cells_are_means_of_what_is_shown(
            corners in prop::array::uniform4(-3.0_f64..3.0),
            size in prop::array::uniform2(1_u32..8),
            cells in prop::array::uniform2(1_u32..4),
            wrap in 0_usize..9,
            nearest in any::<bool>(),
        ) {
            let modes = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
            let sampler = Sampler {
                wrap_s: modes[wrap % 3],
                wrap_t: modes[wrap / 3],
                filter: if nearest { Filter::Nearest } else { Filter::Linear },
            };
            let texture = noise_texture(size[0], size[1], sampler);
            let (low, high) = (DVec2::new(corners[0], corners[1]), DVec2::new(corners[2], corners[3]));
            let found = averages(&texture, low.to_array(), high.to_array(), cells);
            let step = (high - low) / DVec2::new(f64::from(cells[0]), f64::from(cells[1]));
            // Cells that are texels are copied.
            let texels = step * DVec2::new(f64::from(size[0]), f64::from(size[1]));
            prop_assume!((texels.abs() - 1.0).abs().min_element() > 0.07);
            for (k, &cell) in (0_u32..).zip(&found) {
                let place = DVec2::new(f64::from(k % cells[0]), f64::from(k / cells[0]));
                let corner = low + step * place;
                let expected = sampled(&texture, corner, corner + step, 120);
                let error = (Vec3::from(cell) - expected).abs().max_element();
                prop_assert!(error < if nearest { 3e-2 } else { 2e-3 }, "cell {k}: {error}");
            }
        }
    }

    #[test]
    fn whole_texels_are_copied_in_any_order() {
        let texture = noise_texture(8, 4, Sampler::default());
        let texel = |x: u32, y: u32| texture.texel(x % 8, y % 4).xyz().to_array();
        let all = averages(&texture, [0.0, 0.0], [1.0, 1.0], [8, 4]);
        let expected: Vec<_> = (0..32).map(|k| texel(k % 8, k / 8)).collect();
        assert_eq!(all, expected);
        // Moved by repeats and rounding, turned over, and a part of it.
        let turned = averages(&texture, [-3.0 + 1e-7, 5.0], [-4.0, 4.0 - 1e-7], [8, 4]);
        let expected: Vec<_> = (0..32).map(|k| texel(7 - k % 8, 3 - k / 8)).collect();
        assert_eq!(turned, expected);
        let part = averages(&texture, [0.75, 0.5], [1.25, 0.75], [4, 1]);
        assert_eq!(part, [6, 7, 8, 9].map(|x| texel(x, 2)));
    }

    #[test]
    fn hostile_rectangles_are_bounded_work() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for filter in [Filter::Nearest, Filter::Linear] {
                let texture = noise_texture(
                    7,
                    1,
                    Sampler {
                        wrap_s: wrap,
                        wrap_t: wrap,
                        filter,
                    },
                );
                for (low, high) in [
                    (0.0, 1e6),
                    (-1e6, 1e6),
                    (1e6, 1e6 + 1e-9),
                    (5.0, 5.0),
                    (0.3, 0.3 + 1e-12),
                ] {
                    let found = averages(&texture, [low; 2], [high; 2], [16, 2]);
                    for x in found.as_flattened() {
                        assert!(
                            (-1e-6..=1.000_001).contains(x),
                            "{wrap:?} {low} {high}: {x}"
                        );
                    }
                }
            }
        }
    }
}
