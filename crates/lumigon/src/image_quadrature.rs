//! The mean of a light's image as a shading point weighs it, by a few taps.
//!
//! Taps are the product of one row and one column rule, both warped so that they lie where the
//! integrand's weight is: along each axis the weight of a point of a plane seen from a distance is
//! about (1 + x^2)^(-3/2), whose integral is x / sqrt(1 + x^2). No tap knows of the outline, of holes
//! or of the horizon: coverage lives in the image's weights, and what the horizon cuts fades a tap.
//! Only the colour is estimated; it multiplies the exact integral.

use crate::clip::Horizon;
use crate::image_pyramid::ImagePyramid;
use crate::light_image::ImageFrame;
use crate::real::Real;
use crate::vec3::Vec3;

/// Least share of a tap that the horizon leaves: all taps below it still have a mean.
const LEAST_SHARE: f64 = 1e-3;

/// Seen under smaller angles, warped rows or columns would differ from even ones by less than what
/// their differences of nearly equal numbers lose.
const EVEN_BELOW: f64 = 0.02;

/// What a direction weighs.
#[derive(Clone, Copy, Debug)]
pub enum ImageWeight<T> {
    /// Its cosine with the horizon's normal: irradiance and, in cosine space, linearly transformed
    /// cosines.
    Cosine,
    /// One: solid angle.
    SolidAngle,
    /// The inverse cube of its cosine with this unit vector: area projected along it.
    Projection(Vec3<T>),
}

/// Where the taps of one shading point lie, and what they weigh.
#[derive(Clone, Copy, Debug)]
pub struct ImageQuadrature<T> {
    frame: ImageFrame<T>,
    weight: ImageWeight<T>,
    /// Heights over the horizon of the frame's corner and edges.
    heights: Vec3<T>,
    /// Heights over a second horizon, which only cuts.
    cut: Vec3<T>,
    /// Squared length of the edge along u, and its product with the other.
    uu: T,
    uv: T,
    /// Squared length of the edge along v, less what lies along u.
    v_across: T,
    /// Image coordinates of where the weight peaks.
    peak_u: T,
    peak_v: T,
    /// Its squared distance.
    peak_squared: T,
    v_axis: Axis<T>,
}

/// Taps of one row.
#[derive(Clone, Copy, Debug)]
pub struct ImageRow<T> {
    v: T,
    /// What of the image's height the row stands for, as a fraction: its weight, and its extent.
    share: T,
    extent: T,
    u_axis: Axis<T>,
}

/// One lookup.
#[derive(Clone, Copy, Debug)]
pub struct ImageTap<T> {
    /// Across the columns, in \[0, 1\].
    pub u: T,
    /// Down the rows, in \[0, 1\].
    pub v: T,
    /// Extent along u that it stands for, as a fraction of the image.
    pub extent_u: T,
    /// Extent along v.
    pub extent_v: T,
    /// To multiply the texel with.
    pub weight: T,
}

/// One axis of the product rule: how q, even in the warped interval, becomes a coordinate.
#[derive(Clone, Copy, Debug)]
struct Axis<T> {
    /// Coordinate of the peak.
    peak: T,
    /// Distance from the peak where the weight has fallen to a third.
    scale: T,
    start: T,
    length: T,
    /// 1 where the taps lie evenly, else 0.
    even: T,
}

impl<T: Real> Axis<T> {
    #[inline(always)]
    fn new(peak: T, scale: T, even: T) -> Self {
        let one = peak.constant(1.0);
        let inverse = one / scale;
        let start = integral(-peak * inverse);
        Self {
            peak,
            scale,
            start,
            length: integral((one - peak) * inverse) - start,
            even: T::select(inverse.lt(peak.constant(EVEN_BELOW)), one, even),
        }
    }

    /// Coordinate of the tap at `at` in (0, 1) of the interval, and how fast the coordinate moves
    /// with it.
    #[inline(always)]
    fn tap(&self, at: T) -> (T, T) {
        let (zero, one) = (at.constant(0.0), at.constant(1.0));
        let q = self.length.mul_add(at, self.start);
        let k = one / (one - q * q).max(at.constant(1e-7)).sqrt();
        let warped = (self.scale * q).mul_add(k, self.peak).max(zero).min(one);
        let speed = self.scale * self.length * (k * k * k);
        let even = self.even.gt(at.constant(0.5));
        (T::select(even, at, warped), T::select(even, one, speed))
    }
}

