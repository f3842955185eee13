//! The mean of an emissive texture over faces.
//!
//! A bilinear texture is a bilinear function in each cell between four texel centres. Its integral
//! over a face is exact: the face's triangle in texture space is cut along the cells, and each piece
//! contributes its moments 1, x, y and xy. Faces that cover too many cells are cut along those of a
//! smaller level of the texture, made by area averages, instead.
//!
//! What an alpha mask leaves has no such integral: it is sampled.

use std::sync::OnceLock;

use glam::{DVec2, Vec3, Vec4Swizzles};

use super::Emitter;
use crate::scene::{AlphaMode, Filter, Sampler, Texture, TextureRef, Wrap, texture::wrap_index};

/// Cells to cut for all faces of a mesh together.
const MAX_CELLS: f64 = 8_388_608.0;
/// Samples of one face behind an alpha mask.
const MAX_SAMPLES: f64 = 1_048_576.0;
/// Cells that every face may have, however many faces there are.
const MIN_CELLS: f64 = 256.0;

/// The mean radiance of a mesh's faces.
pub(super) struct TextureMean<'a> {
    emitter: &'a Emitter<'a>,
    texture: Option<(&'a TextureRef, &'a Texture)>,
    mask: Option<Mask<'a>>,
    /// Cells that one face may cover.
    cells: f64,
    /// The texture at half the size, at a quarter, and so on to a single texel.
    levels: OnceLock<Vec<Level>>,
}

impl<'a> TextureMean<'a> {
    pub(super) fn new(emitter: &'a Emitter<'a>) -> Self {
        let with_texture =
            |reference: &'a TextureRef| (reference, &emitter.textures[reference.texture]);
        let material = emitter.material;
        let base_color = material.base_color_texture.as_ref().map(with_texture);
        let mask = match material.alpha_mode {
            AlphaMode::Mask { cutoff } => Some(Mask {
                texture: base_color,
                cutoff,
            }),
            _ => None,
        };
        Self {
            emitter,
            texture: material.emissive_texture.as_ref().map(with_texture),
            mask,
            cells: (MAX_CELLS / emitter.mesh.triangles.len().max(1) as f64).max(MIN_CELLS),
            levels: OnceLock::new(),
        }
    }

    /// The mean over the area of the mesh's triangles of factor, strength, texture and alpha mask.
    pub(super) fn radiance(&self, triangles: &[u32]) -> Vec3 {
        let emissive = self.emitter.material.emissive;
        if self.texture.is_none() && self.mask.is_none() {
            return emissive;
        }
        let mesh = self.emitter.mesh;
        let (mut sum, mut area) = (glam::DVec3::ZERO, 0.0);
        for &t in triangles {
            let corners = mesh.triangles[t as usize];
            let [a, b, c] = corners.map(|i| self.emitter.positions[i as usize]);
            let weight = (b - a).cross(c - a).length();
            let mean = match (&self.mask, self.texture) {
                (Some(mask), _) => self.masked(mask, corners),
                (None, Some((reference, texture))) => {
                    self.triangle(texture, corners.map(|i| self.uv(reference, i)))
                }
                (None, None) => Vec3::ONE,
            };
            sum += mean.as_dvec3() * weight;
            area += weight;
        }
        // Factors and images have wide ranges.
        (emissive * (sum / area).as_vec3()).min(Vec3::splat(f32::MAX))
    }

    fn uv(&self, reference: &TextureRef, vertex: u32) -> DVec2 {
        let texcoords = &self.emitter.mesh.texcoords[reference.texcoord];
        let texcoord = texcoords.get(vertex as usize).copied().unwrap_or_default();
        reference.transform.apply(texcoord).as_dvec2()
    }

