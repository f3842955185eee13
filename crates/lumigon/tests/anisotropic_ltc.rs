//! Lobes of any map of positive determinant, clipped by two planes, against a conventional clip at
//! one plane after the other.

mod polygons;

use lumigon::{
    AnisotropicLtc, Ltc, PolygonLight, PreparedLtc, Sides, Vec3, clip_loop, form_factor,
    ltc_form_factor,
};
use polygons::{KINDS, Placed, Random, Vector, array, edge_sum};

type Rows = [Vector; 3];

fn apply(rows: &Rows, v: Vector) -> Vector {
    Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v))
}

fn determinant(rows: &Rows) -> f64 {
    rows[0].dot(rows[1].cross(rows[2]))
}

/// Any map that stretches no more than `stretch` times as far one way as another.
fn any_map(stretch: f64, random: &mut Random) -> Rows {
    let turned = |random: &mut Random| {
        let z = random.direction();
        let (s, t) = z.orthonormal_basis();
        let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
        [s * cos + t * sin, t * cos - s * sin, z]
    };
    let (outer, inner) = (turned(random), turned(random));
    let stretched = inner.map(|row| row * random.log_range(1.0, stretch));
    let columns = |x: &dyn Fn(Vector) -> f64| outer.map(x);
    let [x, y, z] = [
        columns(&|row| row.x),
        columns(&|row| row.y),
        columns(&|row| row.z),
    ];
    [x, y, z].map(|weights| {
        stretched[0] * weights[0] + stretched[1] * weights[1] + stretched[2] * weights[2]
    })
}

/// A map whose lobe ends at the surface's own horizon, or nearly.
fn map_onto_the_surface(normal: Vector, tilt: f64, random: &mut Random) -> Rows {
    let [x, y, _] = any_map(2.0, random);
    let z = (normal + random.direction() * tilt) * random.log_range(0.01, 10.0);
    let rows = [x, y, z];
    if determinant(&rows) < 0.0 {
        [y, x, z]
    } else {
        rows
    }
}

/// Loops clipped at the planes with the given normals, one after the other, and mapped.
fn twin(loops: &[Vec<Vector>], planes: &[Vector], rows: &Rows) -> f64 {
    let clipped: Vec<Vec<_>> = loops
        .iter()
        .map(|vertices| {
            let above = planes
                .iter()
                .fold(vertices.clone(), |kept, &plane| clip_loop(&kept, plane));
            above.iter().map(|&v| apply(rows, v)).collect()
        })
        .collect();
    edge_sum(&clipped)
}

/// A point on the light's front side, and a normal; in every other case the horizon passes through
/// the light.
fn scene(case: usize, random: &mut Random) -> (Placed, Vector, Vector) {
    let placed = Placed::random(case % KINDS, random);
    let height = random.log_range(0.1, 5.0);
    let point = placed.at(random.range(-2.0, 2.0), random.range(-2.0, 2.0), height);
    let normal = if case.is_multiple_of(2) {
        let inside = placed.at(random.range(-0.6, 0.6), random.range(-0.6, 0.6), 0.0);
        let (s, t) = (inside - point).normalize_or_zero().orthonormal_basis();
        let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
        s * sin + t * cos
    } else {
        random.direction()
    };
    (placed, point, normal)
}

#[test]
fn form_factor_is_the_twice_clipped_edge_sum() {
    let mut random = Random::new(31);
    let (mut worst, mut lit, mut cut_by_both) = (0.0_f64, 0, 0);
    for case in 0..40_000 {
        let (placed, point, normal) = scene(case, &mut random);
        let rows = match case % 4 {
            0 => map_onto_the_surface(normal, 0.0, &mut random),
            1 => {
                let tilt = random.log_range(1e-18, 1e-3);
                map_onto_the_surface(normal, tilt, &mut random)
            }
            _ => any_map(5.0, &mut random),
        };
        let prepared = PreparedLtc::from_world_to_cosine(rows, normal);
        let got = ltc_form_factor(&placed.light(Sides::Front), point, &prepared);
        let loops = placed.loops_from(point);
        let expected = twin(&loops, &[normal, rows[2]], &rows);
        let error = (got - expected).abs();
        worst = worst.max(error);
        assert!(
            error < 1e-12,
            "{got} is not {expected}: {case} {rows:?} {point:?} {normal:?} {placed:#?}"
        );
        lit += usize::from(got > 1e-4);
        let without_horizon = twin(&loops, &[rows[2]], &rows);
        let without_lobe = twin(&loops, &[normal], &rows);
        let cut = (without_horizon - got)
            .abs()
            .min((without_lobe - got).abs());
        cut_by_both += usize::from(got > 1e-4 && cut > 1e-4);
    }
    println!("worst error {worst:e}; {lit} lit, {cut_by_both} cut by both planes");
    assert!(lit > 5_000 && cut_by_both > 1_000, "{lit} {cut_by_both}");
}

