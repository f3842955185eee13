//! The mean of a light's image as a shading point weighs it, by a few taps.
//!
//! Taps are the product of a rule across rows and one along each row, and both are the same warp:
//! light that falls from a line onto a surface is, integrated along it, a sine. Seen in the plane
//! through the shading point and the line, in which theta is a point's angle from the line's nearest
//! point and phi the angle by which the horizon's normal leans, the weight cos(theta - phi) d(theta)
//! of a point of the line has the integral sin(theta - phi). Taps lie at even steps of that sine, on
//! the part of the line above the horizon. Whole rows seen along their direction are such points too,
//! as far as they are long; what they are not, the taps' weights make up for.
//!
//! No tap knows of the outline or of holes: coverage lives in the image's weights. Only the colour is
//! estimated; it multiplies the exact integral.

use crate::clip::Horizon;
use crate::image_pyramid::ImagePyramid;
use crate::light_image::ImageFrame;
use crate::real::Real;
use crate::vec3::Vec3;

/// Least square of a cosine that is divided by.
const LEAST_SQUARE: f64 = 1e-14;

/// Least quotient of two cosines that is divided by.
const LEAST_QUOTIENT: f64 = 1e-7;

/// Even steps are those of a sine over an interval as small as this.
const EVEN: f64 = 1e-3;

/// What a direction weighs.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ImageWeight<T> {
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
pub(crate) struct ImageQuadrature<T> {
    frame: ImageFrame<T>,
    weight: ImageWeight<T>,
    /// Heights over the horizon of the frame's corner and edges: x + u y + v z.
    heights: Vec3<T>,
    /// Heights over a second horizon.
    cut: Vec3<T>,
    /// Squared length of the edge along u.
    uu: T,
    /// Squared distance of where the weight peaks.
    peak_squared: T,
    v_warp: Warp<T>,
}

/// Taps of one row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageRow<T> {
    v: T,
    /// How fast v moves with the rows, and how much of it this row stands for.
    speed: T,
    extent: T,
    u_warp: Warp<T>,
}

/// One lookup.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageTap<T> {
    /// Across the columns, in \[0, 1\].
    pub(crate) u: T,
    /// Down the rows, in \[0, 1\].
    pub(crate) v: T,
    /// Extent along u that it stands for, as a fraction of the image.
    pub(crate) extent_u: T,
    /// Extent along v.
    pub(crate) extent_v: T,
    /// To multiply the texel with.
    pub(crate) weight: T,
}

/// Part of a line as a shading point weighs it: how even steps of sin(theta - phi) become a
/// coordinate.
#[derive(Clone, Copy, Debug)]
struct Warp<T> {
    first: T,
    last: T,
    /// sin(theta - phi) and cos(theta - phi) at the first coordinate, and the tangent of theta.
    sine: T,
    cosine: T,
    tangent: T,
    /// Of sin(theta - phi), from the first coordinate to the last.
    length: T,
    /// Coordinate per angle at the first coordinate.
    reach: T,
}

impl<T: Real> Warp<T> {
    /// The line's nearest point has the coordinate `foot` and lies `scale` away, in units of the
    /// coordinate; there the line is at `height` and rises by `slope`.
    ///
    /// Differences of sines of nearly equal angles come from the angles' difference, or single
    /// precision would lose them from afar.
    #[inline(always)]
    fn new([first, last]: [T; 2], foot: T, scale: T, height: T, slope: T) -> Self {
        let (zero, one) = (foot.constant(0.0), foot.constant(1.0));
        let inverse = one / scale;
        let rise = slope * scale;
        let squared = height.mul_add(height, rise * rise);
        let normalize = one / squared.max(foot.constant(1e-30)).sqrt();
        let (lean_cosine, lean_sine) = (height * normalize, rise * normalize);
        let from = (first - foot) * inverse;
        let to = (last - foot) * inverse;
        let from_cosine = one / from.mul_add(from, one).sqrt();
        let cosines = from_cosine / to.mul_add(to, one).sqrt();
        let sine = (from * lean_cosine - lean_sine) * from_cosine;
        let cosine = (from.mul_add(lean_sine, lean_cosine) * from_cosine).max(zero);
        // Of the angle between the ends, and 1 - its cosine.
        let across = (last - first) * inverse * cosines;
        let along = from.mul_add(to, one) * cosines;
        let obtuse = along.lt(zero);
        let sagitta = T::select(
            obtuse,
            one - along,
            across * across / (one + T::select(obtuse, zero, along)),
        );
        Self {
            first,
            last,
            sine,
            cosine,
            tangent: from,
            length: (cosine * across - sine * sagitta).max(zero),
            reach: scale * from.mul_add(from, one),
        }
    }

