//! Indirect light alone, with and without surfaces between, against integrals of polygons.
//!
//! A matte surface under parallel light is as bright from everywhere as a polygon light of its shape.

use super::*;

const ALBEDO: [f64; 3] = [0.8, 0.5, 0.2];
/// On surfaces that face down.
const IRRADIANCE: f64 = 4.0;

fn wall(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Wall {
    let [corner, u, v] = [corner, u, v].map(DVec3::from);
    Wall { corner, u, v }
}

fn sheet([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], height: f64) -> Wall {
    wall([x0, y0, height], [x1 - x0, 0.0, 0.0], [0.0, y1 - y0, 0.0])
}

/// Surfaces over the floor [-1, 1]^2 at z = 0, in parallel light that rises along +x: what faces up is dark.
fn lit_from_below(walls: impl IntoIterator<Item = Wall>) -> TestScene {
    let mut scene = TestScene {
        walls: vec![sheet([-1.0, 1.0], [-1.0, 1.0], 0.0)],
        material: matte(ALBEDO),
        emitted: [0.5; 3],
        emitters: vec![],
        punctual_lights: vec![PunctualLight::Directional {
            direction: [0.96, 0.0, 0.28],
            irradiance: [IRRADIANCE / 0.28; 3],
        }],
    };
    scene.walls.extend(walls);
    scene
}

const SIZE: usize = 14;

/// Straight down at the floor, from just above it.
fn above_floor(x: f64, y: f64) -> Ray {
    let across = |x: f64| 1.8 * x / SIZE as f64 - 0.9;
    Ray {
        origin: [across(x), across(y), 0.01],
        direction: [0.0, 0.0, -1.0],
    }
}

fn single_bounce(shadows: bool, bounce_shadows: bool) -> Settings<'static> {
    Settings {
        bounces: 2,
        direct: false,
        shadows,
        bounce_shadows,
        ..settings(SIZE, 512)
    }
}

fn irradiance_of(loops: &[Vec<[f64; 3]>], point: [f64; 3]) -> f64 {
    let polygon = Polygon::new(loops, false).unwrap();
    let integral = irradiance(&polygon, point, [0.0, 0.0, 1.0], Tolerance::default());
    integral.unwrap().value
}

/// Compares a single bounce with polygons that shine as lit surfaces do, as seen from each point of the floor.
fn check(
    name: &str,
    scene: &TestScene,
    settings: &Settings<'_>,
    irradiance: impl Fn([f64; 3]) -> f64 + Sync,
) {
    let estimate = run(scene, &above_floor, settings);
    assert!(estimate.emitted.iter().all(|&light| light == [0.0; 3]));
    let truths: Vec<f64> = (0..SIZE * SIZE)
        .into_par_iter()
        .map(|i| {
            let ray = above_floor((i % SIZE) as f64 + 0.5, (i / SIZE) as f64 + 0.5);
            let [x, y, _] = ray.origin;
            irradiance([x, y, 0.0]) * FRAC_1_PI * IRRADIANCE * FRAC_1_PI
        })
        .collect();
    for (c, albedo) in ALBEDO.into_iter().enumerate() {
        let mean = estimate.diffuse.mean.iter();
        let z: Vec<f64> = mean
            .zip(&estimate.diffuse.standard_error)
            .zip(&truths)
            .map(|((mean, error), truth)| (mean[c] - albedo * albedo * truth) / error[c])
            .collect();
        assert_standard_normal(&format!("{name}, channel {c}"), &z);
    }
}

#[test]
fn lit_ceiling_is_a_polygon_light() {
    let (x, y) = ([-1.5, 1.2], [-0.4, 1.0]);
    let scene = lit_from_below([sheet(x, y, 1.0)]);
    // The floor's own shadow falls beside the ceiling.
    for (shadows, bounce_shadows) in [(false, false), (false, true), (true, true)] {
        check(
            &format!("ceiling, {shadows} {bounce_shadows}"),
            &scene,
            &single_bounce(shadows, bounce_shadows),
            |point| irradiance_of(&[rectangle(x, y, 1.0)], point),
        );
    }
}

#[test]
fn surface_between_blocks_only_with_bounce_shadows() {
    // It stands along the light: dark itself, and without a shadow.
    let (side, place, bottom, top) = ([-0.5, 0.6], 0.1, 0.5, 0.8);
    let ceiling = [-5.0, 5.0];
    let scene = lit_from_below([
        sheet(ceiling, ceiling, 1.0),
        wall(
            [side[0], place, bottom],
            [side[1] - side[0], 0.0, 0.0],
            [0.0, 0.0, top - bottom],
        ),
    ]);
    let whole = rectangle(ceiling, ceiling, 1.0);
    check("behind", &scene, &single_bounce(false, false), |point| {
        irradiance_of(std::slice::from_ref(&whole), point)
    });
    check("blocked", &scene, &single_bounce(false, true), |point| {
        // What it hides of the ceiling from this point.
        let through = |x: f64, z: f64| {
            let [px, py, _] = point;
            [px + (x - px) / z, py + (place - py) / z, 1.0]
        };
        let mut hidden = vec![
            through(side[0], bottom),
            through(side[1], bottom),
            through(side[1], top),
            through(side[0], top),
        ];
        // Holes turn the other way than outlines.
        if point[1] < place {
            hidden.reverse();
        }
        irradiance_of(&[whole.clone(), hidden], point)
    });
}