/// The general map and the one that only leans agree, and so do the frames they are told in.
#[test]
fn an_isotropic_lobe_is_a_special_case() {
    let mut random = Random::new(32);
    for case in 0..5_000 {
        let (placed, point, normal) = scene(case, &mut random);
        let view = random.direction_above(normal);
        let (m11, m33) = (random.log_range(0.3, 3.0), random.log_range(0.3, 3.0));
        let m13 = random.range(-1.0, 1.0) * m11;
        let m31 = match case % 3 {
            0 => 0.0,
            _ => random.range(-0.9, 0.9) * m11 * m33 / m13.abs().max(0.1),
        };
        let lobe = Ltc {
            shading_to_cosine: [m11, m13, m31, m33],
            amplitude: 1.0,
            schlick: 0.0,
        };
        let tangent = (view - normal * normal.dot(view)).normalize_or_zero();
        let bitangent = normal.cross(tangent);
        let general = AnisotropicLtc {
            shading_to_cosine: [[m11, 0.0, m13], [0.0, 1.0, 0.0], [m31, 0.0, m33]],
            amplitude: 1.0,
            schlick: 0.0,
        };
        let light = placed.light(Sides::Front);
        let special = PreparedLtc::new(&lobe, normal, view);
        let expected = ltc_form_factor(&light, point, &special);
        let prepared = general.prepare(tangent, bitangent, normal);
        // Its rows, taken out and put in again with another scale, are the same lobe.
        let scale = random.log_range(1e-20, 1e20);
        let rows = special.world_to_cosine().map(|row| row * scale);
        let again = PreparedLtc::from_world_to_cosine(rows, normal);
        for lobe in [prepared, again] {
            let got = ltc_form_factor(&light, point, &lobe);
            assert!(
                (got - expected).abs() < 1e-12,
                "{got} {expected}: {case} {general:?} {normal:?} {view:?} {point:?} {placed:#?}"
            );
        }
    }
}

#[test]
fn the_identity_is_lamberts_cosine_in_any_frame() {
    let mut random = Random::new(33);
    for case in 0..5_000 {
        let (placed, point, normal) = scene(case, &mut random);
        // Along an axis nothing rounds, and the planes coincide to the last bit.
        let normal = match case % 3 {
            0 => random.axis(),
            _ => normal,
        };
        let (tangent, bitangent) = normal.orthonormal_basis();
        let rows = [tangent, bitangent, normal];
        let light = placed.light(Sides::Front);
        let prepared = PreparedLtc::from_world_to_cosine(rows, normal);
        let got = ltc_form_factor(&light, point, &prepared);
        let lambert = form_factor(&light, point, normal);
        assert!((got - lambert).abs() < 1e-13, "{got} {lambert} {placed:#?}");
    }
}

/// A light behind everything that the lobe can see: the share above the horizon. The light is a
/// square that nearly fills the half space of the surface.
#[test]
fn share_above_horizon_is_what_the_hemisphere_holds() {
    let mut random = Random::new(34);
    let far = 1e7;
    let square = [[-far, -far], [-far, far], [far, far], [far, -far]];
    let light = PolygonLight::new(&[square.map(|[x, y]| [x, y, 1.0]).to_vec()], Sides::Front);
    let light = light.unwrap();
    let up = Vec3::new(0.0, 0.0, 1.0);
    let (x, y) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0));
    for _ in 0..500 {
        let rows = any_map(5.0, &mut random);
        let lobe = AnisotropicLtc {
            shading_to_cosine: rows.map(array),
            amplitude: 1.0,
            schlick: 0.0,
        };
        let share = lobe.share_above_horizon();
        let got = ltc_form_factor(&light, Vec3::default(), &lobe.prepare(x, y, up));
        // A strip of the hemisphere 1e-7 high stays dark.
        assert!((got - share).abs() < 1e-5, "{got} {share} {rows:?}");
        assert!((0.0..=1.0).contains(&share));
    }
}

