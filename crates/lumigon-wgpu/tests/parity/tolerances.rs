//! How far f32 on a GPU may be from f64 on the CPU, and why.

use lumigon::{
    ImageFrame, Ltc, PreparedLtc, ProjectionBasis, Pyramid, Vec3, light_vector, projection_axis,
};

use crate::cases::{Sight, Subject, double};
use crate::gpu::Place;
use crate::polygons::Vector;

/// Irradiance, light vector, solid angle of a light beyond 2.7 radii that no horizon cuts, relative,
/// over the cosines at light and place: the crate states 2e-6 for its own f32; a GPU divides and
/// takes roots with an error of 2.5 units in the last place more.
pub(crate) const FAR: f64 = 3e-6;

/// The same near, or cut by a horizon, absolute, over the distance from the nearest edge in radii:
/// next to an edge rounding of the place alone turns the edge's direction. The crate states 2e-6 to
/// 3e-6.
pub(crate) const NEAR: f64 = 4e-6;

/// Whether f32 can tell where the place is: not on an edge, where all directions come together, and
/// not in the plane, where there is a jump. A sliver's width is itself near rounding.
pub(crate) fn is_comparable(sight: &Sight) -> bool {
    let height = sight.plane_height.abs();
    let off_plane = height > 1e-4 && height > 2.0 * sight.in_plane && sight.cos_light > 1e-3;
    sight.nearness > 1e-4 && off_plane && !sight.is_sliver
}

/// Quantities that are additive over a light, from the true one: of a light above the horizon or
/// without one.
pub(crate) fn flux(sight: &Sight, has_horizon: bool, exact: f64) -> Option<f64> {
    if !is_comparable(sight) {
        return None;
    }
    // Heights over the horizon are rounded as the distance is.
    let is_whole = !has_horizon || sight.lowest > 1e-3 + 1e-6 * sight.distance;
    if sight.distance > 2.7 && is_whole {
        let cosines = sight.cos_light * if has_horizon { sight.cos_place } else { 1.0 };
        return Some(FAR * exact.abs() / cosines.max(1e-12) + 1e-37);
    }
    Some(NEAR / sight.nearness * sight.edges)
}

/// The same quantities in the near form at any distance; `times` as many sums.
pub(crate) fn near(sight: &Sight, times: f64) -> Option<f64> {
    is_comparable(sight).then(|| times * NEAR / sight.nearness * sight.edges)
}

/// A bound's own rounding, relative: it divides three times by a distance less 1, and once takes a
/// height over the horizon and 1 for a sine; both are rounded as the distance is.
pub(crate) fn bound(sight: &Sight, exact: f64) -> Option<f64> {
    let (nearest, highest) = (sight.distance - 1.0, sight.height + 1.0);
    let steady = (nearest - 1e-3).abs() > 1e-4
        && highest.abs() > 1e-5 * sight.distance.max(1.0)
        && sight.distance < 1e9;
    let divisions = 1.0 / nearest.abs().max(1e-3) + 1.0 / highest.abs() + 1.0 / sight.cos_light;
    (is_comparable(sight) && steady && sight.has_same_circle)
        .then_some(5e-7 * (1.0 + sight.distance * divisions) * exact + 1e-37)
}

/// Of directions: the error of a light vector over its length.
pub(crate) fn direction(vector_error: Option<f64>, length: f64) -> Option<f64> {
    // Shorter than its own error it has no direction.
    vector_error
        .filter(|error| length > 10.0 * error)
        .map(|error| error / length)
}

/// A ramp over a height, which is rounded as the distance is.
pub(crate) fn ramp(sight: &Sight) -> Option<f64> {
    sight
        .has_same_circle
        .then_some(3e-7 * (1.0 + sight.distance))
}

/// A unit vector to a point this far away, in radii: offsets are rounded by 1e-7 radii, which turns
/// it the more the nearer the point.
pub(crate) fn axis(distance: f64) -> Option<f64> {
    // From a billion radii a light is dark, and squares of distances overflow.
    (1e-3..1e9)
        .contains(&distance)
        .then(|| 3e-7 * (1.0 + 1.0 / distance))
}

