//! Images on lights: what must hold of every method, whatever its accuracy.

mod polygons;

use fearless_simd::{Level, Simd, dispatch};
use lumigon::{
    DiffuseMethod, ImageMethod, Lanes, LightImage, LightImageError, LocalOcclusion, Ltc,
    PolygonLight, PreparedLtc, ProjectionBasis, Sides, Vec3, irradiance, ltc_form_factor,
    ltc_mean_image,
};
use polygons::{Random, Vector};

const METHODS: [ImageMethod; 5] = [
    ImageMethod::Lookup,
    ImageMethod::Quadrature { taps: 1 },
    ImageMethod::Quadrature { taps: 2 },
    ImageMethod::Quadrature { taps: 3 },
    ImageMethod::Quadrature { taps: 4 },
];

const DIFFUSE: [DiffuseMethod; 6] = [
    DiffuseMethod::Exact {
        occlusion: LocalOcclusion::Exact,
    },
    DiffuseMethod::LightVector {
        occlusion: LocalOcclusion::Exact,
    },
    DiffuseMethod::LightVector {
        occlusion: LocalOcclusion::Circle,
    },
    DiffuseMethod::ProjectedArea {
        basis: ProjectionBasis::Centroid,
        occlusion: LocalOcclusion::Exact,
    },
    DiffuseMethod::ProjectedArea {
        basis: ProjectionBasis::Biased { bias: 0.3 },
        occlusion: LocalOcclusion::Circle,
    },
    DiffuseMethod::ProjectedArea {
        basis: ProjectionBasis::Optimal,
        occlusion: LocalOcclusion::Exact,
    },
];

/// A concave outline with a hole in the plane z = 0, facing down.
fn outline() -> [Vec<[f64; 3]>; 2] {
    let up = |points: &[[f64; 2]]| points.iter().map(|p| [p[0], p[1], 0.0]).collect();
    [
        up(&[[0.0, 0.0], [0.1, 1.0], [0.5, 0.6], [1.0, 0.9], [1.0, 0.0]]),
        up(&[[0.4, 0.2], [0.7, 0.2], [0.5, 0.4]]),
    ]
}

/// On its bounding square.
const SQUARE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn noise(count: usize, random: &mut Random) -> Vec<[f32; 3]> {
    let mut color = || [(); 3].map(|()| random.range(0.0, 1.0) as f32);
    (0..count).map(|_| color()).collect()
}

