//! Images on polygon lights.

use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use crate::coverage::{coverage, nearest_covered};
use crate::image_lookup::GaussianLevels;
use crate::image_pyramid::{ImagePyramid, Texel, for_each_row};
use crate::polygon::PolygonLight;
use crate::real::{Real, Scalar};
use crate::vec3::Vec3;

/// Weight of colours beyond the outline, which are those of its nearest texels. Without it a lookup
/// that meets no covered texel would have no colour.
const BEYOND: f32 = 1e-3;

/// Longest side of an image.
const LONGEST_SIDE: u32 = 1 << 14;

/// Why a light has no such image. Rows and columns are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LightImageError {
    /// The size is not one that can be halved down to one texel.
    #[error("an image of {width} x {height} texels: give powers of two from 1 to 16384")]
    Size {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
    },
    /// The two edges do not span a parallelogram in the light's plane, or are not finite.
    #[error("the image's edges span no parallelogram: give two that differ in direction")]
    Frame,
    /// There are more or fewer colours than texels.
    #[error("{count} colours for {expected} texels: give one for each, row by row")]
    Count {
        /// How many there are.
        count: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A colour is negative, infinite or NaN.
    #[error("texel ({x}, {y}) is {value}: lights emit finite amounts, at least 0; mend the image")]
    Value {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The first bad channel.
        value: f32,
    },
}

/// The parallelogram that an image covers: its corner at (u, v) = (0, 0), the upper left of the
/// first texel, and its edges along u, across the columns, and along v, down the rows. In radii from
/// the centre of the light's circumscribed circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageFrame<S> {
    /// Where u = v = 0.
    pub corner: Vec3<S>,
    /// From there to u = 1.
    pub edge_u: Vec3<S>,
    /// From there to v = 1.
    pub edge_v: Vec3<S>,
}

impl<S: Scalar> ImageFrame<S> {
    /// The same in every lane, beside `like`.
    #[inline(always)]
    pub(crate) fn broadcast<T: Real<Scalar = S>>(self, like: T) -> ImageFrame<T> {
        ImageFrame {
            corner: Vec3::broadcast(like, self.corner),
            edge_u: Vec3::broadcast(like, self.edge_u),
            edge_v: Vec3::broadcast(like, self.edge_v),
        }
    }
}

impl<T: Real> ImageFrame<T> {
    /// (u, v) of a point in the plane.
    #[inline(always)]
    pub(crate) fn coordinates(&self, point: Vec3<T>) -> [T; 2] {
        let normal = self.edge_u.cross(self.edge_v);
        let squared_area = normal.dot(normal);
        let inverse = squared_area.constant(1.0) / squared_area;
        let offset = point - self.corner;
        [
            offset.cross(self.edge_v).dot(normal) * inverse,
            self.edge_u.cross(offset).dot(normal) * inverse,
        ]
    }
}

/// What a light shows: radiance is the light's own times the image's colour there.
///
/// The image lies on a parallelogram around the light's outline; what is outside the outline emits
/// nothing. Texels carry how much of them the outline covers, and colours continue beyond it, so
/// that filtering mixes no black in.
///
/// Copies share their texels until one of them is replaced.
#[derive(Clone, Debug, PartialEq)]
pub struct LightImage<S> {
    frame: ImageFrame<S>,
    pyramid: Arc<ImagePyramid>,
    /// Share of each texel inside the outline, and which texel gives it its colour; none where all
    /// are wholly inside.
    outline: Option<Arc<Outline>>,
    gaussian: Option<Arc<GaussianLevels>>,
    greatest: [f32; 3],
}

#[derive(Clone, Debug, PartialEq)]
struct Outline {
    coverage: Vec<f32>,
    source: Vec<u32>,
}

