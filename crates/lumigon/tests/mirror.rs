//! The narrowest lobes: linearly transformed cosines become mirrors.

mod polygons;

use lumigon::{
    InclusionRule, Ltc, MINIMUM_ALPHA, PreparedLtc, Real, Sides, Vec3, ltc_form_factor,
    reflected_inclusion,
};
use polygons::{KINDS, Placed, Random, Vector};

/// GGX in the limit of small alpha, where it is a transformed cosine and no fit: of the slopes
/// (tan of the angle from the mirrored view, over the widths) both have the density
/// 1 / (pi (1 + r^2)^2). The widths are 2 alpha in the plane of incidence and 2 alpha cos(theta)
/// across, and the cosine's plane lies on the surface.
fn mirror_lobe(alpha: f64, cos_view: f64) -> Ltc<f64> {
    let sin_view = (1.0 - cos_view * cos_view).sqrt();
    Ltc {
        shading_to_cosine: [cos_view * cos_view, cos_view * sin_view, 0.0, 2.0 * alpha],
        amplitude: 1.0,
        schlick: 0.0,
    }
}

fn cast(ltc: &Ltc<f64>) -> Ltc<f32> {
    Ltc {
        shading_to_cosine: ltc.shading_to_cosine.map(|x| x as f32),
        amplitude: 1.0,
        schlick: 0.0,
    }
}