    /// The mean over one triangle of what the alpha mask leaves, from samples on a grid: two along
    /// each texel, at least 16 along each side, but no more than the triangle's share of cells.
    fn masked(&self, mask: &Mask<'a>, corners: [u32; 3]) -> Vec3 {
        let alphas = corners.map(|i| {
            let color = self.emitter.mesh.colors.get(i as usize);
            self.emitter.material.base_color.w * color.map_or(1.0, |color| color.w)
        });
        let placed = |texture: Option<(&TextureRef, &'a Texture)>| {
            let (reference, texture) = texture?;
            let uv = corners.map(|i| self.uv(reference, i));
            // As rays read coordinates that are not finite.
            let uv = near_origin(uv, texture.sampler).unwrap_or([DVec2::ZERO; 3]);
            let count = covered(uv, texture.width, texture.height, texture.sampler);
            Some((texture, uv, count))
        };
        let (emission, opacity) = (placed(self.texture), placed(mask.texture));
        let count = [&emission, &opacity].into_iter().flatten();
        let count = count.fold(0.0, |most: f64, (_, _, count)| most.max(*count));
        // The cast saturates.
        let most = self.cells.clamp(256.0, MAX_SAMPLES);
        let steps = (4.0 * count).clamp(256.0, most).sqrt() as u32;
        let sample = |placed: &Option<(&Texture, [DVec2; 3], f64)>, weights: [f64; 3]| {
            let (texture, [a, b, c], _) = placed.as_ref()?;
            let uv = *a * weights[0] + *b * weights[1] + *c * weights[2];
            Some(texture.sample(uv.as_vec2()))
        };
        let mut sum = glam::DVec3::ZERO;
        for i in 0..steps {
            for j in 0..2 * (steps - i) - 1 {
                // The centres of steps² equal triangles.
                let third = if j % 2 == 0 { 1.0 } else { 2.0 } / 3.0;
                let u = (f64::from(i) + third) / f64::from(steps);
                let v = (f64::from(j / 2) + third) / f64::from(steps);
                let weights = [1.0 - u - v, u, v];
                let alpha: f64 = (0..3).map(|k| f64::from(alphas[k]) * weights[k]).sum();
                let texel = sample(&opacity, weights).map_or(1.0, |texel| texel.w);
                if alpha as f32 * texel >= mask.cutoff {
                    let color = sample(&emission, weights).map_or(Vec3::ONE, Vec4Swizzles::xyz);
                    sum += color.as_dvec3();
                }
            }
        }
        (sum / f64::from(steps).powi(2)).as_vec3()
    }

    /// The mean over one triangle of texture space.
    fn triangle(&self, texture: &Texture, uv: [DVec2; 3]) -> Vec3 {
        let Some(uv) = near_origin(uv, texture.sampler) else {
            return texture.sample(glam::Vec2::ZERO).xyz();
        };
        if covered(uv, texture.width, texture.height, texture.sampler) <= self.cells {
            let texel = |x, y| texture.wrapped_texel(x, y).xyz();
            return mean(uv, [texture.width, texture.height], texture.sampler, texel);
        }
        let levels = self.levels.get_or_init(|| Level::all(texture));
        let sampler = texture.sampler;
        let fits = |level: &&Level| covered(uv, level.width, level.height, sampler) <= self.cells;
        match levels.iter().find(fits) {
            Some(level) => {
                let texel = |x, y| level.wrapped_texel(x, y, sampler);
                mean(uv, [level.width, level.height], sampler, texel)
            }
            // Over this many repeats only the mean of all is left.
            None => levels.last().map_or(Vec3::ZERO, |level| level.texels[0]),
        }
    }
}

/// Where alpha is less than the cutoff there is nothing.
struct Mask<'a> {
    /// The base colour's.
    texture: Option<(&'a TextureRef, &'a Texture)>,
    cutoff: f32,
}

/// The same triangle, moved by whole repeats to the origin; `None` where it is not finite.
fn near_origin(uv: [DVec2; 3], sampler: Sampler) -> Option<[DVec2; 3]> {
    let low = uv[0].min(uv[1]).min(uv[2]);
    if !uv.iter().all(|uv| uv.is_finite()) {
        return None;
    }
    let shift = |low: f64, wrap| match wrap {
        Wrap::Repeat => low.floor(),
        Wrap::MirroredRepeat => 2.0 * (low * 0.5).floor(),
        Wrap::ClampToEdge => 0.0,
    };
    let shift = DVec2::new(shift(low.x, sampler.wrap_s), shift(low.y, sampler.wrap_t));
    Some(uv.map(|uv| uv - shift))
}

/// How many cells the triangle's bounding box meets.
fn covered(uv: [DVec2; 3], width: u32, height: u32, sampler: Sampler) -> f64 {
    let span = |axis: usize, size: u32, wrap| {
        let values = uv.map(|uv| uv[axis]);
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = match wrap {
            Wrap::ClampToEdge => (low.clamp(0.0, 1.0), high.clamp(0.0, 1.0)),
            _ => (low, high),
        };
        (high - low) * f64::from(size) + 2.0
    };
    span(0, width, sampler.wrap_s) * span(1, height, sampler.wrap_t)
}

