//! Closed form equals quadrature: everything about a bare polygon against `lumigon-reference`,
//! which integrates adaptively over triangles and never sums over edges.

mod polygons;

use lumigon::{
    InclusionRule, LocalOcclusion, PolygonLight, ProjectionBasis, Pyramid, Sides, Vec3, clip_loop,
    form_factor, irradiance, light_vector, light_vector_above, projected_area, projection_axis,
    reflected_inclusion, solid_angle, solid_angle_above,
};
use lumigon_reference as reference;
use polygons::{KINDS, Placed, Random, Vector, array};
use reference::{Polygon, Tolerance};

const TOLERANCE: Tolerance = Tolerance {
    absolute: 1e-13,
    relative: 1e-10,
    max_evaluations: 400_000,
};

/// Absolute and relative: what is left of the cubature's own error, and of rounding near edges.
fn assert_close(got: f64, exact: f64, what: &str, inputs: &dyn std::fmt::Debug) {
    let error = (got - exact).abs();
    assert!(
        error <= 1e-11 + 1e-9 * exact.abs(),
        "{what}: {got} is not {exact}, error {error:e}; {inputs:#?}"
    );
}

/// A polygon, a point before or behind it and a unit normal there.
fn view(case: usize, random: &mut Random) -> (Placed, Vector, Vector) {
    let placed = Placed::random(case % KINDS, random);
    let distance = random.log_range(0.01, 100.0);
    let (x, y) = match case % 3 {
        // Over the light, near or far; else off to the side.
        0 => (random.range(-0.7, 0.7), random.range(-0.7, 0.7)),
        _ => {
            let angle = random.range(0.0, std::f64::consts::TAU);
            let away = distance * random.range(0.0, 3.0);
            (away * angle.cos(), away * angle.sin())
        }
    };
    let point = placed.at(x, y, distance);
    let normal = match case % 4 {
        // The horizon passes exactly through a vertex.
        0 => {
            let vertices = placed.vertices();
            let to_vertex = (vertices[random.index(vertices.len())] - point).normalize_or_zero();
            let (s, t) = to_vertex.orthonormal_basis();
            let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
            s * sin + t * cos
        }
        // The horizon passes through the light somewhere.
        1 => {
            let inside = placed.at(random.range(-0.8, 0.8), random.range(-0.8, 0.8), 0.0);
            let (s, t) = (inside - point).normalize_or_zero().orthonormal_basis();
            let (sin, cos) = random.range(0.0, std::f64::consts::TAU).sin_cos();
            s * sin + t * cos
        }
        2 => (placed.at(0.0, 0.0, 0.0) - point).normalize_or_zero(),
        _ => random.direction(),
    };
    (placed, point, normal)
}

/// Triangles of the light above the horizon, as polygons of their own.
///
/// Sutherland and Hodgman's clip of a triangle is a convex polygon: no degenerate edges.
fn clipped_parts(light: &Polygon, point: Vector, normal: Vector) -> Vec<Polygon> {
    let part = |triangle: [[f64; 3]; 3]| {
        let local = triangle.map(|v| Vec3::from(v) - point);
        let clipped = clip_loop(&local, normal);
        let outline: Vec<_> = clipped.iter().map(|&v| array(v + point)).collect();
        // What is too thin to be a polygon is too thin to matter.
        Polygon::new(&[outline], light.is_two_sided()).ok()
    };
    light.triangles().filter_map(part).collect()
}

