//! The bind group that shaders read lights and tables from, and the shaders' text.

use lumigon_shaders::LinkError;

use crate::distance_fields::DistanceFieldBuffers;
use crate::light_buffers::LightBuffers;
use crate::tables::Tables;

/// The modules of the bindings, in WESL: their names, and their texts. For
/// [`lumigon_shaders::link`], whose root may then import from `package::lights`,
/// `package::light_images` and `package::tables`.
pub const MODULES: &[(&str, &str)] = &[
    ("light_images", include_str!("../shaders/light_images.wesl")),
    ("lights", include_str!("../shaders/lights.wesl")),
    ("tables", include_str!("../shaders/tables.wesl")),
];

/// The layout of the bind group.
///
/// | binding | shaders' name | what |
/// | --- | --- | --- |
/// | 0 | `lights` | read-only storage: a count, then [`LightRecord`](crate::LightRecord)s from byte 16 |
/// | 1 | `light_vertices` | read-only storage: [`VertexRecord`](crate::VertexRecord)s |
/// | 2 | `ltc_tables` | 2D array texture, not filtered: [`Tables::isotropic`] |
/// | 3 | `anisotropic_ltc_table` | 3D texture, not filtered: [`Tables::anisotropic`] |
/// | 4 | `distance_fields` | read-only storage: [`DistanceFieldBuffers::texels`] |
/// | 5 | `light_fields` | read-only storage: [`DistanceFieldBuffers::records`] |
/// | 6 | `light_images` | read-only storage: [`ImageRecord`](crate::ImageRecord)s |
/// | 7 | `light_image_texels` | read-only storage: texels of all images, four numbers each |
#[must_use]
pub fn bind_group_layout(
    device: &wgpu::Device,
    visibility: wgpu::ShaderStages,
) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let storage = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = |view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension,
        multisampled: false,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("polygon lights"),
        entries: &[
            entry(0, storage),
            entry(1, storage),
            entry(2, texture(wgpu::TextureViewDimension::D2Array)),
            entry(3, texture(wgpu::TextureViewDimension::D3)),
            entry(4, storage),
            entry(5, storage),
            entry(6, storage),
            entry(7, storage),
        ],
    })
}

/// The bind group of lights without distance fields; to be made anew when [`LightBuffers::write`] says
/// so.
#[must_use]
pub fn bind_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    lights: &LightBuffers,
    tables: &Tables,
) -> wgpu::BindGroup {
    bind_group_with_fields(
        device,
        layout,
        lights,
        tables,
        &DistanceFieldBuffers::none(device),
    )
}

/// The same of lights with distance fields.
#[must_use]
pub fn bind_group_with_fields(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    lights: &LightBuffers,
    tables: &Tables,
    fields: &DistanceFieldBuffers,
) -> wgpu::BindGroup {
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("polygon lights"),
        layout,
        entries: &[
            entry(0, lights.lights().as_entire_binding()),
            entry(1, lights.vertices().as_entire_binding()),
            entry(2, wgpu::BindingResource::TextureView(tables.isotropic())),
            entry(3, wgpu::BindingResource::TextureView(tables.anisotropic())),
            entry(4, fields.texels().as_entire_binding()),
            entry(5, fields.records().as_entire_binding()),
            entry(6, lights.images().records().as_entire_binding()),
            entry(7, lights.images().texels().as_entire_binding()),
        ],
    })
}

/// WGSL to put before a shader of yours: the bindings in bind group `group`, and every function over
/// them: `irradiance_from(light, point, normal)`, `ltc_form_factor_from(light, point, lobe)`,
/// `mean_image_from(light, point, normal, taps)`,
/// `lookup_ggx(perceptual_roughness, cos_view)` and their like, with the library that they call.
///
/// # Errors
/// Where the library is broken, which the example rules out.
pub fn wgsl(group: u32) -> Result<String, LinkError> {
    let text = lumigon_shaders::library_with(MODULES)?;
    Ok(text.replace("@group(0)", &format!("@group({group})")))
}
