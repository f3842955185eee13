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
