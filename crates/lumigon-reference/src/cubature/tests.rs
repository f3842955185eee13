use std::f64::consts::PI;

use serde_json::Value;

use super::*;

fn lines(name: &str) -> Vec<Value> {
    let path = format!("{}/../../tests/truth/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn read<T: serde_json::value::Index>(line: &Value, key: T) -> f64 {
    line[key].as_f64().unwrap()
}

fn triple(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| value[i].as_f64().unwrap())
}

fn light(line: &Value) -> Polygon {
    let loops = line["loops"].as_array().unwrap();
    let vertices = |l: &Value| l.as_array().unwrap().iter().map(triple).collect();
    Polygon::new(&loops.iter().map(vertices).collect::<Vec<_>>(), false).unwrap()
}

#[test]
fn irradiance_matches_every_line_of_truth() {
    let lines = lines("lambert.jsonl");
    assert_eq!(lines.len(), 240);
    let mut worst = 0.0_f64;
    for (number, line) in lines.iter().enumerate() {
        let tolerance = Tolerance::default();
        let result = irradiance(
            &light(line),
            triple(&line["point"]),
            triple(&line["normal"]),
            tolerance,
        )
        .unwrap();
        let error = (result.value - read(line, "truth")).abs();
        assert!(
            error < 1e-8,
            "line {}: {result:?}, truth {}",
            number + 1,
            line["truth"]
        );
        worst = worst.max(error);
    }
    println!("worst {worst:e}");
}

#[test]
fn ggx_matches_every_line_of_truth() {
    let lines = lines("ggx.jsonl");
    assert_eq!(lines.len(), 800);
    let mut worst = 0.0_f64;
    for (number, line) in lines.iter().enumerate() {
        let [point, normal, view] = ["point", "normal", "view"].map(|key| triple(&line[key]));
        let alpha = read(line, "perceptual_roughness").powi(2);
        let result = ggx(
            &light(line),
            point,
            normal,
            view,
            alpha,
            Tolerance::default(),
        )
        .unwrap();
        let error = (result.value - read(line, "truth"))
            .abs()
            .max((result.schlick - read(line, "truth_schlick")).abs());
        assert!(
            error < 1e-6,
            "line {}: {result:?}, truth {} {}",
            number + 1,
            line["truth"],
            line["truth_schlick"]
        );
        worst = worst.max(error);
    }
    println!("worst {worst:e}");
}

/// The reflected radiance by a plain sum over the light's area, for a BRDF with any number of parts.
fn sum_over_area<const N: usize>(
    light: &Polygon,
    point: [f64; 3],
    normal: [f64; 3],
    brdf: impl Fn([f64; 3]) -> [f64; N],
) -> [f64; N] {
    let (point, normal) = (DVec3::from(point), DVec3::from(normal));
    let n = 400;
    let mut sums = [0.0; N];
    for [a, b, c] in light.triangle_vertices() {
        let vector_area = 0.5 * (b - a).cross(c - a) / f64::from(n * n);
        let mut add = |u: f64, v: f64| {
            let offset = a + u / f64::from(n) * (b - a) + v / f64::from(n) * (c - a) - point;
            let r2 = offset.length_squared();
            let direction = offset / r2.sqrt();
            let solid_angle = -vector_area.dot(direction) / r2;
            let cosine = normal.dot(direction).max(0.0);
            for (sum, f) in sums.iter_mut().zip(brdf(direction.into())) {
                *sum += f * cosine * solid_angle;
            }
        };
        for i in 0..n {
            for j in 0..n - i {
                let (x, y) = (f64::from(i), f64::from(j));
                add(x + 1.0 / 3.0, y + 1.0 / 3.0);
                if j < n - i - 1 {
                    add(x + 2.0 / 3.0, y + 2.0 / 3.0);
                }
            }
        }
    }
    sums
}

/// Asks a lobe for every line of its truth values, and a plain sum over the light's area for every nineteenth.
fn check_lobe<const N: usize>(
    file: &str,
    truths: [&str; N],
    cubature: impl Fn(&Value, &Polygon) -> [f64; N],
    brdf: impl Fn(&Value, [f64; 3]) -> [f64; N],
) {
    let lines = lines(file);
    assert_eq!(lines.len(), 200);
    for (number, line) in lines.iter().enumerate() {
        let light = light(line);
        let values = cubature(line, &light);
        let sums = (number % 19 == 0).then(|| {
            let [point, normal] = ["point", "normal"].map(|key| triple(&line[key]));
            sum_over_area(&light, point, normal, |l| brdf(line, l))
        });
        for (i, value) in values.into_iter().enumerate() {
            let truth = read(line, truths[i]);
            let name = format!("{file}, line {}, {}", number + 1, truths[i]);
            assert!((value - truth).abs() < 1e-7, "{name}: {value} {truth}");
            if let Some(sum) = sums.map(|sums| sums[i]) {
                // What the sum itself is good for.
                let error = (sum - truth).abs();
                assert!(error < 2e-4 * truth + 1e-7, "{name}: sum {sum} {truth}");
            }
        }
    }
}

