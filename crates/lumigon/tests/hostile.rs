//! Every function on near-degenerate input, in f64, f32 and SIMD lanes: finite, within its
//! documented range, dark behind a light, and the same in lanes as in scalars.
//!
//! More than ten million evaluations, seeded; a failure prints its inputs.

mod polygons;

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{Level, Simd, dispatch};
use lumigon::{
    AnisotropicLtc, DistanceField, DistanceFieldSettings, DistanceFieldSmoothness, InclusionRule,
    Lanes, LocalOcclusion, Ltc, LtcTable, PlacedDistanceField, PolygonError, PolygonLight,
    PreparedLtc, ProjectionBasis, Pyramid, Real, Sides, Vec3, circle_occlusion, eon_cosine,
    form_factor, ggx_anisotropic_cosine, ggx_cosine, irradiance, light_direction, light_vector,
    light_vector_above, ltc_form_factor, projected_area, reflected_distance, reflected_inclusion,
    solid_angle, solid_angle_above,
};
use polygons::{KINDS, Outlines, Placed, Random, SLIVER, Vector, hostile_normal};
use rayon::prelude::*;

const PI: f64 = std::f64::consts::PI;
const TAU: f64 = std::f64::consts::TAU;
const HUGE: f64 = f64::MAX;

/// Whether lanes must agree with scalars, and how closely.
#[derive(Clone, Copy, Debug)]
enum Lanewise {
    /// Within this, over the distance from the nearest edge in radii: single precision knows the
    /// place no better.
    Within(f64),
    /// Discontinuous, or without a limit: nothing to compare.
    Apart,
}
use Lanewise::{Apart, Within};

/// What is computed of a place: name, least and greatest value, agreement of lanes.
const QUANTITIES: [(&str, f64, f64, Lanewise); 43] = [
    ("irradiance", 0.0, PI, Within(3e-6)),
    ("form factor", 0.0, 1.0, Within(1e-6)),
    ("light vector, x", -PI, PI, Within(3e-6)),
    ("light vector, y", -PI, PI, Within(3e-6)),
    ("light vector, z", -PI, PI, Within(3e-6)),
    ("light vector's length", 0.0, PI, Within(6e-6)),
    ("light vector above, x", -PI, PI, Within(3e-6)),
    ("light vector above, y", -PI, PI, Within(3e-6)),
    ("light vector above, z", -PI, PI, Within(3e-6)),
    ("light vector above's length", 0.0, PI, Within(6e-6)),
    ("solid angle", 0.0, TAU, Within(6e-6)),
    ("solid angle above", 0.0, TAU, Within(6e-6)),
    ("direction's solid angle, exact", 0.0, TAU, Within(6e-6)),
    ("direction's length, exact", 0.0, 1.0, Apart),
    ("direction's solid angle, circle", 0.0, TAU, Within(6e-6)),
    ("direction's length, circle", 0.0, 1.0, Apart),
    ("circle occlusion", 0.0, 1.0, Apart),
    ("projected area, centroid, exact", 0.0, HUGE, Apart),
    ("projected area, centroid, circle", 0.0, HUGE, Apart),
    ("projected area, weighted, exact", 0.0, HUGE, Apart),
    ("projected area, weighted, circle", 0.0, HUGE, Apart),
    ("projected area, biased, exact", 0.0, HUGE, Apart),
    ("projected area, biased, circle", 0.0, HUGE, Apart),
    ("projected area, optimal, exact", 0.0, HUGE, Apart),
    ("projected area, optimal, circle", 0.0, HUGE, Apart),
    ("pyramid's axis", 0.0, 1.0, Apart),
    ("pyramid's area", 0.0, HUGE, Apart),
    ("pyramid's moment trace", 0.0, HUGE, Apart),
    ("pyramid's moment determinant", 0.0, HUGE, Apart),
    ("pyramid's solid angle", 0.0, TAU, Apart),
    ("pyramid's least solid angle", 0.0, TAU, Apart),
    ("pyramid's greatest solid angle", 0.0, TAU, Apart),
    ("LTC form factor, table", 0.0, 1.0, Apart),
    ("LTC form factor, broad", 0.0, 1.0, Within(1e-5)),
    ("reflected, crossing number", 0.0, 1.0, Apart),
    ("reflected, winding number", 0.0, 1.0, Apart),
    ("GGX", 0.0, HUGE, Apart),
    ("LTC form factor, anisotropic", 0.0, 1.0, Within(1e-5)),
    ("LTC form factor, any rows", 0.0, 1.0, Apart),
    ("GGX, anisotropic", 0.0, HUGE, Apart),
    ("EON", 0.0, HUGE, Apart),
    ("reflected distance", 0.0, 1.0, Apart),
    ("reflected distance, fixed", 0.0, 1.0, Apart),
];

