//! What single precision costs: f32 against f64 for the same inputs, all exact in f32.

mod polygons;

use lumigon::{
    Ltc, PreparedLtc, Sides, Vec3, irradiance, light_vector, ltc_form_factor, solid_angle,
    solid_angle_above,
};
use polygons::{KINDS, Placed, Random, SLIVER, Vector};

fn single(v: Vector) -> Vec3<f32> {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// The nearest vector that f32 holds.
fn exact(v: Vector) -> Vector {
    let v = single(v);
    Vec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

/// A polygon of f32 coordinates in a plane that f32 holds: about the origin and across an axis.
fn exact_polygon(kind: usize, random: &mut Random) -> Placed {
    let shape = polygons::outlines(kind, random);
    let shape = shape
        .iter()
        .map(|outline| {
            outline
                .iter()
                .map(|v| v.map(|x| f64::from(x as f32)))
                .collect()
        })
        .collect();
    let size = f64::from(random.log_range(1e-3, 1e3) as f32)
        .log2()
        .round()
        .exp2();
    Placed::new(kind, &shape, Vec3::default(), random.axis(), size)
}

/// Kinds with an area comparable to their circumscribed circle's: all but slivers, whose own
/// area single precision cannot hold.
fn robust_kind(random: &mut Random) -> usize {
    let kind = random.index(KINDS - 1);
    if kind >= SLIVER { kind + 1 } else { kind }
}

struct Worst {
    error: f64,
    at: String,
}

impl Worst {
    fn new() -> Self {
        Self {
            error: 0.0,
            at: String::new(),
        }
    }

    fn see(&mut self, error: f64, at: impl FnOnce() -> String) {
        // A NaN is worse than anything.
        if error.is_nan() || error > self.error {
            self.error = error;
            self.at = at();
        }
    }

    fn assert_below(&self, limit: f64, what: &str) {
        println!("{what}: {:.2e}, allowed {limit:.0e}", self.error);
        assert!(self.error < limit, "{what}: {} at {}", self.error, self.at);
    }
}

#[test]
fn lights_above_the_horizon_at_any_distance() {
    let mut random = Random::new(21);
    let (mut flux, mut vector, mut angle) = (Worst::new(), Worst::new(), Worst::new());
    for case in 0..60_000 {
        let placed = exact_polygon(robust_kind(&mut random), &mut random);
        let light = placed.light(Sides::Front);
        let light32 = light.cast::<f32>().unwrap();
        let (center, radius) = light.circumscribed_circle();
        let distance = random.log_range(2.0, 1e6);
        let towards = random.direction_above(placed.axes[2]);
        let point = exact(center + towards * (distance * radius));
        let normal = exact(random.direction_above(-towards));
        let direction = (center - point).normalize_or_zero();
        let lowest = placed
            .vertices()
            .iter()
            .map(|&v| normal.dot(v - point))
            .fold(f64::INFINITY, f64::min);
        let (cos_light, cos_receiver) = (-placed.axes[2].dot(direction), normal.dot(direction));
        if lowest < 1e-3 * radius || cos_light < 1e-3 {
            continue;
        }
        let place = || {
            format!(
                "{case}, {distance} away, {cos_light} {cos_receiver}: {point:?} {normal:?} {placed:?}"
            )
        };
        let e64 = irradiance(&light, point, normal);
        let e32 = f64::from(irradiance(&light32, single(point), single(normal)));
        flux.see((e32 / e64 - 1.0).abs() * cos_light * cos_receiver, place);
        let f64_ = light_vector(&light, point);
        let f32_ = light_vector(&light32, single(point));
        let error = (Vec3::new(f32_.x.into(), f32_.y.into(), f32_.z.into()) - f64_).length();
        vector.see(error / f64_.length() * cos_light, place);
        let o64 = solid_angle(&light, point);
        let o32 = f64::from(solid_angle(&light32, single(point)));
        angle.see((o32 / o64 - 1.0).abs() * cos_light, place);
    }
    flux.assert_below(2e-6, "irradiance, relative, times both cosines");
    vector.assert_below(
        2e-6,
        "light vector, relative, times the cosine at the light",
    );
    angle.assert_below(2e-6, "solid angle, relative, times the cosine at the light");
}

/// Where the light is cut, or close: the error is absolute, and grows towards an edge, next to
/// which rounding of the place alone turns the edge's direction.
#[test]
fn lights_near_and_cut() {
    let mut random = Random::new(22);
    let (mut flux, mut angle, mut above) = (Worst::new(), Worst::new(), Worst::new());
    for case in 0..60_000 {
        let placed = exact_polygon(robust_kind(&mut random), &mut random);
        let light = placed.light(Sides::Front);
        let light32 = light.cast::<f32>().unwrap();
        let height = random.log_range(1e-4, 3.0);
        let point = exact(placed.at(random.range(-1.5, 1.5), random.range(-1.5, 1.5), height));
        let normal = exact(random.direction());
        let nearness = placed.distance_to_edges(point).min(1.0);
        let place = || format!("{case}, {nearness} from an edge: {point:?} {normal:?} {placed:?}");
        let e64 = irradiance(&light, point, normal);
        let e32 = f64::from(irradiance(&light32, single(point), single(normal)));
        flux.see((e32 - e64).abs() * nearness, place);
        let o64 = solid_angle(&light, point);
        let o32 = f64::from(solid_angle(&light32, single(point)));
        angle.see((o32 - o64).abs() * nearness, place);
        let o64 = solid_angle_above(&light, point, normal);
        let o32 = f64::from(solid_angle_above(&light32, single(point), single(normal)));
        above.see((o32 - o64).abs() * nearness, place);
    }
    flux.assert_below(
        2e-6,
        "irradiance, absolute, times the distance from an edge in radii",
    );
    angle.assert_below(2e-6, "solid angle, absolute, times that distance");
    above.assert_below(
        3e-6,
        "solid angle above the horizon, absolute, times that distance",
    );
}

#[test]
fn lobes_near_and_far() {
    let mut random = Random::new(23);
    let (mut near, mut far, mut cut) = (Worst::new(), Worst::new(), Worst::new());
    for case in 0..60_000 {
        let placed = exact_polygon(robust_kind(&mut random), &mut random);
        let light = placed.light(Sides::Front);
        let light32 = light.cast::<f32>().unwrap();
        let (center, radius) = light.circumscribed_circle();
        let ltc32 = Ltc::<f32> {
            shading_to_cosine: [
                random.range(0.5, 4.0) as f32,
                random.range(-1.0, 1.0) as f32,
                random.range(-0.3, 0.3) as f32,
                random.range(0.7, 4.0) as f32,
            ],
            amplitude: 1.0,
            schlick: 0.0,
        };
        let ltc = Ltc {
            shading_to_cosine: ltc32.shading_to_cosine.map(f64::from),
            amplitude: 1.0,
            schlick: 0.0,
        };
        let distant = case % 2 == 0;
        let distance = match distant {
            true => random.log_range(8.0, 1e5),
            false => random.log_range(0.1, 3.0),
        };
        let towards = random.direction_above(placed.axes[2]);
        let point = exact(center + towards * (distance * radius));
        let normal = exact(random.direction_above(-towards));
        let view = exact(random.direction_above(normal));
        let lobe = PreparedLtc::new(&ltc, normal, view);
        let lobe32 = PreparedLtc::new(&ltc32, single(normal), single(view));
        let f64_ = ltc_form_factor(&light, point, &lobe);
        let f32_ = f64::from(ltc_form_factor(&light32, single(point), &lobe32));
        let place = || {
            format!("{case}, {distance} away: {ltc32:?} {point:?} {normal:?} {view:?} {placed:?}")
        };
        // Where the lobe ends, in world space.
        let [_, _, m31, m33] = ltc.shading_to_cosine;
        let tangent = (view - normal * normal.dot(view)).normalize_or_zero();
        let lobe_plane = tangent * m31 + normal * m33;
        let lowest = placed
            .vertices()
            .iter()
            .map(|&v| v - point)
            .map(|v| normal.dot(v).min(lobe_plane.dot(v)))
            .fold(f64::INFINITY, f64::min);
        if distant && lowest > 1e-3 * radius {
            // Relative to a light of this size and distance, face-on, where a cosine peaks.
            far.see((f32_ - f64_).abs() * distance * distance, place);
        } else if distant {
            cut.see((f32_ - f64_).abs(), place);
        } else {
            let nearness = placed.distance_to_edges(point).min(1.0);
            near.see((f32_ - f64_).abs() * nearness, place);
        }
    }
    far.assert_below(1e-5, "LTC beyond 8 radii, relative to a light face-on");
    cut.assert_below(2e-7, "LTC beyond 8 radii, cut by a horizon, absolute");
    near.assert_below(
        4e-6,
        "LTC within 3 radii, absolute, times the distance from an edge",
    );
}

/// A mirror's lobe keeps its direction when it is seen from next to its normal, where the view's
/// azimuth is short of digits.
#[test]
fn views_next_to_the_normal() {
    let mut random = Random::new(31);
    let mut worst = Worst::new();
    // A lobe of width 1e-3 about the view's mirror direction.
    let narrow = |tilt: f64| -> [f64; 4] {
        let (sine, cosine) = (tilt.sin(), tilt.cos());
        [cosine, sine, -1e-3 * sine, 1e-3 * cosine]
    };
    for _ in 0..2_000 {
        let normal = exact(random.direction());
        let across = normal.cross(random.direction());
        let across = across * (1.0 / across.length());
        let view = exact(normal + across * random.log_range(2e-6, 1e-3));
        let matrix = narrow(1e-4).map(|x| f64::from(x as f32));
        let ltc = |matrix| Ltc {
            shading_to_cosine: matrix,
            amplitude: 1.0,
            schlick: 0.0,
        };
        let lobe = PreparedLtc::new(&ltc(matrix), normal, view);
        let single_ltc = Ltc {
            shading_to_cosine: matrix.map(|x| x as f32),
            amplitude: 1.0,
            schlick: 0.0,
        };
        let got = PreparedLtc::new(&single_ltc, single(normal), single(view));
        // The normal through both maps: the lobe leans by less than a tenth of its width.
        let through = |rows: [Vec3<f64>; 3]| rows.map(|row| row.dot(normal));
        let rows = got
            .world_to_cosine()
            .map(|v| Vec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z)));
        let (a, b) = (through(rows), through(lobe.world_to_cosine()));
        let error = (0..3)
            .map(|i| (a[i] / a[2] - b[i] / b[2]).abs())
            .fold(0.0, f64::max);
        // Where rounding has the azimuth itself, as it does closer than 1e-5, only the lean counts.
        let lean = (a[0].hypot(a[1]) / a[2] - b[0].hypot(b[1]) / b[2]).abs();
        worst.see(lean.min(error), || format!("{normal:?} {view:?}"));
    }
    assert!(worst.error < 0.1, "{} at {}", worst.error, worst.at);
}

