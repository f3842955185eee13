//! The properties of linearly transformed cosines, and their integrals over polygons by two other
//! means: a conventional clip with an edge sum, and cubature of the density itself.

mod polygons;

use lumigon::{
    Ltc, LtcTable, PolygonLight, PreparedLtc, Sides, Vec3, clip_loop, form_factor, ltc_form_factor,
};
use lumigon_reference::Polygon;
use polygons::{KINDS, Placed, Random, Vector, array, edge_sum};

const UP: Vector = Vec3::new(0.0, 0.0, 1.0);

fn lobe(shading_to_cosine: [f64; 4]) -> Ltc<f64> {
    Ltc {
        shading_to_cosine,
        amplitude: 1.0,
        schlick: 0.0,
    }
}

/// From the shipped table, rounded up or down to anything between its nodes.
fn table_lobe(table: &LtcTable<1>, random: &mut Random) -> Ltc<f64> {
    let perceptual_roughness = random.range(0.0, 1.0) as f32;
    let single = table.lookup(perceptual_roughness, random.range(0.0, 1.0) as f32);
    lobe(single.lobes[0].shading_to_cosine.map(f64::from))
}

/// Stretched and sheared anyhow; up to half of it below the horizon.
fn any_lobe(random: &mut Random) -> Ltc<f64> {
    let m11 = random.log_range(0.05, 20.0);
    let m33 = random.log_range(0.05, 20.0);
    let m13 = random.range(-3.0, 3.0) * m11;
    // The determinant must stay positive.
    let m31 = match random.index(4) {
        0 => 0.0,
        1 => random.range(-1e-9, 1e-9),
        _ => random.range(-0.9, 0.9) * m11 * m33 / m13,
    };
    lobe([m11, m13, m31, m33])
}

/// Moderate enough for cubature that knows nothing of where the peak is.
fn broad_lobe(random: &mut Random) -> Ltc<f64> {
    let m11 = random.log_range(0.4, 3.0);
    let m33 = random.log_range(0.4, 3.0);
    let m13 = random.range(-0.8, 0.8);
    let m31 = random.range(-0.8, 0.8) * (m11 * m33 / m13.abs()).min(1.0);
    lobe([m11, m13, m31, m33])
}

fn to_cosine(ltc: &Ltc<f64>, v: Vector) -> Vector {
    let [m11, m13, m31, m33] = ltc.shading_to_cosine;
    Vec3::new(m11 * v.x + m13 * v.z, v.y, m31 * v.x + m33 * v.z)
}

/// The normal of the plane in the shading frame where the lobe ends.
fn lobe_plane(ltc: &Ltc<f64>) -> Vector {
    let [_, _, m31, m33] = ltc.shading_to_cosine;
    Vec3::new(m31, 0.0, m33)
}

/// Rows of the rotation into the shading frame.
fn shading_frame(normal: Vector, view: Vector) -> [Vector; 3] {
    let x = (view - normal * normal.dot(view)).normalize_or_zero();
    [x, normal.cross(x), normal]
}

fn rotate(rows: &[Vector; 3], v: Vector) -> Vector {
    Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v))
}

/// What [`ltc_form_factor`] should be, by clipping the loops at one plane after the other.
fn twin(placed: &Placed, point: Vector, normal: Vector, view: Vector, ltc: &Ltc<f64>) -> f64 {
    if placed.axes[2].dot(point - placed.origin) <= 0.0 {
        return 0.0;
    }
    let frame = shading_frame(normal, view);
    let clipped: Vec<Vec<_>> = placed
        .loops_from(point)
        .iter()
        .map(|vertices| {
            let local: Vec<_> = vertices.iter().map(|&v| rotate(&frame, v)).collect();
            let above = clip_loop(&clip_loop(&local, UP), lobe_plane(ltc));
            above.iter().map(|&v| to_cosine(ltc, v)).collect()
        })
        .collect();
    edge_sum(&clipped)
}

/// Integral of the density over the directions of a triangle, to an absolute error.
fn integrate_density(ltc: &Ltc<f64>, triangle: [Vector; 3], tolerance: f64) -> f64 {
    let whole = product_rule(ltc, triangle);
    adapt(ltc, triangle, whole, tolerance, 0)
}

