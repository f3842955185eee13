//! The mean of a light's image, by every method.

use lumigon::{
    DiffuseMethod, ImageMethod, LightImage, LocalOcclusion, ProjectionBasis, Scalar, irradiance,
    ltc_form_factor, ltc_mean_image, reflected_image, solid_angle_above,
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

/// What a light shows to a place, and what it is to be weighed by.
struct Expected {
    color: [f64; 3],
    weight: f64,
    /// How much the colour may err.
    allowed: f64,
}

/// A function over images at every place: within the image's range, and what the CPU says where it
/// says so, weighed by the function that it multiplies.
fn check_mean(
    name: &'static str,
    call: &str,
    expected: impl Fn(&Subject, &LightImage<f64>, &Place, &Sight) -> Option<Expected>,
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
        let image = &shown.truth[place.light as usize];
        if let Some(Expected {
            color,
            weight,
            allowed,
        }) = expected(subject, image, place, &sight)
            && weight > 0.0
        {
            let got: Vec<_> = got.iter().map(|x| x * weight as f32).collect();
            worst.see(&got, &color.map(|x| x * weight), weight * allowed, at);
        }
    }
    worst.finish(shown.cases.places.len() / 8);
}

fn quadrature(taps: u32) -> ImageMethod {
    ImageMethod::Quadrature { taps }
}

fn of(place: &Place) -> (Vector, Vector) {
    (double(place.point), double(place.normal))
}

#[test]
fn mean_image_is_the_cpu_s() {
    for (name, taps) in [
        ("mean_image, 1 x 1", 1),
        ("mean_image, 2 x 2", 2),
        ("mean_image, 3 x 3", 3),
        ("mean_image, 4 x 4", 4),
        ("mean_image, 16 x 16", 16),
    ] {
        check_mean(
            name,
            &format!("mean_image_from(place.light, place.point, place.normal, {taps}u)"),
            |subject, image, place, sight| {
                let (light, (point, normal)) = (&subject.light, of(place));
                let exact = DiffuseMethod::default();
                Some(Expected {
                    allowed: tolerances::mean_image(sight, image.size())?,
                    color: exact.mean_image(light, image, point, normal, quadrature(taps)),
                    weight: irradiance(light, point, normal),
                })
            },
        );
    }
}

#[test]
fn conventional_lookup_is_the_cpu_s() {
    check_mean(
        "mean_image, conventional",
        "mean_image_from(place.light, place.point, place.normal, 0u)",
        |subject, image, place, sight| {
            let (light, (point, normal)) = (&subject.light, of(place));
            let exact = DiffuseMethod::default();
            let (frame, size) = (image.frame(), image.size());
            Some(Expected {
                allowed: tolerances::conventional_image(subject, place, sight, &frame, size)?,
                color: exact.mean_image(light, image, point, normal, ImageMethod::Lookup),
                weight: irradiance(light, point, normal),
            })
        },
    );
}

#[test]
fn light_direction_mean_image_is_the_cpu_s() {
    for (name, by_circle, occlusion) in [
        ("light_direction_mean_image", false, LocalOcclusion::Exact),
        (
            "light_direction_mean_image, circle",
            true,
            LocalOcclusion::Circle,
        ),
    ] {
        check_mean(
            name,
            &format!(
                "light_direction_mean_image_from(
                    place.light, place.point, place.normal, {by_circle}, 3u
                )"
            ),
            |subject, image, place, sight| {
                let (light, (point, normal)) = (&subject.light, of(place));
                let method = DiffuseMethod::LightVector { occlusion };
                Some(Expected {
                    allowed: tolerances::mean_image(sight, image.size())?,
                    color: method.mean_image(light, image, point, normal, quadrature(3)),
                    weight: solid_angle_above(light, point, normal),
                })
            },
        );
    }
}

#[test]
fn projected_mean_image_is_the_cpu_s() {
    for (name, constant, basis, by_circle, occlusion) in [
        (
            "projected_mean_image",
            "CENTROID",
            (|_| ProjectionBasis::Centroid) as fn(f64) -> ProjectionBasis,
            false,
            LocalOcclusion::Exact,
        ),
        (
            "projected_mean_image, weighted",
            "WEIGHTED",
            |_| ProjectionBasis::Weighted,
            false,
            LocalOcclusion::Exact,
        ),
        (
            "projected_mean_image, biased",
            "BIASED",
            |bias| ProjectionBasis::Biased { bias },
            true,
            LocalOcclusion::Circle,
        ),
        (
            "projected_mean_image, optimal",
            "OPTIMAL",
            |_| ProjectionBasis::Optimal,
            false,
            LocalOcclusion::Exact,
        ),
    ] {
        check_mean(
            name,
            &format!(
                "projected_mean_image_from(
                    place.light, place.point, place.normal,
                    package::lights::BASIS_{constant}, place.bias, {by_circle}, 2u
                )"
            ),
            |subject, image, place, sight| {
                let (light, (point, normal)) = (&subject.light, of(place));
                let basis = basis(place.bias.into());
                let method = DiffuseMethod::ProjectedArea { basis, occlusion };
                let size = image.size();
                Some(Expected {
                    allowed: tolerances::projected_mean_image(subject, place, sight, basis, size)?,
                    color: method.mean_image(light, image, point, normal, quadrature(2)),
                    weight: solid_angle_above(light, point, normal),
                })
            },
        );
    }
}

const LOBE: &str = "package::ltc::prepare_ltc(place.lobe, place.normal, place.view)";

#[test]
fn ltc_mean_image_is_the_cpu_s() {
    for (name, taps) in [
        ("ltc_mean_image, 1 x 1", 1),
        ("ltc_mean_image, 2 x 2", 2),
        ("ltc_mean_image, 4 x 4", 4),
    ] {
        check_mean(
            name,
            &format!("ltc_mean_image_from(place.light, place.point, {LOBE}, {taps}u)"),
            |subject, image, place, sight| {
                let (light, (point, _)) = (&subject.light, of(place));
                let lobe = prepared(subject, place);
                let (frame, size) = (image.frame(), image.size());
                Some(Expected {
                    allowed: tolerances::ltc_mean_image(
                        subject, place, sight, &lobe, &frame, size,
                    )?,
                    color: ltc_mean_image(light, image, point, &lobe, quadrature(taps)),
                    weight: ltc_form_factor(light, point, &lobe),
                })
            },
        );
    }
}

#[test]
fn reflected_image_is_the_cpu_s() {
    check_mean(
        "reflected_image",
        "reflected_image_from(place.light, place.point, place.normal, place.view, place.alpha)",
        |subject, image, place, sight| {
            let (light, (point, normal)) = (&subject.light, of(place));
            let (frame, size) = (image.frame(), image.size());
            let (view, spread) = (double(place.view), place.alpha.into());
            Some(Expected {
                allowed: tolerances::reflected_image(subject, place, sight, &frame, size)?,
                color: reflected_image(light, image, point, normal, view, spread),
                weight: 1.0,
            })
        },
    );
}
