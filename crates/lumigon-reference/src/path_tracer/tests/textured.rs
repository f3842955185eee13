//! Textured lights, traced, against the sums of their texels.

use super::*;
use crate::{TexelFilter, TexelGrid, Texture, Weighting, texel_weights};

const SIZE: usize = 14;

fn texture(filter: TexelFilter) -> Texture {
    let frame = [[-1.2, 1.1, 0.7], [2.4, 0.3, 0.0], [0.2, -2.3, 0.0]];
    let grid = TexelGrid::new(frame, [7, 5], filter).unwrap();
    let colors = (0..35_u32)
        .map(|i| [9, 13, 17].map(|k| (i.wrapping_mul(2_654_435_761) >> k & 15) as f32 / 4.0));
    Texture::new(grid, colors.collect()).unwrap()
}

fn check(name: &str, material: Material, filter: TexelFilter, weighting: &Weighting) {
    let mut scene = TestScene {
        material,
        ..floor()
    };
    let texture = texture(filter);
    scene.emitters.truncate(1);
    let light = scene.emitters.remove(0).with_texture(texture.clone());
    scene.emitters.push(light.clone());
    let estimate = run(&scene, &camera(SIZE), &settings(SIZE, 1024));
    let mut z = Vec::new();
    for i in 0..SIZE * SIZE {
        let ray = camera(SIZE)((i % SIZE) as f64 + 0.5, (i / SIZE) as f64 + 0.5);
        let point = scene.intersect(ray.origin, ray.direction).unwrap().position;
        let tolerance = Tolerance {
            relative: 1e-5,
            ..Tolerance::default()
        };
        let weights =
            texel_weights(light.polygon(), texture.grid(), point, weighting, tolerance).unwrap();
        let mean = weights.mean(texture.texels()).unwrap().value;
        let response = match weighting {
            Weighting::Cosine { .. } => FRAC_1_PI,
            _ => 1.0,
        };
        for (c, mean) in mean.iter().enumerate() {
            let truth = light.radiance()[c] * weights.total() * mean * response;
            let error = estimate.total.standard_error[i][c];
            z.push((estimate.total.mean[i][c] - truth) / error);
        }
    }
    // Three channels share their samples: as many independent ones as there are pixels.
    let channels = |c: usize| z.iter().skip(c).step_by(3).copied().collect::<Vec<f64>>();
    for c in 0..3 {
        assert_standard_normal(&format!("{name}, channel {c}"), &channels(c));
    }
}

#[test]
fn textured_light_agrees_with_cubature() {
    let normal = [0.0, 0.0, 1.0];
    for filter in [TexelFilter::Nearest, TexelFilter::Bilinear] {
        check(
            "matte",
            matte([1.0; 3]),
            filter,
            &Weighting::Cosine { normal },
        );
        let mirror = Material {
            base_color: [1.0; 3],
            metallic: 1.0,
            alpha: [0.15; 2],
            ..Material::default()
        };
        check(
            "metal",
            mirror,
            filter,
            &Weighting::Ggx {
                normal,
                view: DOWNWARDS.map(|x| -x),
                alpha: 0.15,
            },
        );
    }
}