fn adapt(ltc: &Ltc<f64>, [a, b, c]: [Vector; 3], whole: f64, tolerance: f64, depth: u32) -> f64 {
    let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
    let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    let values = parts.map(|part| product_rule(ltc, part));
    let sum: f64 = values.iter().sum();
    // Splitting gains four orders of magnitude and more once the rule sees the function.
    if depth >= 2 && (sum - whole).abs() < tolerance || depth > 12 {
        return sum;
    }
    parts
        .into_iter()
        .zip(values)
        .map(|(part, value)| adapt(ltc, part, value, tolerance * 0.5, depth + 1))
        .sum()
}

/// Gauss' rule of five points in both directions of a square folded onto the triangle.
fn product_rule(ltc: &Ltc<f64>, [a, b, c]: [Vector; 3]) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.046_910_077_030_668, 0.118_463_442_528_094_5),
        (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
        (0.5, 0.284_444_444_444_444_4),
        (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
        (0.953_089_922_969_332, 0.118_463_442_528_094_5),
    ];
    let volume = a.dot((b - a).cross(c - a)).abs();
    let mut sum = 0.0;
    for (u, weight_u) in NODES {
        for (v, weight_v) in NODES {
            let x = a + ((b - a) + (c - b) * v) * u;
            let length = x.length();
            let density = ltc.density(x * (1.0 / length));
            sum += weight_u * weight_v * u * density / (length * length * length);
        }
    }
    sum * volume
}

/// Triangles of a convex loop.
fn fan(vertices: &[Vector]) -> impl Iterator<Item = [Vector; 3]> + '_ {
    (2..vertices.len()).map(|i| [vertices[0], vertices[i - 1], vertices[i]])
}

/// The sphere as an octahedron's eight faces.
fn octahedron() -> Vec<[Vector; 3]> {
    let mut faces = Vec::new();
    for x in [-1.0, 1.0] {
        for y in [-1.0, 1.0] {
            for z in [-1.0, 1.0] {
                faces.push([
                    Vec3::new(x, 0.0, 0.0),
                    Vec3::new(0.0, y, 0.0),
                    Vec3::new(0.0, 0.0, z),
                ]);
            }
        }
    }
    faces
}

/// Seed text: the integral over the sphere is that of the original cosine, 1.
#[test]
fn density_integrates_to_one_over_the_sphere() {
    let mut random = Random::new(11);
    let table = LtcTable::ggx();
    let mut worst = 0.0_f64;
    for case in 0..40 {
        let ltc = match case % 2 {
            0 => broad_lobe(&mut random),
            _ => {
                let single =
                    table.lookup(random.range(0.5, 1.0) as f32, random.range(0.2, 1.0) as f32);
                lobe(single.lobes[0].shading_to_cosine.map(f64::from))
            }
        };
        let mut sum = 0.0;
        for face in octahedron() {
            for triangle in fan(&clip_loop(&face, lobe_plane(&ltc))) {
                sum += integrate_density(&ltc, triangle, 1e-10);
            }
        }
        worst = worst.max((sum - 1.0).abs());
        assert!((sum - 1.0).abs() < 1e-8, "{sum}: {ltc:?}");
    }
    println!("integral over the sphere within {worst:e} of 1");
}

/// A light, a point, a normal and a view, with lights over the point, through its horizon and
/// reaching below it.
fn scene(case: usize, random: &mut Random) -> (Placed, Vector, Vector, Vector) {
    let placed = Placed::random(case % KINDS, random);
    let height = random.log_range(0.05, 20.0);
    let spread = random.range(0.0, 2.0) * height.max(1.0);
    let turn = random.range(0.0, std::f64::consts::TAU);
    let point = placed.at(spread * turn.cos(), spread * turn.sin(), height);
    let normal = match case % 3 {
        0 => random.direction(),
        1 => {
            // The horizon passes through the light.
            let inside = placed.at(random.range(-0.6, 0.6), random.range(-0.6, 0.6), 0.0);
            let (s, t) = (inside - point).normalize_or_zero().orthonormal_basis();
            let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
            s * sin + t * cos
        }
        _ => random.direction_above(placed.at(0.0, 0.0, 0.0) - point),
    };
    let view = match case % 5 {
        // Grazing: lobes that reach below the horizon.
        0 | 1 => {
            let (s, t) = normal.orthonormal_basis();
            let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
            (s * sin + t * cos + normal * random.log_range(1e-3, 0.3)).normalize_or_zero()
        }
        _ => random.direction_above(normal),
    };
    (placed, point, normal, view)
}