#[test]
fn integrals_equal_cubature() {
    let mut random = Random::new(1);
    let (mut clipped, mut compared) = (0, 0);
    for case in 0..360 {
        let (placed, point, normal) = view(case, &mut random);
        let inputs = (case, &placed, point, normal);
        let light = placed.light(Sides::Front);
        let truth = Polygon::new(&placed.loops, false).unwrap();
        let (p, n) = (array(point), array(normal));

        let exact = reference::irradiance(&truth, p, n, TOLERANCE)
            .unwrap()
            .value;
        let got = irradiance(&light, point, normal);
        assert_close(got, exact, "irradiance", &inputs);
        let exact = reference::form_factor(&truth, p, n, TOLERANCE)
            .unwrap()
            .value;
        assert_close(
            form_factor(&light, point, normal),
            exact,
            "form factor",
            &inputs,
        );

        let whole = reference::light_vector(&truth, p, TOLERANCE).unwrap().value;
        let error = (light_vector(&light, point) - whole.into()).length();
        let length = Vec3::from(whole).length();
        assert_close(length + error, length, "light vector", &inputs);
        let whole_angle = reference::solid_angle(&truth, p, TOLERANCE).unwrap().value;
        assert_close(
            solid_angle(&light, point),
            whole_angle,
            "solid angle",
            &inputs,
        );

        let (mut vector, mut angle) = (Vec3::default(), 0.0);
        for part in clipped_parts(&truth, point, normal) {
            let add = reference::light_vector(&part, p, TOLERANCE).unwrap().value;
            vector += add.into();
            angle += reference::solid_angle(&part, p, TOLERANCE).unwrap().value;
        }
        let above = light_vector_above(&light, point, normal);
        let error = (above - vector).length();
        assert!(
            error < 1e-9,
            "light vector above: {above:?} {vector:?} {inputs:#?}"
        );
        assert!((normal.dot(above) - got).abs() < 1e-12, "{inputs:#?}");
        let got = solid_angle_above(&light, point, normal);
        assert!(
            (got - angle).abs() < 1e-9,
            "solid angle above: {got} is not {angle}; {inputs:#?}"
        );
        clipped += usize::from(angle > 1e-3 * whole_angle && angle < 0.999 * whole_angle);
        compared += 1;
    }
    println!("{compared} polygons, {clipped} of them cut by the horizon");
    assert!(clipped > 100);
}

#[test]
fn two_sided_lights_shine_both_ways() {
    let mut random = Random::new(2);
    for case in 0..60 {
        let (placed, point, normal) = view(case, &mut random);
        let mirrored = point - placed.axes[2] * (2.0 * placed.axes[2].dot(point - placed.origin));
        let two_sided = placed.light(Sides::Both);
        let front_only = placed.light(Sides::Front);
        let truth = Polygon::new(&placed.loops, true).unwrap();
        for point in [point, mirrored] {
            let inputs = (case, &placed, point, normal);
            let (p, n) = (array(point), array(normal));
            let exact = reference::irradiance(&truth, p, n, TOLERANCE)
                .unwrap()
                .value;
            assert_close(
                irradiance(&two_sided, point, normal),
                exact,
                "irradiance",
                &inputs,
            );
            let exact = reference::solid_angle(&truth, p, TOLERANCE).unwrap().value;
            assert_close(
                solid_angle(&two_sided, point),
                exact,
                "solid angle",
                &inputs,
            );
            let exact = reference::light_vector(&truth, p, TOLERANCE).unwrap().value;
            let error = (light_vector(&two_sided, point) - exact.into()).length();
            let length = Vec3::from(exact).length();
            assert_close(length + error, length, "light vector", &inputs);
        }
        assert_eq!(irradiance(&front_only, mirrored, normal), 0.0);
        assert_eq!(light_vector(&front_only, mirrored), Vec3::default());
        assert_eq!(solid_angle(&front_only, mirrored), 0.0);
        assert_eq!(solid_angle_above(&front_only, mirrored, normal), 0.0);
    }
}

const BASES: [ProjectionBasis; 4] = [
    ProjectionBasis::Centroid,
    ProjectionBasis::Weighted,
    ProjectionBasis::Biased { bias: 0.4 },
    ProjectionBasis::Optimal,
];

