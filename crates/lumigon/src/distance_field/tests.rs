//! Fields against their slow twin, and reflections against the uncached ones.

use alloc::vec;
use alloc::vec::Vec;

use super::*;
use crate::polygon::{PolygonLight, Sides};
use crate::reflection::{InclusionRule, reflected_inclusion};
use crate::vec3::Vec3;

fn light(loops: &[Vec<[f64; 2]>]) -> PolygonLight<f64> {
    let flat: Vec<Vec<[f64; 3]>> = loops
        .iter()
        .map(|l| l.iter().map(|&[x, y]| [x, y, 2.0]).collect())
        .collect();
    PolygonLight::new(&flat, Sides::Both).unwrap()
}

fn star(points: usize, inner: f64) -> Vec<[f64; 2]> {
    (0..2 * points)
        .map(|i| {
            let angle = core::f64::consts::PI * i as f64 / points as f64;
            let radius = if i % 2 == 0 { 1.0 } else { inner };
            [radius * libm::cos(angle), radius * libm::sin(angle)]
        })
        .collect()
}

fn comb(teeth: usize) -> Vec<[f64; 2]> {
    let mut outline = vec![[teeth as f64, -1.0], [teeth as f64, 0.0]];
    for i in (0..teeth).rev() {
        outline.push([i as f64 + 0.6, 4.0]);
        outline.push([i as f64, 0.0]);
    }
    outline.push([0.0, -1.0]);
    outline
}

fn shapes() -> Vec<PolygonLight<f64>> {
    let square = |r: f64| vec![[-r, -r], [r, -r], [r, r], [-r, r]];
    let hole = |r: f64| square(r).into_iter().rev().collect::<Vec<_>>();
    let mut repeated = star(5, 0.4);
    repeated.extend(vec![repeated[9]; 40]);
    vec![
        light(&[square(1.0)]),
        light(&[square(1.0), hole(0.5)]),
        light(&[star(7, 0.3)]),
        light(&[star(300, 0.98)]),
        light(&[comb(20)]),
        light(&[repeated]),
        // A sliver, and a triangle with a vertex on its own edge.
        light(&[vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1e-7]]]),
        light(&[vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.5]]]),
    ]
}

/// The definition: every texel against every edge.
fn brute_force(light: &PolygonLight<f64>, settings: DistanceFieldSettings) -> Vec<f64> {
    let n = settings.resolution() as usize;
    let phi = f64::from(settings.phi());
    let place = |i: usize| (2.0 * i as f64 + 1.0) / n as f64 - 1.0;
    let mut texels = Vec::new();
    for i in 0..n * n {
        let (x, y) = (place(i % n), place(i / n));
        let (mut odd, mut nearest) = (false, phi);
        for range in light.loop_ranges() {
            let vertices = &light.plane_offsets[range];
            let count = vertices.len();
            for (k, b) in vertices.iter().enumerate() {
                let a = vertices[(k + count - 1) % count].map(|v| v / phi);
                let b = b.map(|v| v / phi);
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let along = (x - a[0]) * dx + (y - a[1]) * dy;
                let t = (along / (dx * dx + dy * dy).max(1e-300)).clamp(0.0, 1.0);
                nearest = nearest.min(libm::hypot(x - a[0] - t * dx, y - a[1] - t * dy));
                if (a[1] <= y) != (b[1] <= y) && x < a[0] + dx * (y - a[1]) / dy {
                    odd = !odd;
                }
            }
        }
        texels.push(match (odd, settings.is_signed()) {
            (false, _) => nearest,
            (true, true) => -nearest,
            (true, false) => 0.0,
        });
    }
    texels
}

#[test]
fn every_texel_is_the_distance() {
    for (i, light) in shapes().iter().enumerate() {
        for (resolution, phi, signed) in [(64, 1.5, false), (64, 1.0, true), (4, 4.0, true)] {
            let settings = DistanceFieldSettings::new(resolution, phi, signed).unwrap();
            let field = DistanceField::new(light, settings);
            for (k, (&got, exact)) in field
                .level(0)
                .iter()
                .zip(brute_force(light, settings))
                .enumerate()
            {
                let error = (f64::from(got) - exact).abs();
                assert!(error < 1e-6, "shape {i}, texel {k}: {got} is not {exact}");
            }
        }
    }
}

#[test]
fn levels_are_means_and_the_last_is_the_mean_of_all() {
    let settings = DistanceFieldSettings::new(32, 1.5, false).unwrap();
    let field = DistanceField::new(&shapes()[2], settings);
    let mean = |texels: &[f32]| texels.iter().sum::<f32>() / texels.len() as f32;
    for level in 1..settings.levels() {
        assert!((mean(field.level(level)) - mean(field.level(0))).abs() < 1e-6);
    }
    assert_eq!(field.level(settings.levels()).len(), 0);
}

/// Everywhere a field is read continuously, whatever the width: no seam at the square's edge, at
/// texels or at levels.
#[test]
fn a_field_has_no_seams() {
    let settings = DistanceFieldSettings::new(64, 1.5, false).unwrap();
    for light in shapes() {
        let field = DistanceField::new(&light, settings);
        for width in [0.0, 1.0, 1.5, 3.0, 17.0, 64.0, 1e9, f64::NAN, -1.0] {
            for angle in 0..32 {
                let (s, c) = (
                    libm::sin(0.2 * f64::from(angle)),
                    libm::cos(0.2 * f64::from(angle)),
                );
                let mut before = field.fetch(0.0, 0.0, width);
                for i in 1..=4000 {
                    let r = f64::from(i) * 1e-3;
                    let distance = field.fetch(r * c, r * s, width);
                    // The distance itself has slope 1; bilinear interpolation has sqrt 2 at most.
                    let step = (distance - before).abs();
                    assert!(step < 2.3e-3, "{step} at {r}, width {width}");
                    before = distance;
                }
            }
        }
        for i in 0..1000 {
            let width = libm::exp2(f64::from(i) * 0.01);
            let finer = field.fetch(0.3, -0.9, width);
            let coarser = field.fetch(0.3, -0.9, width * 1.007);
            assert!(
                (finer - coarser).abs() < 2e-2 * (width / 64.0).max(1.0),
                "{finer} {coarser} at {width}"
            );
        }
    }
}