/// Enough for [`check_lobe`], and much cheaper than the default.
const COARSE: Tolerance = Tolerance {
    absolute: 1e-8,
    relative: 0.0,
    max_evaluations: 2_000_000,
};

#[test]
fn anisotropic_ggx_matches_truth_and_a_plain_sum() {
    let surface = |line: &Value| {
        let vectors = ["normal", "tangent", "view"].map(|key| triple(&line[key]));
        (vectors, [0, 1].map(|i| line["alpha"][i].as_f64().unwrap()))
    };
    check_lobe(
        "ggx_anisotropic.jsonl",
        ["truth", "truth_schlick"],
        |line, light| {
            let ([normal, tangent, view], alpha) = surface(line);
            let point = triple(&line["point"]);
            let result = ggx_anisotropic(light, point, normal, tangent, view, alpha, COARSE);
            let result = result.unwrap();
            [result.value, result.schlick]
        },
        |line, l| {
            let ([normal, tangent, view], alpha) = surface(line);
            let f = crate::ggx_anisotropic_brdf(normal, tangent, view, l, alpha);
            let h_dot_v = (DVec3::from(view) + DVec3::from(l))
                .normalize()
                .dot(l.into());
            [f, f * (1.0 - h_dot_v).powi(5)]
        },
    );
}

#[test]
fn charlie_matches_truth_and_a_plain_sum() {
    check_lobe(
        "charlie.jsonl",
        ["truth"],
        |line, light| {
            let [point, normal, view] = ["point", "normal", "view"].map(|key| triple(&line[key]));
            let result = charlie(light, point, normal, view, read(line, "alpha"), COARSE);
            [result.unwrap().value]
        },
        |line, l| {
            let [normal, view] = ["normal", "view"].map(|key| triple(&line[key]));
            [crate::charlie_brdf(normal, view, l, read(line, "alpha"))]
        },
    );
}

#[test]
fn eon_matches_truth_and_a_plain_sum() {
    let roughness = |line: &Value| read(line, "diffuse_roughness");
    check_lobe(
        "eon.jsonl",
        ["truth_single", "truth_multiple"],
        |line, light| {
            let [point, normal, view] = ["point", "normal", "view"].map(|key| triple(&line[key]));
            let result = eon(light, point, normal, view, roughness(line), COARSE).unwrap();
            [result.single, result.multiple]
        },
        |line, l| {
            let [normal, view] = ["normal", "view"].map(|key| triple(&line[key]));
            let brdf = crate::eon_brdf(normal, view, l, roughness(line));
            [brdf.single, brdf.multiple]
        },
    );
}

#[test]
fn eon_of_albedo_one_reflects_everything() {
    for cos_theta_view in [1e-4, 0.01, 0.3, 0.9, 1.0] {
        for diffuse_roughness in [0.0, 0.1, 0.5, 1.0] {
            let albedo = eon_albedo(cos_theta_view, diffuse_roughness, COARSE).unwrap();
            let total = albedo.with_albedo(1.0, diffuse_roughness);
            let case = format!("{cos_theta_view} {diffuse_roughness}: {albedo:?}");
            assert!((total - 1.0).abs() < 1e-7, "{case}: {total}");
        }
    }
}