/// An edge along the horizon of a surface that is seen along its normal: both of the lobe's planes
/// are the same, and cut it once.
#[test]
fn an_edge_along_one_horizon() {
    let mut random = Random::new(32);
    let mut worst = Worst::new();
    for _ in 0..2_000 {
        let normal = exact(random.direction());
        let along = normal.cross(random.direction());
        let along = along * (1.0 / along.length());
        let away = normal.cross(along);
        let corner = |x: f64, y: f64, z: f64| -> [f64; 3] {
            exact(along * x + away * y + normal * z).into()
        };
        let (near, far) = (random.log_range(0.3, 3.0), random.log_range(0.3, 3.0));
        let outline = vec![
            corner(-near, 1.0, 0.0),
            corner(far, 1.0, 0.0),
            corner(far, 1.0, 1.0),
            corner(-near, 1.0, 1.0),
        ];
        let light = lumigon::PolygonLight::new(&[outline], Sides::Both).unwrap();
        let ltc = |like: f64| Ltc {
            shading_to_cosine: [1.0, 0.0, 0.0, 0.5 + like],
            amplitude: 1.0,
            schlick: 0.0,
        };
        let point = Vec3::default();
        let exact_lobe = PreparedLtc::new(&ltc(0.0), normal, normal);
        let expected = ltc_form_factor(&light, point, &exact_lobe);
        let single_ltc = Ltc {
            shading_to_cosine: [1.0_f32, 0.0, 0.0, 0.5],
            amplitude: 1.0,
            schlick: 0.0,
        };
        let lobe = PreparedLtc::new(&single_ltc, single(normal), single(normal));
        let light = light.cast::<f32>().unwrap();
        let got = ltc_form_factor(&light, Vec3::default(), &lobe);
        worst.see((f64::from(got) - expected).abs(), || format!("{normal:?}"));
    }
    assert!(worst.error < 2e-6, "{} at {}", worst.error, worst.at);
}

/// The pyramid's axis is found in single precision too, where areas are all rounding.
#[test]
fn pyramid_axes() {
    let mut random = Random::new(33);
    let mut worst = Worst::new();
    for _ in 0..4_000 {
        let placed = exact_polygon(robust_kind(&mut random), &mut random);
        let light = placed.light(Sides::Both);
        let (_, radius) = light.circumscribed_circle();
        let point = exact(random.direction() * (radius * random.log_range(0.3, 30.0)));
        let expected = lumigon::Pyramid::new(&light, point);
        let got = lumigon::Pyramid::new(&light.cast::<f32>().unwrap(), single(point));
        let axis = Vec3::new(
            f64::from(got.axis.x),
            f64::from(got.axis.y),
            f64::from(got.axis.z),
        );
        // In the light's plane there is no pyramid, and next to it rounding tilts the spread.
        if expected.area > 1e-3 {
            let error = (axis - expected.axis).length();
            worst.see(error, || format!("{point:?} from {placed:?}"));
        }
    }
    println!("axis: {}", worst.error);
    assert!(worst.error < 5e-5, "{} at {}", worst.error, worst.at);
}