/// The mean over a triangle of a texture given by its texels.
fn mean(
    uv: [DVec2; 3],
    [width, height]: [u32; 2],
    sampler: Sampler,
    texel: impl Fn(i64, i64) -> Vec3,
) -> Vec3 {
    let size = DVec2::new(f64::from(width), f64::from(height));
    // Cells between texel centres, or the texels themselves, start at whole numbers.
    let start = match sampler.filter {
        Filter::Linear => 0.5,
        Filter::Nearest => 0.0,
    };
    let corners = uv.map(|uv| uv * size - start);
    let [a, b, c] = corners;
    let doubled = (b - a).perp_dot(c - a);
    let extent = (b - a).abs().max((c - a).abs()).max_element();
    let cell = |i: i64, j: i64| Cell::new(i, j, sampler.filter, &texel);
    if doubled.abs() <= 1e-9 * extent * extent {
        return mean_of_samples(corners, sampler, [width, height], cell);
    }
    let mut sum = glam::DVec3::ZERO;
    let mut rest = Piece::triangle(corners);
    while let Some((row, above)) = rest.cut(1, height, sampler.wrap_t) {
        let mut rest_of_row = row;
        while let Some((piece, beyond)) = rest_of_row.cut(0, width, sampler.wrap_s) {
            let (i, j) = (
                piece.cell(0, width, sampler.wrap_s),
                piece.cell(1, height, sampler.wrap_t),
            );
            sum += cell(i, j).integral(&piece, DVec2::new(i as f64, j as f64));
            rest_of_row = beyond;
        }
        rest = above;
    }
    (sum / (0.5 * doubled)).as_vec3()
}

/// For triangles without area in texture space: the mean of points spread over it.
fn mean_of_samples(
    [a, b, c]: [DVec2; 3],
    sampler: Sampler,
    [width, height]: [u32; 2],
    cell: impl Fn(i64, i64) -> Cell,
) -> Vec3 {
    const STEPS: u32 = 16;
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for i in 0..STEPS {
        for j in 0..STEPS - i {
            let third = 1.0 / 3.0;
            let u = (f64::from(i) + third) / f64::from(STEPS);
            let v = (f64::from(j) + third) / f64::from(STEPS);
            let p = a + (b - a) * u + (c - a) * v;
            let (i, j) = (
                cell_of(p.x, width, sampler.wrap_s),
                cell_of(p.y, height, sampler.wrap_t),
            );
            sum += cell(i, j).at(p - DVec2::new(i as f64, j as f64)).as_vec3();
            count += 1.0;
        }
    }
    sum / count
}

/// The cell that holds a coordinate. Beyond a clamped border there is one, without end.
fn cell_of(x: f64, size: u32, wrap: Wrap) -> i64 {
    let cell = x.floor();
    match wrap {
        Wrap::ClampToEdge => cell.clamp(-1.0, f64::from(size) - 1.0) as i64,
        _ => cell as i64,
    }
}

/// A bilinear function by its coefficients of 1, x, y and xy.
struct Cell {
    coefficients: [glam::DVec3; 4],
}

impl Cell {
    fn new(i: i64, j: i64, filter: Filter, texel: impl Fn(i64, i64) -> Vec3) -> Self {
        let texel = |i, j| texel(i, j).as_dvec3();
        let c00 = texel(i, j);
        let zero = glam::DVec3::ZERO;
        let coefficients = match filter {
            Filter::Nearest => [c00, zero, zero, zero],
            Filter::Linear => {
                let (c10, c01, c11) = (texel(i + 1, j), texel(i, j + 1), texel(i + 1, j + 1));
                [c00, c10 - c00, c01 - c00, c00 - c10 - c01 + c11]
            }
        };
        Self { coefficients }
    }

    fn at(&self, p: DVec2) -> glam::DVec3 {
        let [one, x, y, xy] = self.coefficients;
        one + x * p.x + y * p.y + xy * (p.x * p.y)
    }

    /// The signed integral over a piece of the cell that starts at `origin`.
    fn integral(&self, piece: &Piece, origin: DVec2) -> glam::DVec3 {
        let points = &piece.points[..piece.count];
        let [one, x, y, xy] = self.coefficients;
        let mut sum = glam::DVec3::ZERO;
        for pair in points[1..].windows(2) {
            let [a, b, c] = [points[0], pair[0], pair[1]].map(|p| p - origin);
            let area = 0.5 * (b - a).perp_dot(c - a);
            let total = a + b + c;
            let products = a.x * a.y + b.x * b.y + c.x * c.y + total.x * total.y;
            sum += (one + (x * total.x + y * total.y) / 3.0 + xy * (products / 12.0)) * area;
        }
        sum
    }
}

/// A convex piece of the triangle: it gains at most one corner with each of four cuts.
#[derive(Clone, Copy)]
struct Piece {
    points: [DVec2; 8],
    count: usize,
}