fn single(v: Vector) -> Vec3<f32> {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// Angle between a ray from the point and the nearest edge.
fn angle_to_edges(placed: &Placed, point: Vector, direction: Vector) -> f64 {
    let angle = |v: Vector| direction.cross(v).length().atan2(direction.dot(v));
    let to_edge = |(a, b): (Vector, Vector)| {
        let (a, b) = (a - point, b - point);
        let normal = a.cross(b).normalize_or_zero();
        let foot = direction - normal * normal.dot(direction);
        let within = a.cross(foot).dot(normal) > 0.0 && foot.cross(b).dot(normal) > 0.0;
        if within {
            angle(foot)
        } else {
            angle(a).min(angle(b))
        }
    };
    placed
        .edges()
        .into_iter()
        .map(to_edge)
        .fold(f64::INFINITY, f64::min)
}

/// A light over or through the horizon, and a view whose reflection mostly goes towards it.
fn scene(case: usize, random: &mut Random) -> (Placed, Vector, Vector, Vector) {
    let placed = Placed::random(case % KINDS, random);
    let spread = random.range(0.0, 1.5);
    let height = random.log_range(0.1, 3.0);
    let point = placed.at(spread, random.range(-0.5, 0.5), height);
    let aim = placed.at(random.range(-1.2, 1.2), random.range(-1.2, 1.2), 0.0);
    let reflected = (aim - point).normalize_or_zero();
    let normal = random.direction_above(reflected);
    let view = normal * (2.0 * normal.dot(reflected)) - reflected;
    (placed, point, normal, view)
}

#[test]
fn narrow_lobes_are_the_reflected_ray() {
    let mut random = Random::new(41);
    let (mut worst, mut worst32) = (0.0_f64, 0.0_f64);
    let (mut hits, mut misses) = (0, 0);
    for case in 0..30_000 {
        let (placed, point, normal, view) = scene(case, &mut random);
        let cos_view = normal.dot(view);
        let reflected = normal * (2.0 * cos_view) - view;
        // The lobe's tail past an angle a is about (2 alpha / a)^2: 1.6e-5 here.
        if cos_view < 0.05 || angle_to_edges(&placed, point, reflected) < 0.05 {
            continue;
        }
        let light = placed.light(Sides::Front);
        let rule = InclusionRule::CrossingNumber;
        let inside = reflected_inclusion(&light, point, normal, view, rule);
        let lobe = mirror_lobe(MINIMUM_ALPHA, cos_view);
        let got = ltc_form_factor(&light, point, &PreparedLtc::new(&lobe, normal, view));
        let prepared = PreparedLtc::new(&cast(&lobe), single(normal), single(view));
        let light32 = light.cast::<f32>().unwrap();
        let got32 = f64::from(ltc_form_factor(&light32, single(point), &prepared));
        worst = worst.max((got - inside).abs());
        worst32 = worst32.max((got32 - got).abs());
        assert!(
            (got - inside).abs() < 2e-5 && (got32 - got).abs() < 1.5e-5,
            "{got}, {got32} in f32, is not {inside}: {case} {point:?} {normal:?} {view:?} {placed:#?}"
        );
        if inside == 1.0 {
            hits += 1;
        } else {
            misses += 1;
        }
    }
    println!("{hits} hits, {misses} misses: within {worst:e}; f32 within {worst32:e} of f64");
    assert!(hits > 1_000 && misses > 1_000, "{hits} {misses}");
}

/// The general map's lobe, and one in f32 at any view and place: in \[0, 1\].
#[test]
fn narrow_lobes_are_finite_everywhere() {
    let mut random = Random::new(42);
    for case in 0..20_000 {
        let (placed, point, normal, view) = scene(case, &mut random);
        // Grazing views too, and rays through edges and vertices.
        let (tangent, _) = normal.orthonormal_basis();
        let view = match case % 3 {
            0 => (tangent + normal * random.log_range(1e-6, 0.1)).normalize_or_zero(),
            1 => {
                let vertices = placed.vertices();
                let at = (vertices[random.index(vertices.len())] - point).normalize_or_zero();
                normal * (2.0 * normal.dot(at)) - at
            }
            _ => view,
        };
        let light = placed.light(Sides::Both);
        let lobe = mirror_lobe(MINIMUM_ALPHA, normal.dot(view).abs().max(1e-3));
        let prepared = PreparedLtc::new(&lobe, normal, view);
        let general = PreparedLtc::from_world_to_cosine(prepared.world_to_cosine(), normal);
        let got = ltc_form_factor(&light, point, &prepared);
        let again = ltc_form_factor(&light, point, &general);
        let prepared = PreparedLtc::new(&cast(&lobe), single(normal), single(view));
        let general = PreparedLtc::from_world_to_cosine(prepared.world_to_cosine(), single(normal));
        let light32 = light.cast::<f32>().unwrap();
        let got32 = ltc_form_factor(&light32, single(point), &prepared);
        let again32 = ltc_form_factor(&light32, single(point), &general);
        for value in [got, again, f64::from(got32), f64::from(again32)] {
            assert!(
                (0.0..=1.0).contains(&value),
                "{value}: {case} {point:?} {normal:?} {view:?} {placed:#?}"
            );
        }
        assert!((got - again).abs() < 1e-8, "{got} {again}: {case}");
    }
}

/// An edge through the reflected ray: half the lobe, and the profile across it is the closed form
/// (1 + u / sqrt(1 + u^2)) / 2, u widths from the edge.
#[test]
fn profile_across_an_edge() {
    for cos_view in [1.0, 0.6, 0.1] {
        let sin_view = f64::sqrt(1.0 - cos_view * cos_view);
        let normal = Vec3::new(0.0, 0.0, 1.0);
        let view = Vec3::new(sin_view, 0.0, cos_view);
        let width = 2.0 * MINIMUM_ALPHA;
        for u in [-3.0, -1.0, 0.0, 0.5, 2.0] {
            // A wide light across the ray, whose edge is u widths aside in the plane of incidence.
            let across = Vec3::new(cos_view, 0.0, sin_view);
            let ahead = Vec3::new(-sin_view, 0.0, cos_view);
            let corner = |along: f64, aside: f64| {
                let v = ahead + across * along + Vec3::new(0.0, aside, 0.0);
                [v.x, v.y, v.z]
            };
            let edge = u * width;
            let far = cos_view.min(0.5) * 0.5;
            let outline = vec![
                corner(edge, -1.0),
                corner(edge - far, -1.0),
                corner(edge - far, 1.0),
                corner(edge, 1.0),
            ];
            let light = lumigon::PolygonLight::new(&[outline], Sides::Both).unwrap();
            let lobe = mirror_lobe(MINIMUM_ALPHA, cos_view);
            let prepared = PreparedLtc::new(&lobe, normal, view);
            let got = ltc_form_factor(&light, Vec3::default(), &prepared);
            // The tilt of the cosine's plane stretches the widths by cos / (cos + u width sin).
            let slope = u * cos_view / (cos_view + edge * sin_view);
            let want = 0.5 * (1.0 + slope / f64::sqrt(1.0 + slope * slope));
            assert!((got - want).abs() < 1e-5, "{cos_view} {u}: {got} {want}");
            // In f32 an offset of 1 is rounded by 6e-8, which is 3e-4 widths.
            let light32 = light.cast::<f32>().unwrap();
            let prepared = PreparedLtc::new(&cast(&lobe), single(normal), single(view));
            let got32 = ltc_form_factor(&light32, Vec3::default(), &prepared);
            assert!(
                (f64::from(got32) - want).abs() < 1e-3,
                "{cos_view} {u}: {got32} {want}"
            );
            assert!(Real::abs(got32) <= 1.0);
        }
    }
}