/// Shoelace area of loops projected on the plane at unit distance along `axis`, and the least
/// depth of a vertex.
fn shoelace(loops: &[Vec<Vector>], axis: Vector) -> (f64, f64) {
    let (x, y) = axis.orthonormal_basis();
    let (mut doubled, mut nearest) = (0.0, f64::INFINITY);
    for vertices in loops {
        let project = |v: Vector| {
            let depth = axis.dot(v);
            [x.dot(v) / depth, y.dot(v) / depth]
        };
        for i in 0..vertices.len() {
            let (a, b) = (vertices[i], vertices[(i + 1) % vertices.len()]);
            nearest = nearest.min(axis.dot(a));
            let ([ax, ay], [bx, by]) = (project(a), project(b));
            doubled += ax * by - ay * bx;
        }
    }
    // Counter-clockwise from the front is clockwise about an axis that points at the front.
    (-0.5 * doubled, nearest)
}

#[test]
fn projected_area_is_the_shoelace_sum_of_projected_vertices() {
    let mut random = Random::new(3);
    let mut compared = [0; 4];
    for case in 0..2_000 {
        let (placed, point, normal) = view(case, &mut random);
        let light = placed.light(Sides::Front);
        let truth = Polygon::new(&placed.loops, false).unwrap();
        let to_centroid = (Vec3::from(truth.centroid()) - point).normalize_or_zero();
        let weighted = placed
            .vertices()
            .iter()
            .fold(Vec3::default(), |sum, &v| {
                sum + (v - point).normalize_or_zero()
            })
            .normalize_or_zero();
        for (i, basis) in BASES.into_iter().enumerate() {
            let inputs = (case, basis, &placed, point, normal);
            let axis = projection_axis(&light, point, basis);
            let expected = match basis {
                ProjectionBasis::Centroid | ProjectionBasis::Biased { .. } => to_centroid,
                ProjectionBasis::Weighted => weighted,
                // Its own test tells whether it is right.
                ProjectionBasis::Optimal => axis,
            };
            assert!(
                (axis - expected).length() < 1e-9,
                "{expected:?} {inputs:#?}"
            );
            let bias = match basis {
                ProjectionBasis::Biased { bias } => axis * bias,
                _ => Vec3::default(),
            };
            let whole: Vec<Vec<_>> = placed
                .loops_from(point)
                .iter()
                .map(|vertices| vertices.iter().map(|&v| v + bias).collect())
                .collect();
            let (area, nearest) = shoelace(&whole, axis);
            // Where a vertex comes this close to the projection plane the method has no answer.
            if nearest < 1e-2 {
                continue;
            }
            let cut: Vec<Vec<_>> = placed
                .loops_from(point)
                .iter()
                .map(|vertices| {
                    let kept = clip_loop(vertices, normal);
                    kept.iter().map(|&v| v + bias).collect()
                })
                .collect();
            let (cut_area, _) = shoelace(&cut, axis);
            // Rounding of a projection that stretches by 1/depth, twice.
            let tolerance = 1e-12 * (1.0 + area) * (1.0 + 1.0 / nearest);
            let got = projected_area(&light, point, normal, basis, LocalOcclusion::Exact);
            assert!(
                (got - cut_area).abs() < tolerance,
                "{got} is not {cut_area} of {area}; {inputs:#?}"
            );
            let (center, radius) = light.circumscribed_circle();
            let ramp = (normal.dot(center - point) / radius * 0.5 + 0.5).clamp(0.0, 1.0);
            let got = projected_area(&light, point, normal, basis, LocalOcclusion::Circle);
            assert!(
                (got - area * ramp).abs() < tolerance,
                "{got} is not {area} {ramp}; {inputs:#?}"
            );
            compared[i] += 1;
        }
    }
    println!("compared {compared:?} of 2000");
    assert!(compared.iter().all(|&count| count > 1_000));
}

