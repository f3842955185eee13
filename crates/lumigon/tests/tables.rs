//! The shipped tables, in single precision, against independent truth values.

use lumigon::{
    AnisotropicLtcTable, Ltc, LtcSum, LtcTable, PolygonLight, PreparedLtc, Sides, Vec3,
    ggx_polynomial, ltc_form_factor,
};
use serde::Deserialize;

type Vector = Vec3<f32>;

#[derive(Deserialize)]
struct Case {
    loops: Vec<Vec<[f64; 3]>>,
    point: [f64; 3],
    normal: [f64; 3],
    view: [f64; 3],
    tangent: Option<[f64; 3]>,
    perceptual_roughness: Option<f64>,
    sheen_perceptual_roughness: Option<f64>,
    diffuse_roughness: Option<f64>,
    alpha: Option<serde_json::Value>,
    truth: Option<f64>,
    truth_schlick: Option<f64>,
    truth_single: Option<f64>,
    truth_multiple: Option<f64>,
}

fn cases(name: &str) -> Vec<Case> {
    let path = format!(
        "{}/../../tests/truth/{name}.jsonl",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn single(v: [f64; 3]) -> Vector {
    Vec3::from(v.map(|x| x as f32))
}

impl Case {
    fn light(&self) -> PolygonLight<f32> {
        PolygonLight::new(&self.loops, Sides::Front)
            .unwrap()
            .cast()
            .unwrap()
    }

    /// Sums over lobes: F = 1 and under the second weight.
    fn response<'a>(&self, lobes: impl IntoIterator<Item = &'a Ltc<f32>>) -> [f64; 2] {
        let (light, point) = (self.light(), single(self.point));
        let (normal, view) = (single(self.normal), single(self.view));
        let mut sums = [0.0; 2];
        for lobe in lobes {
            let prepared = PreparedLtc::new(lobe, normal, view);
            let form_factor = ltc_form_factor(&light, point, &prepared);
            sums[0] += f64::from(lobe.amplitude * form_factor);
            sums[1] += f64::from(lobe.schlick * form_factor);
        }
        sums
    }

    fn cos_view(&self) -> f32 {
        single(self.normal).dot(single(self.view))
    }
}

/// Errors over many lights.
#[derive(Default)]
struct Errors {
    squares: f64,
    count: f64,
    relative: Vec<f64>,
}

impl Errors {
    fn add(&mut self, got: f64, truth: f64) {
        assert!(got.is_finite() && got >= 0.0);
        self.squares += (got - truth).powi(2);
        self.count += 1.0;
        if truth > 1e-3 {
            self.relative.push((got - truth).abs() / truth);
        }
    }

    fn rmse(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }

    fn median_relative(&mut self) -> f64 {
        self.relative.sort_by(f64::total_cmp);
        self.relative[self.relative.len() / 2]
    }
}

fn ggx<const LOBES: usize>(lookup: impl Fn(f32, f32) -> LtcSum<LOBES>) -> [Errors; 2] {
    let mut errors = [Errors::default(), Errors::default()];
    let cases = cases("ggx");
    assert_eq!(cases.len(), 800);
    for case in &cases {
        let lobes = lookup(case.perceptual_roughness.unwrap() as f32, case.cos_view());
        let [value, schlick] = case.response(lobes.iter());
        errors[0].add(value, case.truth.unwrap());
        errors[1].add(schlick, case.truth_schlick.unwrap());
    }
    errors
}

#[test]
fn one_lobe() {
    let table = LtcTable::ggx();
    let [mut whole, schlick] = ggx(|u, cosine| table.lookup(u, cosine));
    let (rmse, median) = (whole.rmse(), whole.median_relative());
    println!(
        "ggx: RMSE {rmse:.5}, median relative {median:.4}, Schlick-weighted {:.5}",
        schlick.rmse()
    );
    assert!(rmse <= 0.0065 && median <= 0.012, "{rmse} {median}");
    assert!(schlick.rmse() <= 0.0065, "{}", schlick.rmse());
}

#[test]
fn two_lobes() {
    let table = LtcTable::ggx_2();
    let [mut whole, schlick] = ggx(|u, cosine| table.lookup(u, cosine));
    let (rmse, median) = (whole.rmse(), whole.median_relative());
    println!(
        "ggx-2: RMSE {rmse:.5}, median relative {median:.4}, Schlick-weighted {:.5}",
        schlick.rmse()
    );
    assert!(rmse <= 0.0025 && median <= 0.012, "{rmse} {median}");
    assert!(schlick.rmse() <= 0.0040, "{}", schlick.rmse());
}

#[test]
fn polynomial() {
    let [mut whole, schlick] = ggx(ggx_polynomial);
    let (rmse, median) = (whole.rmse(), whole.median_relative());
    println!(
        "ggx polynomial: RMSE {rmse:.5}, median relative {median:.4}, Schlick-weighted {:.5}",
        schlick.rmse()
    );
    assert!(rmse <= 0.0065 && median <= 0.012, "{rmse} {median}");
}

/// The narrowest lobes are mirrors: all of a light that the reflected ray hits well inside, nothing
/// of one that it misses.
#[test]
fn smooth_surfaces_reflect_like_mirrors() {
    let (one, two) = (LtcTable::ggx(), LtcTable::ggx_2());
    let (normal, origin) = (Vec3::new(0.0_f32, 0.0, 1.0), Vec3::new(0.0, 0.0, 0.0));
    for perceptual_roughness in [0.0_f32, 0.01, 0.014, 0.03] {
        for step in 0..200 {
            let angle = 1.5 * step as f32 / 200.0;
            let azimuth = 7.0 * angle;
            let (sine, cosine) = angle.sin_cos();
            let view = Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
            let mirrored = Vec3::new(-view.x, -view.y, view.z);
            let (s, t) = mirrored.orthonormal_basis();
            for (offset, expected) in [(0.0_f32, 1.0_f32), (0.06, 0.0)] {
                // A square of 0.02 to either side, one unit away, or three times that beside.
                let center = mirrored + s * offset;
                let corner = |x: f32, y: f32| <[f32; 3]>::from(center + s * x + t * y);
                let outline = [(-0.02, -0.02), (-0.02, 0.02), (0.02, 0.02), (0.02, -0.02)]
                    .map(|(x, y)| corner(x, y).map(f64::from))
                    .to_vec();
                let light = PolygonLight::new(&[outline], Sides::Both).unwrap();
                let light: PolygonLight<f32> = light.cast().unwrap();
                let response = |lobes: &mut dyn Iterator<Item = &Ltc<f32>>| -> f32 {
                    lobes
                        .map(|lobe| {
                            let prepared = PreparedLtc::new(lobe, normal, view);
                            lobe.amplitude * ltc_form_factor(&light, origin, &prepared)
                        })
                        .sum()
                };
                let (a, b) = (
                    one.lookup(perceptual_roughness, cosine),
                    two.lookup(perceptual_roughness, cosine),
                );
                for got in [response(&mut a.iter()), response(&mut b.iter())] {
                    assert!(
                        (got - expected).abs() < 0.03,
                        "{perceptual_roughness} {angle}: {got} for {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn anisotropic() {
    let table = AnisotropicLtcTable::ggx();
    let isotropic = LtcTable::ggx();
    let [mut whole, mut schlick, mut stand_in] = [(); 3].map(|()| Errors::default());
    for case in cases("ggx_anisotropic") {
        let alpha: [f32; 2] = serde_json::from_value(case.alpha.clone().unwrap()).unwrap();
        let normal = single(case.normal);
        let tangent = single(case.tangent.unwrap());
        let tangent = (tangent - normal * normal.dot(tangent)).normalize_or_zero();
        let bitangent = normal.cross(tangent);
        let view = single(case.view);
        let local = Vec3::new(tangent.dot(view), bitangent.dot(view), normal.dot(view));
        let lobe = table.lookup(alpha, local);
        let prepared = lobe.prepare(tangent, bitangent, normal);
        let form_factor = ltc_form_factor(&case.light(), single(case.point), &prepared);
        whole.add(f64::from(lobe.amplitude * form_factor), case.truth.unwrap());
        schlick.add(
            f64::from(lobe.schlick * form_factor),
            case.truth_schlick.unwrap(),
        );
        let mean = (alpha[0] * alpha[1]).sqrt().sqrt();
        let lobes = isotropic.lookup(mean, case.cos_view());
        stand_in.add(case.response(lobes.iter())[0], case.truth.unwrap());
    }
    println!(
        "anisotropic: RMSE {:.5}, median relative {:.4}, Schlick-weighted {:.5}; isotropic stand-in: {:.5}, {:.4}",
        whole.rmse(),
        whole.median_relative(),
        schlick.rmse(),
        stand_in.rmse(),
        stand_in.median_relative(),
    );
    assert!(whole.rmse() <= 0.010, "{}", whole.rmse());
    assert!(whole.rmse() < 0.5 * stand_in.rmse());
}

#[test]
fn sheen() {
    let table = LtcTable::charlie();
    let mut errors = Errors::default();
    for case in cases("charlie") {
        let roughness = case.sheen_perceptual_roughness.unwrap() as f32;
        let lobes = table.lookup(roughness, case.cos_view());
        errors.add(case.response(lobes.iter())[0], case.truth.unwrap());
    }
    println!(
        "charlie: RMSE {:.5}, median relative {:.4}",
        errors.rmse(),
        errors.median_relative()
    );
    assert!(errors.rmse() <= 0.005, "{}", errors.rmse());
}

#[test]
fn rough_diffuse() {
    let table = LtcTable::eon();
    let [mut one, mut many] = [(); 2].map(|()| Errors::default());
    for case in cases("eon") {
        let lobes = table.lookup(case.diffuse_roughness.unwrap() as f32, case.cos_view());
        let [value, second] = case.response(lobes.iter());
        one.add(value, case.truth_single.unwrap());
        many.add(second, case.truth_multiple.unwrap());
    }
    println!(
        "eon: single scattering RMSE {:.5}, median relative {:.4}; multiple {:.5}",
        one.rmse(),
        one.median_relative(),
        many.rmse()
    );
    assert!(one.rmse() <= 0.005 && many.rmse() <= 0.005);
}

/// The symmetries that a table of one quadrant and one order of widths leaves to its lookup: a
/// turned or mirrored surface reflects turned or mirrored light.
#[test]
fn anisotropic_symmetries() {
    let table = AnisotropicLtcTable::ggx();
    let view = Vec3::new(0.6_f32, 0.35, 0.72).normalize_or_zero();
    let light = Vec3::new(-0.5_f32, -0.4, 0.77).normalize_or_zero();
    let lobe = table.lookup([0.5, 0.1], view);
    let density = lobe.density(light);
    assert!(density > 0.1);
    for (x, y) in [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        let flip = |v: Vector| Vec3::new(v.x * x, v.y * y, v.z);
        let there = table.lookup([0.5, 0.1], flip(view)).density(flip(light));
        assert!((there / density - 1.0).abs() < 1e-4, "{there} {density}");
    }
    // A quarter turn exchanges the widths.
    let turn = |v: Vector| Vec3::new(-v.y, v.x, v.z);
    let turned = table.lookup([0.1, 0.5], turn(view));
    assert!((turned.density(turn(light)) / density - 1.0).abs() < 1e-4);
    assert_eq!(turned.amplitude, lobe.amplitude);
}

/// Anywhere in the tables: lobes of positive determinant whose albedos are at most 1.
#[test]
fn lookups_are_lobes_everywhere() {
    let check = |lobe: &Ltc<f32>| {
        let [m11, m13, m31, m33] = lobe.shading_to_cosine;
        assert!(m11 * m33 - m13 * m31 > 0.0, "{lobe:?}");
        assert!(lobe.amplitude >= 0.0 && lobe.schlick >= 0.0);
    };
    let (one, two) = (LtcTable::ggx(), LtcTable::ggx_2());
    let (charlie, eon) = (LtcTable::charlie(), LtcTable::eon());
    let anisotropic = AnisotropicLtcTable::ggx();
    for i in 0..=400 {
        for j in 0..=100 {
            let (u, cosine) = (i as f32 / 400.0, j as f32 / 100.0);
            for lobe in one.lookup(u, cosine).iter() {
                check(lobe);
            }
            two.lookup(u, cosine).iter().for_each(check);
            charlie.lookup(u, cosine).iter().for_each(check);
            eon.lookup(u, cosine).iter().for_each(check);
            ggx_polynomial(u, cosine).iter().for_each(check);
            assert!(ggx_polynomial(u, cosine).albedo() < 1.0 + 1e-5);
            assert!(one.lookup(u, cosine).albedo() < 1.0 + 1e-5);
            assert!(two.lookup(u, cosine).albedo() < 1.0 + 1e-5);
            let sine = (1.0 - cosine * cosine).sqrt();
            let azimuth = 7.0 * u;
            let view = Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
            let lobe = anisotropic.lookup([u, 1.0 - u * cosine], view);
            let [a, b, c] = lobe.shading_to_cosine.map(Vec3::from);
            assert!(a.dot(b.cross(c)) > 0.0, "{lobe:?}");
        }
    }
    for (u, cosine) in [
        (f32::NAN, f32::NAN),
        (-1.0, 2.0),
        (f32::INFINITY, f32::NEG_INFINITY),
    ] {
        one.lookup(u, cosine).iter().for_each(check);
        let lobe = anisotropic.lookup([u, cosine], Vec3::new(u, cosine, u));
        assert!(lobe.amplitude.is_finite());
    }
}

/// Linear lookup leaves ripples between texels. As roughness or view sweeps from one texel to the
/// next, the error is straight but for this much: the largest of |e(a) - 2 e(middle) + e(b)| / 2
/// over texels and lights of radiance 1.
fn ripple<const LOBES: usize>(table: &LtcTable<LOBES>) -> f64 {
    let square = |x: f64, y: f64, half: f64| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(sx, sy)| [x + sx * half, y + sy * half, 1.0])
            .to_vec()
    };
    let normal = Vec3::new(0.0_f32, 0.0, 1.0);
    let last = (table.size() - 1) as f64;
    let mut worst = 0.0_f64;
    for outline in [
        square(0.0, 0.0, 0.7),
        square(-1.5, 0.0, 0.5),
        square(-6.0, 1.0, 2.5),
    ] {
        let light = PolygonLight::new(std::slice::from_ref(&outline), Sides::Both).unwrap();
        let light: PolygonLight<f32> = light.cast().unwrap();
        let polygon = lumigon_reference::Polygon::new(&[outline], true).unwrap();
        let error = |u: f64, v: f64| {
            let cosine = 1.0 - v * v;
            let view = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
            let truth = lumigon_reference::ggx(
                &polygon,
                [0.0; 3],
                [0.0, 0.0, 1.0],
                view,
                u * u,
                lumigon_reference::Tolerance::default(),
            )
            .unwrap();
            let mut response = 0.0;
            for lobe in table.lookup(u as f32, cosine as f32).iter() {
                let prepared = PreparedLtc::new(lobe, normal, single(view));
                let form_factor = ltc_form_factor(&light, single([0.0; 3]), &prepared);
                response += f64::from(lobe.amplitude * form_factor);
            }
            response - truth.value
        };
        for row in (1..29).step_by(3) {
            for column in (3..31).step_by(3) {
                let (u, v) = (f64::from(column) / last, f64::from(row) / last);
                let here = error(u, v);
                for (du, dv) in [(1.0 / last, 0.0), (0.0, 1.0 / last)] {
                    let middle = error(u + 0.5 * du, v + 0.5 * dv);
                    let there = error(u + du, v + dv);
                    worst = worst.max(0.5 * (here - 2.0 * middle + there).abs());
                }
            }
        }
    }
    worst
}

/// Below what a display of 8 bits can show.
#[test]
fn no_bands() {
    for (name, ripple) in [
        ("ggx", ripple(&LtcTable::ggx())),
        ("ggx-2", ripple(&LtcTable::ggx_2())),
    ] {
        println!("{name}: ripple between texels up to {ripple:.5}");
        assert!(ripple < 1.0 / 255.0, "{name}: {ripple}");
    }
}
