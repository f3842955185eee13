//! Functions of bare numbers and vectors.

use lumigon::{Real, Vec3};

use crate::cases::double;
use crate::compare::Worst;
use crate::gpu::{Place, evaluate};
use crate::polygons::Random;
use crate::tolerances::{ANGLE, ANGLE_OVER_SINE, UNIT};

/// Two numbers of any size and sign, an angle's squared sine and cosine times any length, and unit
/// vectors.
fn places() -> Vec<Place> {
    let mut random = Random::new(72);
    (0..20_000)
        .map(|i| {
            let number = |random: &mut Random| {
                let sign = if random.chance(0.5) { 1.0 } else { -1.0 };
                match random.index(5) {
                    0 => 0.0,
                    1 => sign,
                    _ => sign * random.log_range(1e-18, 1e18),
                }
            };
            let [y, x] = [number(&mut random), number(&mut random)];
            let angle = match i % 4 {
                0 => random.log_range(1e-9, 1.0),
                1 => std::f64::consts::PI - random.log_range(1e-3, 1.0),
                _ => random.range(0.0, 3.1),
            };
            let size = random.log_range(1e-9, 1e9);
            let axis = if i % 8 == 0 {
                random.axis()
            } else {
                random.direction()
            };
            Place {
                normal: [axis.x as f32, axis.y as f32, axis.z as f32],
                lobe: [
                    y as f32,
                    x as f32,
                    (angle.sin() * size).powi(2) as f32,
                    (angle.cos() * size) as f32,
                ],
                ..Place::default()
            }
        })
        .collect()
}

#[test]
fn arctangents_are_the_cpu_s() {
    let places = places();
    let body = "fn evaluate(place: Place) -> array<vec4f, 3> {
        let square = clamp(abs(place.lobe.x), 0.0, 1.0);
        return four(vec4f(
            package::arctangent::arctangent(place.lobe.x, place.lobe.y),
            package::arctangent::angle_over_sine(place.lobe.z, place.lobe.w),
            package::arctangent::angle_over_sine_excess(square),
            0.0
        ));
    }";
    let values = evaluate("arctangent", body, &[], &places);
    let mut angle = Worst::new("arctangent");
    let mut over_sine = Worst::new("angle_over_sine");
    let mut excess = Worst::new("angle_over_sine_excess");
    let pi = std::f32::consts::PI;
    for (place, values) in places.iter().zip(&values) {
        let [y, x, squared_sine, cosine] = place.lobe.map(f64::from);
        let at = || format!("{:?}", place.lobe);
        angle.within(&values[..1], -pi, pi, at);
        angle.see(&values[..1], &[y.atan2(x)], ANGLE, at);
        let exact = f64::angle_over_sine(squared_sine, cosine);
        over_sine.see(&values[1..2], &[exact], ANGLE_OVER_SINE * exact, at);
        let square = y.abs().min(1.0);
        let exact = f64::angle_over_sine_excess(square);
        excess.see(&values[2..3], &[exact], 2e-6 * square, at);
    }
    angle.finish(places.len());
    over_sine.finish(places.len());
    excess.finish(places.len());
}

#[test]
fn tangents_are_the_cpu_s() {
    let places = places();
    let body = "fn evaluate(place: Place) -> array<vec4f, 3> {
        return three(package::vector::tangent_of(place.normal));
    }";
    let values = evaluate("tangent_of", body, &[], &places);
    let mut tangents = Worst::new("tangent_of");
    for (place, values) in places.iter().zip(&values) {
        let normal = double(place.normal);
        let at = || format!("{normal:?}");
        let (tangent, _) = normal.orthonormal_basis();
        tangents.see(&values[..3], &<[f64; 3]>::from(tangent), UNIT, at);
        let got: Vec3<f64> = double([values[0], values[1], values[2]]);
        let lean = [got.dot(normal) as f32, got.length() as f32 - 1.0];
        tangents.see(&lean, &[0.0, 0.0], UNIT, at);
    }
    tangents.finish(places.len());
}