impl Piece {
    const EMPTY: Self = Self {
        points: [DVec2::ZERO; 8],
        count: 0,
    };

    fn triangle([a, b, c]: [DVec2; 3]) -> Self {
        let mut piece = Self::EMPTY;
        [a, b, c].into_iter().for_each(|p| piece.push(p));
        piece
    }

    fn push(&mut self, p: DVec2) {
        // Rounding can make a convex piece meet a line more than twice; what is lost then has no area.
        if self.count < self.points.len() {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    fn low(&self, axis: usize) -> f64 {
        let points = &self.points[..self.count];
        points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min)
    }

    /// The cell that the piece lies in.
    fn cell(&self, axis: usize, size: u32, wrap: Wrap) -> i64 {
        let points = &self.points[..self.count];
        let middle = points.iter().map(|p| p[axis]).sum::<f64>() / self.count as f64;
        cell_of(middle, size, wrap)
    }

    /// Cuts off what lies in the lowest cell along an axis; `None` when nothing is left.
    fn cut(&self, axis: usize, size: u32, wrap: Wrap) -> Option<(Self, Self)> {
        if self.count < 3 {
            return None;
        }
        let low = self.low(axis);
        let border = match wrap {
            Wrap::ClampToEdge if low < 0.0 => 0.0,
            Wrap::ClampToEdge if low >= f64::from(size) - 1.0 => f64::INFINITY,
            _ => low.floor() + 1.0,
        };
        let (mut below, mut above) = (Self::EMPTY, Self::EMPTY);
        let points = &self.points[..self.count];
        for (i, &p) in points.iter().enumerate() {
            let q = points[(i + 1) % points.len()];
            if p[axis] <= border {
                below.push(p);
            }
            if p[axis] >= border {
                above.push(p);
            }
            if (p[axis] < border && q[axis] > border) || (p[axis] > border && q[axis] < border) {
                let mut crossing = p + (q - p) * ((border - p[axis]) / (q[axis] - p[axis]));
                crossing[axis] = border;
                below.push(crossing);
                above.push(crossing);
            }
        }
        Some((below, above))
    }
}

/// A smaller version of a texture, made of area averages.
struct Level {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
}

impl Level {
    /// All smaller versions, down to a single texel.
    fn all(texture: &Texture) -> Vec<Self> {
        let first = Self::halved(texture.width, texture.height, |x, y| {
            texture.texel(x, y).xyz()
        });
        let mut levels = vec![first];
        while let Some(last) = levels
            .last()
            .filter(|last| last.width > 1 || last.height > 1)
        {
            let texel = |x: u32, y: u32| last.texels[(y * last.width + x) as usize];
            levels.push(Self::halved(last.width, last.height, texel));
        }
        levels
    }

    /// Half as many texels along each side, rounded up, each the mean over what it covers.
    fn halved(width: u32, height: u32, texel: impl Fn(u32, u32) -> Vec3) -> Self {
        let (w, h) = (width.div_ceil(2), height.div_ceil(2));
        let mut texels = Vec::with_capacity(w as usize * h as usize);
        for y in 0..h {
            for x in 0..w {
                let mut sum = Vec3::ZERO;
                for (j, wy) in coverage(y, height, h) {
                    for (i, wx) in coverage(x, width, w) {
                        sum += texel(i, j) * (wx * wy);
                    }
                }
                texels.push(sum);
            }
        }
        Self {
            width: w,
            height: h,
            texels,
        }
    }