impl<S: Scalar> LightImage<S> {
    /// A white image of `size` texels, powers of two, on the parallelogram that starts at `corner`,
    /// all in the space of the light's vertices.
    ///
    /// # Errors
    /// Where size or parallelogram are none.
    pub fn new(
        light: &PolygonLight<f64>,
        [corner, edge_u, edge_v]: [[f64; 3]; 3],
        size: [u32; 2],
    ) -> Result<Self, LightImageError> {
        let [width, height] = size;
        if size
            .iter()
            .any(|side| !side.is_power_of_two() || *side > LONGEST_SIDE)
        {
            return Err(LightImageError::Size { width, height });
        }
        let frame = flat_frame(light, [corner, edge_u, edge_v])?;
        let scaled = |offset: Vec3<f64>| {
            let [u, v] = frame.coordinates(offset);
            [u * f64::from(width), v * f64::from(height)]
        };
        let corners: Vec<_> = light.offsets().iter().map(|&v| scaled(v)).collect();
        let coverage = coverage(&corners, light.loop_ranges(), size);
        let whole = coverage.iter().all(|&share| share > 0.999_999);
        let outline = (!whole).then(|| {
            let texel = [
                frame.edge_u.length() / f64::from(width),
                frame.edge_v.length() / f64::from(height),
            ];
            let source = nearest_covered(&coverage, width as usize, texel);
            Arc::new(Outline { coverage, source })
        });
        let mut image = Self {
            frame: cast_frame(&frame),
            pyramid: Arc::new(ImagePyramid::new(size)),
            outline,
            gaussian: None,
            greatest: [0.0; 3],
        };
        image.fill(&vec![[1.0; 3]; width as usize * height as usize]);
        Ok(image)
    }

    /// The same texels on a light that has been moved, turned or scaled as a whole: its outline lies in
    /// the parallelogram, in space as [`LightImage::new`] takes it, as the one before did in its own.
    /// Nothing is filtered again.
    ///
    /// # Errors
    /// Where the parallelogram is none.
    pub fn moved(
        &self,
        light: &PolygonLight<f64>,
        parallelogram: [[f64; 3]; 3],
    ) -> Result<Self, LightImageError> {
        Ok(Self {
            frame: cast_frame(&flat_frame(light, parallelogram)?),
            ..self.clone()
        })
    }

    /// Shows other colours: linear, one a texel of [`LightImage::size`], row by row from (0, 0). Filters
    /// them, on all processors with the feature `parallel`.
    ///
    /// # Errors
    /// Where their number is wrong or one is no colour; the image then stays what it was.
    pub fn replace(&mut self, colors: &[[f32; 3]]) -> Result<(), LightImageError> {
        let [width, height] = self.size().map(|side| side as usize);
        if colors.len() != width * height {
            return Err(LightImageError::Count {
                count: colors.len(),
                expected: width * height,
            });
        }
        // Finite sums of texels, whatever they are: a texel adds less than the largest number over
        // their count.
        let most = f32::MAX / 16.0 / (width * height) as f32;
        let bad = |value: &f32| !(0.0..=most).contains(value);
        if let Some(i) = colors.iter().position(|color| color.iter().any(bad)) {
            let value = colors[i].into_iter().find(bad).unwrap_or_default();
            let (x, y) = (i % width, i / width);
            return Err(LightImageError::Value { x, y, value });
        }
        self.fill(colors);
        Ok(())
    }

    fn fill(&mut self, colors: &[[f32; 3]]) {
        let width = self.size()[0] as usize;
        let outline = self.outline.as_deref();
        let pyramid = Arc::make_mut(&mut self.pyramid);
        for_each_row(pyramid.base(), width, |y, row| {
            for (x, texel) in row.iter_mut().enumerate() {
                let i = y * width + x;
                let (weight, source) = match outline {
                    None => (1.0 + BEYOND, i),
                    Some(outline) => (outline.coverage[i] + BEYOND, outline.source[i] as usize),
                };
                let [r, g, b] = colors[source].map(|c| c * weight);
                *texel = [r, g, b, weight];
            }
        });
        pyramid.filter();
        self.greatest = [0.0; 3];
        for &[r, g, b, weight] in self.pyramid.level(0) {
            for (greatest, channel) in self.greatest.iter_mut().zip([r, g, b]) {
                *greatest = greatest.max(channel / weight);
            }
        }
        if self.gaussian.is_some() {
            self.filter_gaussian_levels();
        }
    }

