//! Any loops at all: a light with sound numbers, or an error that says what is wrong.

use lumigon::{PolygonError, PolygonLight, Pyramid, Sides, Vec3, irradiance, solid_angle};
use proptest::prelude::*;

/// Coordinates as files bring them: plain, equal, enormous, tiny, not numbers.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -2.0..2.0,
        4 => (-3_i32..=3).prop_map(f64::from),
        1 => any::<f64>(),
        1 => (-300..300_i32).prop_map(|e| 10_f64.powi(e)),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX, 5e-324]),
    ]
}

/// Loops whose coordinates all come from one strategy.
fn loops(coordinate: impl Strategy<Value = f64>) -> impl Strategy<Value = Vec<Vec<[f64; 3]>>> {
    let vertex = prop::array::uniform3(coordinate);
    prop::collection::vec(prop::collection::vec(vertex, 0..8), 0..4)
}

/// Loops in one plane, so that most of them pass.
fn planar(coordinate: impl Strategy<Value = f64>) -> impl Strategy<Value = Vec<Vec<[f64; 3]>>> {
    let slopes = (-3.0..3.0_f64, -3.0..3.0_f64, -3.0..3.0_f64);
    (loops(coordinate), slopes).prop_map(|(mut loops, (a, b, c))| {
        for v in loops.iter_mut().flatten() {
            v[2] = a * v[0] + b * v[1] + c;
        }
        loops
    })
}

fn check(loops: &[Vec<[f64; 3]>]) -> Result<(), TestCaseError> {
    let light = match PolygonLight::new(loops, Sides::Both) {
        Ok(light) => light,
        Err(fault) => {
            prop_assert!(!fault.to_string().is_empty());
            return Ok(());
        }
    };
    let normal = light.normal();
    prop_assert!((normal.length() - 1.0).abs() < 1e-9, "{normal:?}");
    prop_assert!(light.area().is_finite() && light.area() >= 0.0);
    let (center, radius) = light.circumscribed_circle();
    prop_assert!(radius > 0.0 && radius.is_finite());
    prop_assert!(center.x.is_finite() && center.y.is_finite() && center.z.is_finite());
    let centroid = light.centroid();
    prop_assert!(centroid.x.is_finite() && centroid.y.is_finite() && centroid.z.is_finite());
    prop_assert_eq!(
        light.vertex_count(),
        loops.iter().map(Vec::len).sum::<usize>()
    );
    // Vertices lie in the circle and the plane: what the clip's early-outs rely on.
    for vertex in light.loops().flatten() {
        let offset = (vertex - center) * (1.0 / radius);
        let place = center.length() / radius * 1e-15;
        prop_assert!(offset.length() <= 1.0 + 1e-9 + place, "{offset:?}");
        prop_assert!(normal.dot(offset).abs() <= 1e-9 + place, "{offset:?}");
    }
    let point = center - normal * radius;
    for value in [
        irradiance(&light, point, normal),
        solid_angle(&light, point),
        Pyramid::new(&light, point).area,
    ] {
        // Loops that overlap or wind backwards count by their winding: no upper bound.
        prop_assert!(value.is_finite() && value >= 0.0, "{value}");
    }
    match light.cast::<f32>() {
        Ok(single) => {
            let point = Vec3::new(point.x as f32, point.y as f32, point.z as f32);
            prop_assert!(!solid_angle(&single, point).is_nan());
        }
        Err(fault) => {
            let out_of_range = matches!(fault, PolygonError::OutOfRange { .. });
            prop_assert!(out_of_range, "{fault}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 4_000,
        rng_seed: prop::test_runner::RngSeed::Fixed(41),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_loops(loops in loops(coordinate())) {
        check(&loops)?;
    }

    #[test]
    fn planar_loops(loops in planar(-2.0..2.0_f64)) {
        check(&loops)?;
    }

    #[test]
    fn planar_loops_on_a_grid(loops in planar((-3_i32..=3).prop_map(f64::from))) {
        check(&loops)?;
    }

    #[test]
    fn planar_loops_of_any_size(loops in planar(coordinate())) {
        check(&loops)?;
    }
}