#[test]
fn form_factor_is_the_twice_clipped_edge_sum() {
    let mut random = Random::new(12);
    let table = LtcTable::ggx();
    let (mut worst, mut cut) = (0.0_f64, 0);
    for case in 0..60_000 {
        let (placed, point, normal, view) = scene(case, &mut random);
        let ltc = match case % 2 {
            0 => table_lobe(&table, &mut random),
            _ => any_lobe(&mut random),
        };
        let light = placed.light(Sides::Front);
        let prepared = PreparedLtc::new(&ltc, normal, view);
        let got = ltc_form_factor(&light, point, &prepared);
        let expected = twin(&placed, point, normal, view, &ltc);
        let error = (got - expected).abs();
        worst = worst.max(error);
        // Maps that squeeze by 100 magnify rounding by as much.
        assert!(
            error < 1e-10,
            "{got} is not {expected}: {case} {ltc:?} {point:?} {normal:?} {view:?} {placed:#?}"
        );
        let without_horizon = {
            let frame = shading_frame(normal, view);
            let loops: Vec<Vec<_>> = placed
                .loops_from(point)
                .iter()
                .map(|vertices| {
                    let local: Vec<_> = vertices.iter().map(|&v| rotate(&frame, v)).collect();
                    let above = clip_loop(&local, lobe_plane(&ltc));
                    above.iter().map(|&v| to_cosine(&ltc, v)).collect()
                })
                .collect();
            edge_sum(&loops)
        };
        cut += usize::from(got > 1e-4 && (without_horizon - got).abs() > 1e-4);
    }
    println!("worst error {worst:e}; {cut} lights cut by both planes or by the horizon alone");
    assert!(cut > 3_000);
}

/// Seed text: the integral over a polygon is the cosine's over the transformed polygon.
#[test]
fn form_factor_is_the_integral_of_the_density() {
    let mut random = Random::new(13);
    let (mut worst, mut lit) = (0.0_f64, 0);
    for case in 0..600 {
        let (placed, point, normal, view) = scene(case, &mut random);
        let ltc = broad_lobe(&mut random);
        let light = placed.light(Sides::Front);
        let got = ltc_form_factor(&light, point, &PreparedLtc::new(&ltc, normal, view));
        let truth = Polygon::new(&placed.loops, false).unwrap();
        let frame = shading_frame(normal, view);
        let mut sum = 0.0;
        for triangle in truth.triangles() {
            let local = triangle.map(|v| rotate(&frame, Vec3::from(v) - point));
            let visible = clip_loop(&clip_loop(&local, UP), lobe_plane(&ltc));
            for part in fan(&visible) {
                sum += integrate_density(&ltc, part, 1e-11);
            }
        }
        let error = (got - sum).abs();
        worst = worst.max(error);
        lit += usize::from(got > 1e-3);
        assert!(
            error < 1e-8,
            "{got} is not {sum}: {case} {ltc:?} {point:?} {placed:#?}"
        );
    }
    println!("worst error {worst:e}; {lit} of 600 lit");
    assert!(lit > 200);
}

#[test]
fn the_identity_is_lamberts_cosine() {
    let mut random = Random::new(14);
    let ltc = Ltc::cosine(1.0);
    for case in 0..5_000 {
        let (placed, point, normal, view) = scene(case, &mut random);
        let light = placed.light(Sides::Front);
        let got = ltc_form_factor(&light, point, &PreparedLtc::new(&ltc, normal, view));
        let lambert = form_factor(&light, point, normal);
        assert!(
            (got - lambert).abs() < 1e-13,
            "{got} {lambert} {placed:#?} {point:?} {normal:?}"
        );
        let direction = random.direction();
        let density = direction.z.max(0.0) / std::f64::consts::PI;
        assert!((ltc.density(direction) - density).abs() < 1e-15);
        assert!((ltc.cosine_to_shading(direction) - direction).length() < 1e-15);
    }
}

