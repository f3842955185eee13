//! Khronos Texture 2.0, <https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html>: one level,
//! no supercompression; the data format descriptor after the Khronos Data Format Specification
//! 1.3, section 5.

use crate::description::layer_index;
use crate::error::TableError;
use crate::image::TableImage;
use crate::raw;

const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
const HEADER: usize = 80;
const LEVEL_INDEX: usize = 24;
/// Basic descriptor block: 24 bytes, and 16 for each of four samples.
const DESCRIPTOR_BLOCK: u32 = 24 + 4 * 16;

/// `VK_FORMAT_R32G32B32A32_SFLOAT` or `VK_FORMAT_R16G16B16A16_SFLOAT`.
pub(crate) fn encode(image: &TableImage, half: bool) -> Result<Vec<u8>, TableError> {
    let fits = |size: usize| {
        u32::try_from(size).map_err(|_| TableError::Format {
            name: image.name().to_owned(),
            format: "KTX2",
            problem: "it has more than 2^32 texels a side or layers".to_owned(),
        })
    };
    let (vk_format, number) = if half { (97, 2) } else { (109, 4) };
    let data = raw::bytes(&image.layered(), half);
    let descriptor = descriptor(number);
    let texts = key_value_data(image)?;
    let descriptor_at = HEADER + LEVEL_INDEX;
    let texts_at = descriptor_at + descriptor.len();
    // A level begins at a multiple of its texel block's size and of 4.
    let data_at = (texts_at + texts.len()).next_multiple_of(4 * number as usize);

    let mut file = Vec::with_capacity(data_at + data.len());
    file.extend(IDENTIFIER);
    for word in [
        vk_format,
        number,
        fits(image.sizes()[0])?,
        fits(image.sizes()[1])?,
        0, // depth: two-dimensional
        fits(image.layers())?,
        1, // faces
        1, // levels
        0, // no supercompression
        fits(descriptor_at)?,
        fits(descriptor.len())?,
        fits(texts_at)?,
        fits(texts.len())?,
    ] {
        file.extend(word.to_le_bytes());
    }
    let (data_offset, data_length) = (data_at as u64, data.len() as u64);
    // No supercompression global data; then the one level.
    for word in [0, 0, data_offset, data_length, data_length] {
        file.extend(word.to_le_bytes());
    }
    file.extend(descriptor);
    file.extend(texts);
    file.resize(data_at, 0);
    file.extend(data);
    Ok(file)
}

