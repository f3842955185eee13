use std::f64::consts::PI;

use super::*;
use crate::{TexelFilter, Texture, form_factor, ggx, irradiance, solid_angle};

const TIGHT: Tolerance = Tolerance {
    absolute: 0.0,
    relative: 1e-6,
    max_evaluations: 20_000_000,
};

/// A concave outline with a hole in the plane z = 1, facing down, and a leaning grid around it.
fn light() -> (Polygon, [[f64; 3]; 3]) {
    let up = |points: &[[f64; 2]]| points.iter().rev().map(|p| [p[0], p[1], 1.0]).collect();
    let outline = up(&[
        [-1.0, -1.0],
        [1.0, -1.0],
        [1.1, 1.0],
        [0.2, 0.1],
        [-0.9, 0.8],
    ]);
    let hole = up(&[[0.0, -0.6], [-0.2, -0.1], [0.3, -0.5]]);
    let polygon = Polygon::new(&[outline, hole], false).unwrap();
    (
        polygon,
        [[-1.4, -1.2, 1.0], [2.6, 0.2, 0.0], [-0.3, 2.4, 0.0]],
    )
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    DVec3::from(v).normalize().into()
}

#[test]
fn weights_add_up_to_the_untextured_light() {
    let (light, frame) = light();
    let [high, low] = [[0.3, -0.2, -1.5], [0.4, 0.2, 0.7]];
    for filter in [TexelFilter::Nearest, TexelFilter::Bilinear] {
        let grid = TexelGrid::new(frame, [16, 8], filter).unwrap();
        let total = |point, weighting| {
            let weights = texel_weights(&light, &grid, point, &weighting, TIGHT).unwrap();
            let sum: f64 = weights.weights().iter().sum();
            assert!((sum / weights.total() - 1.0).abs() < 1e-9);
            weights.total()
        };
        for point in [high, low] {
            // The second's horizon cuts the light.
            for normal in [[0.0, 0.0, 1.0], unit([0.9, 0.1, 0.2])] {
                let e = irradiance(&light, point, normal, Tolerance::default()).unwrap();
                let found = total(point, Weighting::Cosine { normal });
                assert!((found / e.value - 1.0).abs() < 2e-6, "{found} {e:?}");
                // A lobe that is the surface's own cosine.
                let rows = shading_frame(normal.into(), DVec3::ZERO).map(Into::into);
                let f = form_factor(&light, point, normal, Tolerance::default()).unwrap();
                let to_cosine: [[f64; 3]; 3] = rows;
                let lobe = total(point, Weighting::TransformedCosine { to_cosine, normal });
                assert!((lobe / f.value - 1.0).abs() < 2e-6, "{lobe} {f:?}");
                let view = unit([0.2, 0.3, 0.6]);
                for alpha in [0.01, 0.3] {
                    let exact = ggx(&light, point, normal, view, alpha, Tolerance::default());
                    let exact = exact.unwrap().value;
                    let weighting = Weighting::Ggx {
                        normal,
                        view,
                        alpha,
                    };
                    let found = total(point, weighting);
                    assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
                }
            }
            let normal = [0.0, 0.0, 1.0];
            let omega = solid_angle(&light, point, Tolerance::default()).unwrap();
            let found = total(point, Weighting::SolidAngle { normal });
            assert!((found / omega.value - 1.0).abs() < 2e-6);
            // Straight up, an area at height h covers 1 / h^2 of itself.
            let found = total(
                point,
                Weighting::ProjectedArea {
                    axis: normal,
                    normal,
                },
            );
            let height = 1.0 - point[2];
            assert!((found * height * height / light.area() - 1.0).abs() < 1e-6);
        }
    }
}