/// Seed text: scaling changes no direction, so neither the scene's scale nor the map's matters.
#[test]
fn scale_does_not_matter() {
    let mut random = Random::new(15);
    for case in 0..2_000 {
        let (placed, point, normal, view) = scene(case, &mut random);
        let ltc = any_lobe(&mut random);
        let prepared = PreparedLtc::new(&ltc, normal, view);
        let got = ltc_form_factor(&placed.light(Sides::Front), point, &prepared);
        let scale = random.log_range(1e-3, 1e3);
        let scaled: Vec<Vec<_>> = placed
            .loops_from(point)
            .iter()
            .map(|vertices| vertices.iter().map(|&v| array(v * scale)).collect())
            .collect();
        let light = PolygonLight::new(&scaled, Sides::Front).unwrap();
        let other = ltc_form_factor(&light, Vec3::default(), &prepared);
        assert!(
            (got - other).abs() < 1e-11,
            "{got} {other} {scale} {ltc:?} {placed:#?}"
        );
        // The published form of the density, with the map times any factor.
        let direction = random.direction();
        let mapped = to_cosine(&ltc, direction) * scale;
        let [m11, m13, m31, m33] = ltc.shading_to_cosine;
        let determinant = (m11 * m33 - m13 * m31) * scale * scale * scale;
        let length = mapped.length();
        let cosine = (mapped.z / length).max(0.0) / std::f64::consts::PI;
        let density = cosine * determinant / (length * length * length);
        let got = ltc.density(direction);
        assert!((got - density).abs() <= 1e-11 * density, "{got} {density}");
    }
}

/// Seed text: rotations turn the distribution and keep its shape.
#[test]
fn rotation_does_not_matter() {
    let mut random = Random::new(16);
    for case in 0..2_000 {
        let (placed, point, normal, view) = scene(case, &mut random);
        let ltc = any_lobe(&mut random);
        let light = placed.light(Sides::Front);
        let got = ltc_form_factor(&light, point, &PreparedLtc::new(&ltc, normal, view));
        // About the normal in every third case, else about any axis.
        let axis = if case % 3 == 0 {
            normal
        } else {
            random.direction()
        };
        let (s, t) = axis.orthonormal_basis();
        let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
        let turn = |v: Vector| {
            let (x, y) = (s.dot(v), t.dot(v));
            axis * axis.dot(v) + s * (cos * x - sin * y) + t * (sin * x + cos * y)
        };
        let turned: Vec<Vec<_>> = placed
            .loops
            .iter()
            .map(|vertices| vertices.iter().map(|&v| array(turn(v.into()))).collect())
            .collect();
        let light = PolygonLight::new(&turned, Sides::Front).unwrap();
        let prepared = PreparedLtc::new(&ltc, turn(normal), turn(view));
        let other = ltc_form_factor(&light, turn(point), &prepared);
        assert!(
            (got - other).abs() < 1e-11,
            "{got} {other} {ltc:?} {placed:#?}"
        );
    }
}

