use ddsfile::{AlphaMode, D3D10ResourceDimension, Dds, DxgiFormat, NewDxgiParams};

use crate::error::TableError;
use crate::image::TableImage;
use crate::raw;

/// `DXGI_FORMAT_R32G32B32A32_FLOAT` or `R16G16B16A16_FLOAT`, `arraySize` the count of layers.
pub(crate) fn encode(image: &TableImage, half: bool) -> Result<Vec<u8>, TableError> {
    let failed = |problem: String| TableError::Format {
        name: image.name().to_owned(),
        format: "DDS",
        problem,
    };
    let data = raw::bytes(&image.layered(), half);
    let fits = |size: usize| {
        u32::try_from(size).map_err(|_| failed("it has more than 2^32 bytes".to_owned()))
    };
    fits(data.len())?;
    let mut dds = Dds::new_dxgi(NewDxgiParams {
        width: fits(image.sizes()[0])?,
        height: fits(image.sizes()[1])?,
        depth: None,
        format: match half {
            true => DxgiFormat::R16G16B16A16_Float,
            false => DxgiFormat::R32G32B32A32_Float,
        },
        mipmap_levels: None,
        array_layers: Some(fits(image.layers())?),
        caps2: None,
        is_cubemap: false,
        resource_dimension: D3D10ResourceDimension::Texture2D,
        // The fourth channel is a number like the others.
        alpha_mode: AlphaMode::Custom,
    })
    .map_err(|error| failed(error.to_string()))?;
    dds.data = data;
    let mut bytes = Vec::new();
    dds.write(&mut bytes)
        .map_err(|error| failed(error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::tests::example;
    use crate::raw::{tests::assert_same, values};

    #[test]
    fn round_trip() {
        for half in [false, true] {
            for sizes in [vec![3, 2], vec![3, 2, 5, 4]] {
                let image = example(&sizes);
                let bytes = encode(&image, half).unwrap();
                let read = Dds::read(bytes.as_slice()).unwrap();
                assert_eq!(read.get_num_array_layers() as usize, image.layers());
                let layers: Vec<f32> = (0..read.get_num_array_layers())
                    .flat_map(|layer| values(read.get_data(layer).unwrap(), half))
                    .collect();
                assert_same(&layers, &image.layered(), half);
            }
        }
    }

    /// The header's fields at the offsets of Microsoft's documentation, not of the library.
    #[test]
    fn header_is_direct3d_s() {
        for (half, format) in [(false, 2), (true, 10)] {
            let bytes = encode(&example(&[3, 2, 5, 4]), half).unwrap();
            let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
            assert_eq!(&bytes[..4], b"DDS ");
            assert_eq!((word(4), word(76)), (124, 32), "sizes of the structures");
            assert_eq!((word(12), word(16)), (2, 3), "height, width");
            assert_eq!(&bytes[84..88], b"DX10");
            assert_eq!(word(128), format, "DXGI_FORMAT");
            assert_eq!(word(132), 3, "D3D10_RESOURCE_DIMENSION_TEXTURE2D");
            assert_eq!(word(136), 0, "no cube");
            assert_eq!(word(140), 40, "arraySize");
            let texel = if half { 8 } else { 16 };
            assert_eq!(bytes.len(), 148 + 40 * 6 * texel);
        }
    }
}