/// Four floating-point samples of `number` bytes, linear.
fn descriptor(number: u32) -> Vec<u8> {
    const RGBSDA: u32 = 1;
    const UNSPECIFIED_PRIMARIES: u32 = 0;
    const LINEAR: u32 = 1;
    const VERSION: u32 = 2;
    const FLOAT_SIGNED: u32 = 0x80 | 0x40;
    let mut words = vec![
        4 + DESCRIPTOR_BLOCK,
        0, // Khronos, basic
        VERSION | (DESCRIPTOR_BLOCK << 16),
        RGBSDA | (UNSPECIFIED_PRIMARIES << 8) | (LINEAR << 16),
        0,          // texel blocks of 1 x 1 x 1 x 1
        4 * number, // bytes of plane 0
        0,
    ];
    for (i, channel) in [0, 1, 2, 15].into_iter().enumerate() {
        let bits = 8 * number;
        words.extend([
            (i as u32 * bits) | ((bits - 1) << 16) | ((channel | FLOAT_SIGNED) << 24),
            0,
            (-1.0_f32).to_bits(),
            1.0_f32.to_bits(),
        ]);
    }
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Keys sorted, as the specification asks; values are text that ends with NUL.
fn key_value_data(image: &TableImage) -> Result<Vec<u8>, TableError> {
    let mut texts: Vec<(String, String)> = image
        .texts()
        .iter()
        .map(|(key, value)| (format!("lumigon-{key}"), value.clone()))
        .collect();
    let sizes: Vec<String> = image.sizes().iter().map(ToString::to_string).collect();
    texts.extend([
        ("KTXorientation".to_owned(), "rd".to_owned()),
        (
            "KTXwriter".to_owned(),
            concat!("lumigon ", env!("CARGO_PKG_VERSION")).to_owned(),
        ),
        ("lumigon-channels".to_owned(), image.channels().join(" ")),
        ("lumigon-index".to_owned(), layer_index(image)),
        ("lumigon-sizes".to_owned(), sizes.join(" ")),
    ]);
    texts.sort();
    texts.dedup_by(|a, b| a.0 == b.0);
    let mut bytes = Vec::new();
    for (key, value) in texts {
        let length =
            u32::try_from(key.len() + value.len() + 2).map_err(|_| TableError::Format {
                name: image.name().to_owned(),
                format: "KTX2",
                problem: format!("the text {key:?} is longer than 2^32 bytes"),
            })?;
        bytes.extend(length.to_le_bytes());
        bytes.extend(key.bytes().chain([0]).chain(value.bytes()).chain([0]));
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use ktx2::{ColorModel, Format, Reader, TransferFunction};

    use super::*;
    use crate::image::tests::example;
    use crate::raw::{tests::assert_same, values};

    #[test]
    fn round_trip() {
        for half in [false, true] {
            for sizes in [vec![3, 2], vec![3, 2, 5, 4]] {
                let image = example(&sizes);
                let reader = Reader::new(encode(&image, half).unwrap()).unwrap();
                let header = reader.header();
                let format = match half {
                    true => Format::R16G16B16A16_SFLOAT,
                    false => Format::R32G32B32A32_SFLOAT,
                };
                assert_eq!(header.format, Some(format));
                assert_eq!(header.type_size, if half { 2 } else { 4 });
                assert_eq!((header.pixel_width, header.pixel_height), (3, 2));
                assert_eq!((header.pixel_depth, header.face_count), (0, 1));
                assert_eq!(header.layer_count as usize, image.layers());
                let levels: Vec<_> = reader.levels().collect();
                assert_eq!(levels.len(), 1);
                assert_same(&values(levels[0].data, half), &image.layered(), half);
                let start = levels[0].data.as_ptr() as usize - reader.data().as_ptr() as usize;
                assert_eq!(start % if half { 8 } else { 16 }, 0);
            }
        }
    }

    #[test]
    fn descriptor_describes_floats() {
        for half in [false, true] {
            let reader = Reader::new(encode(&example(&[3, 2]), half).unwrap()).unwrap();
            assert_eq!(reader.color_model(), Some(ColorModel::RGBSDA));
            assert_eq!(reader.transfer_function(), Some(TransferFunction::Linear));
            let blocks = reader.dfd_blocks();
            assert_eq!(blocks.len(), 1);
            let ktx2::dfd::Block::Basic(basic) = &blocks[0] else {
                panic!("{:?}", blocks[0]);
            };
            let bits = if half { 16 } else { 32 };
            assert_eq!(u32::from(basic.bytes_planes[0]), bits / 2);
            let samples: Vec<_> = basic.sample_information.iter().collect();
            assert_eq!(samples.len(), 4);
            for (i, sample) in samples.iter().enumerate() {
                assert_eq!(u32::from(sample.bit_offset), i as u32 * bits);
                assert_eq!(u32::from(sample.bit_length.get()), bits);
            }
        }
    }

    #[test]
    fn texts_are_found_again() {
        let reader = Reader::new(encode(&example(&[3, 2, 5, 4]), false).unwrap()).unwrap();
        let texts: Vec<(&str, &str)> = reader
            .key_value_data()
            .map(|(key, value)| {
                let (end, text) = value.split_last().unwrap();
                assert_eq!(*end, 0);
                (key, std::str::from_utf8(text).unwrap())
            })
            .collect();
        let text = |key: &str| texts.iter().find(|text| text.0 == key).unwrap().1;
        assert!(texts.is_sorted_by_key(|text| text.0));
        assert_eq!(text("lumigon-sizes"), "3 2 5 4");
        assert!(text("lumigon-index").contains("(channel / 4) * 20 + i3 * 5 + i2"));
        assert_eq!(text("lumigon-frame"), "z = normal, \u{3b8}");
        assert_eq!(
            text("lumigon-channels"),
            "m11 m13 m31 m33 amplitude schlick zero zero"
        );
    }
}