/// Far below a square, what a texel adds is its area times the irradiance of an element: by hand.
#[test]
fn far_weights_are_areas() {
    let square = vec![
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
    ];
    let light = Polygon::new(&[square], false).unwrap();
    let frame = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let distance = 1e4;
    let point = [0.5, 0.5, -distance];
    let weighting = Weighting::Cosine {
        normal: [0.0, 0.0, 1.0],
    };
    for filter in [TexelFilter::Nearest, TexelFilter::Bilinear] {
        let grid = TexelGrid::new(frame, [4, 2], filter).unwrap();
        let weights = texel_weights(&light, &grid, point, &weighting, TIGHT).unwrap();
        for weight in weights.weights() {
            assert!(
                (weight * distance * distance * 8.0 - 1.0).abs() < 1e-6,
                "{weight}"
            );
        }
    }
    // From behind it is dark.
    let grid = TexelGrid::new(frame, [4, 2], TexelFilter::Nearest).unwrap();
    let weights = texel_weights(&light, &grid, [0.5, 0.5, 1.0], &weighting, TIGHT).unwrap();
    assert_eq!(weights.total(), 0.0);
    assert_eq!(weights.mean(&[[1.0; 3]; 8]), None);
}

/// Two halves of a light are two lights.
#[test]
fn texels_are_lights_of_their_own() {
    let half = |x0: f64, x1: f64| {
        let loops = [vec![
            [x0, 0.0, 1.0],
            [x0, 2.0, 1.0],
            [x1, 2.0, 1.0],
            [x1, 0.0, 1.0],
        ]];
        Polygon::new(&loops, false).unwrap()
    };
    let frame = [[-1.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let grid = TexelGrid::new(frame, [2, 1], TexelFilter::Nearest).unwrap();
    let normal = unit([0.4, 0.1, 0.3]);
    let point = [0.3, -0.2, 0.6];
    let weighting = Weighting::Cosine { normal };
    let weights = texel_weights(&half(-1.0, 1.0), &grid, point, &weighting, TIGHT).unwrap();
    let [left, right] = [half(-1.0, 0.0), half(0.0, 1.0)].map(|l| {
        irradiance(&l, point, normal, Tolerance::default())
            .unwrap()
            .value
    });
    assert!((weights.weights()[0] - left).abs() < 1e-6);
    assert!((weights.weights()[1] - right).abs() < 1e-6);
    let mean = weights.mean(&[[1.0, 0.0, 3.0], [0.0, 2.0, 3.0]]).unwrap();
    let sum = left + right;
    let expected = [left / sum, 2.0 * right / sum, 3.0];
    for (found, expected) in mean.value.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{mean:?} {expected}");
    }
    assert!(mean.error < 1e-5);
}

/// Straight under the middle of a disk-like light, a gradient along it has its mean there; that of the squared distance
/// has a closed form: the integral of 2 r^3 / (1 + r^2)^2 over that of 2 r / (1 + r^2)^2.
#[test]
fn a_smooth_image_has_the_mean_of_its_integral() {
    const SIDES: usize = 400;
    let outline = (0..SIDES)
        .map(|i| {
            let angle = -2.0 * PI * i as f64 / SIDES as f64;
            [angle.cos(), angle.sin(), 1.0]
        })
        .collect();
    let light = Polygon::new(&[outline], false).unwrap();
    let frame = [[-1.0, -1.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let grid = TexelGrid::new(frame, [64, 64], TexelFilter::Bilinear).unwrap();
    let texels: Vec<[f32; 3]> = (0..64 * 64)
        .map(|i| {
            let at = |k: usize| (k as f64 + 0.5) / 32.0 - 1.0;
            let (x, y) = (at(i % 64), at(i / 64));
            [(1.0 + x) as f32, (x * x + y * y) as f32, 1.0]
        })
        .collect();
    let weighting = Weighting::Cosine {
        normal: [0.0, 0.0, 1.0],
    };
    let tolerance = Tolerance {
        relative: 1e-5,
        ..TIGHT
    };
    let weights = texel_weights(&light, &grid, [0.0; 3], &weighting, tolerance).unwrap();
    let mean = weights.mean(&texels).unwrap();
    let integral = 2_f64.ln() - 0.5;
    assert!((mean.value[0] - 1.0).abs() < 1e-4, "{mean:?}");
    // Bilinear texels overestimate a parabola by up to a quarter of a texel squared, twice.
    assert!((mean.value[1] - integral / 0.5).abs() < 1e-3, "{mean:?}");
    assert!((mean.value[2] - 1.0).abs() < 1e-12);
}

/// What is integrated is what the texture shows.
#[test]
fn weights_agree_with_the_textures_colors() {
    let (light, frame) = light();
    for filter in [TexelFilter::Nearest, TexelFilter::Bilinear] {
        let grid = TexelGrid::new(frame, [5, 7], filter).unwrap();
        let colors: Vec<[f32; 3]> = (0..35_u32)
            .map(|i| [0_u32, 1, 2].map(|k| (i.wrapping_mul(2_654_435_761) >> (8 + k) & 255) as f32))
            .collect();
        let texture = Texture::new(grid, colors.clone()).unwrap();
        let normal = [0.0, 0.0, 1.0];
        let point = [0.5, -0.3, 0.4];
        let weights = texel_weights(&light, &grid, point, &Weighting::Cosine { normal }, TIGHT);
        let mean = weights.unwrap().mean(&colors).unwrap().value;
        // Points of each triangle on a fine lattice.
        const STEPS: usize = 300;
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for [a, b, c] in light.triangle_vertices() {
            let area = (*b - *a).cross(*c - *a).length();
            for i in 0..STEPS * STEPS {
                let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
                let (u, v) = (at(i % STEPS), at(i / STEPS));
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let place = *a + (*b - *a) * u + (*c - *a) * v;
                let offset = place - DVec3::from(point);
                let weight = area * offset.z / offset.length_squared().powi(2);
                sum += weight * DVec3::from(texture.color(place.into()));
                total += weight;
            }
        }
        let expected = sum / total;
        let error = (expected - DVec3::from(mean)).abs().max_element();
        assert!(error < 0.1, "{mean:?} {expected}");
    }
}

#[test]
fn hostile_questions_have_answers() {
    let (light, frame) = light();
    let grid = TexelGrid::new(frame, [16, 16], TexelFilter::Bilinear).unwrap();
    let normal = [0.0, 0.0, 1.0];
    let ask =
        |point, weighting| texel_weights(&light, &grid, point, &weighting, Tolerance::default());
    let fault = ask([f64::NAN; 3], Weighting::Cosine { normal }).unwrap_err();
    assert!(matches!(fault, CubatureError::Point(_)), "{fault}");
    let fault = ask([0.0; 3], Weighting::Cosine { normal: [2.0; 3] }).unwrap_err();
    assert!(matches!(fault, CubatureError::NotUnit { .. }), "{fault}");
    for to_cosine in [
        [[0.0; 3]; 3],
        [[f64::NAN; 3]; 3],
        [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
    ] {
        let fault = ask([0.0; 3], Weighting::TransformedCosine { to_cosine, normal }).unwrap_err();
        assert!(matches!(fault, CubatureError::NoLobe(_)), "{fault}");
    }
    // On the light's plane nothing is seen, a nanometre before it a half space.
    let weights = ask([0.5, -0.8, 1.0], Weighting::Cosine { normal }).unwrap();
    assert_eq!(weights.total(), 0.0);
    let near = texel_weights(
        &light,
        &grid,
        [0.5, -0.8, 1.0 - 1e-9],
        &Weighting::Cosine { normal },
        Tolerance {
            relative: 1e-4,
            absolute: 0.0,
            ..Tolerance::default()
        },
    );
    assert!((near.unwrap().total() / PI - 1.0).abs() < 1e-4);
    // A few evaluations do not do.
    let few = Tolerance {
        max_evaluations: 20,
        ..Tolerance::default()
    };
    let fault =
        texel_weights(&light, &grid, [0.0; 3], &Weighting::Cosine { normal }, few).unwrap_err();
    assert!(
        matches!(fault, CubatureError::NotConverged { .. }),
        "{fault}"
    );
}
