//! Images filtered on the device.

use lumigon::{LightImage, LightImageError, PolygonLight, Sides};
use lumigon_wgpu::{ImageColors, Light, ReplaceImageError};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::gpu::texels_after_replacing;

/// A light in the shape of an L, or its bounding square, with a white image.
fn light(size: [u32; 2], whole: bool) -> Light {
    let outline: &[[f64; 3]] = if whole {
        &[
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
        ]
    } else {
        &[
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 0.7, 0.0],
            [0.6, 0.7, 0.0],
            [0.6, 2.0, 0.0],
            [0.0, 2.0, 0.0],
        ]
    };
    let polygon = PolygonLight::new(&[outline], Sides::Front).unwrap();
    let corners = [[0.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, -2.0, 0.0]];
    Light {
        image: Some(LightImage::new(&polygon, corners, size).unwrap()),
        polygon: polygon.cast().unwrap(),
        radiance: [1.0; 3],
    }
}

#[test]
fn replaced_images_are_the_cpu_s() {
    let mut random = Pcg64Mcg::new(5);
    let mut worst = 0.0_f32;
    for (size, whole) in [
        ([1, 1], true),
        ([1, 64], true),
        ([128, 1], false),
        ([2, 2], false),
        ([64, 16], false),
        ([256, 256], true),
        ([256, 512], false),
    ] {
        let count = (size[0] * size[1]) as usize;
        let bytes: Vec<[u8; 4]> = (0..count).map(|_| random.random()).collect();
        let numbers: Vec<[f32; 3]> = (0..count)
            .map(|_| random.random::<[f32; 3]>().map(|x| x * x * 100.0))
            .collect();
        // Among others, so that it does not start at 0.
        let lights = [
            light([8, 4], false),
            light(size, whole),
            light([4, 4], true),
        ];
        for colors in [ImageColors::Srgb(&bytes), ImageColors::Linear(&numbers)] {
            let mut expected = lights.clone();
            let image = expected[1].image.as_mut().unwrap();
            image.replace(&colors.to_linear()).unwrap();
            let expected: Vec<_> = expected
                .iter()
                .flat_map(|light| light.image.as_ref().unwrap().pyramid().texels())
                .collect();
            let got = texels_after_replacing(&lights, 1, colors).unwrap();
            assert_eq!(got.len(), expected.len());
            for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
                for (got, expected) in got.iter().zip(expected) {
                    let error = (got - expected).abs() / expected.abs().max(1e-3);
                    assert!(
                        error < 1e-6,
                        "{size:?} {whole}: texel {i} is {got}, not {expected}"
                    );
                    worst = worst.max(error);
                }
            }
        }
    }
    println!("image pyramids: {worst:e} at worst");
}

#[test]
fn images_with_the_conventional_levels_are_replaced_whole() {
    let mut kept = light([32, 16], false);
    kept.image.as_mut().unwrap().filter_gaussian_levels();
    let bytes: Vec<[u8; 4]> = (0..32 * 16).map(|i| [i as u8, 255, 0, 9]).collect();
    let colors = ImageColors::Srgb(&bytes);
    let got = texels_after_replacing(&[kept.clone()], 0, colors).unwrap();
    let image = kept.image.as_mut().unwrap();
    image.replace(&colors.to_linear()).unwrap();
    let levels = image.gaussian_levels().unwrap().levels();
    let gaussian = levels.iter().flat_map(|level| &level.texels);
    let expected: Vec<_> = image
        .pyramid()
        .texels()
        .iter()
        .chain(gaussian)
        .copied()
        .collect();
    assert_eq!(got, expected);
}

fn refusal(lights: &[Light], light: usize, colors: ImageColors<'_>) -> ReplaceImageError {
    texels_after_replacing(lights, light, colors).unwrap_err()
}

#[test]
fn what_is_no_image_is_refused() {
    let plain = Light {
        image: None,
        ..light([4, 4], true)
    };
    let lights = [plain, light([4, 4], true)];
    let four = [[1.0; 3]; 16];
    for light in [0, 2, usize::MAX] {
        let fault = refusal(&lights, light, ImageColors::Linear(&four));
        assert_eq!(fault, ReplaceImageError::NoImage { light });
    }
    let count = |count| {
        ReplaceImageError::Colors(LightImageError::Count {
            count,
            expected: 16,
        })
    };
    assert_eq!(
        refusal(&lights, 1, ImageColors::Linear(&four[..15])),
        count(15)
    );
    assert_eq!(refusal(&lights, 1, ImageColors::Srgb(&[])), count(0));
    for bad in [f32::NAN, f32::INFINITY, -1e-9, f32::MAX] {
        let mut colors = four;
        colors[6] = [0.0, bad, 1.0];
        let fault = refusal(&lights, 1, ImageColors::Linear(&colors));
        assert!(
            matches!(
                fault,
                ReplaceImageError::Colors(LightImageError::Value { x: 2, y: 1, .. })
            ),
            "{fault}"
        );
    }
}