/// Of (1 + x^2)^(-3/2).
#[inline(always)]
fn integral<T: Real>(x: T) -> T {
    let one = x.constant(1.0);
    x / x.mul_add(x, one).sqrt()
}

impl<T: Real> ImageQuadrature<T> {
    /// `frame` is relative to the shading point, in any space that `horizon` is in. Of `cut` the
    /// heights over a second horizon of the frame's corner and edges: (1, 0, 0) for none.
    #[inline(always)]
    pub(crate) fn new(
        frame: ImageFrame<T>,
        horizon: impl Horizon<T>,
        cut: Vec3<T>,
        weight: ImageWeight<T>,
    ) -> Self {
        let like = frame.corner.x;
        let (zero, one) = (like.constant(0.0), like.constant(1.0));
        let ImageFrame {
            corner,
            edge_u,
            edge_v,
        } = frame;
        let cross = edge_u.cross(edge_v);
        let area = cross.length();
        let normal = cross.normalize_or_zero();
        let signed = normal.dot(corner);
        let normal = Vec3::select(signed.lt(zero), -normal, normal);
        let distance = signed.abs().max(like.constant(1e-5) * area.sqrt());

        let tiny = like.constant(1e-30);
        let uu = edge_u.dot(edge_u).max(tiny);
        let vv = edge_v.dot(edge_v).max(tiny);
        let uv = edge_u.dot(edge_v);
        let u_across = (uu - uv * uv / vv).max(like.constant(1e-9) * uu);
        let v_across = (vv - uv * uv / uu).max(like.constant(1e-9) * vv);

        // From the foot of the point on the plane to the peak of cosine over distance^4.
        let lean = horizon.height(normal);
        let step = match weight {
            ImageWeight::Cosine => {
                let root = lean.mul_add(lean, like.constant(3.0)).sqrt();
                distance / (root + lean + lean).max(like.constant(1e-3))
            }
            _ => zero,
        };
        let up = horizon.normal(like);
        let peak = normal * (distance - lean * step) + up * step;
        let from_corner = peak - corner;
        let along_u = edge_u.dot(from_corner);
        let along_v = edge_v.dot(from_corner);
        let peak_u = (along_u - uv / vv * along_v) / u_across;
        let peak_v = (along_v - uv / uu * along_u) / v_across;
        let peak_squared = peak.dot(peak);

        // Along v the weight peaks where the column nearest to the peak has its own.
        let nearest = peak_u.max(zero).min(one) - peak_u;
        let scale = ((peak_squared + u_across * nearest * nearest) / v_across).sqrt();
        let even = match weight {
            ImageWeight::Projection(_) => one,
            _ => zero,
        };
        Self {
            frame,
            weight,
            heights: Vec3::new(
                horizon.height(corner),
                horizon.height(edge_u),
                horizon.height(edge_v),
            ),
            cut,
            uu,
            uv,
            v_across,
            peak_u,
            peak_v,
            peak_squared,
            v_axis: Axis::new(peak_v - uv / vv * nearest, scale, even),
        }
    }

    /// The row at `at`: (j + 1/2) / count for row j.
    #[inline(always)]
    pub fn row(&self, at: T, count: T) -> ImageRow<T> {
        let one = at.constant(1.0);
        let (v, speed) = self.v_axis.tap(at);
        let from_peak = v - self.peak_v;
        let scale = ((self.peak_squared + self.v_across * from_peak * from_peak) / self.uu).sqrt();
        ImageRow {
            v,
            share: speed,
            extent: (speed / count).min(one),
            u_axis: Axis::new(
                self.peak_u - self.uv / self.uu * from_peak,
                scale,
                self.v_axis.even,
            ),
        }
    }

