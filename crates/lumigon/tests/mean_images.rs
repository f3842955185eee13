//! How far the mean images are from cubature of the same textured lights.

mod polygons;

use lumigon::{
    DiffuseMethod, ImageMethod, LightImage, LocalOcclusion, Ltc, LtcTable, PolygonLight,
    PreparedLtc, ProjectionBasis, Sides, Vec3, ltc_mean_image,
};
use lumigon_reference::{Polygon, TexelFilter, TexelGrid, Tolerance, Weighting, texel_weights};
use polygons::{Random, Vector};

const SIZE: usize = 64;

const TOLERANCE: Tolerance = Tolerance {
    absolute: 0.0,
    relative: 1e-4,
    max_evaluations: 5_000_000,
};

/// The conventional lookup first.
const METHODS: [ImageMethod; 5] = [
    ImageMethod::Lookup,
    ImageMethod::Quadrature { taps: 1 },
    ImageMethod::Quadrature { taps: 2 },
    ImageMethod::Quadrature { taps: 3 },
    ImageMethod::Quadrature { taps: 4 },
];

/// A light in the plane z = 0, facing up, and what it shows, for both crates.
struct Light {
    light: PolygonLight<f64>,
    image: LightImage<f64>,
    texels: Vec<[f32; 3]>,
    reference: Polygon,
    grid: TexelGrid,
}

impl Light {
    /// A concave outline with a hole, or a rectangle; a smooth, a chequered and a noisy channel.
    fn new(concave: bool, random: &mut Random) -> Self {
        let up = |points: &[[f64; 2]]| points.iter().map(|p| [p[0], p[1], 0.0]).collect();
        let outline: Vec<Vec<[f64; 3]>> = if concave {
            vec![
                up(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.9], [0.5, 0.6], [0.1, 1.0]]),
                up(&[[0.4, 0.2], [0.5, 0.4], [0.7, 0.2]]),
            ]
        } else {
            vec![up(&[[0.0, 0.0], [1.3, 0.0], [1.3, 0.8], [0.0, 0.8]])]
        };
        let frame = if concave {
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        } else {
            [[0.0; 3], [1.3, 0.0, 0.0], [0.0, 0.8, 0.0]]
        };
        let slope = [random.range(-0.5, 0.5), random.range(-0.5, 0.5)];
        let squares = [random.range(2.0, 6.0), random.range(2.0, 6.0)];
        let mut noise = vec![0.0; SIZE * SIZE];
        for cells in [2, 4, 8, 16, 32, 64] {
            let heights: Vec<f64> = (0..cells * cells)
                .map(|_| random.range(-0.2, 0.2))
                .collect();
            for (i, noise) in noise.iter_mut().enumerate() {
                let at = |k: usize| k * cells / SIZE;
                *noise += heights[at(i / SIZE) * cells + at(i % SIZE)];
            }
        }
        let texels: Vec<[f32; 3]> = (0..SIZE * SIZE)
            .map(|i| {
                let at = |k: usize| (k as f64 + 0.5) / SIZE as f64;
                let (u, v) = (at(i % SIZE), at(i / SIZE));
                let gradient = 0.5 + slope[0] * (u - 0.5) + slope[1] * (v - 0.5);
                let square = (u * squares[0]).floor() + (v * squares[1]).floor();
                let chequered = if square % 2.0 < 1.0 { 0.8 } else { 0.2 };
                [gradient, chequered, (0.5 + noise[i]).max(0.0)].map(|c| c as f32)
            })
            .collect();
        let light = PolygonLight::new(&outline, Sides::Front).unwrap();
        let mut image = LightImage::new(&light, frame, [SIZE as u32; 2]).unwrap();
        image.filter_gaussian_levels();
        image.replace(&texels).unwrap();
        Self {
            light,
            image,
            texels,
            reference: Polygon::new(&outline, false).unwrap(),
            grid: TexelGrid::new(frame, [SIZE; 2], TexelFilter::Bilinear).unwrap(),
        }
    }

    /// Truth, where at least a share of what there is to see comes from the light.
    fn truth(&self, point: Vector, weighting: &Weighting, least: f64) -> Option<[f64; 3]> {
        let weights = texel_weights(
            &self.reference,
            &self.grid,
            point.into(),
            weighting,
            TOLERANCE,
        )
        .unwrap();
        let mean = weights.mean(&self.texels)?;
        (weights.total() > least).then_some(mean.value)
    }
}

/// A point from a third of the light's size to ten times as far, and a normal that sees some of it.
fn place(random: &mut Random) -> (Vector, Vector) {
    let mut from = random.direction();
    from.z = from.z.abs().max(0.1);
    let middle = Vec3::new(0.5, 0.45, 0.0);
    let point = middle + from * random.log_range(0.3, 10.0);
    (point, random.direction_above(middle - point))
}