/// Area and centroid of the cross-section at unit distance along `axis`, triangle by triangle;
/// and its second moment's trace about the axis.
fn cross_section(light: &Polygon, point: Vector, axis: Vector) -> (f64, [f64; 2], f64) {
    let (x, y) = axis.orthonormal_basis();
    let (mut area, mut sum, mut moment) = (0.0, [0.0; 2], 0.0);
    for triangle in light.triangles() {
        let flat = triangle.map(|v| {
            let v = Vec3::from(v) - point;
            [x.dot(v) / axis.dot(v), y.dot(v) / axis.dot(v)]
        });
        let [a, b, c] = flat;
        let weight = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        area += weight;
        for k in 0..2 {
            let total = a[k] + b[k] + c[k];
            sum[k] += weight * total / 3.0;
            moment += weight * (total * total + a[k] * a[k] + b[k] * b[k] + c[k] * c[k]) / 12.0;
        }
    }
    (area, sum.map(|s| s / area), moment / area)
}

#[test]
fn optimal_axis_meets_the_centroid_of_its_section_near_and_far() {
    let mut random = Random::new(4);
    let mut worst = 0.0_f64;
    for case in 0..4_000 {
        let placed = Placed::random(case % KINDS, &mut random);
        let light = placed.light(Sides::Both);
        let truth = Polygon::new(&placed.loops, true).unwrap();
        // From a thousandth of the size, at any slant: over the light, its holes and beside it.
        let height = random.log_range(1e-3, 1e4);
        let spread = height.max(1.0) * random.range(0.0, 2.0);
        let turn = random.range(0.0, std::f64::consts::TAU);
        let side = if random.chance(0.5) { 1.0 } else { -1.0 };
        let point = placed.at(spread * turn.cos(), spread * turn.sin(), side * height);
        let inputs = (case, &placed, point, height);

        let pyramid = Pyramid::new(&light, point);
        let axis = pyramid.axis;
        let nearest = placed
            .vertices()
            .iter()
            .fold(f64::INFINITY, |m, &v| m.min(axis.dot(v - point)));
        assert!(nearest > 0.0, "a vertex behind: {nearest:e} {inputs:#?}");
        let (area, [x, y], moment) = cross_section(&truth, point, axis);
        let off = x.hypot(y) / (1.0 + moment);
        worst = worst.max(off);
        assert!(
            off < 3e-6,
            "the centroid is {off:e} off the axis; {inputs:#?}"
        );
        assert!(
            (pyramid.area / area - 1.0).abs() < 1e-6,
            "{pyramid:?} {area} {inputs:#?}"
        );
        assert!((pyramid.moment_trace - moment).abs() < 1e-6 * (1.0 + moment));

        let exact = solid_angle(&light, point);
        let (least, greatest) = pyramid.solid_angle_bounds();
        assert!(
            least <= exact * (1.0 + 1e-6) && exact <= greatest * (1.0 + 1e-6),
            "{exact} is not in {least} to {greatest}; {inputs:#?}"
        );
        let estimate = pyramid.solid_angle();
        assert!(estimate >= 0.0 && estimate <= greatest, "{inputs:#?}");
    }
    println!("centroid at most {worst:e} off the axis");
}

#[test]
fn pyramids_solid_angle_errs_as_documented() {
    let mut random = Random::new(5);
    let (mut small, mut large) = (Vec::new(), Vec::new());
    for case in 0..6_000 {
        let placed = Placed::random(case % 4, &mut random);
        let light = placed.light(Sides::Both);
        let point = placed.origin + random.direction() * random.log_range(0.3, 10.0);
        let exact = solid_angle(&light, point);
        let error = (Pyramid::new(&light, point).solid_angle() / exact - 1.0).abs();
        match exact {
            0.001..0.1 => small.push(error),
            0.5..1.5 => large.push(error),
            _ => {}
        }
    }
    let median = |mut errors: Vec<f64>| {
        assert!(errors.len() > 500, "{}", errors.len());
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    };
    let (small, large) = (median(small), median(large));
    println!("median relative error: {small:.1e} below 0.1 sr, {large:.1e} at 0.5 to 1.5 sr");
    assert!(small < 1e-3 && large < 0.06);
}