    /// The tap of a row at `at`: (i + 1/2) / count for tap i.
    #[inline(always)]
    pub fn tap(&self, row: &ImageRow<T>, at: T, count: T) -> ImageTap<T> {
        let like = at;
        let one = like.constant(1.0);
        let (u, speed) = row.u_axis.tap(at);
        let extent = (speed / count).min(one);
        let ImageFrame {
            corner,
            edge_u,
            edge_v,
        } = self.frame;
        let place = edge_u.mul_add(u, edge_v.mul_add(row.v, corner));
        let nearness = self.peak_squared / place.dot(place).max(like.constant(1e-30));
        // Height in the middle, and half of what it varies over the tap.
        let height = |heights: Vec3<T>| {
            let middle = heights.y.mul_add(u, heights.z.mul_add(row.v, heights.x));
            let varies = heights.y.abs() * extent + heights.z.abs() * row.extent;
            (
                middle,
                varies.mul_add(like.constant(0.5), like.constant(1e-12)),
            )
        };
        let least = like.constant(LEAST_SHARE);
        let above = |heights: Vec3<T>| {
            let (middle, varies) = height(heights);
            let half = like.constant(0.5);
            (middle / varies).mul_add(half, half).max(least).min(one)
        };
        let weight = match self.weight {
            ImageWeight::Cosine => {
                let (middle, varies) = height(self.heights);
                let share = (middle / varies).max(least).min(one);
                let cosine = T::select(share.lt(one), share * share * varies, middle);
                cosine * above(self.cut) * nearness * nearness
            }
            ImageWeight::SolidAngle => above(self.cut) * nearness * nearness.sqrt(),
            ImageWeight::Projection(axis) => {
                let tiny = like.constant(1e-3);
                let depth = self.peak_squared.sqrt() / axis.dot(place).max(tiny);
                above(self.cut) * depth * depth * depth
            }
        };
        ImageTap {
            u,
            v: row.v,
            extent_u: extent,
            extent_v: row.extent,
            weight: weight * row.share * speed,
        }
    }

    /// The mean colour by `taps` times `taps` taps.
    #[inline(always)]
    pub(crate) fn mean(&self, pyramid: &ImagePyramid, taps: u32) -> [T; 3] {
        let like = self.uu;
        let count = like.constant(f64::from(taps));
        let step = like.constant(1.0) / count;
        let mut sum = [like.constant(0.0); 4];
        for j in 0..taps {
            let row = self.row(step * like.constant(f64::from(j) + 0.5), count);
            for i in 0..taps {
                let tap = self.tap(&row, step * like.constant(f64::from(i) + 0.5), count);
                let texel = look_up(pyramid, &tap);
                for (sum, channel) in sum.iter_mut().zip(texel) {
                    *sum = channel.mul_add(tap.weight, *sum);
                }
            }
        }
        divided(sum, pyramid)
    }
}

/// The texel of a tap.
#[inline(always)]
fn look_up<T: Real>(pyramid: &ImagePyramid, tap: &ImageTap<T>) -> [T; 4] {
    let [width, height] = pyramid.size().map(|side| side as f32);
    T::lookup(
        [tap.u, tap.v, tap.extent_u, tap.extent_v],
        #[inline(always)]
        |numbers| {
            let [u, v, extent_u, extent_v] = numbers.map(single);
            let level = image_level(extent_u * width, extent_v * height);
            pyramid.sample(u, v, level).map(from_single)
        },
    )
}

/// Level of a pyramid whose texels are half as wide as a tap that stands for so many of the largest
/// level's.
#[inline(always)]
pub(crate) fn image_level(width: f32, height: f32) -> f32 {
    log2(width.max(height)) - 1.0
}

/// Base 2 logarithm to within 0.01, for numbers from 2^-126: levels are blended in any case.
#[inline(always)]
fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = (bits >> 23) as f32 - 127.0;
    let mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - 1.0;
    exponent + mantissa + 0.344 * mantissa * (1.0 - mantissa)
}

#[inline(always)]
pub(crate) fn single<S: crate::real::Scalar>(x: S) -> f32 {
    x.to_f64() as f32
}

#[inline(always)]
pub(crate) fn from_single<S: crate::real::Scalar>(x: f32) -> S {
    S::from_f64(f64::from(x))
}

/// Colour from a weighted sum; the image's mean where nothing weighs anything.
#[inline(always)]
pub(crate) fn divided<T: Real>([r, g, b, weight]: [T; 4], pyramid: &ImagePyramid) -> [T; 3] {
    let one = weight.constant(1.0);
    // Of less there would be no finite inverse, and from a light that is out of reach squares overflow.
    let some = weight.gt(weight.constant(1e-35)) & weight.lt(weight.constant(1e37));
    let inverse = one / T::select(some, weight, one);
    let mean = crate::light_image::color(pyramid.mean());
    let mean = mean.map(|c| weight.broadcast(from_single(c)));
    let [red, green, blue] = mean;
    [
        T::select(some, r * inverse, red),
        T::select(some, g * inverse, green),
        T::select(some, b * inverse, blue),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_is_close() {
        for i in 1..4000 {
            let x = i as f32 * 0.37;
            assert!((log2(x) - libm::log2f(x)).abs() < 0.01, "{x}");
        }
        assert!(log2(0.0) < -100.0 && log2(0.0).is_finite());
    }
}