/// Vertices in radii from a place.
fn vertices(subject: &Subject, place: &Place) -> Vec<Vector> {
    let (_, radius) = subject.light.circumscribed_circle();
    let point = double(place.point);
    let relative = |v: Vector| (v - point) * (1.0 / radius);
    subject
        .placed
        .vertices()
        .into_iter()
        .map(relative)
        .collect()
}

/// The mean direction of the vertices.
pub(crate) fn on_vertices(subject: &Subject, place: &Place, sight: &Sight) -> Option<f64> {
    let vertices = vertices(subject, place);
    let mut sum = Vector::default();
    let mut rounding = 0.0;
    for v in &vertices {
        sum += v.normalize_or_zero();
        rounding += 3e-7 * (1.0 + 1.0 / v.length().max(1e-9));
    }
    // Where the directions cancel, there is none.
    let steady = sum.length() > 0.01 * vertices.len() as f64 && sight.distance < 1e9;
    (is_comparable(sight) && steady).then(|| rounding / sum.length())
}

/// Least depth of the vertices along an axis.
fn least_depth(vertices: &[Vector], axis: Vector) -> f64 {
    vertices
        .iter()
        .map(|v| axis.dot(*v))
        .fold(f64::INFINITY, f64::min)
}

/// Projected areas: relative, over the least depth of a vertex along the axis relative to the
/// distance, which divides twice. Behind the projection's plane there is no answer.
pub(crate) fn projection(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    basis: ProjectionBasis,
    exact: f64,
    rise: f64,
) -> Option<f64> {
    let axis = projection_axis(&subject.light, double(place.point), basis);
    let (_, radius) = subject.light.circumscribed_circle();
    let bias = match basis {
        ProjectionBasis::Biased { bias } => bias / radius,
        _ => 0.0,
    };
    let depth = least_depth(&vertices(subject, place), axis) + bias;
    if !is_comparable(sight) || depth < 0.02 * sight.distance.max(1.0) {
        return None;
    }
    // A horizon's cut is where heights say, which are rounded as the distance is.
    let cut = if sight.lowest > 1e-3 + 1e-6 * sight.distance {
        1.0
    } else {
        1.0 + sight.distance
    };
    Some((4e-6 * sight.edges * cut / sight.nearness + rise) * (exact + 1.0 / (depth * depth)))
}

/// Newton's method stops within 2e-6 of the axis, relative to the cross-section's spread; from afar
/// the cross-section is found as the difference of places that are rounded as the distance is.
pub(crate) fn pyramid_axis(subject: &Subject, place: &Place, sight: &Sight) -> Option<f64> {
    let pyramid = Pyramid::new(&subject.light, double(place.point));
    let depth = least_depth(&vertices(subject, place), pyramid.axis);
    if !is_comparable(sight) || sight.distance > 1e3 || depth < 1e-2 {
        return None;
    }
    Some(3e-6 * sight.edges * (1.0 + pyramid.moment_trace) / sight.cos_light)
}

/// Its area and moments, relative.
pub(crate) fn pyramid_area(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    exact: &[f64; 3],
) -> Option<f64> {
    let axis = pyramid_axis(subject, place, sight)?;
    let [a, b, c] = *exact;
    Some(Vec3::new(a, b, c).length() * axis * sight.distance.max(1.0))
}

/// A mirrored ray hits or misses; not within rounding of an edge.
pub(crate) fn mirrored(subject: &Subject, place: &Place, sight: &Sight) -> Option<f64> {
    let (normal, view) = (double(place.normal), double(place.view));
    let reflected = normal * (2.0 * normal.dot(view)) - view;
    let point = double(place.point);
    let (_, radius) = subject.light.circumscribed_circle();
    let to_edge = |(a, b): (Vector, Vector)| {
        let (a, b) = ((a - point) * (1.0 / radius), (b - point) * (1.0 / radius));
        // Distance of the segment from the ray, over the distance from the place.
        let across = |v: Vector| v - reflected * reflected.dot(v);
        let (a, b) = (across(a), across(b));
        let along = b - a;
        let t = (-a.dot(along) / along.dot(along).max(1e-300)).clamp(0.0, 1.0);
        (a + along * t).length()
    };
    let edges = subject.placed.edges();
    let nearest = edges.into_iter().map(to_edge).fold(f64::INFINITY, f64::min);
    let steady = normal.dot(view).abs() > 1e-6
        && subject.light.normal().dot(reflected).abs() > 1e-3
        && nearest > 1e-4 + 2e-6 * sight.distance;
    (is_comparable(sight) && steady).then_some(1e-9)
}