const BASES: [ProjectionBasis; 4] = [
    ProjectionBasis::Centroid,
    ProjectionBasis::Weighted,
    ProjectionBasis::Biased { bias: 0.3 },
    ProjectionBasis::Optimal,
];

/// Where one looks from and how.
#[derive(Clone, Copy, Debug)]
struct Place<T> {
    point: Vec3<T>,
    normal: Vec3<T>,
    view: Vec3<T>,
    /// Towards a punctual light, for the BRDF.
    towards: Vec3<T>,
    alpha: T,
    lobe: Ltc<T>,
}

/// Fills in [`QUANTITIES`], in their order.
#[inline(always)]
fn evaluate<T: Real>(
    light: &PolygonLight<T::Scalar>,
    field: &DistanceField,
    place: &Place<T>,
    out: &mut [T],
) {
    let &Place {
        point,
        normal,
        view,
        towards,
        alpha,
        lobe,
    } = place;
    out[0] = irradiance(light, point, normal);
    out[1] = form_factor(light, point, normal);
    let vector = light_vector(light, point);
    [out[2], out[3], out[4], out[5]] = [vector.x, vector.y, vector.z, vector.length()];
    let vector = light_vector_above(light, point, normal);
    [out[6], out[7], out[8], out[9]] = [vector.x, vector.y, vector.z, vector.length()];
    out[10] = solid_angle(light, point);
    out[11] = solid_angle_above(light, point, normal);
    let direction = light_direction(light, point, normal, LocalOcclusion::Exact);
    (out[12], out[13]) = (direction.solid_angle, direction.direction.length());
    let direction = light_direction(light, point, normal, LocalOcclusion::Circle);
    (out[14], out[15]) = (direction.solid_angle, direction.direction.length());
    out[16] = circle_occlusion(light, point, normal);
    for (i, basis) in BASES.into_iter().enumerate() {
        // One copy of the machine code for all bases: there are four processor levels of it.
        let basis = std::hint::black_box(basis);
        for (j, occlusion) in [LocalOcclusion::Exact, LocalOcclusion::Circle]
            .into_iter()
            .enumerate()
        {
            let occlusion = std::hint::black_box(occlusion);
            out[17 + 2 * i + j] = projected_area(light, point, normal, basis, occlusion);
        }
    }
    let pyramid = Pyramid::new(light, point);
    out[25] = pyramid.axis.length();
    out[26] = pyramid.area;
    out[27] = pyramid.moment_trace;
    out[28] = pyramid.moment_determinant;
    out[29] = pyramid.solid_angle();
    (out[30], out[31]) = pyramid.solid_angle_bounds();
    out[32] = ltc_form_factor(light, point, &PreparedLtc::new(&lobe, normal, view));
    let broad = Ltc {
        shading_to_cosine: [
            alpha.constant(1.3),
            alpha.constant(-0.2),
            alpha.constant(0.15),
            alpha.constant(1.1),
        ],
        ..lobe
    };
    out[33] = ltc_form_factor(light, point, &PreparedLtc::new(&broad, normal, view));
    for (i, rule) in [InclusionRule::CrossingNumber, InclusionRule::WindingNumber]
        .into_iter()
        .enumerate()
    {
        let rule = std::hint::black_box(rule);
        out[34 + i] = reflected_inclusion(light, point, normal, view, rule);
    }
    out[36] = ggx_cosine(alpha, normal, view, towards);
    let (tangent, bitangent) = normal.orthonormal_basis();
    let map = [[1.3, 0.2, -0.2], [-0.1, 0.9, 0.3], [0.15, -0.2, 1.1]];
    let general = AnisotropicLtc {
        shading_to_cosine: map.map(
            #[inline(always)]
            |row| {
                row.map(
                    #[inline(always)]
                    |x| alpha.constant(x),
                )
            },
        ),
        amplitude: lobe.amplitude,
        schlick: lobe.schlick,
    };
    let prepared = general.prepare(tangent, bitangent, normal);
    out[37] = ltc_form_factor(light, point, &prepared);
    // Whatever the vectors at hand make: of either orientation, singular where they are parallel.
    let rows = [view, towards * alpha, normal];
    let prepared = PreparedLtc::from_world_to_cosine(rows, normal);
    out[38] = ltc_form_factor(light, point, &prepared);
    let widths = [alpha, alpha.constant(0.3)];
    out[39] = ggx_anisotropic_cosine(widths, tangent, bitangent, normal, view, towards);
    out[40] = eon_cosine(lobe.amplitude, alpha, normal, view, towards);
    let placed = PlacedDistanceField::own(field);
    let fixed = DistanceFieldSmoothness::fixed(2.0).unwrap_or_default();
    for (i, smoothness) in [DistanceFieldSmoothness::default(), fixed]
        .into_iter()
        .enumerate()
    {
        let smoothness = std::hint::black_box(smoothness);
        out[41 + i] = reflected_distance(light, placed, point, normal, view, alpha, smoothness);
    }
}

