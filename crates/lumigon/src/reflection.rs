//! Mirror reflections of a polygon light by point inclusion.
//!
//! Petryaev, "Polygons as lights", section on specular reflections, without the cache: the view
//! vector is reflected and the point where it meets the light's plane is tested for inclusion, by
//! crossing number (Franklin, "PNPOLY") or by winding number (Sunday).

use crate::clip::Seen;
use crate::image_quadrature::{from_single, image_level, single};
use crate::light_image::{LightImage, color};
use crate::polygon::PolygonLight;
use crate::real::Real;
use crate::vec3::Vec3;

/// What makes a point of the plane part of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InclusionRule {
    /// A ray from it crosses the outlines an odd number of times.
    #[default]
    CrossingNumber,
    /// The outlines wind around it; for loops as [`PolygonLight`] wants them the same set.
    WindingNumber,
}

/// 1 where the view vector, mirrored at the surface, meets the light; else 0.
///
/// `normal` and `view` (from the point to the viewer) are unit vectors. 0 behind a one-sided
/// light, and where view or reflection are below the horizon.
#[inline(always)]
pub fn reflected_inclusion<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
    view: Vec3<T>,
    rule: InclusionRule,
) -> T {
    let seen = Seen::new(light, point);
    let like = point.x;
    let (zero, one) = (like.constant(0.0), like.constant(1.0));
    let mirrored = Mirrored::new(&seen, normal, view);
    let hit = mirrored.direction * mirrored.distance - seen.center;
    let (x_axis, y_axis) = light.plane_axes;
    let x = Vec3::broadcast(like, x_axis).dot(hit);
    let y = Vec3::broadcast(like, y_axis).dot(hit);
    T::select(mirrored.seen & contains(light, x, y, rule), one, zero)
}

/// The view vector, mirrored at the surface.
pub(crate) struct Mirrored<T: Real> {
    /// Unit vector.
    pub(crate) direction: Vec3<T>,
    /// Radii along it to the light's plane; finite where it does not meet it, too.
    pub(crate) distance: T,
    /// Whether it meets the plane from an emitting side, with view and surface on one side.
    pub(crate) seen: T::Mask,
}

impl<T: Real> Mirrored<T> {
    #[inline(always)]
    pub(crate) fn new(seen: &Seen<T>, normal: Vec3<T>, view: Vec3<T>) -> Self {
        let zero = seen.plane_distance.constant(0.0);
        let cosine = normal.dot(view);
        let direction = normal * (cosine + cosine) - view;
        let approach = seen.away.dot(direction);
        let meets = approach.gt(zero);
        let one = zero.constant(1.0);
        Self {
            direction,
            distance: seen.plane_distance / T::select(meets, approach, one),
            seen: seen.lit & meets & cosine.gt(zero),
        }
    }
}

/// The colour of the light's image where the mirrored view meets the light's plane, or the nearest
/// that the image has. Linear RGB.
///
/// `spread` is how much wider a lobe grows per unit of its length: 0 for a mirror. The image is read
/// as wide as the lobe is there.
#[inline(always)]
pub fn reflected_image<T: Real>(
    light: &PolygonLight<T::Scalar>,
    image: &LightImage<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
    view: Vec3<T>,
    spread: T,
) -> [T; 3] {
    let seen = Seen::new(light, point);
    let like = point.x;
    let Mirrored {
        direction,
        distance,
        ..
    } = Mirrored::new(&seen, normal, view);
    let frame = image.frame().broadcast(like);
    let [u, v] = frame.coordinates(direction * distance - seen.center);
    // Widths of the lobe in texels.
    let [width, height] = image.size().map(f64::from);
    let across = distance * spread;
    let columns = across * like.constant(width) / frame.edge_u.length();
    let rows = across * like.constant(height) / frame.edge_v.length();
    let pyramid = image.pyramid();
    T::lookup(
        [u, v, columns, rows],
        #[inline(always)]
        |numbers| {
            let [u, v, columns, rows] = numbers.map(single);
            color(pyramid.sample(u, v, image_level(columns, rows))).map(from_single)
        },
    )
}

/// A vertex in radii along the plane's axes.
#[inline(always)]
fn plane_vertex<T: Real>(light: &PolygonLight<T::Scalar>, like: T, i: usize) -> (T, T) {
    let [x, y] = light.plane_offsets[i];
    (like.broadcast(x), like.broadcast(y))
}

/// Whether the plane's point (x, y), in radii along the plane's axes, is in the light.
#[inline(always)]
fn contains<T: Real>(light: &PolygonLight<T::Scalar>, x: T, y: T, rule: InclusionRule) -> T::Mask {
    let (zero, one) = (x.constant(0.0), x.constant(1.0));
    let mut odd = one.lt(zero);
    let mut winding = zero;
    for range in light.loop_ranges() {
        let (mut x0, mut y0) = plane_vertex(light, x, range.end - 1);
        for i in range {
            let (x1, y1) = plane_vertex(light, x, i);
            let up = y0.le(y) & y1.gt(y);
            let down = y1.le(y) & y0.gt(y);
            // Twice the signed area of (start, end, point): positive to the left of the edge.
            let left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0);
            let up_left = up & left.gt(zero);
            let down_right = down & left.lt(zero);
            odd = odd ^ (up_left | down_right);
            winding += T::select(up_left, one, zero) - T::select(down_right, one, zero);
            (x0, y0) = (x1, y1);
        }
    }
    match rule {
        InclusionRule::CrossingNumber => odd,
        InclusionRule::WindingNumber => winding.abs().gt(x.constant(0.5)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PolygonLight, Sides};
    use alloc::vec;

    #[test]
    fn a_ring_reflects_as_a_ring() {
        let square = |r: f64| vec![[-r, -r, 2.0], [-r, r, 2.0], [r, r, 2.0], [r, -r, 2.0]];
        let hole = square(0.5).into_iter().rev().collect();
        let light = PolygonLight::new(&[square(1.0), hole], Sides::Front).unwrap();
        let normal = Vec3::new(0.0, 0.0, 1.0);
        for rule in [InclusionRule::CrossingNumber, InclusionRule::WindingNumber] {
            for (x, inside) in [
                (0.0, 0.0),
                (0.49, 0.0),
                (0.51, 1.0),
                (-0.99, 1.0),
                (1.01, 0.0),
            ] {
                // The mirrored view from the origin meets the light's plane at (x, 0).
                let view = Vec3::new(-x, 0.0, 2.0).normalize_or_zero();
                let got = reflected_inclusion(&light, Vec3::default(), normal, view, rule);
                assert_eq!(got, inside, "{rule:?} at {x}");
            }
            let behind = Vec3::new(0.0, 0.0, 4.0);
            let view = Vec3::new(-0.3, 0.0, -1.0).normalize_or_zero();
            assert_eq!(
                reflected_inclusion(&light, behind, -normal, view, rule),
                0.0
            );
        }
    }
}