#[test]
fn albedos_add_up_from_a_sky_in_pieces() {
    let (x, y, far) = (-0.37, 0.11, 1e7);
    let (normal, tangent) = (UP, [0.6, 0.8, 0.0]);
    for degrees in [0.0_f64, 50.0, 85.0] {
        let view = view_at(degrees);
        // In the frame of the tangent.
        let turned = [0.6 * view[0], -0.8 * view[0], view[2]];
        for alpha in [[1e-3, 1.0], [0.3, 0.05], [0.2, 0.2], [1.0, 1.0]] {
            let mut sums = [0.0; 4];
            for (xs, ys) in [
                ([-far, x], [-far, y]),
                ([x, far], [-far, y]),
                ([-far, x], [y, far]),
                ([x, far], [y, far]),
            ] {
                let light = Polygon::new(&[rectangle(xs, ys, 1.0)], false).unwrap();
                let ggx =
                    ggx_anisotropic(&light, ORIGIN, normal, tangent, view, alpha, COARSE).unwrap();
                let charlie = charlie(&light, ORIGIN, normal, view, alpha[0], COARSE).unwrap();
                let eon = eon(&light, ORIGIN, normal, view, alpha[0], COARSE).unwrap();
                let parts = [ggx.value, ggx.schlick, charlie.value, eon.single];
                for (sum, part) in sums.iter_mut().zip(parts) {
                    *sum += part;
                }
            }
            let ggx = ggx_anisotropic_albedo(turned, alpha, COARSE).unwrap();
            let charlie = charlie_albedo(view[2], alpha[0], COARSE).unwrap().value;
            let single = eon_albedo(view[2], alpha[0], COARSE).unwrap().single;
            for (sum, albedo) in sums
                .into_iter()
                .zip([ggx.value, ggx.schlick, charlie, single])
            {
                assert!(
                    (sum - albedo).abs() < 3e-7,
                    "{degrees} {alpha:?}: {sum} {albedo}"
                );
            }
            if alpha[0] == alpha[1] {
                let isotropic = ggx_albedo(view[2], alpha[0], COARSE).unwrap();
                assert!((isotropic.value - ggx.value).abs() < 3e-8);
                assert!((isotropic.schlick - ggx.schlick).abs() < 3e-8);
            }
        }
    }
}

fn rectangle(x: [f64; 2], y: [f64; 2], height: f64) -> Vec<[f64; 3]> {
    // Facing down: counter-clockwise seen from below.
    vec![
        [x[0], y[0], height],
        [x[0], y[1], height],
        [x[1], y[1], height],
        [x[1], y[0], height],
    ]
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];
const ORIGIN: [f64; 3] = [0.0; 3];

fn view_at(degrees: f64) -> [f64; 3] {
    let theta = degrees.to_radians();
    [theta.sin(), 0.0, theta.cos()]
}

/// Form factor of a rectangle seen from a parallel element below its corner (a textbook formula).
fn corner_form_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / (2.0 * PI)
}

#[test]
fn parallel_rectangles_at_any_distance_have_the_textbook_form_factor() {
    for height in [1e-9, 1e-5, 0.1, 1.0, 1e3, 1e6] {
        for (a, b) in [(1.0, 1.0), (1.0, 1e-6), (3.0, 0.02)] {
            let light = Polygon::new(&[rectangle([0.0, a], [0.0, b], height)], false).unwrap();
            let tolerance = Tolerance {
                absolute: 0.0,
                relative: 1e-9,
                ..Tolerance::default()
            };
            let result = form_factor(&light, ORIGIN, UP, tolerance).unwrap();
            let exact = corner_form_factor(a, b, height);
            assert!(
                (result.value - exact).abs() < 2e-9 * exact,
                "{height} {a} {b}: {result:?} {exact}"
            );
        }
    }
}

#[test]
fn solid_angle_and_light_vector_agree_with_symmetry() {
    // A cube's face seen from its centre, from one side or both.
    let cube = rectangle([-1.0, 1.0], [-1.0, 1.0], 1.0);
    let below = Polygon::new(std::slice::from_ref(&cube), false).unwrap();
    let both = Polygon::new(&[cube], true).unwrap();
    let tolerance = Tolerance::default();
    for (light, point) in [(&below, ORIGIN), (&both, ORIGIN), (&both, [0.0, 0.0, 2.0])] {
        let omega = solid_angle(light, point, tolerance).unwrap();
        assert!(
            (omega.value - 4.0 * PI / 6.0).abs() <= omega.error.max(1e-13),
            "{omega:?}"
        );
        let vector = light_vector(light, point, tolerance).unwrap();
        let face = 4.0 * PI * corner_form_factor(1.0, 1.0, 1.0) * (1.0 - point[2]);
        assert!(
            (vector.value[2] - face).abs() < 1e-9 && vector.value[0].abs() < 1e-9,
            "{vector:?} {face}"
        );
    }
    assert_eq!(
        solid_angle(&below, [0.0, 0.0, 2.0], tolerance)
            .unwrap()
            .value,
        0.0
    );
    assert_eq!(
        solid_angle(&both, [0.0, 0.0, 1.0], tolerance)
            .unwrap()
            .value,
        0.0
    );
    // A hair below the middle of a face the light fills the hemisphere.
    let near = solid_angle(&below, [0.3, 0.0, 1.0 - 1e-10], tolerance).unwrap();
    assert!((near.value - 2.0 * PI).abs() < 1e-8, "{near:?}");
}

