//! Sound and hostile bytes of each format.

use std::io::Cursor;

use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage,
};
use image::{ExtendedColorType, ImageEncoder, codecs::hdr::HdrEncoder};

use super::*;

const SIZE: [u32; 2] = [5, 3];

/// Colours that half the floats hold, up to 2^14.
fn colors() -> Vec<[f32; 4]> {
    let color = |i: u32| {
        let x = i as f32;
        [x, 0.25 * x, (1 << i) as f32, 0.5]
    };
    (0..SIZE[0] * SIZE[1]).map(color).collect()
}

fn exr_of(texels: &[[f32; 4]], encoding: Encoding) -> Vec<u8> {
    let width = SIZE[0] as usize;
    let channels = SpecificChannels::rgba(|Vec2(x, y)| {
        let [r, g, b, a] = texels[y * width + x];
        (r, g, b, a)
    });
    let size = (width, SIZE[1] as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layer(layer);
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn hdr_of([width, height]: [u32; 2], texels: &[[f32; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let rgb: Vec<u8> = texels
        .iter()
        .flat_map(|t| t[..3].iter().flat_map(|x| x.to_ne_bytes()))
        .collect();
    HdrEncoder::new(&mut bytes)
        .write_image(&rgb, width, height, ExtendedColorType::Rgb32F)
        .unwrap();
    bytes
}

fn png_of() -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let image = ::image::RgbaImage::from_fn(SIZE[0], SIZE[1], |x, y| {
        ::image::Rgba([x as u8, y as u8, 200, 255])
    });
    image
        .write_to(&mut bytes, ::image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

fn decode(bytes: &[u8]) -> Result<ImageFile, SceneError> {
    decode_image(bytes, "a picture", &Limits::default())
}

fn message(bytes: &[u8]) -> String {
    let message = decode(bytes).unwrap_err().to_string();
    assert!(message.contains("a picture"), "{message}");
    message
}

#[test]
fn exr_keeps_every_number() {
    for encoding in [
        Encoding::UNCOMPRESSED,
        Encoding::FAST_LOSSLESS,
        Encoding::SMALL_LOSSLESS,
    ] {
        let image = decode(&exr_of(&colors(), encoding)).unwrap();
        assert_eq!(image.size, SIZE);
        assert_eq!(*image.texels, Texels::F32(colors()));
        // Linear, whatever the material thinks of its textures.
        let texture = image.texture(true, Sampler::default());
        assert_eq!(texture.texel(3, 2).to_array(), colors()[13]);
    }
}

#[test]
fn exr_shows_its_display_window() {
    use exr::prelude::{ImageAttributes, IntegerBounds};
    let channels = SpecificChannels::rgb(|Vec2(x, y)| (x as f32, y as f32, 1.0_f32));
    let at = LayerAttributes {
        layer_position: Vec2(2, -1),
        ..LayerAttributes::default()
    };
    let layer = Layer::new((2, 2), at, Encoding::UNCOMPRESSED, channels);
    let window = IntegerBounds::from_dimensions((4, 2));
    let mut image = Image::from_layer(layer);
    image.attributes = ImageAttributes::new(window);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let image = decode(&bytes.into_inner()).unwrap();
    let (none, left, right) = ([0.0; 4], [0.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]);
    let expected = vec![none, none, left, right, none, none, none, none];
    assert_eq!(
        (image.size, &*image.texels),
        ([4, 2], &Texels::F32(expected))
    );
}

#[test]
fn radiance_hdr_shares_an_exponent() {
    // Eight texels and more are run-length encoded.
    let wide: Vec<[f32; 4]> = (0..32).map(|i| [1.0, 0.5, (i / 8) as f32, 1.0]).collect();
    for (size, texels) in [(SIZE, colors()), ([16, 2], wide)] {
        let mut bytes = hdr_of(size, &texels);
        for _ in 0..2 {
            let image = decode(&bytes).unwrap();
            assert_eq!(image.size, size);
            let Texels::F32(found) = &*image.texels else {
                panic!("not in floating point")
            };
            for (found, expected) in found.iter().zip(&texels) {
                let largest = expected[..3].iter().fold(0.0, |m: f32, &x| m.max(x));
                for k in 0..3 {
                    // Eight bits below the largest channel.
                    assert!((found[k] - expected[k]).abs() <= largest / 128.0);
                }
                assert_eq!(found[3], 1.0);
            }
            // The other signature.
            let rest = bytes.strip_prefix(b"#?RADIANCE".as_slice());
            bytes = rest.map_or(bytes.clone(), |rest| [b"#?RGBE", rest].concat());
        }
    }
}

#[test]
fn light_that_is_none_is_refused_by_texel_and_channel() {
    for (bad, shown) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "inf"),
        (-0.5, "-5e-1"),
        (2e30, "2e30"),
    ] {
        for channel in 0..4 {
            let mut texels = colors();
            texels[7][channel] = bad;
            let message = message(&exr_of(&texels, Encoding::UNCOMPRESSED));
            let name = ["red", "green", "blue", "alpha"][channel];
            let expected = format!("texel (2, 1) has {name} {shown}");
            assert!(message.contains(&expected), "{message}");
        }
        let error = ImageFile::from_linear("a frame", [1, 1], &[[0.0, bad, 0.0]]).unwrap_err();
        assert!(error.to_string().contains("green"), "{error}");
    }
    assert!(ImageFile::from_linear("", [2, 1], &[[0.0; 3]]).is_err());
    assert!(ImageFile::from_linear("", [0, 0], &[]).is_err());
    assert!(ImageFile::from_linear("", [u32::MAX; 2], &[[0.0; 3]]).is_err());
}

#[test]
fn claimed_sizes_are_checked_before_texels_are_made() {
    let hdr = |line: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n").into_bytes();
    for (line, expected) in [
        ("-Y 0 +X 0", "0 × 0 texels"),
        ("-Y 1 +X 65536", "65536 × 1 texels, outside 1 to 16384"),
        ("-Y 16384 +X 16384", "need 4294967296 bytes"),
        ("-Y 4294967295 +X 4294967295", ""),
        ("-Y -1 +X 5", ""),
    ] {
        let message = message(&hdr(line));
        assert!(message.contains(expected), "{line}: {message}");
    }
    // The windows of an EXR file are four integers after their names.
    let original = exr_of(&colors(), Encoding::UNCOMPRESSED);
    let with_windows = |width: i32, height: i32| {
        let mut bytes = original.clone();
        for name in [b"dataWindow\0box2i\0".as_slice(), b"displayWindow\0box2i\0"] {
            let place = bytes.windows(name.len()).position(|w| w == name).unwrap();
            let corner = place + name.len() + 4 + 8;
            bytes[corner..corner + 4].copy_from_slice(&width.wrapping_sub(1).to_le_bytes());
            bytes[corner + 4..corner + 8].copy_from_slice(&height.wrapping_sub(1).to_le_bytes());
        }
        bytes
    };
    assert!(decode(&with_windows(5, 3)).is_ok());
    for (width, height) in [
        (0, 0),
        (65536, 1),
        (1, 65536),
        (16384, 16384),
        (i32::MAX, i32::MAX),
        (1 << 30, 1 << 30),
        (i32::MIN, 3),
    ] {
        message(&with_windows(width, height));
    }
    let limits = Limits {
        image_bytes: 16 * 15 - 1,
        ..Limits::default()
    };
    let error = decode_image(&original, "x", &limits).unwrap_err();
    assert!(error.to_string().contains("need 240 bytes"), "{error}");
}

#[test]
fn truncated_and_mutated_images_never_panic() {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        // Xorshift, Marsaglia 2003.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let limits = Limits {
        image_bytes: 1 << 22,
        ..Limits::default()
    };
    for original in [
        exr_of(&colors(), Encoding::UNCOMPRESSED),
        exr_of(&colors(), Encoding::SMALL_LOSSLESS),
        hdr_of(SIZE, &colors()),
        hdr_of([15, 1], &colors()),
        png_of(),
    ] {
        assert!(decode(&original).is_ok());
        for length in 0..original.len() {
            let cut = decode_image(&original[..length], "cut", &limits);
            // A PNG's last chunk holds nothing.
            assert!(cut.is_err() || (length + 12 >= original.len()), "{length}");
        }
        for _ in 0..1000 {
            let mut bytes = original.clone();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                match random(2) {
                    0 => bytes[at] ^= 1 << random(8),
                    _ => bytes[at] = [0, 0xff, 0x7f, 0x80][random(4)],
                }
            }
            let _ = decode_image(&bytes, "mutant", &limits);
        }
    }
}

#[test]
fn files_are_named_in_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("light.hdr");
    let limits = Limits::default();
    let missing = read_image(&path, &limits).unwrap_err().to_string();
    assert!(missing.contains("light.hdr"), "{missing}");
    std::fs::write(&path, "GIF89a").unwrap();
    let other = read_image(&path, &limits).unwrap_err().to_string();
    assert!(
        other.contains("light.hdr") && other.contains("convert"),
        "{other}"
    );
    // What the bytes say counts.
    std::fs::write(&path, png_of()).unwrap();
    assert_eq!(read_image(&path, &limits).unwrap().size, SIZE);
    assert!(read_image(folder.path(), &limits).is_err());
}