type Values = [f32; QUANTITIES.len()];

/// All places, a register at a time.
#[inline(always)]
fn evaluate_lanes<S: Simd>(
    simd: S,
    light: &PolygonLight<f32>,
    field: &DistanceField,
    places: &[Place<f32>],
    values: &mut [Values],
) {
    let count = Lanes::<S>::COUNT;
    let mut out = [Lanes::<S>::splat(simd, 0.0); QUANTITIES.len()];
    for (places, values) in places.chunks(count).zip(values.chunks_mut(count)) {
        // The last register is filled up with the last place.
        let last = places.len() - 1;
        let gather = |get: &dyn Fn(&Place<f32>) -> f32| {
            let list: [f32; 16] = std::array::from_fn(|i| get(&places[i.min(last)]));
            Lanes::<S>::from_slice(simd, &list)
        };
        let vector = |get: &dyn Fn(&Place<f32>) -> Vec3<f32>| {
            Vec3::new(
                gather(&|p| get(p).x),
                gather(&|p| get(p).y),
                gather(&|p| get(p).z),
            )
        };
        let place = Place {
            point: vector(&|p| p.point),
            normal: vector(&|p| p.normal),
            view: vector(&|p| p.view),
            towards: vector(&|p| p.towards),
            alpha: gather(&|p| p.alpha),
            lobe: Ltc {
                shading_to_cosine: [0, 1, 2, 3].map(|i| gather(&|p| p.lobe.shading_to_cosine[i])),
                amplitude: gather(&|p| p.lobe.amplitude),
                schlick: gather(&|p| p.lobe.schlick),
            },
        };
        evaluate(light, field, &place, &mut out);
        for (i, lanes) in out.iter().enumerate() {
            let mut list = [0.0_f32; 16];
            lanes.store(&mut list);
            for (value, number) in values.iter_mut().zip(list) {
                value[i] = number;
            }
        }
    }
}

/// Compiled once for each level of the processor.
#[inline(never)]
fn in_lanes(
    light: &PolygonLight<f32>,
    field: &DistanceField,
    places: &[Place<f32>],
) -> Vec<Values> {
    let mut values = vec![[0.0; QUANTITIES.len()]; places.len()];
    dispatch!(Level::new(), simd => evaluate_lanes(simd, light, field, places, &mut values));
    values
}