    /// Filters the levels that [`ImageMethod::Lookup`](crate::ImageMethod::Lookup) reads, now and at
    /// every [`LightImage::replace`]: a few times the work of the pyramid.
    pub fn filter_gaussian_levels(&mut self) {
        self.gaussian = Some(Arc::new(GaussianLevels::new(&self.pyramid, BEYOND)));
    }

    /// The levels of [`LightImage::filter_gaussian_levels`], if it was called.
    pub fn gaussian_levels(&self) -> Option<&GaussianLevels> {
        self.gaussian.as_deref()
    }

    /// Whether both have the very same texels in memory, the conventional lookup's left out: what has been
    /// done for those of one need not be done for the other's.
    pub fn shares_texels_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.pyramid, &other.pyramid)
    }

    /// The greatest of its colours, channel by channel.
    pub fn greatest(&self) -> [f32; 3] {
        self.greatest
    }

    /// Texels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.pyramid.size()
    }

    /// Where it lies.
    pub fn frame(&self) -> ImageFrame<S> {
        self.frame
    }

    /// Its levels: texels are colour times weight, and weight; the weight is what the outline covers
    /// of them, and a thousandth.
    pub fn pyramid(&self) -> &ImagePyramid {
        &self.pyramid
    }

    /// How much of each texel is inside the outline, row by row, and which texel gives it its
    /// colour; `None` where the outline covers all of the image.
    pub fn coverage(&self) -> Option<(&[f32], &[u32])> {
        let outline = self.outline.as_deref()?;
        Some((&outline.coverage, &outline.source))
    }

    /// The mean colour of the outline's inside.
    pub fn mean(&self) -> [f32; 3] {
        color(self.pyramid.mean())
    }
}

/// A parallelogram on the light's plane, as its vertices are, in its radii.
fn flat_frame(
    light: &PolygonLight<f64>,
    [corner, edge_u, edge_v]: [[f64; 3]; 3],
) -> Result<ImageFrame<f64>, LightImageError> {
    let (center, radius) = light.circumscribed_circle();
    let inverse = 1.0 / radius;
    let flat = |v: Vec3<f64>| v - light.normal() * light.normal().dot(v);
    let plane = light.normal() * light.normal().dot(light.offsets()[0]);
    let frame = ImageFrame {
        corner: flat((Vec3::from(corner) - center) * inverse) + plane,
        edge_u: flat(Vec3::from(edge_u) * inverse),
        edge_v: flat(Vec3::from(edge_v) * inverse),
    };
    let area = frame.edge_u.cross(frame.edge_v).length();
    let lengths = frame.edge_u.length() * frame.edge_v.length();
    let finite = area.is_finite() && frame.corner.length().is_finite();
    if !finite || area <= 1e-9 * lengths || lengths < 1e-18 {
        return Err(LightImageError::Frame);
    }
    Ok(frame)
}

fn cast_frame<S: Scalar>(frame: &ImageFrame<f64>) -> ImageFrame<S> {
    let cast = |v: Vec3<f64>| Vec3::new(S::from_f64(v.x), S::from_f64(v.y), S::from_f64(v.z));
    ImageFrame {
        corner: cast(frame.corner),
        edge_u: cast(frame.edge_u),
        edge_v: cast(frame.edge_v),
    }
}

/// The colour of a weighted texel.
#[inline(always)]
pub(crate) fn color([r, g, b, weight]: Texel) -> [f32; 3] {
    let inverse = 1.0 / weight;
    [r * inverse, g * inverse, b * inverse]
}