#[test]
fn density_integrates_to_one() {
    let mut random = Random::new(35);
    for _ in 0..20 {
        let rows = any_map(2.0, &mut random);
        let lobe = AnisotropicLtc {
            shading_to_cosine: rows.map(array),
            amplitude: 1.0,
            schlick: 0.0,
        };
        // Archimedes: uniform in z and azimuth. The kink where the lobe ends limits the order.
        let (heights, azimuths) = (600, 600);
        let mut sum = 0.0;
        for i in 0..heights {
            let z = -1.0 + (f64::from(i) + 0.5) * 2.0 / f64::from(heights);
            let r = (1.0 - z * z).sqrt();
            for j in 0..azimuths {
                let azimuth = (f64::from(j) + 0.5) / f64::from(azimuths) * std::f64::consts::TAU;
                sum += lobe.density(Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z));
            }
        }
        let area = 4.0 * std::f64::consts::PI / f64::from(heights * azimuths);
        assert!((sum * area - 1.0).abs() < 1e-3, "{} {rows:?}", sum * area);
    }
}

/// Nothing from below the surface leaks in, whatever of the lobe is there: exactly 0.
#[test]
fn lights_below_the_surface_are_dark() {
    let mut random = Random::new(36);
    let mut leaks = 0;
    for case in 0..10_000 {
        let (placed, point, _) = scene(case, &mut random);
        // Horizons above every vertex.
        let away = random.direction();
        let highest = placed
            .vertices()
            .iter()
            .map(|&v| away.dot((v - point).normalize_or_zero()))
            .fold(f64::NEG_INFINITY, f64::max);
        if highest > 0.0 {
            continue;
        }
        let rows = any_map(20.0, &mut random);
        let prepared = PreparedLtc::from_world_to_cosine(rows, away);
        for sides in [Sides::Front, Sides::Both] {
            assert_eq!(ltc_form_factor(&placed.light(sides), point, &prepared), 0.0);
        }
        leaks += usize::from(twin(&placed.loops_from(point), &[rows[2]], &rows) > 1e-3);
    }
    println!("{leaks} lights would leak through with the lobe's plane alone");
    assert!(leaks > 50, "the case must occur to be tested: {leaks}");
}

/// Maps that are none, and numbers that are none: in \[0, 1\] or NaN, and no panic.
#[test]
fn hostile_maps() {
    let mut random = Random::new(37);
    let numbers = [
        0.0,
        -1.0,
        1.0,
        1e-45,
        1e-30,
        1e30,
        f32::MAX,
        f32::MIN_POSITIVE,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    for case in 0..20_000 {
        let (placed, point, normal) = scene(case, &mut random);
        let light = placed.light(Sides::Both).cast::<f32>().unwrap();
        let single = |v: Vector| Vec3::new(v.x as f32, v.y as f32, v.z as f32);
        let mut rows = any_map(100.0, &mut random).map(single);
        match case % 4 {
            0 => {
                let number = |random: &mut Random| numbers[random.index(numbers.len())];
                rows = [(); 3].map(|()| {
                    Vec3::new(
                        number(&mut random),
                        number(&mut random),
                        number(&mut random),
                    )
                });
            }
            1 => rows[2] = rows[1],
            2 => rows[random.index(3)] = Vec3::default(),
            _ => {
                let tiny = numbers[random.index(numbers.len())];
                let row = random.index(3);
                rows[row] = rows[row] * tiny;
            }
        }
        let normals = [single(normal), Vec3::default(), rows[2]];
        let prepared = PreparedLtc::from_world_to_cosine(rows, normals[random.index(3)]);
        let got = ltc_form_factor(&light, single(point), &prepared);
        assert!(
            got.is_nan() || (0.0..=1.0).contains(&got),
            "{got} {rows:?} {point:?} {placed:#?}"
        );
    }
}
