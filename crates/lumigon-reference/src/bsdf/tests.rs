use std::f64::consts::PI;

use super::*;
use crate::material::Material;

/// A material with every lobe.
fn stack() -> Material {
    Material {
        base_color: [0.8, 0.5, 0.2],
        metallic: 0.3,
        dielectric_f0: [0.06, 0.04, 0.02],
        dielectric_f90: 0.9,
        alpha: [0.5, 0.1],
        tangent: [0.6, 0.8, 0.0],
        diffuse_roughness: 0.7,
        sheen_color: [0.2, 0.5, 0.4],
        sheen_alpha: 0.2,
        clearcoat: 0.8,
        clearcoat_alpha: 0.05,
        clearcoat_normal: [0.3, 0.1, 0.9],
    }
}

fn surface(material: Material, shading_normal: [f64; 3]) -> Surface {
    Surface {
        position: [0.0; 3],
        geometric_normal: [0.0, 0.0, 1.0],
        shading_normal,
        material,
        emitted: [0.0; 3],
    }
}

#[test]
fn hostile_surfaces_stay_finite_and_their_weights_bounded() {
    let nan = f64::NAN;
    let extreme = |alpha: f64| Material {
        alpha: [alpha, 1.0],
        sheen_alpha: alpha,
        clearcoat_alpha: alpha,
        clearcoat: 1.0,
        diffuse_roughness: 1.0,
        base_color: [1.0; 3],
        sheen_color: [1.0, 0.5, 0.0],
        ..stack()
    };
    let plain = |alpha: f64| Material {
        alpha: [alpha; 2],
        base_color: [0.5; 3],
        ..Material::default()
    };
    let materials = [
        extreme(0.0),
        extreme(0.01),
        extreme(1.0),
        plain(0.0),
        plain(0.01),
        plain(1.0),
        Material {
            // Backwards, and far out of range.
            clearcoat_normal: [0.0, 0.0, -1.0],
            tangent: [0.0, 0.6, 0.8],
            base_color: [7.0, -1.0, 0.5],
            metallic: -3.0,
            ..stack()
        },
        Material {
            base_color: [nan; 3],
            metallic: nan,
            dielectric_f0: [nan; 3],
            dielectric_f90: nan,
            alpha: [nan; 2],
            tangent: [nan; 3],
            diffuse_roughness: nan,
            sheen_color: [1.0, nan, 1.0],
            sheen_alpha: nan,
            clearcoat: 1.0,
            clearcoat_alpha: nan,
            clearcoat_normal: [nan; 3],
        },
    ];
    let views = [
        [0.0, -0.8, 0.59],
        [0.0, 0.6, 0.8],
        [0.0, -0.6, 0.0001],
        [1.0, 0.0, 0.01],
    ];
    let mut random = Random::new(1, 2);
    let mut largest = 0.0_f64;
    for (index, material) in materials.into_iter().enumerate() {
        for normal in [[0.0, 0.6, 0.8], [0.0, 0.0, 1.0], [nan; 3]] {
            for view in views {
                let view = DVec3::from(view).normalize();
                let bsdf = Bsdf::new(&surface(material, normal), view);
                assert!((0.0..=1.0).contains(&bsdf.below_clearcoat()), "{index}");
                for _ in 0..1000 {
                    let Some((direction, weight)) = bsdf.sample(&mut random) else {
                        continue;
                    };
                    let weight = weight.sum();
                    let case = format!("{index} {normal:?} {view}: {direction} {weight}");
                    assert!(direction.is_normalized() && weight.is_finite(), "{case}");
                    assert!(weight.min_element() >= 0.0, "{case}");
                    largest = largest.max(weight.max_element());
                }
                for direction in bsdf.sample_each(&mut random).collect::<Vec<_>>() {
                    let density = bsdf.density_of_each(direction);
                    assert!(density >= 0.0 && density.is_finite(), "{index} {density}");
                }
            }
        }
    }
    println!("largest weight {largest}");
    // No technique's share is below 1/15, and uniform directions bound a rough white lobe by pi over theirs.
    assert!(largest < 45.0, "{largest}");
}