/// Nothing from below the surface leaks in, whatever of the lobe is there.
#[test]
fn lights_below_the_surface_are_dark() {
    let mut random = Random::new(17);
    let mut leaks = 0;
    for case in 0..30_000 {
        let placed = Placed::random(case % KINDS, &mut random);
        let point = placed.at(
            random.range(-3.0, 3.0),
            random.range(-3.0, 3.0),
            random.log_range(0.01, 3.0),
        );
        // A horizon above every vertex.
        let away = random.direction();
        let highest = placed
            .vertices()
            .iter()
            .map(|&v| away.dot((v - point).normalize_or_zero()))
            .fold(f64::NEG_INFINITY, f64::max);
        if highest > 0.0 {
            continue;
        }
        let (_, _, _, view) = scene(case, &mut random);
        let view = if view.dot(away) < 0.0 { -view } else { view };
        let ltc = any_lobe(&mut random);
        let prepared = PreparedLtc::new(&ltc, away, view);
        for sides in [Sides::Front, Sides::Both] {
            assert_eq!(ltc_form_factor(&placed.light(sides), point, &prepared), 0.0);
        }
        let frame = shading_frame(away, view);
        let of_lobe: Vec<Vec<_>> = placed
            .loops_from(point)
            .iter()
            .map(|vertices| {
                let local: Vec<_> = vertices.iter().map(|&v| rotate(&frame, v)).collect();
                let above = clip_loop(&local, lobe_plane(&ltc));
                above.iter().map(|&v| to_cosine(&ltc, v)).collect()
            })
            .collect();
        leaks += usize::from(edge_sum(&of_lobe) > 1e-3);
    }
    println!("{leaks} lights would leak through with the lobe's plane alone");
    assert!(leaks > 20, "the case must occur to be tested");
}

/// Seed text: mapping cosine-distributed directions samples the lobe.
#[test]
fn mapped_cosine_samples_have_the_density() {
    let mut random = Random::new(18);
    // Each octant in four.
    let cells: Vec<[Vector; 3]> = octahedron()
        .into_iter()
        .flat_map(|[a, b, c]| {
            let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    let contains = |&[a, b, c]: &[Vector; 3], v: Vector| {
        let volume = a.dot(b.cross(c)).signum();
        [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(from, to)| from.cross(to).dot(v) * volume >= 0.0)
    };
    for _ in 0..8 {
        let ltc = broad_lobe(&mut random);
        let expected: Vec<f64> = cells
            .iter()
            .map(|cell| {
                let clipped = clip_loop(cell, lobe_plane(&ltc));
                let integrals = fan(&clipped).map(|t| integrate_density(&ltc, t, 1e-9));
                integrals.sum()
            })
            .collect();
        let samples = 200_000;
        let mut counts = vec![0.0; cells.len()];
        for _ in 0..samples {
            let squared_sine = random.range(0.0, 1.0);
            let (s, c) = random.range(0.0, std::f64::consts::TAU).sin_cos();
            let sine = squared_sine.sqrt();
            let cosine = Vec3::new(sine * c, sine * s, (1.0 - squared_sine).sqrt());
            let direction = ltc.cosine_to_shading(cosine);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let cell = cells.iter().position(|cell| contains(cell, direction));
            counts[cell.unwrap()] += 1.0;
        }
        let (mut squares, mut freedom) = (0.0, -1.0);
        for (&count, &share) in counts.iter().zip(&expected) {
            let mean = share * f64::from(samples);
            if mean > 5.0 {
                squares += (count - mean) * (count - mean) / mean;
                freedom += 1.0;
            } else {
                assert!(count < 30.0, "{count} samples where {mean} belong: {ltc:?}");
            }
        }
        // Chi-squared: five standard deviations.
        let limit = freedom + 5.0 * f64::sqrt(2.0 * freedom);
        assert!(squares < limit, "{squares} for {freedom} cells: {ltc:?}");
    }
}

/// A factor on the lobe's frame: a view along the normal has no azimuth, and needs none where the
/// lobe is round.
#[test]
fn a_view_along_the_normal_is_nothing_special() {
    let mut random = Random::new(19);
    for case in 0..500 {
        let (placed, point, normal, _) = scene(case, &mut random);
        let light = placed.light(Sides::Front);
        let ltc = lobe([1.0, 0.0, 0.0, random.log_range(0.1, 10.0)]);
        let along = ltc_form_factor(&light, point, &PreparedLtc::new(&ltc, normal, normal));
        let (tangent, _) = normal.orthonormal_basis();
        let nearly = (normal + tangent * random.log_range(1e-12, 1e-3)).normalize_or_zero();
        let other = ltc_form_factor(&light, point, &PreparedLtc::new(&ltc, normal, nearly));
        assert!((along - other).abs() < 1e-9, "{along} {other} {placed:#?}");
    }
}
