//! Procedural textures that repeat, as PNG files.

use super::random::Random;
use glam::DVec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Texels along each side of most textures.
const SIZE: u32 = 512;

/// Encodes one colour a texel; components are in [0, 1] and stored as they are.
fn png(colour: impl Fn(u32, u32) -> [f64; 3]) -> Vec<u8> {
    square_png(SIZE, colour)
}

fn square_png(size: u32, colour: impl Fn(u32, u32) -> [f64; 3]) -> Vec<u8> {
    let texels: Vec<u8> = (0..size * size)
        .flat_map(|k| colour(k % size, k / size))
        .map(|x| (255.0 * x.clamp(0.0, 1.0) + 0.5) as u8)
        .collect();
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive)
        .write_image(&texels, size, size, ExtendedColorType::Rgb8)
        .expect("an image of a fixed size is encoded to memory");
    file
}

/// A picture in linear light of `colour` at (u, v), v running down: the mean of nine samples a texel.
pub(crate) fn picture(width: u32, height: u32, colour: impl Fn(f64, f64) -> [f64; 3]) -> Vec<u8> {
    let texel = |k: u32| {
        let mut sum = DVec3::ZERO;
        for sample in 0..9 {
            let [x, y] = [k % width * 3 + sample % 3, k / width * 3 + sample / 3];
            let [u, v] = [(x, width), (y, height)]
                .map(|(at, count)| (f64::from(at) + 0.5) / f64::from(3 * count));
            sum += DVec3::from(colour(u, v));
        }
        (sum / 9.0).to_array().map(encoded)
    };
    let texels: Vec<u8> = (0..width * height)
        .flat_map(texel)
        .map(|x| (255.0 * x.clamp(0.0, 1.0) + 0.5) as u8)
        .collect();
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive)
        .write_image(&texels, width, height, ExtendedColorType::Rgb8)
        .expect("an image of a fixed size is encoded to memory");
    file
}

/// A number in [0, 1) that belongs to a cell of a pattern.
pub(crate) fn cell_value(seed: u64, x: u32, y: u32) -> f64 {
    Random(seed ^ (u64::from(x) << 40) ^ (u64::from(y) << 16)).unit()
}

pub(crate) fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Value noise in [0, 1) on a lattice of `period` cells over the texture's unit square, smooth and periodic.
fn noise(seed: u64, period: u32, u: f64, v: f64) -> f64 {
    let lattice = |x: f64| {
        let x = x.rem_euclid(1.0) * f64::from(period);
        let cell = x.floor();
        let t = x - cell;
        let t = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let k = cell as u32 % period;
        (k, (k + 1) % period, t)
    };
    let (x0, x1, s) = lattice(u);
    let (y0, y1, t) = lattice(v);
    let value = |x, y| cell_value(seed, x, y);
    let low = value(x0, y0) * (1.0 - s) + value(x1, y0) * s;
    let high = value(x0, y1) * (1.0 - s) + value(x1, y1) * s;
    low * (1.0 - t) + high * t
}

/// Octaves of noise about zero, each half as strong and twice as fine as the one before.
pub(crate) fn cloud(seed: u64, period: u32, octaves: u32, u: f64, v: f64) -> f64 {
    (0..octaves)
        .map(|k| {
            let strength = 1.0 / f64::from(1 << k);
            strength * (noise(seed + u64::from(k), period << k, u, v) - 0.5)
        })
        .sum()
}

/// Texture coordinates of a texel's centre.
fn centre(x: u32, y: u32) -> [f64; 2] {
    [x, y].map(|k| (f64::from(k) + 0.5) / f64::from(SIZE))
}

/// sRGB's transfer function, for colours: IEC 61966-2-1.
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// Glazed bricks in running bond.
pub(crate) struct Bricks {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
}

impl Bricks {
    /// The brick at (u, v), the place in it from -1 to 1, and its half sizes in texels.
    fn locate(&self, u: f64, v: f64) -> ([u32; 2], [f64; 2], [f64; 2]) {
        let y = v.rem_euclid(1.0) * f64::from(self.rows);
        let row = y.floor() as u32 % self.rows;
        let shift = 0.5 * f64::from(row % 2);
        let x = u.rem_euclid(1.0) * f64::from(self.columns) + shift;
        let column = x.floor() as u32 % self.columns;
        let half = [self.columns, self.rows].map(|count| f64::from(SIZE / count) / 2.0);
        (
            [column, row],
            [2.0 * (x - x.floor()) - 1.0, 2.0 * (y - y.floor()) - 1.0],
            half,
        )
    }

    /// Texels to the brick's rounded border, positive inside.
    fn inside(place: [f64; 2], half: [f64; 2]) -> f64 {
        const CORNER: f64 = 5.0;
        const JOINT: f64 = 1.2;
        let [dx, dy] =
            [0, 1].map(|k| (place[k].abs() * half[k] - (half[k] - JOINT - CORNER)).max(0.0));
        CORNER - libm::sqrt(dx * dx + dy * dy)
    }

