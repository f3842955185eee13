//! Fitted tables as textures.

use half::f16;
use lumigon::{AnisotropicLtcTable, LtcTable};

/// How texels are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TableFormat {
    /// Half precision: half the memory and bandwidth, an error of 5e-4 of each number.
    F16,
    /// Single precision, as the CPU has them.
    #[default]
    F32,
}

/// The tables that ship with lumigon, on a device: for [`bind_group`](crate::bind_group).
#[derive(Debug)]
pub struct Tables {
    isotropic: wgpu::TextureView,
    anisotropic: wgpu::TextureView,
    format: TableFormat,
}

impl Tables {
    /// Uploads them.
    #[must_use]
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, format: TableFormat) -> Self {
        let (ggx, ggx_two) = (LtcTable::ggx(), LtcTable::ggx_2());
        let (charlie, eon) = (LtcTable::charlie(), LtcTable::eon());
        let size = ggx.size();
        debug_assert!([ggx_two.size(), charlie.size(), eon.size()] == [size; 3]);
        let mut layers = Vec::new();
        for texels in [
            ggx.texels(),
            ggx_two.texels(),
            charlie.texels(),
            eon.texels(),
        ] {
            let channels = texels.len() / (size * size);
            layers.extend(parts(texels, channels));
        }
        let isotropic = upload(
            device,
            queue,
            "LTC tables",
            wgpu::TextureDimension::D2,
            [size, size, layers.len() / (4 * size * size)],
            format,
            &layers,
        );
        let table = AnisotropicLtcTable::ggx();
        let [x, y, z, w] = table.sizes();
        // Slices of one azimuth and view angle, the three parts of a texel one after the other.
        let slices: Vec<f32> = table
            .texels()
            .chunks(12 * x * y)
            .flat_map(|slice| parts(slice, 12))
            .collect();
        let anisotropic = upload(
            device,
            queue,
            "anisotropic LTC table",
            wgpu::TextureDimension::D3,
            [x, y, 3 * z * w],
            format,
            &slices,
        );
        Self {
            isotropic,
            anisotropic,
            format,
        }
    }

    /// How the texels are stored.
    #[must_use]
    pub fn format(&self) -> TableFormat {
        self.format
    }

    /// The shaders' `ltc_tables`: a two-dimensional array, layers of four numbers a texel: GGX (two
    /// layers), GGX of two lobes (three), Charlie (two) and EON (two).
    #[must_use]
    pub fn isotropic(&self) -> &wgpu::TextureView {
        &self.isotropic
    }

    /// The shaders' `anisotropic_ltc_table`: three-dimensional, the first two axes of the table, and
    /// three slices of four numbers a texel for each pair of the other two.
    #[must_use]
    pub fn anisotropic(&self) -> &wgpu::TextureView {
        &self.anisotropic
    }
}

/// Texels of many channels as images of four: the first four of all texels, then the next.
fn parts(texels: &[f32], channels: usize) -> impl Iterator<Item = f32> + '_ {
    (0..channels / 4).flat_map(move |part| {
        texels
            .chunks(channels)
            .flat_map(move |texel| texel[4 * part..4 * part + 4].iter().copied())
    })
}

fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    dimension: wgpu::TextureDimension,
    [width, height, depth]: [usize; 3],
    format: TableFormat,
    numbers: &[f32],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width: width as u32,
        height: height as u32,
        depth_or_array_layers: depth as u32,
    };
    let (texture_format, bytes): (_, Vec<u8>) = match format {
        TableFormat::F32 => (
            wgpu::TextureFormat::Rgba32Float,
            numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ),
        TableFormat::F16 => (
            wgpu::TextureFormat::Rgba16Float,
            numbers
                .iter()
                .flat_map(|&x| f16::from_f32(x).to_le_bytes())
                .collect(),
        ),
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format: texture_format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    queue.write_texture(
        texture.as_image_copy(),
        &bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some((bytes.len() / (height * depth)) as u32),
            rows_per_image: Some(height as u32),
        },
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        // One layer or slice is an array of one, or has depth one, all the same.
        dimension: Some(match dimension {
            wgpu::TextureDimension::D3 => wgpu::TextureViewDimension::D3,
            _ => wgpu::TextureViewDimension::D2Array,
        }),
        ..wgpu::TextureViewDescriptor::default()
    })
}