#[test]
fn horizon_halves_a_symmetric_light() {
    let light = Polygon::new(&[rectangle([-1.0, 1.0], [-2.0, 2.0], 0.5)], false).unwrap();
    let result = irradiance(&light, ORIGIN, [1.0, 0.0, 0.0], Tolerance::default()).unwrap();
    let half = Polygon::new(&[rectangle([0.0, 1.0], [-2.0, 2.0], 0.5)], false).unwrap();
    let vector = light_vector(&half, ORIGIN, Tolerance::default()).unwrap();
    assert!((result.value - vector.value[0]).abs() < 2e-9);
}

/// The albedo by a plain product rule over half vectors, tan theta = alpha t / (1 - t).
fn albedo_over_half_vectors(view: DVec3, alpha: f64) -> [f64; 2] {
    let n = 2000;
    let mut sums = [0.0; 2];
    for i in 0..n {
        let t = (f64::from(i) + 0.5) / f64::from(n);
        let tangent = alpha * t / (1.0 - t);
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        let sine = tangent * cosine;
        let d_theta = cosine * cosine * alpha / ((1.0 - t) * (1.0 - t)) / f64::from(n);
        for j in 0..n {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(n);
            let h = DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
            let h_dot_v = h.dot(view);
            let light = 2.0 * h_dot_v * h - view;
            if h_dot_v > 0.0 && light.z > 0.0 {
                let f = crate::ggx_brdf(UP, view.into(), light.normalize().into(), alpha);
                let value = f * light.z * 4.0 * h_dot_v * sine * d_theta * 2.0 * PI / f64::from(n);
                sums[0] += value;
                sums[1] += value * (1.0 - h_dot_v).powi(5);
            }
        }
    }
    sums
}

#[test]
fn albedo_agrees_with_integration_over_half_vectors() {
    for (degrees, alpha) in [
        (0.0, 1.0),
        (40.0, 0.3),
        (80.0, 0.05),
        (88.0, 0.0025),
        (85.0, 0.5),
    ] {
        let view = DVec3::from(view_at(degrees));
        let result = ggx_albedo(view.z, alpha, Tolerance::default()).unwrap();
        let [value, schlick] = albedo_over_half_vectors(view, alpha);
        assert!(
            (result.value - value).abs() < 1e-5 && (result.schlick - schlick).abs() < 1e-5,
            "{degrees} {alpha}: {result:?} {value} {schlick}"
        );
        assert!(result.value <= 1.0);
    }
}

#[test]
fn sharp_and_grazing_lobes_converge_and_add_up() {
    for alpha in [1e-4, 0.0025, 0.01, 0.2, 1.0] {
        for degrees in [0.0, 45.0, 80.0, 88.0, 89.9, 89.99] {
            let view = view_at(degrees);
            // What rounding of directions leaves of a lobe that is narrower still.
            let absolute = (2e-16 / (alpha * view[2])).max(1e-9);
            let tolerance = Tolerance {
                absolute,
                ..Tolerance::default()
            };
            let albedo = ggx_albedo(view[2], alpha, tolerance).unwrap();
            // A ceiling that hides the sky, cut in four at an arbitrary place.
            let (x, y, far) = (-0.37, 0.11, 1e7);
            let mut sum = [0.0; 2];
            for (xs, ys) in [
                ([-far, x], [-far, y]),
                ([x, far], [-far, y]),
                ([-far, x], [y, far]),
                ([x, far], [y, far]),
            ] {
                let light = Polygon::new(&[rectangle(xs, ys, 1.0)], false).unwrap();
                let part = ggx(&light, ORIGIN, UP, view, alpha, tolerance).unwrap();
                sum[0] += part.value;
                sum[1] += part.schlick;
            }
            let error = (sum[0] - albedo.value)
                .abs()
                .max((sum[1] - albedo.schlick).abs());
            // Five estimated errors, the sliver of sky that the ceiling leaves open, and rounding of its far corners.
            assert!(
                error < 5.0 * absolute + 1e-8,
                "{alpha} {degrees}: {albedo:?} {sum:?}"
            );
        }
    }
}