/// Sums and products of a few numbers up to 1.
pub(crate) const ALBEDO: f64 = 6e-7;

/// Interpolated numbers, of which some are in the tens; both sides in f32.
pub(crate) const TABLE: f64 = 1e-5;

/// An arctangent's absolute error, by its polynomial and rounding.
pub(crate) const ANGLE: f64 = 5e-7;
/// Relative.
pub(crate) const ANGLE_OVER_SINE: f64 = 1e-6;
/// Of unit vectors.
pub(crate) const UNIT: f64 = 1e-6;

/// Normal, view and light.
fn units(place: &Place) -> [Vector; 3] {
    [place.normal, place.view, place.towards].map(|v| double(v).normalize_or_zero())
}

/// Cosines at view and light, and the length of their vectors' sum; not where f32 cannot tell on
/// which side of the horizon they are.
fn cosines(place: &Place) -> Option<[f64; 3]> {
    let [normal, view, light] = units(place);
    let (cos_view, cos_light) = (normal.dot(view), normal.dot(light));
    // Where view and light cancel, there is no half vector.
    let sum = (view + light).length();
    let steady = cos_view.abs() > 1e-5 && cos_light.abs() > 1e-5 && sum > 1e-2;
    steady.then(|| [cos_view.abs(), cos_light.abs(), sum])
}

/// A reflection model's value, relative: cosines are rounded by 1e-7.
pub(crate) fn brdf(place: &Place, exact: f64) -> Option<f64> {
    let [view, light, _] = cosines(place)?;
    Some(exact * 4e-7 * (4.0 + 1.0 / view + 1.0 / light) + 1e-30)
}

/// A rough diffuse surface's value: near the retroreflecting and the opposite direction its terms
/// cancel.
pub(crate) fn diffuse(place: &Place, exact: f64) -> Option<f64> {
    let [_, light, _] = cosines(place)?;
    Some(brdf(place, exact)? + 1e-6 * light)
}

/// Microfacets: a half vector rounded by 1e-7 counts in units of the width.
pub(crate) fn facets(place: &Place, alpha: f32, exact: f64) -> Option<f64> {
    let [_, _, sum] = cosines(place)?;
    let half = 1.0 / (f64::from(alpha).max(1e-4) * sum);
    Some(brdf(place, exact)? + exact * 1e-6 * half)
}

/// Sheen: of exponentials of numbers up to 17 their rounding, relative; and what a half vector
/// rounded by 3e-7 does to a sine to the power of 1/alpha, without the masking that makes it less.
pub(crate) fn cloth(place: &Place, exact: f64) -> Option<f64> {
    let [cos_view, _, sum] = cosines(place)?;
    let [normal, view, light] = units(place);
    let half = (view + light).normalize_or_zero();
    let (cosine, sine) = (normal.dot(half).abs(), normal.cross(half).length().min(1.0));
    let power = 1.0 / f64::from(place.alpha).clamp(1e-6, 1.0);
    let turned = (sine + 3e-7 / sum * cosine).min(1.0);
    let risen = turned.powf(power) - sine.powf(power);
    let scale = (2.0 + power) / (8.0 * std::f64::consts::PI * cos_view);
    Some(brdf(place, exact)? + exact * 1e-5 + scale * risen)
}