#[inline(never)]
fn in_f32(light: &PolygonLight<f32>, field: &DistanceField, place: &Place<f32>) -> Values {
    let mut values = [0.0; QUANTITIES.len()];
    evaluate(light, field, place, &mut values);
    values
}

#[inline(never)]
fn in_f64(
    light: &PolygonLight<f64>,
    field: &DistanceField,
    place: &Place<f64>,
) -> [f64; QUANTITIES.len()] {
    let mut values = [0.0; QUANTITIES.len()];
    evaluate(light, field, place, &mut values);
    values
}

fn single(v: Vector) -> Vec3<f32> {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

fn double(v: Vec3<f32>) -> Vector {
    Vec3::new(v.x.into(), v.y.into(), v.z.into())
}

impl Place<f64> {
    fn single(&self) -> Place<f32> {
        let lobe = self.lobe;
        Place {
            point: single(self.point),
            normal: single(self.normal),
            view: single(self.view),
            towards: single(self.towards),
            alpha: self.alpha as f32,
            lobe: Ltc {
                shading_to_cosine: lobe.shading_to_cosine.map(|x| x as f32),
                amplitude: lobe.amplitude as f32,
                schlick: lobe.schlick as f32,
            },
        }
    }
}

/// A polygon at an awkward place and scale.
fn hostile_polygon(case: usize, random: &mut Random) -> Placed {
    let kind = random.index(KINDS);
    let mut shape: Outlines = polygons::outlines(kind, random);
    if case.is_multiple_of(7) {
        // Round coordinates: exact zeros, exact horizons, exact edges through the zenith.
        for vertex in shape.iter_mut().flatten() {
            *vertex = vertex.map(|x| (x * 8.0).round() / 8.0);
        }
    }
    let normal = if random.chance(0.5) {
        random.axis()
    } else {
        random.direction()
    };
    let size = match case % 5 {
        0 => 1.0,
        1 => random.log_range(1e-30, 1e30),
        2 => random.log_range(1e-3, 1e3),
        3 => 1e-30,
        _ => 1e30,
    };
    let origin = match random.index(3) {
        0 => Vec3::default(),
        1 => random.axis() * (size * random.range(0.0, 3.0)),
        _ => random.direction() * (size * random.log_range(1e-3, 1e3)),
    };
    Placed::new(kind, &shape, origin, normal, size)
}

/// A shading point that hits some degeneracy of the polygon.
fn hostile_point(placed: &Placed, random: &mut Random) -> Vector {
    let edges = placed.edges();
    let (a, b) = edges[random.index(edges.len())];
    let on_edge = a + (b - a) * random.range(0.0, 1.0);
    let side = if random.chance(0.7) { 1.0 } else { -1.0 };
    let (x, y) = (random.range(-1.2, 1.2), random.range(-1.2, 1.2));
    let normal = placed.axes[2];
    match random.index(14) {
        // At a vertex, on an edge, on an edge's line.
        0 => a,
        1 => on_edge,
        2 => a + (b - a) * random.range(-2.0, 3.0),
        // In the plane, in the outline or out of it; and hardly over it.
        3 => placed.at(x, y, 0.0),
        4 => placed.at(x * 10.0, y * 10.0, 0.0),
        5 => placed.at(x, y, side * 1e-5),
        6 => on_edge + normal * (placed.size * side * random.log_range(1e-12, 1e-2)),
        7 => a + normal * (placed.size * side * random.log_range(1e-12, 1e-2)),
        // A millionth and a million sizes away, straight and slanting.
        8 => placed.at(x, y, side * random.log_range(1e-6, 1e-4)),
        9 => placed.origin + random.direction() * (placed.size * 1e6),
        10 => placed.origin + random.direction() * (placed.size * random.log_range(1.0, 1e6)),
        11 => placed.origin,
        // The origin of the world, and near its end.
        12 => Vec3::default(),
        _ if random.chance(0.1) => random.direction() * random.log_range(1e-30, 1e30),
        _ => placed.at(x, y, side * random.log_range(0.01, 3.0)),
    }
}

fn hostile_place(placed: &Placed, table: &LtcTable<1>, random: &mut Random) -> Place<f64> {
    let point = hostile_point(placed, random);
    let normal = hostile_normal(placed, point, random);
    let view = match random.index(6) {
        0 => normal,
        // Grazing, and below the horizon.
        1 => {
            let (s, _) = normal.orthonormal_basis();
            (s + normal * random.log_range(1e-9, 0.1)).normalize_or_zero()
        }
        2 => normal.orthonormal_basis().1,
        3 => -random.direction_above(normal),
        _ => random.direction_above(normal),
    };
    let towards = match random.index(3) {
        // The mirror direction, which is the narrow peak, and straight on.
        0 => (normal * (2.0 * normal.dot(view)) - view).normalize_or_zero(),
        1 => random.direction_above(normal),
        _ => view,
    };
    let perceptual_roughness = match random.index(4) {
        0 => 0.0,
        1 => 1.0,
        _ => random.range(0.0, 1.0),
    };
    let [single] = table
        .lookup(perceptual_roughness as f32, normal.dot(view) as f32)
        .lobes;
    Place {
        point,
        normal,
        view,
        towards,
        alpha: perceptual_roughness * perceptual_roughness,
        lobe: Ltc {
            shading_to_cosine: single.shading_to_cosine.map(f64::from),
            amplitude: single.amplitude.into(),
            schlick: single.schlick.into(),
        },
    }
}

/// What is wrong with a value, if anything is.
fn fault(i: usize, value: f64, slack: f64) -> Option<String> {
    let (_, least, greatest, _) = QUANTITIES[i];
    let slack = slack * greatest.min(10.0);
    // Where nothing is negative, rounding is no excuse either.
    let floor = if least < 0.0 { least - slack } else { least };
    let good = value.is_finite() && value >= floor && value - slack <= greatest;
    (!good).then(|| format!("{value:e} is not in {least} to {greatest:e}"))
}

/// Quantities that are dark behind a one-sided light.
fn is_light(i: usize) -> bool {
    (0..13).contains(&i) || i == 14 || (17..25).contains(&i) || (32..36).contains(&i) || i > 40
}

const PLACES: usize = 48;

/// Coarse: there are thousands of lights.
fn field_of(light: &PolygonLight<f64>) -> DistanceField {
    let settings = DistanceFieldSettings::new(8, 2.0, true);
    DistanceField::new(light, settings.unwrap())
}

#[test]
fn ten_million_hostile_evaluations() {
    let table = LtcTable::ggx();
    let evaluations = AtomicU64::new(0);
    let faults = Mutex::new(BTreeMap::new());
    (0..2_400_usize).into_par_iter().for_each(|case| {
        let mut random = Random::new(31_000 + case as u64);
        let placed = hostile_polygon(case, &mut random);
        let sides = if random.chance(0.5) {
            Sides::Front
        } else {
            Sides::Both
        };
        let light = match PolygonLight::new(&placed.loops, sides) {
            Ok(light) => light,
            // Rounded to eighths, slivers vanish and holes may swallow their outline.
            Err(PolygonError::NoArea) => return,
            Err(fault) => panic!("{fault}: {placed:#?}"),
        };
        let light32 = light
            .cast::<f32>()
            .unwrap_or_else(|fault| panic!("{fault}: {placed:#?}"));
        let places: Vec<_> = (0..PLACES)
            .map(|_| hostile_place(&placed, &table, &mut random))
            .collect();
        let singles: Vec<_> = places.iter().map(Place::single).collect();
        let field = field_of(&light);
        let lanes = in_lanes(&light32, &field, &singles);
        let complain =
            |number: &'static str, what: &'static str, fault: String, place: &Place<f64>| {
                let example = || format!("{fault}; case {case}, {place:?}, {placed:?}");
                faults
                    .lock()
                    .unwrap()
                    .entry((what, number))
                    .and_modify(|(count, _)| *count += 1)
                    .or_insert_with(|| (1, example()));
            };
        for ((place, single), lanes) in places.iter().zip(&singles).zip(&lanes) {
            let scalar = in_f32(&light32, &field, single);
            let exact = in_f64(&light, &field, place);
            let height = placed.axes[2].dot(place.point - placed.origin) / placed.size;
            let dark = sides == Sides::Front && height < -1e-3;
            let nearness = placed.distance_to_edges(double(single.point)).min(1.0);
            // Every edge adds its rounding. In the plane there is a jump; a sliver's width is
            // itself near rounding.
            let edges = (light.vertex_count() as f64 / 4.0).max(1.0);
            let comparable = nearness > 1e-4 && height.abs() > 1e-4 && placed.kind != SLIVER;
            for (i, (name, _, _, lanewise)) in QUANTITIES.into_iter().enumerate() {
                let numbers = [
                    ("f64", exact[i], 1e-9),
                    ("f32", scalar[i].into(), 2e-5),
                    ("lanes", lanes[i].into(), 2e-5),
                ];
                for (number, value, slack) in numbers {
                    if let Some(fault) = fault(i, value, slack) {
                        complain(number, name, fault, place);
                    }
                    if dark && is_light(i) && value != 0.0 {
                        complain(number, name, format!("{value:e} behind"), place);
                    }
                }
                if let Within(tolerance) = lanewise {
                    let difference = f64::from((scalar[i] - lanes[i]).abs());
                    let agree = difference * nearness < tolerance * edges;
                    if comparable && !agree {
                        let fault = format!(
                            "{} in scalars, {} in lanes, {nearness:e} from an edge",
                            scalar[i], lanes[i]
                        );
                        complain("lanes against scalars", name, fault, place);
                    }
                }
            }
        }
        let count = 3 * PLACES * QUANTITIES.len();
        evaluations.fetch_add(count as u64, Ordering::Relaxed);
    });
    let evaluations = evaluations.into_inner();
    println!("{evaluations} evaluations");
    let faults = faults.into_inner().unwrap();
    for ((what, number), (count, example)) in &faults {
        println!("{what}, {number}: {count} faults, one: {example}");
    }
    assert!(faults.is_empty(), "faults are listed above");
    assert!(evaluations >= 10_000_000);
}

/// What is not a number gives what it may, but never a panic.
#[test]
fn not_a_number_is_no_panic() {
    let table = LtcTable::ggx();
    let mut random = Random::new(32);
    let poison = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        0.0,
        1e-320,
    ];
    for case in 0..300 {
        let placed = Placed::random(case % KINDS, &mut random);
        let light = placed.light(Sides::Both);
        let light32 = light.cast::<f32>().unwrap();
        let places: Vec<_> = (0..PLACES)
            .map(|_| {
                let mut place = hostile_place(&placed, &table, &mut random);
                for _ in 0..1 + random.index(3) {
                    let value = poison[random.index(poison.len())];
                    let vector = match random.index(5) {
                        0 => &mut place.point,
                        1 => &mut place.normal,
                        2 => &mut place.view,
                        3 => &mut place.towards,
                        _ => {
                            place.alpha = value;
                            place.lobe.shading_to_cosine[random.index(4)] = value;
                            continue;
                        }
                    };
                    match random.index(4) {
                        0 => vector.x = value,
                        1 => vector.y = value,
                        2 => vector.z = value,
                        _ => *vector = Vec3::new(value, value, value),
                    }
                }
                place
            })
            .collect();
        let singles: Vec<_> = places.iter().map(Place::single).collect();
        let field = field_of(&light);
        std::hint::black_box(in_lanes(&light32, &field, &singles));
        for (place, single) in places.iter().zip(&singles) {
            std::hint::black_box(in_f64(&light, &field, place));
            std::hint::black_box(in_f32(&light32, &field, single));
        }
        std::hint::black_box(table.lookup(f32::NAN, f32::NEG_INFINITY));
    }
}
