// Light from polygons on a rough dielectric or metal. The shader module is lumigon.wgsl, followed
// by this file.

/// A light as the host stores it: 96 bytes.
struct Light {
    polygon: PolygonLight,
    /// Linear RGB.
    radiance: vec3f,
    /// Index of its first record in `light_vertices`.
    first_record: u32,
    /// One past its last.
    end_record: u32,
}

@group(0) @binding(0) var<storage, read> lights: array<Light>;
/// xyz: a vertex in radii from its light's centre; w: 1 for a move, 0 for a line.
@group(0) @binding(1) var<storage, read> light_vertices: array<vec4f>;
/// tables/ggx-32.ktx2: layer 0 holds matrices, layer 1 amplitudes.
@group(0) @binding(2) var ggx_table: texture_2d_array<f32>;
@group(0) @binding(3) var<uniform> camera: vec3f;

/// Four numbers of the table, blended.
fn ggx_numbers(column: TableCell, row: TableCell, layer: u32) -> vec4f {
    let texel = vec2u(column.texel, row.texel);
    return bilinear(
        textureLoad(ggx_table, texel, layer, 0),
        textureLoad(ggx_table, texel + vec2u(1u, 0u), layer, 0),
        textureLoad(ggx_table, texel + vec2u(0u, 1u), layer, 0),
        textureLoad(ggx_table, texel + vec2u(1u, 1u), layer, 0),
        column.fraction,
        row.fraction,
    );
}

/// Radiance towards the unit vector `view` from all lights, unshadowed. `diffuse` is the Lambertian
/// albedo, `f0` the reflectance at normal incidence.
fn light_from_polygons(
    point: vec3f,
    normal: vec3f,
    view: vec3f,
    diffuse: vec3f,
    f0: vec3f,
    perceptual_roughness: f32,
) -> vec3f {
    // Once for a point: its lobes.
    let cos_view = dot(normal, view);
    let size = textureDimensions(ggx_table);
    let coordinates = ltc_table_coordinates(perceptual_roughness, cos_view);
    let column = table_cell(coordinates.x, size.x);
    let row = table_cell(coordinates.y, size.y);
    let lobes = ggx_lobes(
        ggx_numbers(column, row, 0u),
        ggx_numbers(column, row, 1u),
        perceptual_roughness,
        cos_view,
    );
    let prepared = prepare_ltc(lobes.lobe.shading_to_cosine, normal, view);
    let f90 = vec3f(1.0);
    let by_lobe = reflectance(lobes.lobe.amplitude, lobes.lobe.schlick, f0, f90);
    let by_cosine = reflectance(lobes.cosine_amplitude, lobes.cosine_schlick, f0, f90);

    var reflected = vec3f(0.0);
    for (var index = 0u; index < arrayLength(&lights); index++) {
        let light = lights[index];
        var irradiance_sum = begin_irradiance(light.polygon, point, normal);
        var lobe_sum = begin_ltc_form_factor(light.polygon, point, prepared);
        for (var i = light.first_record; i < light.end_record; i++) {
            let record = light_vertices[i];
            if record.w != 0.0 {
                irradiance_sum = irradiance_move_to(irradiance_sum, record.xyz);
                lobe_sum = ltc_form_factor_move_to(lobe_sum, record.xyz);
            } else {
                irradiance_sum = irradiance_line_to(irradiance_sum, record.xyz);
                lobe_sum = ltc_form_factor_line_to(lobe_sum, record.xyz);
            }
        }
        let share = form_factor(irradiance_sum);
        let specular = by_lobe * ltc_form_factor(lobe_sum) + by_cosine * share;
        reflected += light.radiance * (diffuse * share + specular);
    }
    return reflected;
}

@fragment
fn main(@location(0) point: vec3f, @location(1) normal: vec3f) -> @location(0) vec4f {
    let unit_normal = normalize(normal);
    let view = normalize(camera - point);
    let color = light_from_polygons(point, unit_normal, view, vec3f(0.5), vec3f(0.04), 0.3);
    return vec4f(color, 1.0);
}