/// The integral of the BRDF times cosine over the sphere, by a plain sum.
fn albedo(bsdf: &Bsdf) -> Lobes {
    let (rows, columns) = (800, 500);
    let mut sum = Lobes::default();
    for i in 0..rows {
        let z: f64 = 2.0 * (f64::from(i) + 0.5) / f64::from(rows) - 1.0;
        for j in 0..columns {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns);
            let radius = (1.0 - z * z).sqrt();
            sum += bsdf.evaluate(DVec3::new(radius * phi.cos(), radius * phi.sin(), z));
        }
    }
    sum * DVec3::splat(4.0 * PI / f64::from(rows * columns))
}

#[test]
fn paths_continue_with_the_right_mean() {
    let without = |change: fn(&mut Material)| {
        let mut material = stack();
        change(&mut material);
        material
    };
    let materials = [
        stack(),
        without(|m| m.clearcoat = 0.0),
        without(|m| m.sheen_color = [0.0; 3]),
        without(|m| (m.base_color, m.dielectric_f0, m.dielectric_f90) = ([0.0; 3], [0.0; 3], 0.0)),
        Material {
            alpha: [0.2; 2],
            ..Material::default()
        },
    ];
    let mut random = Random::new(4, 2);
    for (index, material) in materials.into_iter().enumerate() {
        for view in [[0.3, 0.2, 0.8], [-0.9, 0.3, 0.3]] {
            let view = DVec3::from(view).normalize();
            let bsdf = Bsdf::new(&surface(material, [0.0, 0.1, 0.9]), view);
            let expected = albedo(&bsdf);
            let (mut sum, mut squares) = (Lobes::default(), DVec3::ZERO);
            let n = 60_000;
            for _ in 0..n {
                if let Some((_, weight)) = bsdf.sample(&mut random) {
                    sum += weight;
                    squares += weight.sum() * weight.sum();
                }
            }
            let mean = sum * DVec3::splat(1.0 / f64::from(n));
            let error = (squares / f64::from(n)).map(f64::sqrt) / f64::from(n).sqrt();
            for (a, b) in [
                (mean.diffuse, expected.diffuse),
                (mean.specular, expected.specular),
            ] {
                let z = (a - b) / error.max(DVec3::splat(1e-12));
                assert!(z.abs().max_element() < 4.5, "{index} {view}: {a} {b} z {z}");
            }
        }
    }
}

#[test]
fn no_view_reflects_more_than_it_gets() {
    let white = Material {
        base_color: [1.0; 3],
        metallic: 0.0,
        dielectric_f0: [0.04, 0.1, 0.3],
        dielectric_f90: 1.0,
        clearcoat_normal: [0.0; 3],
        sheen_color: [1.0, 0.5, 0.2],
        clearcoat: 0.5,
        ..stack()
    };
    let materials = [
        white,
        Material {
            sheen_alpha: 0.03,
            clearcoat: 0.0,
            ..white
        },
        Material {
            sheen_color: [0.0; 3],
            ..white
        },
        Material {
            metallic: 1.0,
            alpha: [0.2; 2],
            ..white
        },
        Material {
            sheen_color: [0.0; 3],
            clearcoat: 0.0,
            alpha: [0.3; 2],
            ..white
        },
    ];
    for (index, material) in materials.into_iter().enumerate() {
        for degrees in [0.0_f64, 40.0, 75.0, 87.0] {
            let theta = degrees.to_radians();
            let view = DVec3::new(theta.sin(), 0.0, theta.cos());
            let bsdf = Bsdf::new(&surface(material, [0.0, 0.0, 1.0]), view);
            let albedo = albedo(&bsdf).sum();
            println!("{index} {degrees}: {albedo}");
            // The plain sum is good to 2e-3 for these widths.
            assert!(albedo.max_element() < 1.002, "{index} {degrees}: {albedo}");
            assert!(albedo.min_element() > 0.3, "{index} {degrees}: {albedo}");
        }
    }
}