    /// Height in texels, v running down.
    fn height(&self, u: f64, v: f64) -> f64 {
        let ([column, row], place, half) = self.locate(u, v);
        let rise = smoothstep(-1.5, 6.0, Self::inside(place, half));
        // No two bricks lie quite flat, and their glaze is uneven.
        let [tilt_x, tilt_y, level] = [1, 2, 3].map(|seed| cell_value(seed, column, row) - 0.5);
        let lie =
            0.9 * level + 0.05 * tilt_x * place[0] * half[0] + 0.08 * tilt_y * place[1] * half[1];
        let glaze = 2.2 * cloud(10, 32, 2, u, v);
        rise * (4.0 + lie + glaze) + (1.0 - rise) * 0.4 * cloud(20, 64, 1, u, v)
    }

    /// Tangent-space normals, +y up the image as glTF wants.
    pub(crate) fn normals(&self) -> Vec<u8> {
        png(|x, y| {
            let [u, v] = centre(x, y);
            let texel = 1.0 / f64::from(SIZE);
            let along_u = (self.height(u + texel, v) - self.height(u - texel, v)) / 2.0;
            let along_v = (self.height(u, v + texel) - self.height(u, v - texel)) / 2.0;
            let normal = DVec3::new(-along_u, along_v, 1.0).normalize();
            (normal * 0.5 + 0.5).to_array()
        })
    }

    /// Reflectance: `colour` with a shade for every brick and dark joints.
    pub(crate) fn colours(&self, colour: [f64; 3]) -> Vec<u8> {
        png(|x, y| {
            let [u, v] = centre(x, y);
            let ([column, row], place, half) = self.locate(u, v);
            let rise = smoothstep(-1.0, 2.0, Self::inside(place, half));
            let shade = 0.72 + 0.5 * cell_value(5, column, row);
            colour.map(|c| encoded(c * (0.35 + 0.65 * rise) * shade))
        })
    }
}

/// Polished stone slabs with thin joints.
pub(crate) struct Slabs {
    pub(crate) count: u32,
}

impl Slabs {
    /// The slab at (u, v), and how much of the texel is stone rather than joint.
    fn locate(&self, u: f64, v: f64) -> ([u32; 2], f64) {
        let cells = [u, v].map(|x| x * f64::from(self.count));
        let texels = f64::from(SIZE / self.count);
        let border = cells
            .map(|x| (0.5 - (x - x.floor() - 0.5).abs()) * texels)
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        (
            cells.map(|x| x.floor() as u32),
            smoothstep(0.4, 2.0, border),
        )
    }

    /// Reflectance: clouds in `colour`, a shade for every slab, darker joints.
    pub(crate) fn colours(&self, colour: [f64; 3]) -> Vec<u8> {
        png(|x, y| {
            let [u, v] = centre(x, y);
            let ([column, row], stone) = self.locate(u, v);
            let shade = 0.85 + 0.3 * cell_value(7, column, row) + 0.5 * cloud(30, 6, 4, u, v);
            colour.map(|c| encoded(c * shade * (0.4 + 0.6 * stone)))
        })
    }

    /// glTF's metallic-roughness channels: perceptual roughness in green, metallic (none) in blue.
    ///
    /// Some slabs are polished better than others, worn patches are duller, joints are rough.
    pub(crate) fn polish(&self, low: f64, high: f64) -> Vec<u8> {
        png(|x, y| {
            let [u, v] = centre(x, y);
            let ([column, row], stone) = self.locate(u, v);
            let wear = (0.5 * cell_value(8, column, row) + 0.25 + 0.55 * cloud(40, 5, 3, u, v))
                .clamp(0.0, 1.0);
            let stone_roughness = low + (high - low) * wear;
            [0.0, stone * stone_roughness + (1.0 - stone) * 0.7, 0.0]
        })
    }
}

/// Lacquered paint: flakes below, a wavy coat above. 128 texels a side.
pub(crate) struct Paint;

impl Paint {
    const SIZE: u32 = 128;
    const FLAKES: u32 = 32;

    /// Tangent-space normals of flat flakes, each tilted its own way by up to `slope`.
    pub(crate) fn flakes(slope: f64) -> Vec<u8> {
        square_png(Self::SIZE, |x, y| {
            let texels = Self::SIZE / Self::FLAKES;
            let tilt = |seed| 2.0 * slope * (cell_value(seed, x / texels, y / texels) - 0.5);
            (DVec3::new(tilt(60), tilt(61), 1.0).normalize() * 0.5 + 0.5).to_array()
        })
    }

    /// Tangent-space normals of the coat's waves, as high as `height` texels.
    pub(crate) fn waves(height: f64) -> Vec<u8> {
        square_png(Self::SIZE, |x, y| {
            let texel = 1.0 / f64::from(Self::SIZE);
            let [u, v] = [x, y].map(|k| (f64::from(k) + 0.5) * texel);
            let level = |u, v| height * cloud(70, 6, 1, u, v);
            let along_u = (level(u + texel, v) - level(u - texel, v)) / 2.0;
            let along_v = (level(u, v + texel) - level(u, v - texel)) / 2.0;
            (DVec3::new(-along_u, along_v, 1.0).normalize() * 0.5 + 0.5).to_array()
        })
    }
}