/// Bilinear interpolation and what lies beyond the square, against distances of finer fields.
#[test]
fn fetches_are_near_the_distance() {
    for light in shapes() {
        let read = DistanceField::new(&light, DistanceFieldSettings::default());
        let phi = f64::from(read.settings().phi());
        // Covers four radii; its texels' centres are where distances are exact.
        let wide = DistanceFieldSettings::new(64, 4.0, false).unwrap();
        for (i, exact) in brute_force(&light, wide).into_iter().enumerate() {
            let place = |i: usize| ((2.0 * i as f64 + 1.0) / 64.0 - 1.0) * 4.0 / phi;
            let got = read.fetch(place(i % 64), place(i / 64), 1.0) * phi;
            let exact = exact * 4.0;
            assert!((got - exact).abs() < 0.017 + 0.035 * exact, "{got} {exact}");
        }
    }
}

fn mirror(
    light: &PolygonLight<f64>,
    field: &DistanceField,
    x: f64,
    y: f64,
    smoothness: f32,
) -> [f64; 2] {
    let (center, _) = light.circumscribed_circle();
    let normal = Vec3::new(0.0, 0.0, 1.0);
    let point = Vec3::new(center.x, center.y, 0.0);
    let view = Vec3::new(-x, -y, 2.0).normalize_or_zero();
    let placed = PlacedDistanceField::own(field);
    let rule = InclusionRule::CrossingNumber;
    let smoothness = DistanceFieldSmoothness::fixed(smoothness).unwrap();
    [
        reflected_distance(light, placed, point, normal, view, 0.0, smoothness),
        reflected_inclusion(light, point, normal, view, rule),
    ]
}

#[test]
fn a_smooth_surface_is_a_mirror() {
    let light = light(&[star(5, 0.4)]);
    let field = DistanceField::new(&light, DistanceFieldSettings::default());
    let texel = 4.0 / 128.0;
    let (mut lit, mut dark) = (0, 0);
    for i in 0..1600 {
        let (x, y) = (
            f64::from(i % 40) * 0.055 - 1.04,
            f64::from(i / 40) * 0.055 - 1.03,
        );
        let [smooth, sharp] = mirror(&light, &field, x, y, 1e6);
        // Within a texel of the outline it is between both.
        let around = [(-1.5, 0.0), (1.5, 0.0), (0.0, -1.5), (0.0, 1.5)]
            .map(|(a, b)| mirror(&light, &field, x + a * texel, y + b * texel, 1e6)[1]);
        if around == [sharp; 4] {
            assert!(
                (smooth - sharp).abs() < 1e-6,
                "{smooth} {sharp} at {x}, {y}"
            );
            lit += usize::from(sharp > 0.0);
            dark += usize::from(sharp == 0.0);
        }
    }
    assert!(lit > 200 && dark > 400, "{lit} {dark}");
}

#[test]
fn reflections_fade_with_the_distance() {
    let light = light(&[star(4, 0.9)]);
    let field = DistanceField::new(&light, DistanceFieldSettings::default());
    for smoothness in [0.5, 3.0, 30.0] {
        let at = |x: f64| mirror(&light, &field, x, 0.0, smoothness)[0];
        assert_eq!(at(0.0), 1.0);
        for x in [1.5, 3.0, 20.0] {
            let exact = libm::pow((x - 1.0) / 2.0 + 1.0, -f64::from(smoothness));
            let relative = 0.02 * (1.0 + f64::from(smoothness));
            assert!((at(x) / exact - 1.0).abs() < relative, "{x} {smoothness}");
        }
    }
}

#[test]
fn it_is_dark_behind_and_below() {
    let square = vec![
        [-1.0, -1.0, 2.0],
        [1.0, -1.0, 2.0],
        [1.0, 1.0, 2.0],
        [-1.0, 1.0, 2.0],
    ];
    let light = PolygonLight::new(&[square], Sides::Front).unwrap();
    let field = DistanceField::new(&light, DistanceFieldSettings::default());
    let at = |point: [f64; 3], normal: [f64; 3], view: [f64; 3]| {
        let view = Vec3::from(view).normalize_or_zero();
        let placed = PlacedDistanceField::own(&field);
        reflected_distance(
            &light,
            placed,
            point.into(),
            normal.into(),
            view,
            0.1,
            Default::default(),
        )
    };
    // It emits upwards.
    let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let lit = at([0.0, 0.0, 4.0], down, [0.1, 0.0, -1.0]);
    assert!((0.8..=1.0).contains(&lit), "{lit}");
    assert_eq!(at([0.0, 0.0, 0.0], up, [0.1, 0.0, 1.0]), 0.0);
    assert_eq!(at([0.0, 0.0, 4.0], down, [0.1, 0.0, 1.0]), 0.0);
    assert_eq!(at([0.0, 0.0, 4.0], up, [0.1, 0.0, 1.0]), 0.0);
    // Along the plane; and far from the light hardly anything is left.
    assert_eq!(at([0.0, 0.0, 4.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.0);
    let grazing = at([0.0, 0.0, 4.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1e-9]);
    assert!((0.0..1e-9).contains(&grazing), "{grazing}");
}