fn single(v: Vector) -> Vec3<f32> {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// A lobe and its place: point, normal and view.
fn place(random: &mut Random) -> (Vector, Vector, Vector, Ltc<f64>) {
    let point = Vec3::new(
        random.range(-2.0, 3.0),
        random.range(-2.0, 3.0),
        -random.log_range(1e-3, 1e3),
    );
    let normal = random.direction();
    let view = random.direction_above(normal);
    let mut lobe = Ltc::cosine(0.0);
    let alpha = random.log_range(0.01, 1.0);
    lobe.shading_to_cosine = [
        1.0 / alpha,
        random.range(-2.0, 2.0),
        random.range(-0.5, 0.5),
        1.0,
    ];
    if random.chance(0.5) {
        lobe.shading_to_cosine = [1.0, 0.0, 0.0, alpha];
    }
    (point, normal, view, lobe)
}

/// A constant image changes nothing, to rounding.
#[test]
fn constant_images_are_no_images() {
    let light = PolygonLight::new(&outline(), Sides::Front).unwrap();
    let light: PolygonLight<f64> = light;
    let mut image = LightImage::<f32>::new(&light, SQUARE, [64, 32]).unwrap();
    image.filter_gaussian_levels();
    let color = [0.1_f32, 3.7, 20_000.0];
    image.replace(&vec![color; 64 * 32]).unwrap();
    let light = light.cast::<f32>().unwrap();
    let mut random = Random::new(1);
    for _ in 0..2_000 {
        let (point, normal, view, lobe) = place(&mut random);
        let [point, normal, view] = [point, normal, view].map(single);
        let mut narrow = Ltc::cosine(0.0_f32);
        narrow.shading_to_cosine = lobe.shading_to_cosine.map(|m| m as f32);
        let lobe = PreparedLtc::new(&narrow, normal, view);
        for method in METHODS {
            let found = DIFFUSE.map(|d| d.mean_image(&light, &image, point, normal, method));
            let specular = ltc_mean_image(&light, &image, point, &lobe, method);
            for mean in found.into_iter().chain([specular]) {
                for (mean, color) in mean.into_iter().zip(color) {
                    assert!(
                        (mean / color - 1.0).abs() < 1e-6,
                        "{method:?} {mean} {color}"
                    );
                }
            }
        }
    }
}

/// No colour is darker or brighter than the image has it, on hostile places too, and lanes agree
/// with scalars.
#[test]
fn means_lie_within_the_image() {
    let light = PolygonLight::new(&outline(), Sides::Both).unwrap();
    let mut image = LightImage::<f32>::new(&light, SQUARE, [16, 64]).unwrap();
    image.filter_gaussian_levels();
    image.replace(&noise(16 * 64, &mut Random::new(2))).unwrap();
    let light = light.cast::<f32>().unwrap();
    let mut random = Random::new(3);
    for round in 0..4_000 {
        let (mut point, normal, view, mut lobe) = place(&mut random);
        match round % 8 {
            0 => point.z = 0.0,
            1 => point.z = -1e-12,
            2 => point = point * 1e8,
            3 => point.z = -1e5,
            4 => lobe.shading_to_cosine = [1e4, 3e3, 0.1, 1.0],
            _ => {}
        }
        let mut narrow = Ltc::cosine(0.0_f32);
        narrow.shading_to_cosine = lobe.shading_to_cosine.map(|m| m as f32);
        let [point, normal, view] = [point, normal, view].map(single);
        let prepared = PreparedLtc::new(&narrow, normal, view);
        for method in METHODS {
            let mut found: Vec<_> = DIFFUSE
                .map(|d| d.mean_image(&light, &image, point, normal, method))
                .into();
            found.push(ltc_mean_image(&light, &image, point, &prepared, method));
            for (i, mean) in found.iter().enumerate() {
                assert!(
                    mean.iter().all(|c| (-1e-6..=1.000_001).contains(c)),
                    "{round} {method:?} {i}: {mean:?} at {point:?} {normal:?}"
                );
            }
            let lanes = dispatch!(Level::new(), simd => {
                in_lanes(simd, &light, &image, point, normal, view, &narrow, method)
            });
            // The one lookup jumps where it sees the light edge-on, and scalars are not fused.
            if round % 8 > 4 && method != ImageMethod::Lookup {
                let lit = [
                    irradiance(&light, point, normal),
                    ltc_form_factor(&light, point, &prepared),
                ];
                for ((lane, scalar), lit) in lanes.into_iter().zip([found[0], found[6]]).zip(lit) {
                    if lit < 1e-5 {
                        continue;
                    }
                    for (a, b) in lane.into_iter().zip(scalar) {
                        assert!(
                            (a - b).abs() < 1e-2,
                            "{round} {method:?}: {lane:?} {scalar:?} at {point:?} {normal:?} {view:?} {narrow:?}"
                        );
                    }
                }
            }
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "all of a place")]
#[inline(always)]
fn in_lanes<S: Simd>(
    simd: S,
    light: &PolygonLight<f32>,
    image: &LightImage<f32>,
    point: Vec3<f32>,
    normal: Vec3<f32>,
    view: Vec3<f32>,
    lobe: &Ltc<f32>,
    method: ImageMethod,
) -> [[f32; 3]; 2] {
    let like = Lanes::splat(simd, 0.0);
    let [point, normal, view] = [point, normal, view].map(|v| Vec3::broadcast(like, v));
    let mut wide = Ltc::cosine(like);
    wide.shading_to_cosine = lobe.shading_to_cosine.map(|m| Lanes::splat(simd, m));
    let prepared = PreparedLtc::new(&wide, normal, view);
    let diffuse = DiffuseMethod::default().mean_image(light, image, point, normal, method);
    let specular = ltc_mean_image(light, image, point, &prepared, method);
    [diffuse, specular].map(|mean| {
        mean.map(|channel| {
            let mut numbers = [0.0; 16];
            channel.store(&mut numbers);
            numbers[Lanes::<S>::COUNT - 1]
        })
    })
}

/// The means by brute force: many points of the image's square.
fn brute_force(
    light: &PolygonLight<f64>,
    colors: &dyn Fn(f64, f64) -> [f64; 3],
    weight: impl Fn(Vector) -> f64,
    point: Vector,
) -> [f64; 3] {
    const STEPS: usize = 400;
    let mut sum = [0.0; 4];
    for i in 0..STEPS * STEPS {
        let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
        let (u, v) = (at(i % STEPS), at(i / STEPS));
        let inside = lumigon::reflected_inclusion(
            light,
            Vec3::new(u, v, -1.0),
            Vec3::new(0.0, 0.0, 1.0),
            Vec3::new(0.0, 0.0, 1.0),
            lumigon::InclusionRule::CrossingNumber,
        );
        if inside > 0.0 {
            let w = weight(Vec3::new(u, v, 0.0) - point);
            let color = colors(u, v);
            for channel in 0..3 {
                sum[channel] += w * color[channel];
            }
            sum[3] += w;
        }
    }
    [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]
}

/// Smooth images come out right: gradients and soft blobs, by the cosine and by a lobe.
#[test]
fn smooth_images_agree_with_sums_over_the_light() {
    let light = PolygonLight::new(&outline(), Sides::Both).unwrap();
    let colors = |u: f64, v: f64| {
        let blob = (-((u - 0.3) * (u - 0.3) + (v - 0.4) * (v - 0.4)) / 0.05).exp();
        [u, v, blob]
    };
    let mut image = LightImage::<f64>::new(&light, SQUARE, [128, 128]).unwrap();
    let texels: Vec<_> = (0..128 * 128)
        .map(|i| {
            let at = |k: usize| (k as f64 + 0.5) / 128.0;
            colors(at(i % 128), at(i / 128)).map(|c| c as f32)
        })
        .collect();
    image.replace(&texels).unwrap();
    let mut random = Random::new(5);
    let (mut worst, mut count) = ([0.0_f64; 4], 0);
    while count < 40 {
        let (mut point, mut normal, view, lobe) = place(&mut random);
        point.z = -random.log_range(0.2, 5.0);
        normal.z = normal.z.abs();
        let prepared = PreparedLtc::new(&lobe, normal, view);
        let lit: f64 = irradiance(&light, point, normal);
        let reflected: f64 = ltc_form_factor(&light, point, &prepared);
        if lit < 1e-3 || reflected < 1e-3 {
            continue;
        }
        count += 1;
        let cosine = |d: Vector| normal.dot(d).max(0.0) / d.dot(d).powi(2);
        let rows = prepared.world_to_cosine();
        let by_lobe = |d: Vector| {
            let t = Vec3::new(rows[0].dot(d), rows[1].dot(d), rows[2].dot(d));
            let above = if normal.dot(d) > 0.0 { 1.0 } else { 0.0 };
            above * t.z.max(0.0) / t.dot(t).powi(2)
        };
        let truth = [
            brute_force(&light, &colors, cosine, point),
            brute_force(&light, &colors, by_lobe, point),
        ];
        for (i, taps) in [2, 4].into_iter().enumerate() {
            let method = ImageMethod::Quadrature { taps };
            let found = [
                DiffuseMethod::default().mean_image(&light, &image, point, normal, method),
                ltc_mean_image(&light, &image, point, &prepared, method),
            ];
            for kind in 0..2 {
                for channel in 0..3 {
                    let error = (found[kind][channel] - truth[kind][channel]).abs();
                    worst[2 * i + kind] = worst[2 * i + kind].max(error);
                }
            }
        }
    }
    println!("worst: {worst:?}");
    assert!(
        worst[0] < 0.15 && worst[1] < 0.35 && worst[2] < 0.04 && worst[3] < 0.1,
        "{worst:?}"
    );
}

/// From far away an image is its mean over the outline, and every method agrees.
#[test]
fn far_away_only_the_mean_is_left() {
    let light = PolygonLight::new(&outline(), Sides::Both).unwrap();
    let mut image = LightImage::<f64>::new(&light, SQUARE, [32, 32]).unwrap();
    image.replace(&noise(32 * 32, &mut Random::new(7))).unwrap();
    let mean = image.mean();
    for distance in [1e2, 1e4, 1e6] {
        let point = Vec3::new(0.3 * distance, 0.1, -distance);
        let normal = Vec3::new(0.0, 0.0, 1.0);
        for method in [2, 3, 4].map(|taps| ImageMethod::Quadrature { taps }) {
            for diffuse in DIFFUSE {
                let found = diffuse.mean_image(&light, &image, point, normal, method);
                for (found, mean) in found.into_iter().zip(mean) {
                    let error = (found - f64::from(mean)).abs();
                    assert!(error < 0.02, "{distance} {method:?} {diffuse:?}: {error}");
                }
            }
        }
    }
}

/// Beyond the outline nothing emits, however bright the image is there.
#[test]
fn no_light_comes_from_outside_the_outline() {
    let light = PolygonLight::new(&outline(), Sides::Both).unwrap();
    let mut image = LightImage::<f64>::new(&light, SQUARE, [64, 64]).unwrap();
    // Bright where (x - 0.5)(y - 0.85) is near the notch, and in the hole.
    let texels: Vec<[f32; 3]> = (0..64 * 64)
        .map(|i| {
            let (u, v) = (f64::from(i % 64) / 64.0, f64::from(i / 64) / 64.0);
            let notch = v > 0.75 && (0.35..0.65).contains(&u);
            let hole = (0.48..0.55).contains(&u) && (0.23..0.29).contains(&v);
            [if notch || hole { 1e3 } else { 0.0 }, 1.0, 1.0]
        })
        .collect();
    image.replace(&texels).unwrap();
    let mut random = Random::new(9);
    assert_eq!(image.mean()[0], 0.0);
    for _ in 0..500 {
        let (point, normal, view, lobe) = place(&mut random);
        let prepared = PreparedLtc::new(&lobe, normal, view);
        for method in METHODS {
            let diffuse =
                DiffuseMethod::default().mean_image(&light, &image, point, normal, method);
            let specular = ltc_mean_image(&light, &image, point, &prepared, method);
            assert_eq!([diffuse[0], specular[0]], [0.0; 2]);
        }
    }
}

/// What cannot be shown is refused, and the image stays what it was.
#[test]
fn bad_images_are_refused() {
    let light = PolygonLight::new(&outline(), Sides::Both).unwrap();
    let refused = |size| LightImage::<f32>::new(&light, SQUARE, size).unwrap_err();
    for size in [[0, 4], [3, 4], [4, 1 << 15]] {
        let [width, height] = size;
        assert_eq!(refused(size), LightImageError::Size { width, height });
    }
    for edges in [
        [SQUARE[0], SQUARE[1], SQUARE[1]],
        [SQUARE[0], SQUARE[1], [0.0; 3]],
        [SQUARE[0], SQUARE[1], [0.0, 0.0, 1.0]],
        [SQUARE[0], SQUARE[1], [f64::NAN, 1.0, 0.0]],
        [[f64::INFINITY, 0.0, 0.0], SQUARE[1], SQUARE[2]],
    ] {
        let fault = LightImage::<f32>::new(&light, edges, [4, 4]).unwrap_err();
        assert_eq!(fault, LightImageError::Frame);
    }
    let mut image = LightImage::<f32>::new(&light, SQUARE, [4, 4]).unwrap();
    let good = noise(16, &mut Random::new(11));
    image.replace(&good).unwrap();
    let before = image.clone();
    for value in [f32::NAN, f32::INFINITY, -1.0, f32::MAX] {
        let mut bad = good.clone();
        bad[6][1] = value;
        let fault = image.replace(&bad).unwrap_err();
        assert!(
            matches!(fault, LightImageError::Value { x: 2, y: 1, .. }),
            "{fault}"
        );
        assert_eq!(image, before);
    }
    assert_eq!(
        image.replace(&good[1..]).unwrap_err(),
        LightImageError::Count {
            count: 15,
            expected: 16
        }
    );
}
