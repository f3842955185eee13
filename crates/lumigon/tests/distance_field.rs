//! Reflections from baked distance fields against GGX.

use lumigon::{
    DistanceField, DistanceFieldSettings, DistanceFieldSmoothness, Ltc, LtcTable,
    PlacedDistanceField, PolygonLight, PreparedLtc, Sides, Vec3, ltc_form_factor,
    reflected_distance,
};

/// A polygon of so many vertices, every other one at `inner`, flattened to `height`, in z = 0.
fn polygon(count: usize, height: f64, inner: f64) -> PolygonLight<f64> {
    let vertices: Vec<_> = (0..count)
        .map(|i| {
            let angle = std::f64::consts::TAU * (i as f64 + 0.5) / count as f64;
            let radius = if i % 2 == 0 { 1.0 } else { inner };
            [radius * angle.cos(), height * radius * angle.sin(), 0.0]
        })
        .collect();
    PolygonLight::new(&[vertices], Sides::Both).unwrap()
}

const NORMAL: Vec3<f64> = Vec3::new(0.0, 0.0, 1.0);

/// GGX with F = 1 by the two-lobed table, whose own error is a tenth of what is measured here.
fn ggx(light: &PolygonLight<f64>, point: Vec3<f64>, view: Vec3<f64>, alpha: f64) -> f64 {
    let table = LtcTable::ggx_2();
    let sum = table.lookup(alpha.sqrt() as f32, view.z as f32);
    let lobe = |lobe: &Ltc<f32>| {
        let lobe = Ltc {
            shading_to_cosine: lobe.shading_to_cosine.map(f64::from),
            amplitude: lobe.amplitude.into(),
            schlick: 0.0,
        };
        lobe.amplitude * ltc_form_factor(light, point, &PreparedLtc::new(&lobe, NORMAL, view))
    };
    sum.iter().map(lobe).sum()
}

/// Root mean square errors for several factors to the smoothness, and of no reflection.
fn errors<const N: usize>(settings: DistanceFieldSettings, factors: [f32; N]) -> ([f64; N], f64) {
    let (mut errors, mut unlit, mut count) = ([0.0; N], 0.0, 0.0);
    for light in [
        polygon(4, 1.0, 1.0),
        polygon(4, 0.4, 1.0),
        polygon(10, 1.0, 0.5),
    ] {
        let field = DistanceField::new(&light, settings);
        let placed = PlacedDistanceField::own(&field);
        for alpha in [
            0.003, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0,
        ] {
            for height in [1.0, 2.0, 4.0, 8.0, 16.0] {
                for cosine in [1.0_f64, 0.9, 0.7, 0.5] {
                    let sine = (1.0 - cosine * cosine).sqrt();
                    let view = Vec3::new(-sine, 0.0, cosine);
                    for i in 0..91 {
                        // Where the mirrored view meets the light's plane.
                        let (x, y) = (0.5 * f64::from(i % 13) - 3.0, 0.5 * f64::from(i / 13));
                        if x * x + y * y > 9.0 {
                            continue;
                        }
                        let point = Vec3::new(x - height / cosine * sine, y, -height);
                        let exact = ggx(&light, point, view, alpha);
                        for (error, factor) in errors.iter_mut().zip(factors) {
                            let smoothness = DistanceFieldSmoothness::of_material(factor).unwrap();
                            let got = reflected_distance(
                                &light, placed, point, NORMAL, view, alpha, smoothness,
                            );
                            *error += (got - exact) * (got - exact);
                        }
                        unlit += exact * exact;
                        count += 1.0;
                    }
                }
            }
        }
    }
    let root = |sum: f64| (sum / count).sqrt();
    (errors.map(root), root(unlit))
}

/// What `distance_field_smoothness` states.
#[test]
fn smoothness_is_fitted_to_ggx() {
    for phi in [1.5, 2.0, 3.0] {
        let settings = DistanceFieldSettings::new(128, phi, false).unwrap();
        let ([half, fitted, double], unlit) = errors(settings, [0.5, 1.0, 2.0]);
        println!("phi {phi}: {half} {fitted} {double} of {unlit}");
        assert!(fitted < 0.031 && fitted < half && fitted < double);
        assert!(unlit > 0.1);
    }
}