    fn wrapped_texel(&self, x: i64, y: i64, sampler: Sampler) -> Vec3 {
        let x = wrap_index(x, self.width, sampler.wrap_s);
        let y = wrap_index(y, self.height, sampler.wrap_t);
        self.texels[(y * self.width + x) as usize]
    }
}

/// The old texels that one of `new` texels covers, with their weights, which sum to 1.
fn coverage(index: u32, old: u32, new: u32) -> impl Iterator<Item = (u32, f32)> {
    let scale = f64::from(old) / f64::from(new);
    let (start, end) = (f64::from(index) * scale, f64::from(index + 1) * scale);
    let last = ((end.ceil() as u32).max(1) - 1).min(old - 1);
    (start as u32..=last).map(move |i| {
        let overlap = end.min(f64::from(i) + 1.0) - start.max(f64::from(i));
        (i, (overlap / scale) as f32)
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use proptest::prelude::*;

    use super::*;

    fn noise_texture(width: u32, height: u32, sampler: Sampler) -> Texture {
        let texels = (0..width * height)
            .map(|i| {
                let hash = (i + 1).wrapping_mul(2_654_435_761);
                let [a, b, c, _] = (hash ^ (hash >> 15)).to_le_bytes();
                [a, b, c, 255]
            })
            .collect();
        Texture::from_rgba8("", [width, height], texels, false, sampler).unwrap()
    }

    fn mean_of(texture: &Texture, uv: [DVec2; 3]) -> Vec3 {
        let texel = |x, y| texture.wrapped_texel(x, y).xyz();
        let uv = near_origin(uv, texture.sampler).unwrap();
        mean(uv, [texture.width, texture.height], texture.sampler, texel)
    }

    /// The mean by many samples: good to the spacing of the samples.
    fn sampled(texture: &Texture, [a, b, c]: [DVec2; 3], steps: u32) -> Vec3 {
        let (mut sum, mut count) = (glam::DVec3::ZERO, 0.0);
        for i in 0..steps {
            for j in 0..2 * (steps - i) - 1 {
                let (even, third) = (j % 2 == 0, if j % 2 == 0 { 1.0 } else { 2.0 } / 3.0);
                let u = (f64::from(i) + third) / f64::from(steps);
                let v = (f64::from(j / 2) + if even { 1.0 / 3.0 } else { 2.0 / 3.0 })
                    / f64::from(steps);
                let uv: Vec2 = (a + (b - a) * u + (c - a) * v).as_vec2();
                sum += texture.sample(uv).xyz().as_dvec3();
                count += 1.0;
            }
        }
        (sum / count).as_vec3()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn exact_mean_agrees_with_samples(
            corners in prop::array::uniform6(-2.0_f64..3.0),
            width in 1_u32..7,
            height in 1_u32..7,
            wrap in 0_usize..9,
            nearest in any::<bool>(),
        ) {
            let modes = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
            let sampler = Sampler {
                wrap_s: modes[wrap % 3],
                wrap_t: modes[wrap / 3],
                filter: if nearest { Filter::Nearest } else { Filter::Linear },
            };
            let texture = noise_texture(width, height, sampler);
            let [a, b, c, d, e, f] = corners;
            let uv = [DVec2::new(a, b), DVec2::new(c, d), DVec2::new(e, f)];
            let error = (mean_of(&texture, uv) - sampled(&texture, uv, 200)).abs().max_element();
            prop_assert!(error < if nearest { 1e-2 } else { 5e-4 }, "error {error}");
        }
    }

    #[test]
    fn whole_image_gives_the_mean_of_its_texels() {
        let texture = noise_texture(5, 3, Sampler::default());
        let expected: Vec3 = (0..15)
            .map(|i| texture.texel(i % 5, i / 5).xyz())
            .sum::<Vec3>()
            / 15.0;
        let [a, b, c, d] = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(DVec2::from);
        let found = (mean_of(&texture, [a, b, c]) + mean_of(&texture, [a, c, d])) * 0.5;
        assert!(
            (found - expected).abs().max_element() < 1e-6,
            "{found} {expected}"
        );
        for level in Level::all(&texture) {
            let count = (level.width * level.height) as f32;
            let mean = level.texels.iter().sum::<Vec3>() / count;
            assert!((mean - expected).abs().max_element() < 1e-6);
        }
    }

    #[test]
    fn hostile_coordinates_are_bounded_work() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for filter in [Filter::Nearest, Filter::Linear] {
                let texture = noise_texture(
                    7,
                    5,
                    Sampler {
                        wrap_s: wrap,
                        wrap_t: wrap,
                        filter,
                    },
                );
                for big in [
                    1e3,
                    1e9,
                    1e18,
                    1e38,
                    f64::from(f32::MAX),
                    f64::INFINITY,
                    f64::NAN,
                ] {
                    let far = DVec2::splat(big);
                    for uv in [
                        [DVec2::ZERO, DVec2::X * big, DVec2::Y * big],
                        [far, far + DVec2::X, far + DVec2::Y],
                        [far, far, far],
                        [DVec2::ZERO, far, far * 0.5],
                    ] {
                        let mesh = crate::scene::Mesh::default();
                        let material = crate::scene::Material::default();
                        let textures = [];
                        let emitter = Emitter {
                            mesh: &mesh,
                            index: 0,
                            positions: &[],
                            noise: 0.0,
                            material: &material,
                            textures: &textures,
                        };
                        let mean = TextureMean::new(&emitter).triangle(&texture, uv);
                        assert!(
                            mean.min_element() >= -1e-4 && mean.max_element() <= 1.0001,
                            "{wrap:?} {filter:?} {uv:?} {mean}"
                        );
                    }
                }
            }
        }
    }
}