    /// Even steps of the coordinate itself.
    #[inline(always)]
    fn even([first, last]: [T; 2]) -> Self {
        let (zero, one) = (first.constant(0.0), first.constant(1.0));
        let length = first.constant(EVEN);
        Self {
            first,
            last,
            sine: zero,
            cosine: one,
            tangent: zero,
            length,
            reach: (last - first) / length,
        }
    }

    /// Coordinate at `at` in (0, 1) of the interval, and how fast it moves with it.
    #[inline(always)]
    fn tap(&self, at: T) -> (T, T) {
        let one = at.constant(1.0);
        let step = self.length * at;
        let sine = self.sine + step;
        // 1 - the sine's square, without cancellation near the horizon.
        let fall = step * (self.sine + sine);
        let cosine = (self.cosine * self.cosine - fall)
            .max(at.constant(LEAST_SQUARE))
            .sqrt();
        // Sine and cosine of the angle from the first coordinate.
        let bend = self.sine * fall / (self.cosine + cosine);
        let across = step.mul_add(self.cosine, bend);
        let along = sine.mul_add(self.sine, cosine * self.cosine);
        let inverse = one / (along - self.tangent * across).max(at.constant(LEAST_QUOTIENT));
        let coordinate = (self.reach * across).mul_add(inverse, self.first);
        let speed = self.reach * self.length * inverse * inverse / cosine;
        (coordinate.max(self.first).min(self.last), speed)
    }

    #[inline(always)]
    fn extent(&self, speed: T, count: T) -> T {
        (speed / count).min(self.last - self.first)
    }
}