/// Root mean squares over samples and channels.
fn rms(errors: &[[[f64; 3]; 5]]) -> [f64; 5] {
    std::array::from_fn(|method| {
        let squares = errors.iter().flat_map(|e| e[method]).map(|e| e * e);
        (squares.sum::<f64>() / (3 * errors.len()) as f64).sqrt()
    })
}

fn difference(found: [f64; 3], truth: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| found[c] - truth[c])
}

/// Few taps do better than the lookup, more do better still.
#[test]
fn quadrature_beats_the_lookup() {
    let mut random = Random::new(21);
    let lights: Vec<Light> = (0..6)
        .map(|i| Light::new(i % 2 == 1, &mut random))
        .collect();
    let table = LtcTable::ggx();
    let (mut diffuse, mut specular) = (Vec::new(), Vec::new());
    while diffuse.len() < 150 || specular.len() < 150 {
        let light = &lights[random.index(lights.len())];
        let (point, normal) = place(&mut random);
        let weighting = Weighting::Cosine {
            normal: normal.into(),
        };
        let squared = point.dot(point).max(1.0);
        if let Some(truth) = light.truth(point, &weighting, 0.02 / squared) {
            diffuse.push(METHODS.map(|method| {
                let found = DiffuseMethod::default();
                let found = found.mean_image(&light.light, &light.image, point, normal, method);
                difference(found, truth)
            }));
        }
        // A mirrored view that meets the light's surroundings.
        let target = Vec3::new(random.range(-0.2, 1.2), random.range(-0.2, 1.2), 0.0);
        let towards = (target - point) * (1.0 / (target - point).length());
        let cosine = normal.dot(towards);
        if cosine < 0.05 {
            continue;
        }
        let view = normal * (2.0 * cosine) - towards;
        let fitted = table
            .lookup(random.range(0.05, 1.0) as f32, cosine as f32)
            .lobes[0];
        let mut lobe = Ltc::cosine(0.0);
        lobe.shading_to_cosine = fitted.shading_to_cosine.map(f64::from);
        let lobe = PreparedLtc::new(&lobe, normal, view);
        let weighting = Weighting::TransformedCosine {
            to_cosine: lobe.world_to_cosine().map(Into::into),
            normal: normal.into(),
        };
        if let Some(truth) = light.truth(point, &weighting, 0.01) {
            specular.push(METHODS.map(|method| {
                let found = ltc_mean_image(&light.light, &light.image, point, &lobe, method);
                difference(found, truth)
            }));
        }
    }
    for (name, errors, bounds) in [
        ("diffuse", &diffuse, [0.5, 0.32, 0.25, 0.18]),
        ("specular", &specular, [0.75, 0.6, 0.47, 0.35]),
    ] {
        let rms = rms(errors);
        println!("{name}: {rms:.4?}");
        for (method, bound) in bounds.into_iter().enumerate() {
            let ratio = rms[method + 1] / rms[0];
            assert!(ratio < bound, "{name} {:?}: {ratio}", METHODS[method + 1]);
        }
    }
}

/// The other diffuse methods weigh otherwise, and their means follow.
#[test]
fn every_weight_has_its_mean() {
    let mut random = Random::new(22);
    let lights: Vec<Light> = (0..4)
        .map(|i| Light::new(i % 2 == 1, &mut random))
        .collect();
    let occlusion = LocalOcclusion::Exact;
    let mut errors = [Vec::new(), Vec::new()];
    while errors[1].len() < 120 {
        let light = &lights[random.index(lights.len())];
        let (point, normal) = place(&mut random);
        let centroid: Vector = light.light.centroid();
        let axis = (centroid - point) * (1.0 / (centroid - point).length());
        // No corner of the image is beside or behind.
        let nearest = [[0.0, 0.0], [1.3, 0.0], [0.0, 1.0], [1.3, 1.0]]
            .map(|[x, y]| axis.dot(Vec3::new(x, y, 0.0) - point))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        if nearest < 0.3 * (centroid - point).length() {
            continue;
        }
        let normal_array: [f64; 3] = normal.into();
        let questions = [
            (
                DiffuseMethod::LightVector { occlusion },
                Weighting::SolidAngle {
                    normal: normal_array,
                },
            ),
            (
                DiffuseMethod::ProjectedArea {
                    basis: ProjectionBasis::Centroid,
                    occlusion,
                },
                Weighting::ProjectedArea {
                    axis: axis.into(),
                    normal: normal_array,
                },
            ),
        ];
        for (errors, (diffuse, weighting)) in errors.iter_mut().zip(questions) {
            let least = 0.02 / point.dot(point).max(1.0);
            if let Some(truth) = light.truth(point, &weighting, least) {
                errors.push(METHODS.map(|method| {
                    let found =
                        diffuse.mean_image(&light.light, &light.image, point, normal, method);
                    difference(found, truth)
                }));
            }
        }
    }
    for (name, errors) in ["solid angle", "projected area"].iter().zip(&errors) {
        let rms = rms(errors);
        println!("{name}: {rms:.4?}");
        assert!(rms[2] < 0.06 && rms[4] < 0.04, "{name}: {rms:?}");
    }
}