/// A light as a lobe's cosine space shows it, in radii: its centre's distance, that to the nearest
/// edge, and the least height of a vertex over both planes.
fn in_cosine_space(subject: &Subject, place: &Place, lobe: &PreparedLtc<f64>) -> [f64; 3] {
    let rows = lobe.world_to_cosine();
    let transform = |v: Vector| Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
    let (center, radius) = subject.light.circumscribed_circle();
    let (point, normal) = (double(place.point), double(place.normal));
    let scaled = |v: Vector| (v - point) * (1.0 / radius);
    let nearness = subject.placed.edges().into_iter().map(|(a, b)| {
        let (a, b) = (transform(scaled(a)), transform(scaled(b)));
        let along = b - a;
        let t = (-a.dot(along) / along.dot(along).max(1e-300)).clamp(0.0, 1.0);
        (a + along * t).length()
    });
    let lowest = subject
        .placed
        .vertices()
        .into_iter()
        .map(|v| normal.dot(scaled(v)).min(transform(scaled(v)).z));
    [
        transform(scaled(center)).length(),
        nearness.fold(f64::INFINITY, f64::min),
        lowest.fold(f64::INFINITY, f64::min),
    ]
}

/// A lobe's form factor: as [`flux`], in cosine space, where places are rounded as in world space
/// but may be much nearer.
pub(crate) fn lobe(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    lobe: &PreparedLtc<f64>,
) -> Option<f64> {
    let [distance, nearness, lowest] = in_cosine_space(subject, place, lobe);
    let reach = sight.distance.max(1.0);
    if !is_comparable(sight) || nearness < 1e-4 * reach {
        return None;
    }
    if distance > 2.7 && lowest > 1e-3 + 1e-6 * sight.distance {
        let relative = 3e-6 * sight.edges * sight.distance / distance;
        return Some(relative / (distance * distance) + 1e-37);
    }
    Some(2e-6 * sight.edges * reach / nearness.min(reach))
}

/// Its bound's rounding, as [`bound`].
pub(crate) fn lobe_bound(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    lobe: &PreparedLtc<f64>,
    exact: f64,
) -> Option<f64> {
    let [distance, _, _] = in_cosine_space(subject, place, lobe);
    let rows = lobe.world_to_cosine();
    let (center, radius) = subject.light.circumscribed_circle();
    let height = rows[2].dot((center - double(place.point)) * (1.0 / radius));
    let (nearest, highest) = (distance - 1.0, height + 1.0);
    let steady = (nearest - 1e-3).abs() > 1e-4 * sight.distance.max(1.0)
        && highest.abs() > 1e-5 * sight.distance.max(1.0)
        && (sight.height + 1.0).abs() > 1e-5 * sight.distance.max(1.0)
        && sight.distance < 1e9;
    let divisions = 1.0 / nearest.abs().max(1e-3) + 1.0 / highest.abs();
    // The area grows with a normal that may be all but rounding.
    let normal = 2e-6 * sight.distance / (distance * sight.cos_light);
    (is_comparable(sight) && steady && sight.has_same_circle).then(|| {
        let stretched = std::f64::consts::FRAC_1_PI / (nearest.max(1e-3) * nearest.max(1e-3));
        1e-6 * sight.distance.max(1.0) * divisions * exact + normal * stretched.min(1.0) + 1e-37
    })
}

/// A lobe's density, relative: the fourth power of a length that is a sum of two products.
pub(crate) fn lobe_density(ltc: &Ltc<f64>, light: Vector, exact: f64) -> Option<f64> {
    let [a, b, c, d] = ltc.shading_to_cosine;
    let (x, z) = (a * light.x + b * light.z, c * light.x + d * light.z);
    let lost = |sum: f64, p: f64, q: f64| (p.abs() + q.abs()) / sum.abs().max(1e-30);
    let length = (x * x + light.y * light.y + z * z).sqrt();
    let rounding = (a * light.x).abs() + (b * light.z).abs() + light.y.abs() + z.abs();
    let terms = 4.0 * rounding / length
        + lost(z, c * light.x, d * light.z)
        + lost(a * d - b * c, a * d, b * c);
    // Not where f32 cannot tell the side.
    (lost(z, c * light.x, d * light.z) < 1e4).then_some(3e-7 * terms * exact + 1e-30)
}

/// Its inverse map's direction.
pub(crate) fn lobe_direction(ltc: &Ltc<f64>, direction: Vector) -> Option<f64> {
    let [a, b, c, d] = ltc.shading_to_cosine;
    let x = d * direction.x - b * direction.z;
    let z = a * direction.z - c * direction.x;
    let y = direction.y * (a * d - b * c);
    let rounding = (d * direction.x).abs()
        + (b * direction.z).abs()
        + (a * direction.z).abs()
        + (c * direction.x).abs()
        + direction.y.abs() * ((a * d).abs() + (b * c).abs());
    let length = (x * x + y * y + z * z).sqrt();
    (length > 1e-9).then(|| 3e-7 * rounding / length + 3e-7)
}