/// The part of an interval where `height + coordinate * slope` is above 0.
#[inline(always)]
fn above<T: Real>([first, last]: [T; 2], height: T, slope: T) -> [T; 2] {
    let zero = height.constant(0.0);
    let rises = slope.gt(zero);
    let steepness = slope.abs().max(height.constant(1e-30));
    let crossing = T::select(rises, -height, height) / steepness;
    let crossing = crossing.max(first).min(last);
    [
        T::select(rises, crossing, first),
        T::select(rises, last, crossing),
    ]
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
        let (heights, lean, step) = match weight {
            ImageWeight::Cosine => {
                let heights = Vec3::new(
                    horizon.height(corner),
                    horizon.height(edge_u),
                    horizon.height(edge_v),
                );
                let lean = horizon.height(normal);
                let root = lean.mul_add(lean, like.constant(3.0)).sqrt();
                let step = distance / (root + lean + lean).max(like.constant(1e-3));
                (heights, lean, step)
            }
            _ => (Vec3::new(one, zero, zero), zero, zero),
        };
        let up = horizon.normal(like);
        let peak = normal * (distance - lean * step) + up * step;
        let from_corner = peak - corner;
        let along_u = edge_u.dot(from_corner);
        let along_v = edge_v.dot(from_corner);
        let peak_u = ((along_u - uv / vv * along_v) / u_across)
            .max(zero)
            .min(one);

        // Rows that reach above both horizons.
        let highest = |heights: Vec3<T>| heights.x + heights.y.max(zero);
        let lit = above([zero, one], highest(heights), heights.z);
        let lit = above(lit, highest(cut), cut.z);
        let v_warp = match weight {
            ImageWeight::Projection(_) => Warp::even(lit),
            _ => {
                // The column through the peak stands for all, seen along the rows.
                let column = edge_u.mul_add(peak_u, corner);
                let foot = -edge_v.dot(column) / vv;
                let nearest = edge_v.mul_add(foot, column);
                let squared = nearest.dot(nearest).max(distance * distance);
                let height = heights
                    .y
                    .mul_add(peak_u, heights.z.mul_add(foot, heights.x));
                let slope = heights.z - uv / uu * heights.y;
                // Where it dips below the horizon before its rows do, it is raised.
                let end = T::select(slope.gt(zero), lit[0], lit[1]);
                let lowest = (end - foot).mul_add(slope, height);
                let height = height - lowest.min(zero);
                Warp::new(lit, foot, (squared / v_across).sqrt(), height, slope)
            }
        };
        Self {
            frame,
            weight,
            heights,
            cut,
            uu,
            peak_squared: peak.dot(peak),
            v_warp,
        }
    }

    /// The row at `at`: (j + 1/2) / count for row j.
    #[inline(always)]
    pub(crate) fn row(&self, at: T, count: T) -> ImageRow<T> {
        let (zero, one) = (at.constant(0.0), at.constant(1.0));
        let (v, speed) = self.v_warp.tap(at);
        let heights = self.heights;
        let height = heights.z.mul_add(v, heights.x);
        let lit = above([zero, one], height, heights.y);
        let lit = above(lit, self.cut.z.mul_add(v, self.cut.x), self.cut.y);
        let u_warp = match self.weight {
            ImageWeight::Projection(_) => Warp::even(lit),
            _ => {
                let start = self.frame.edge_v.mul_add(v, self.frame.corner);
                let foot = -self.frame.edge_u.dot(start) / self.uu;
                let nearest = self.frame.edge_u.mul_add(foot, start);
                let squared = nearest.dot(nearest).max(at.constant(1e-10) * self.uu);
                Warp::new(
                    lit,
                    foot,
                    (squared / self.uu).sqrt(),
                    heights.y.mul_add(foot, height),
                    heights.y,
                )
            }
        };
        ImageRow {
            v,
            speed,
            extent: self.v_warp.extent(speed, count),
            u_warp,
        }
    }

    /// The tap of a row at `at`: (i + 1/2) / count for tap i.
    #[inline(always)]
    pub(crate) fn tap(&self, row: &ImageRow<T>, at: T, count: T) -> ImageTap<T> {
        let zero = at.constant(0.0);
        let (u, speed) = row.u_warp.tap(at);
        let ImageFrame {
            corner,
            edge_u,
            edge_v,
        } = self.frame;
        let place = edge_u.mul_add(u, edge_v.mul_add(row.v, corner));
        let nearness = self.peak_squared / place.dot(place).max(at.constant(1e-30));
        let weight = match self.weight {
            ImageWeight::Cosine => {
                let heights = self.heights;
                let height = heights.y.mul_add(u, heights.z.mul_add(row.v, heights.x));
                height.max(zero) * nearness * nearness
            }
            ImageWeight::SolidAngle => nearness * nearness.sqrt(),
            ImageWeight::Projection(axis) => {
                let tiny = at.constant(1e-3);
                let depth = self.peak_squared.sqrt() / axis.dot(place).max(tiny);
                depth * depth * depth
            }
        };
        ImageTap {
            u,
            v: row.v,
            extent_u: row.u_warp.extent(speed, count),
            extent_v: row.extent,
            weight: weight * row.speed * speed,
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
/// level's; unequal sides count by their root mean square.
#[inline(always)]
pub(crate) fn image_level(width: f32, height: f32) -> f32 {
    0.5 * log2(width * width + height * height) - 1.5
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