#[test]
fn hostile_arguments_are_named() {
    let light = Polygon::new(&[rectangle([0.0, 1.0], [0.0, 1.0], 1.0)], false).unwrap();
    let tolerance = Tolerance::default();
    assert!(matches!(
        irradiance(&light, [f64::NAN, 0.0, 0.0], UP, tolerance),
        Err(CubatureError::Point(_))
    ));
    let error = irradiance(&light, ORIGIN, [0.0, 0.0, 2.0], tolerance).unwrap_err();
    assert!(
        error.to_string().contains("normal") && error.to_string().contains("length 2"),
        "{error}"
    );
    let nan = [f64::NAN; 3];
    assert!(matches!(
        ggx(&light, ORIGIN, UP, nan, 0.5, tolerance),
        Err(CubatureError::NotUnit { name: "view", .. })
    ));
    for alpha in [0.0, -1.0, f64::NAN, 1.5] {
        assert!(matches!(
            ggx(&light, ORIGIN, UP, UP, alpha, tolerance),
            Err(CubatureError::Alpha(_))
        ));
    }
    for alpha in [[0.0, 0.5], [0.5, f64::NAN], [0.5, 2.0]] {
        let result = ggx_anisotropic(&light, ORIGIN, UP, [1.0, 0.0, 0.0], UP, alpha, tolerance);
        assert!(matches!(result, Err(CubatureError::Alpha(_))));
    }
    let leaning = DVec3::new(1.0, 0.0, 0.1).normalize().into();
    let error = ggx_anisotropic(&light, ORIGIN, UP, leaning, UP, [0.5; 2], tolerance).unwrap_err();
    assert!(error.to_string().contains("not orthogonal"), "{error}");
    for alpha in [0.0, f64::NAN, 1.1] {
        assert!(matches!(
            charlie(&light, ORIGIN, UP, UP, alpha, tolerance),
            Err(CubatureError::Alpha(_))
        ));
    }
    for roughness in [-0.1, f64::NAN, 1.1] {
        assert!(matches!(
            eon(&light, ORIGIN, UP, UP, roughness, tolerance),
            Err(CubatureError::DiffuseRoughness(_))
        ));
    }
    // From below there is nothing to see, whatever the lobe.
    let below = [0.6, 0.0, -0.8];
    assert_eq!(
        charlie(&light, ORIGIN, UP, below, 0.5, tolerance)
            .unwrap()
            .value,
        0.0
    );
    assert_eq!(
        eon(&light, ORIGIN, UP, below, 0.5, tolerance)
            .unwrap()
            .single,
        0.0
    );
    assert!(matches!(
        ggx_albedo(f64::NAN, 0.5, tolerance),
        Err(CubatureError::CosThetaView(_))
    ));
    let hopeless = Tolerance {
        absolute: 0.0,
        relative: 1e-30,
        max_evaluations: 10_000,
    };
    assert!(matches!(
        ggx(&light, ORIGIN, UP, view_at(70.0), 0.1, hopeless),
        Err(CubatureError::NotConverged { .. })
    ));
}

