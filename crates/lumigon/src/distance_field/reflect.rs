//! Reflections read from a baked field.

use super::field::DistanceField;
use super::settings::DistanceFieldSmoothness;
use crate::clip::Seen;
use crate::polygon::PolygonLight;
use crate::real::{Mask, Real};
use crate::reflection::Mirrored;
use crate::vec3::Vec3;

/// In radii: rays that meet a light's plane farther away are taken to meet it there.
const FARTHEST_HIT: f64 = 1e12;

/// How much wider a lobe gets for each unit of its length, over alpha: light turns by twice as much as
/// a facet does, to either side.
pub const DISTANCE_FIELD_SPREAD: f64 = 4.0;

/// A field, and how a light lies in it.
#[derive(Clone, Copy, Debug)]
pub struct PlacedDistanceField<'a, S> {
    /// The field of the light's shape.
    pub field: &'a DistanceField,
    /// As [`FieldPlacement::light_to_field`](super::FieldPlacement::light_to_field).
    pub light_to_field: [S; 4],
}

impl<'a, S: crate::Scalar> PlacedDistanceField<'a, S> {
    /// The field of the very light that it was baked for.
    pub fn own(field: &'a DistanceField) -> Self {
        let scale = S::from_f64(1.0 / f64::from(field.settings().phi()));
        let zero = S::from_f64(0.0);
        Self {
            field,
            light_to_field: [scale, zero, zero, zero],
        }
    }
}

/// How much of the light a surface reflects to the viewer, 0 to 1: 1/(d + 1)^k, k = `k_s`, of the distance d
/// from the light at which the mirrored view meets its plane.
///
/// `normal` and `view` (from the point to the viewer) are unit vectors; `alpha`, at least 0, is the
/// width of the surface's lobe. The lobe widens along its ray: d is smoothed over a square as wide
/// as the lobe where it meets the plane, 4 alpha of the ray's length, since light turns by twice as
/// much as a facet does, to either side. So rough surfaces see neither an outline's corners nor the
/// creases between them, and small lights are dim to them. 0 reads the finest level everywhere.
///
/// 0 behind a one-sided light, and where view or reflection are below the horizon or do not meet the
/// plane. What light comes from the sides of a lobe is a guess; see
/// [`distance_field_smoothness`](super::distance_field_smoothness) for how good a one.
///
/// Petryaev, "Polygons as lights", section on specular reflections. d is in the field's units there
/// and here, radii over Phi; the smoothing is new.
#[inline(always)]
pub fn reflected_distance<T: Real>(
    light: &PolygonLight<T::Scalar>,
    placed: PlacedDistanceField<'_, T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
    view: Vec3<T>,
    alpha: T,
    smoothness: DistanceFieldSmoothness,
) -> T {
    let seen = Seen::new(light, point);
    let like = point.x;
    let zero = like.constant(0.0);
    let mirrored = Mirrored::new(&seen, normal, view);
    if !mirrored.seen.any() {
        return zero;
    }
    let distance = mirrored.distance.min(like.constant(FARTHEST_HIT));
    let hit = mirrored.direction * distance - seen.center;
    let (x_axis, y_axis) = light.plane_axes;
    let x = Vec3::broadcast(like, x_axis).dot(hit);
    let y = Vec3::broadcast(like, y_axis).dot(hit);
    let [a, b, c, d] = placed.light_to_field.map(
        #[inline(always)]
        |number| like.broadcast(number),
    );
    let u = a.mul_add(x, c) - b * y;
    let v = b.mul_add(x, d) + a * y;
    let settings = placed.field.settings();
    let texels_per_radius = 0.5 * f64::from(settings.resolution()) / f64::from(settings.phi());
    let spread = alpha * distance;
    let width = spread * like.constant(DISTANCE_FIELD_SPREAD * texels_per_radius);
    let smoothness = smoothness.at(spread, like.constant(settings.phi().into()));
    let [response] = T::lookup(
        [u, v, width, smoothness],
        #[inline(always)]
        |[u, v, width, smoothness]| {
            let distance = placed.field.fetch(u, v, width);
            [response(distance, smoothness)]
        },
    );
    T::select(mirrored.seen, response, zero)
}

/// 1/(d + 1)^k, k the smoothness; 1 inside.
#[inline(always)]
fn response<S: crate::Scalar>(distance: S, smoothness: S) -> S {
    let zero = S::from_f64(0.0);
    let outside = if distance > zero { distance } else { zero };
    (outside + S::from_f64(1.0)).powf(-smoothness)
}