#[test]
fn sheets_behind_each_other_count_once_or_both() {
    let (low, high) = ([-0.4, 0.3], [-5.0, 5.0]);
    let scene = lit_from_below([sheet(low, low, 0.6), sheet(high, high, 1.0)]);
    let [near, far] = [rectangle(low, low, 0.6), rectangle(high, high, 1.0)];
    // As bright as what it hides, the near one is not to be told from it.
    check("nearest", &scene, &single_bounce(false, true), |point| {
        irradiance_of(std::slice::from_ref(&far), point)
    });
    check("both", &scene, &single_bounce(false, false), |point| {
        irradiance_of(std::slice::from_ref(&far), point)
            + irradiance_of(std::slice::from_ref(&near), point)
    });
}

/// Mean of a picture's reflected light, and its standard error.
fn mean(estimate: &Estimate, channel: &Channel, c: usize) -> (f64, f64) {
    let pixels = (estimate.width * estimate.height) as f64;
    let sum: f64 = channel.mean.iter().map(|m| m[c]).sum();
    let variance: f64 = channel.standard_error.iter().map(|e| e[c] * e[c]).sum();
    (sum / pixels, variance.sqrt() / pixels)
}

#[test]
fn paths_past_each_other_add_up() {
    // Three wide planes above one another, lit from above, nothing blocking anything. With albedo a, what faces down
    // gets a for each plane below, what faces up gets from each above: floor, first and second ceiling send to the
    // floor 3 a^2 after two reflections, 8 a^4 after four.
    let wide = [-1e5, 1e5];
    let scene = TestScene {
        walls: [0.0, 1.0, 2.0].map(|z| sheet(wide, wide, z)).into(),
        punctual_lights: vec![PunctualLight::Directional {
            direction: [0.0, 0.0, -1.0],
            irradiance: [PI; 3],
        }],
        ..lit_from_below([])
    };
    for (bounces, orders) in [
        (2, [0.0, 0.0]),
        (3, [3.0, 0.0]),
        (4, [3.0, 0.0]),
        (5, [3.0, 8.0]),
    ] {
        let deep = Settings {
            bounces,
            ..single_bounce(false, false)
        };
        let estimate = run(&scene, &above_floor, &deep);
        for (c, a) in ALBEDO.into_iter().enumerate() {
            let truth = orders[0] * a.powi(3) + orders[1] * a.powi(5);
            let (mean, error) = mean(&estimate, &estimate.diffuse, c);
            println!("{bounces} bounces, albedo {a}: {mean:.5} +- {error:.5}, truth {truth:.5}");
            assert!(
                (mean - truth).abs() <= 3.5 * error + 1e-9,
                "{bounces} {c}: {mean} +- {error}, {truth}"
            );
            assert!(error < 0.01 * truth.max(0.1));
        }
    }
}

#[test]
fn direct_and_indirect_are_all_light() {
    let mut scene = furnace(stack());
    scene.emitters.truncate(2);
    scene.punctual_lights = vec![PunctualLight::Point {
        position: [0.3, -0.2, 0.5],
        intensity: [0.4, 0.8, 0.1],
        range: None,
    }];
    let camera = furnace_camera(SIZE, 0.8);
    let with = |bounces, direct, seed| {
        let settings = Settings {
            bounces,
            direct,
            shadows: true,
            seed,
            ..settings(SIZE, 256)
        };
        run(&scene, &camera, &settings)
    };
    let [direct, indirect, all] = [with(1, true, 1), with(4, false, 2), with(4, true, 3)];
    assert_eq!(direct.emitted, all.emitted);
    assert!(indirect.emitted.iter().all(|&light| light == [0.0; 3]));
    for c in 0..3 {
        for (name, channel) in [
            ("diffuse", (|e| &e.diffuse) as fn(&Estimate) -> &Channel),
            ("specular", |e| &e.specular),
            ("total", |e| &e.total),
        ] {
            let [one, two, both] = [&direct, &indirect, &all].map(|e| mean(e, channel(e), c));
            let error = (one.1 * one.1 + two.1 * two.1 + both.1 * both.1).sqrt();
            let difference = one.0 + two.0 - both.0;
            println!(
                "{name} {c}: {:.4} + {:.4} = {:.4}, off by {difference:.5} +- {error:.5}",
                one.0, two.0, both.0
            );
            assert!(difference.abs() < 3.5 * error, "{name} {c}");
            assert!(error < 0.02 * two.0, "{name} {c}: {error}");
        }
    }
}

#[test]
fn closed_box_keeps_all_its_light() {
    // Walls that emit 1 and reflect a: a from the walls themselves, a^2 + a^3 + ... from their reflections.
    let scene = furnace(matte(ALBEDO));
    let settings = Settings {
        bounces: 80,
        direct: false,
        shadows: true,
        ..settings(10, 256)
    };
    let camera = furnace_camera(10, 0.8);
    let estimate = run(&scene, &camera, &settings);
    for (c, a) in ALBEDO.into_iter().enumerate() {
        let truth = a * a / (1.0 - a);
        let (mean, error) = mean(&estimate, &estimate.total, c);
        println!("albedo {a}: {mean:.5} +- {error:.5}, truth {truth:.5}");
        assert!(
            (mean - truth).abs() < 3.5 * error,
            "{c}: {mean} +- {error}, {truth}"
        );
        assert!(error < 0.01 * truth);
    }
    // Nothing lies behind the walls of a box.
    let through = Settings {
        bounce_shadows: false,
        ..settings
    };
    assert_eq!(run(&scene, &camera, &through), estimate);
}

#[test]
fn one_bounce_without_direct_light_is_black() {
    let settings = Settings {
        bounces: 1,
        direct: false,
        ..settings(4, 4)
    };
    let estimate = run(&floor(), &camera(4), &settings);
    let black = vec![[0.0; 3]; 16];
    assert_eq!(
        [
            &estimate.emitted,
            &estimate.total.mean,
            &estimate.total.standard_error
        ],
        [&black; 3]
    );
}