#[test]
fn near_degenerate_lights_give_finite_light_in_range_that_adds_up() {
    use crate::sampling::Random;
    let mut random = Random::new(11, 0);
    let mut pick = |values: &[f64]| values[(random.uniform() * values.len() as f64) as usize];
    let coordinates = [-1.0, -0.5, -1e-9, 0.0, 0.0, 1e-9, 0.3, 1.0];
    let tolerance = Tolerance::default();
    let (mut tried, mut lit, mut cut) = (0, 0, 0);
    while tried < 3000 {
        // A quad across the horizon, through the zenith, in the light's plane, sliver, far or near.
        let size = pick(&[1e-160, 1.0, 1.0, 1.0]);
        let height = pick(&[0.0, 1e-17, 1e-12, 1e-6, 1e-6, 0.1, 1.0, 1e6]) * size;
        let flat = [0; 4].map(|_| [0; 2].map(|_| size * pick(&coordinates)));
        let upright = pick(&[0.0, 1.0]) > 0.5;
        let lift = |[x, y]: [f64; 2]| {
            if upright {
                [height, x, y]
            } else {
                [x, -y, height]
            }
        };
        let corners = flat.map(lift);
        let Ok(whole) = Polygon::new(&[corners.to_vec()], true) else {
            continue;
        };
        tried += 1;
        let alpha = pick(&[0.0025, 0.1, 1.0]);
        let view = view_at(pick(&[0.0, 60.0, 88.0]));
        let case = format!("{corners:?} {alpha} {view:?}");
        let value = |light: &Polygon| {
            let e = irradiance(light, ORIGIN, UP, tolerance).map(|e| e.value);
            let g = ggx(light, ORIGIN, UP, view, alpha, tolerance);
            if height > 0.0 && height < 1e-7 * size {
                // Closer to the plane than rounding of the directions along it can tell.
                return [e.unwrap_or(0.0), g.map_or(0.0, |g| g.value), 0.0];
            }
            let (e, g) = (
                e.unwrap_or_else(|e| panic!("{case}: {e}")),
                g.unwrap_or_else(|e| panic!("{case}: {e}")),
            );
            [e, g.value, g.schlick]
        };
        let [e, g, schlick] = value(&whole);
        assert!(
            (0.0..=PI + 1e-8).contains(&e) && (0.0..=1.0 + 1e-8).contains(&g),
            "{case}: {e} {g}"
        );
        assert!(schlick <= g + 1e-9, "{case}: {schlick} {g}");
        lit += usize::from(e > 0.0);
        // Cut in two by hand where that is a cut, the same light is left.
        let halves =
            [[0, 1, 2], [0, 2, 3]].map(|t| Polygon::new(&[t.map(|i| corners[i]).to_vec()], true));
        let [Ok(a), Ok(b)] = &halves else { continue };
        let aligned = DVec3::from(a.normal()).dot(b.normal().into()) > 0.0;
        if aligned && height >= 1e-7 * size {
            cut += 1;
            let (a, b) = (value(a), value(b));
            for (i, total) in [e, g, schlick].into_iter().enumerate() {
                assert!(
                    (a[i] + b[i] - total).abs() < 5e-9,
                    "{case}: {a:?} + {b:?}, {total}"
                );
            }
        }
    }
    assert!(lit > 500 && cut > 300, "{lit} {cut}");
}

#[test]
fn near_degenerate_lights_keep_every_lobe_in_range() {
    use crate::sampling::Random;
    let mut random = Random::new(12, 0);
    let mut pick = |values: &[f64]| values[(random.uniform() * values.len() as f64) as usize];
    let coordinates = [-1.0, -0.5, -1e-9, 0.0, 0.0, 1e-9, 0.3, 1.0];
    let tolerance = Tolerance {
        absolute: 1e-5,
        ..Tolerance::default()
    };
    let (mut tried, mut lit) = (0, 0);
    while tried < 300 {
        let height = pick(&[0.0, 1e-6, 0.1, 1.0, 1e6]);
        let flat = [0; 4].map(|_| [0; 2].map(|_| pick(&coordinates)));
        let upright = pick(&[0.0, 1.0]) > 0.5;
        let corners = flat.map(|[x, y]| match upright {
            true => [height, x, y],
            false => [x, -y, height],
        });
        let Ok(light) = Polygon::new(&[corners.to_vec()], true) else {
            continue;
        };
        tried += 1;
        let view = view_at(pick(&[0.0, 60.0, 88.0]));
        let (alpha, other) = (pick(&[0.0025, 0.1, 1.0]), pick(&[0.01, 1.0]));
        let tangent = [0.6, 0.8, 0.0];
        let case = format!("{corners:?} {view:?} {alpha} {other}");
        let ggx = ggx_anisotropic(&light, ORIGIN, UP, tangent, view, [alpha, other], tolerance);
        let ggx = ggx.unwrap_or_else(|e| panic!("{case}: ggx, {e}"));
        let charlie = charlie(&light, ORIGIN, UP, view, alpha, tolerance);
        let charlie = charlie.unwrap_or_else(|e| panic!("{case}: charlie, {e}"));
        let eon = eon(&light, ORIGIN, UP, view, alpha, tolerance);
        let eon = eon.unwrap_or_else(|e| panic!("{case}: eon, {e}"));
        assert!((0.0..1.0 + 1e-4).contains(&ggx.value), "{case}: {ggx:?}");
        assert!(
            (0.0..=ggx.value + 1e-4).contains(&ggx.schlick),
            "{case}: {ggx:?}"
        );
        // The narrowest sheen's albedo at 88 degrees is below 4.
        assert!((0.0..4.0).contains(&charlie.value), "{case}: {charlie:?}");
        assert!(
            (0.0..1.0 + 1e-4).contains(&(eon.single + eon.multiple)),
            "{case}: {eon:?}"
        );
        lit += usize::from(eon.single > 0.0);
    }
    assert!(lit > 100, "{lit}");
}