/// Of an image that varies by 1 from texel to texel, by how much of the image a lookup may miss its
/// place; `size` is the image's.
fn color_error(missed: f64, size: [u32; 2]) -> f64 {
    (missed * f64::from(size[0].max(size[1]))).min(1.0)
}

/// The colour that taps find: where they lie and what they weigh is rounded as places are, relative
/// to the plane's distance.
pub(crate) fn mean_image(sight: &Sight, size: [u32; 2]) -> Option<f64> {
    let rounding = 2e-6 * (1.0 + sight.distance) / sight.plane_height.abs().min(1.0);
    (is_comparable(sight) && sight.has_same_circle).then(|| color_error(rounding, size))
}

/// By projected area, which moreover divides by depths along the axis.
pub(crate) fn projected_mean_image(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    basis: ProjectionBasis,
    size: [u32; 2],
) -> Option<f64> {
    let axis = projection_axis(&subject.light, double(place.point), basis);
    let depth = least_depth(&vertices(subject, place), axis);
    let reach = sight.distance.max(1.0);
    (depth > 0.02 * reach).then_some(mean_image(sight, size)? * reach / depth)
}

/// By a lobe: in cosine space, where places are rounded as in world space but may be much nearer.
pub(crate) fn ltc_mean_image(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    lobe: &PreparedLtc<f64>,
    frame: &ImageFrame<f64>,
    size: [u32; 2],
) -> Option<f64> {
    mean_image(sight, size)?;
    let [distance, _, _] = in_cosine_space(subject, place, lobe);
    let rows = lobe.world_to_cosine();
    let transform = |v: Vector| Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
    let (u, v) = (transform(frame.edge_u), transform(frame.edge_v));
    let (center, radius) = subject.light.circumscribed_circle();
    let to_center = transform((center - double(place.point)) * (1.0 / radius));
    let normal = u.cross(v).normalize_or_zero();
    let height = normal.dot(to_center).abs();
    // A sheared image's own coordinates, and a plane that rounding turns.
    let lean = u.length() * v.length() / u.cross(v).length();
    let reach = sight.distance.max(1.0);
    let rounding = 2e-6 * lean * reach / height.min(distance).min(1.0);
    Some(color_error(rounding, size))
}

/// Where a ray from `distance` off the image's plane meets it under this cosine, for a direction that
/// may err by so much: as a share of the image.
fn missed(frame: &ImageFrame<f64>, distance: f64, cosine: f64, direction_error: f64) -> f64 {
    let area = frame.edge_u.cross(frame.edge_v).length();
    let narrowest = area / frame.edge_u.length().max(frame.edge_v.length());
    direction_error * distance / (cosine * cosine * narrowest)
}

/// The conventional lookup: where the light vector meets the plane.
pub(crate) fn conventional_image(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    frame: &ImageFrame<f64>,
    size: [u32; 2],
) -> Option<f64> {
    let own = mean_image(sight, size)?;
    let vector = light_vector(&subject.light, double(place.point));
    let error = direction(flux(sight, false, vector.length()), vector.length())?;
    let cosine = subject.light.normal().dot(vector.normalize_or_zero()).abs();
    let missed = missed(frame, sight.plane_height.abs(), cosine, error);
    Some((own + color_error(missed, size)).min(1.0))
}

/// The image where a mirrored view meets the plane.
pub(crate) fn reflected_image(
    subject: &Subject,
    place: &Place,
    sight: &Sight,
    frame: &ImageFrame<f64>,
    size: [u32; 2],
) -> Option<f64> {
    let own = mean_image(sight, size)?;
    let (normal, view) = (double(place.normal), double(place.view));
    let reflected = normal * (2.0 * normal.dot(view)) - view;
    let cosine = subject.light.normal().dot(reflected).abs();
    let missed = missed(frame, sight.distance.max(1.0), cosine, 1e-6);
    (cosine > 1e-3).then(|| (own + color_error(missed, size)).min(1.0))
}
