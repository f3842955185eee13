//! GLSL ES 3.00, run: what an exported function gives on a GPU is what the CPU gives in f64.

use std::fs;
use std::path::Path;
use std::process::Command;

use lumigon::{
    Ltc, LtcTable, PolygonLight, PreparedLtc, Sides, Vec3, form_factor, irradiance, light_vector,
    ltc_form_factor, solid_angle,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::tool::python_tool;
use crate::{export, read, write};

const CASES: usize = 400;
/// Texels of a case's row.
const WIDTH: usize = 9;
/// Texels of a row of records.
const RECORD_WIDTH: usize = 256;
/// Texels of a picture's row.
const QUANTITIES: usize = 6;

/// Irradiance, solid angle and light vector, absolute: points are at least 0.2 radii off the light's
/// plane, where the library states 1e-6 over the distance to an edge.
const FLUX_TOLERANCE: f64 = 2e-6;
/// Form factor of a lobe, absolute: in the lobe's space a light comes closer by the lobe's width,
/// and the lobe itself is looked up in f32.
const LOBE_TOLERANCE: f64 = 3e-6;
/// Numbers from the table, relative to the greatest of their group, in f32.
const TABLE_TOLERANCE: f64 = 2e-6;
/// The same in f16: half a unit in its last place, 2^-11.
const HALF_TOLERANCE: f64 = 5e-4;

/// A light, and a surface that it shines on. All numbers are f32's.
struct Case {
    exact: PolygonLight<f64>,
    light: PolygonLight<f32>,
    point: [f32; 3],
    normal: [f32; 3],
    view: [f32; 3],
    perceptual_roughness: f32,
}

fn unit(random: &mut Pcg64Mcg) -> Vec3<f64> {
    loop {
        let mut number = || random.random_range(-1.0..1.0);
        let v = Vec3::new(number(), number(), number());
        let squared: f64 = v.dot(v);
        if (0.01..1.0).contains(&squared) {
            return v * (1.0 / squared.sqrt());
        }
    }
}

/// A star with points and notches at random radii, counter-clockwise; with a hole now and then.
fn loops(random: &mut Pcg64Mcg) -> Vec<Vec<[f64; 2]>> {
    let count = random.random_range(3..9);
    let star = |random: &mut Pcg64Mcg, count: usize, radii: std::ops::Range<f64>| {
        let turn = random.random_range(0.0..std::f64::consts::TAU);
        let corners = (0..count).map(|i| {
            let azimuth = turn + std::f64::consts::TAU * i as f64 / count as f64;
            let radius = random.random_range(radii.clone());
            [radius * azimuth.cos(), radius * azimuth.sin()]
        });
        corners.collect::<Vec<_>>()
    };
    let mut loops = vec![star(random, count, 0.5..1.0)];
    if random.random_bool(0.3) {
        let hole = star(random, 4, 0.05..0.2);
        loops.push(hole.into_iter().rev().collect());
    }
    loops
}

/// Loops in space, whose numbers are f32's, within some four radii of the origin: farther away,
/// rounding of positions would be all that shows.
pub(crate) fn random_light(random: &mut Pcg64Mcg) -> (Vec<Vec<[f64; 3]>>, Sides) {
    let (x, y) = unit(random).orthonormal_basis();
    let size = 10.0_f64.powf(random.random_range(-2.0..2.0));
    let middle = unit(random) * (size * random.random_range(0.0..3.0));
    let in_space = |[u, v]: [f64; 2]| {
        let vertex = middle + x * (u * size) + y * (v * size);
        rounded(vertex).map(f64::from)
    };
    let loops = loops(random)
        .into_iter()
        .map(|corners| corners.into_iter().map(in_space).collect())
        .collect();
    let sides = [Sides::Front, Sides::Both][usize::from(random.random_bool(0.5))];
    (loops, sides)
}

fn rounded(v: Vec3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn case(random: &mut Pcg64Mcg) -> Case {
    let (loops, sides) = random_light(random);
    let exact = PolygonLight::new(&loops, sides).unwrap();
    let (middle, size) = exact.circumscribed_circle();
    let axis = exact.normal();
    let distance = 0.2 * 10.0_f64.powf(random.random_range(0.0..3.0));
    let side = if random.random_bool(0.8) { 1.0 } else { -1.0 };
    let lateral = unit(random) * (size * random.random_range(0.0..2.0));
    let lateral = lateral - axis * axis.dot(lateral);
    let point = middle + axis * (side * distance * size) + lateral;
    // Half of the surfaces face the light, or nearly.
    let away = (middle - point).normalize_or_zero();
    let lean = random.random_range(0.0..2.0);
    let normal = (away + unit(random) * lean).normalize_or_zero();
    let view = unit(random);
    let view = if normal.dot(view) < 0.0 {
        view * -1.0
    } else {
        view
    };
    Case {
        light: exact.cast().unwrap(),
        exact,
        point: rounded(point),
        normal: rounded(normal),
        view: rounded(view),
        perceptual_roughness: random.random_range(0.1..1.0),
    }
}

/// The two textures' numbers.
fn textures(cases: &[Case]) -> (Vec<f32>, Vec<f32>) {
    let (mut rows, mut records) = (Vec::new(), Vec::new());
    for case in cases {
        let light = &case.light;
        let (center, radius) = light.circumscribed_circle();
        let first = records.len() / 4;
        for range in light.loop_ranges() {
            let vertices = &light.offsets()[range];
            let moved = vertices.last().map(|v| [v.x, v.y, v.z, 1.0]);
            let lines = vertices.iter().map(|v| [v.x, v.y, v.z, 0.0]);
            records.extend(moved.into_iter().chain(lines).flatten());
        }
        let end = records.len() / 4;
        let mut push = |v: [f32; 3], w: f32| rows.extend([v[0], v[1], v[2], w]);
        push(center.into(), 1.0 / radius);
        push(light.normal().into(), light.doubled_unit_area());
        push(light.centroid_offset().into(), light.plane_tolerance());
        let both = f32::from(light.sides() == Sides::Both);
        push(light.plane_axes().0.into(), both);
        push(case.point, 0.0);
        push(case.normal, 0.0);
        push(case.view, case.perceptual_roughness);
        push([first as f32, end as f32, 0.0], 0.0);
        push([0.0; 3], 0.0);
    }
    records.resize(records.len().next_multiple_of(4 * RECORD_WIDTH), 0.0);
    (rows, records)
}

/// What the CPU gives, as the picture's texels.
fn expected(case: &Case, table: &LtcTable<1>) -> [[f64; 4]; QUANTITIES] {
    let vector = |v: [f32; 3]| Vec3::from(v.map(f64::from));
    let (point, normal, view) = (vector(case.point), vector(case.normal), vector(case.view));
    let light = &case.exact;
    let cos_view = normal.dot(view) as f32;
    let lobes = table.lookup(case.perceptual_roughness, cos_view);
    let lobe = &lobes.lobes[0];
    let matrix = lobe.shading_to_cosine.map(f64::from);
    let lobe = Ltc {
        shading_to_cosine: matrix,
        amplitude: f64::from(lobe.amplitude),
        schlick: f64::from(lobe.schlick),
    };
    let prepared = PreparedLtc::new(&lobe, normal, view);
    let direction = light_vector(light, point);
    let [stored, amplitudes] = stored(table, case.perceptual_roughness, cos_view);
    [
        [
            irradiance(light, point, normal),
            form_factor(light, point, normal),
            solid_angle(light, point),
            ltc_form_factor(light, point, &prepared),
        ],
        [direction.x, direction.y, direction.z, 0.0],
        matrix,
        [
            lobe.amplitude,
            lobe.schlick,
            f64::from(lobes.cosine.amplitude),
            f64::from(lobes.cosine.schlick),
        ],
        stored.map(f64::abs),
        amplitudes.map(f64::abs),
    ]
}

/// The table's own eight numbers, bilinear, in f64.
fn stored(table: &LtcTable<1>, perceptual_roughness: f32, cos_view: f32) -> [[f64; 4]; 2] {
    let size = table.size();
    let cell = |coordinate: f64| {
        let at = coordinate.clamp(0.0, 1.0) * (size - 1) as f64;
        let low = (at as usize).min(size - 2);
        (low, at - low as f64)
    };
    let (column, u) = cell(f64::from(perceptual_roughness));
    let (row, v) = cell((1.0 - f64::from(cos_view).clamp(0.0, 1.0)).sqrt());
    let number = |group: usize, channel: usize| {
        let texel = |i: usize, j: usize| {
            f64::from(table.texels()[(j * size + i) * 8 + 4 * group + channel])
        };
        (1.0 - v) * ((1.0 - u) * texel(column, row) + u * texel(column + 1, row))
            + v * ((1.0 - u) * texel(column, row + 1) + u * texel(column + 1, row + 1))
    };
    [0, 1].map(|group| [0, 1, 2, 3].map(|channel| number(group, channel)))
}

fn bytes(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// How far a texel may be from what is expected.
fn tolerance(quantity: usize, channel: usize, expected: &[f64; 4]) -> f64 {
    let greatest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    match (quantity, channel) {
        (0, 3) => LOBE_TOLERANCE,
        (0 | 1, _) => FLUX_TOLERANCE,
        (2 | 3, _) => TABLE_TOLERANCE * greatest,
        _ => HALF_TOLERANCE * greatest,
    }
}

#[test]
fn numbers_equal_those_of_the_cpu() {
    let mut random = Pcg64Mcg::seed_from_u64(0x300e5);
    let cases: Vec<Case> = (0..CASES).map(|_| case(&mut random)).collect();
    let (rows, records) = textures(&cases);

    let folder = export("glsl-es300");
    let library = read(&folder, "lumigon.glsl");
    let shader = format!("#version 300 es\n{library}\n{}", include_str!("es300.frag"));
    let shader = write(&folder, "es300.frag", &shader);
    let path = |name: &str| folder.path().join(name);
    fs::write(path("cases"), bytes(&rows)).unwrap();
    fs::write(path("records"), bytes(&records)).unwrap();
    let texture = |name: &str, width: usize, height: usize, kind: &str, file: &str| {
        format!("{name}:{width}:{height}:{kind}:{}", path(file).display())
    };
    let record_rows = records.len() / 4 / RECORD_WIDTH;
    let output = Command::new(python_tool("python"))
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/shaders_export/render_es300.py"))
        .arg(shader)
        .args([QUANTITIES.to_string(), CASES.to_string()])
        .arg(path("picture"))
        .arg(texture("cases", WIDTH, CASES, "f4", "cases"))
        .arg(texture(
            "records",
            RECORD_WIDTH,
            record_rows,
            "f4",
            "records",
        ))
        .arg(texture("ggx_table", 64, 32, "f4", "tables/ggx-32.f32"))
        .arg(texture("ggx_half", 64, 32, "f2", "tables/ggx-32.f16"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "no OpenGL through EGL? Install libegl1, libgl1 and libgl1-mesa-dri, or run ./check\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    println!("{}", String::from_utf8_lossy(&output.stdout));

    let picture = fs::read(path("picture")).unwrap();
    let (numbers, rest) = picture.as_chunks::<4>();
    assert!(rest.is_empty() && numbers.len() == CASES * QUANTITIES * 4);
    let table = LtcTable::ggx();
    let mut worst = [[0.0_f64; 4]; QUANTITIES];
    let mut lit = 0;
    for (index, case) in cases.iter().enumerate() {
        for (quantity, expected) in expected(case, &table).iter().enumerate() {
            for channel in 0..4 {
                let found = numbers[(index * QUANTITIES + quantity) * 4 + channel];
                let found = f64::from(f32::from_le_bytes(found));
                let error = (found - expected[channel]).abs();
                let allowed = tolerance(quantity, channel, expected);
                assert!(
                    error <= allowed,
                    "case {index}, quantity {quantity}.{channel}: {found} is not {}: {:?} from {:?}, \
                     normal {:?}, view {:?}, perceptual roughness {}",
                    expected[channel],
                    case.exact.loops().collect::<Vec<_>>(),
                    case.point,
                    case.normal,
                    case.view,
                    case.perceptual_roughness
                );
                let share = &mut worst[quantity][channel];
                *share = share.max(error / allowed.max(1e-30));
            }
            lit += usize::from(quantity == 0 && expected[0] > 1e-4 && expected[3] > 1e-4);
        }
    }
    println!("{lit} of {CASES} lit; greatest errors, in tolerances: {worst:.2?}");
    assert!(lit > CASES / 4);
}