/// Whether a point of the light's plane lies in one of its triangles.
fn in_triangles(light: &Polygon, hit: Vector) -> bool {
    light.triangles().any(|triangle| {
        let [a, b, c] = triangle.map(Vec3::from);
        let normal = (b - a).cross(c - a);
        let inside =
            |&(from, to): &(Vector, Vector)| (to - from).cross(hit - from).dot(normal) >= 0.0;
        // Collinear vertices make triangles that contain nothing, and have no normal to say so.
        normal.length() > 1e-14 && [(a, b), (b, c), (c, a)].iter().all(inside)
    })
}

#[test]
fn reflected_inclusion_is_inclusion_in_the_triangles() {
    let mut random = Random::new(6);
    let mut counts = [0; 2];
    for case in 0..20_000 {
        let placed = Placed::random(case % KINDS, &mut random);
        let sides = if case % 2 == 0 {
            Sides::Front
        } else {
            Sides::Both
        };
        let light = placed.light(sides);
        let truth = Polygon::new(&placed.loops, sides == Sides::Both).unwrap();
        let side = if random.chance(0.8) { 1.0 } else { -1.0 };
        let point = placed.at(
            random.range(-2.0, 2.0),
            random.range(-2.0, 2.0),
            side * random.range(0.05, 3.0),
        );
        // Mostly aimed near the light.
        let normal = random.direction();
        let aim = placed.at(random.range(-1.2, 1.2), random.range(-1.2, 1.2), 0.0);
        let direction = match random.chance(0.9) {
            true => (aim - point).normalize_or_zero(),
            false => random.direction(),
        };
        let view = normal * (2.0 * normal.dot(direction)) - direction;

        let approach = placed.axes[2].dot(direction);
        let height = placed.axes[2].dot(placed.origin - point);
        let distance = height / approach;
        let hit = point + direction * distance;
        if placed.distance_to_edges(hit) < 1e-9 || normal.dot(view).abs() < 1e-9 {
            continue;
        }
        let emits = sides == Sides::Both || height < 0.0;
        let expected =
            emits && distance > 0.0 && normal.dot(view) > 0.0 && in_triangles(&truth, hit);
        let expected = f64::from(u8::from(expected));
        for rule in [InclusionRule::CrossingNumber, InclusionRule::WindingNumber] {
            let got = reflected_inclusion(&light, point, normal, view, rule);
            assert_eq!(
                got, expected,
                "{rule:?} {case} {placed:#?} {point:?} {normal:?} {view:?}"
            );
        }
        counts[expected as usize] += 1;
    }
    println!("{} rays miss, {} hit", counts[0], counts[1]);
    assert!(counts.iter().all(|&count| count > 1_000));
}

/// Cutting a light in two changes no integral: the horizon's crossings on the shared edge cancel.
#[test]
fn a_light_is_the_sum_of_its_triangles() {
    let mut random = Random::new(7);
    for case in 0..2_000 {
        let (placed, point, normal) = view(case, &mut random);
        let light = placed.light(Sides::Front);
        let truth = Polygon::new(&placed.loops, false).unwrap();
        let (mut sum, mut angle) = (0.0, 0.0);
        for triangle in truth.triangles() {
            let Ok(part) = PolygonLight::new(&[triangle], Sides::Front) else {
                continue;
            };
            sum += irradiance(&part, point, normal);
            angle += solid_angle_above(&part, point, normal);
        }
        let inputs = (case, &placed, point, normal);
        let whole = irradiance(&light, point, normal);
        assert!((whole - sum).abs() < 1e-10, "{whole} {sum} {inputs:#?}");
        let whole = solid_angle_above(&light, point, normal);
        assert!((whole - angle).abs() < 1e-9, "{whole} {angle} {inputs:#?}");
    }
}
