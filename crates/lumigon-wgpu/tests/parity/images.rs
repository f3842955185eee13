//! The mean of a light's image, by every method.

use lumigon::{
    DiffuseMethod, ImageMethod, LightImage, LocalOcclusion, ProjectionBasis, Scalar, Vec3,
    irradiance, ltc_form_factor, ltc_mean_image, reflected_image, solid_angle_above,
};
use lumigon_wgpu::Light;

use crate::cases::{Cases, Sight, Subject, cases, double};
use crate::compare::Worst;
use crate::gpu::{Place, evaluate_on};
use crate::lobes::prepared;
use crate::polygons::{Random, Vector};
use crate::tolerances;

/// Lights with images: f32 ones for the device, f64 ones as truth.
struct Shown {
    cases: Cases,
    lights: Vec<Light>,
    truth: Vec<LightImage<f64>>,
}

fn shown() -> Shown {
    let cases = cases(73, 120, 64);
    let mut random = Random::new(74);
    let mut shown = Shown {
        lights: Vec::new(),
        truth: Vec::new(),
        cases,
    };
    for (i, subject) in shown.cases.subjects.iter().enumerate() {
        let corners = frame(subject, i, &mut random);
        let size = [[16, 16], [1, 1], [8, 2], [64, 32], [1, 16], [4, 128]][i % 6];
        let seed = random.index(1 << 20);
        shown.lights.push(Light {
            polygon: subject.single.clone(),
            radiance: [1.0; 3],
            image: Some(image(subject, corners, size, seed)),
        });
        shown.truth.push(image(subject, corners, size, seed));
    }
    shown
}

/// A parallelogram around the outline: turned, sheared, mirrored, and larger than need be.
fn frame(subject: &Subject, i: usize, random: &mut Random) -> [[f64; 3]; 3] {
    let light = &subject.light;
    let (center, radius) = light.circumscribed_circle();
    let (x, y) = light.plane_axes();
    let turn = random.range(0.0, std::f64::consts::TAU);
    let along = x * turn.cos() + y * turn.sin();
    let across = y * turn.cos() - x * turn.sin();
    let shear = if i.is_multiple_of(3) {
        random.range(-0.7, 0.7)
    } else {
        0.0
    };
    let leaning = across + along * shear;
    // Coordinates along both edges.
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &vertex in light.offsets() {
        let v = across.dot(vertex);
        let u = along.dot(vertex) - v * shear;
        for (k, at) in [u, v].into_iter().enumerate() {
            low[k] = low[k].min(at);
            high[k] = high[k].max(at);
        }
    }
    if i.is_multiple_of(5) {
        for k in 0..2 {
            let by = 0.2 * (high[k] - low[k]);
            (low[k], high[k]) = (low[k] - by, high[k] + by);
        }
    }
    if i.is_multiple_of(2) {
        (low[0], high[0]) = (high[0], low[0]);
    }
    let plane = light.normal() * light.normal().dot(light.offsets()[0]);
    let corner = center + (plane + along * low[0] + leaning * low[1]) * radius;
    [
        corner.into(),
        (along * ((high[0] - low[0]) * radius)).into(),
        (leaning * ((high[1] - low[1]) * radius)).into(),
    ]
}

/// Gradients and noise: red and green tell where taps lie, blue at which level.
fn image<S: Scalar>(
    subject: &Subject,
    corners: [[f64; 3]; 3],
    size: [u32; 2],
    seed: usize,
) -> LightImage<S> {
    let mut image = LightImage::new(&subject.light, corners, size)
        .unwrap_or_else(|fault| panic!("{fault}: {corners:?} {subject:?}"));
    let mut random = Random::new(seed as u64);
    let texels = (0..size[0] * size[1]).map(|i| {
        let u = (i % size[0]) as f32 / size[0] as f32;
        let v = (i / size[0]) as f32 / size[1] as f32;
        [u, v, random.range(0.0, 1.0) as f32]
    });
    image.replace(&texels.collect::<Vec<_>>()).unwrap();
    image.filter_gaussian_levels();
    image
}

/// A function over images at every place: within the image's range, and what the CPU says, weighed
/// by the function that it multiplies.
fn check_mean(
    name: &'static str,
    call: &str,
    exact: impl Fn(&Subject, &LightImage<f64>, Vector, Vector, &Place) -> [f64; 3],
    allowed: impl Fn(&Subject, &Place, &Sight) -> Option<(f64, f64)>,
) {
    let shown = shown();
    let body = format!(
        "fn evaluate(place: Place) -> array<vec4f, 3> {{
            return three(package::light_images::{call});
        }}"
    );
    let values = evaluate_on(name, &body, &shown.lights, &shown.cases.places);
    let mut worst = Worst::new(name);
    for (place, values) in shown.cases.places.iter().zip(&values) {
        let subject = shown.cases.subject(place);
        let sight = subject.sight(place);
        let got = &values[..3];
        let at = || format!("{place:?} {sight:?} {subject:?}");
        worst.within(got, -1e-6, 1.0 + 1e-6, at);
        if let Some((weight, allowed)) = allowed(subject, place, &sight) {
            let image = &shown.truth[place.light as usize];
            let exact = exact(
                subject,
                image,
                double(place.point),
                double(place.normal),
                place,
            );
            let got: Vec<_> = got.iter().map(|x| x * weight as f32).collect();
            worst.see(&got, &exact.map(|x| x * weight), allowed, at);
        }
    }
    worst.finish(shown.cases.places.len() / 4);
}

const METHODS: [(&str, ImageMethod); 5] = [
    ("0u", ImageMethod::Lookup),
    ("1u", ImageMethod::Quadrature { taps: 1 }),
    ("2u", ImageMethod::Quadrature { taps: 2 }),
    ("3u", ImageMethod::Quadrature { taps: 3 }),
    ("4u", ImageMethod::Quadrature { taps: 4 }),
];

#[test]
fn mean_image_is_the_cpu_s() {
    for (taps, method) in METHODS {
        check_mean(
            "mean_image",
            &format!("mean_image_from(place.light, place.point, place.normal, {taps})"),
            |subject, image, point, normal, _| {
                let exact = DiffuseMethod::default();
                exact.mean_image(&subject.light, image, point, normal, method)
            },
            |subject, place, sight| {
                let (point, normal) = (double(place.point), double(place.normal));
                let weight = irradiance(&subject.light, point, normal);
                Some((weight, tolerances::mean_image(sight)?))
            },
        );
    }
}
