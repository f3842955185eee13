#version 450
// Light from polygons on a rough dielectric or metal.
#extension GL_GOOGLE_include_directive : require
#include "lumigon.glsl"

// A light as the host stores it: 96 bytes.
struct Light {
    PolygonLight polygon;
    // Linear RGB.
    vec3 radiance;
    // Index of its first record in `light_vertices`.
    uint first_record;
    // One past its last.
    uint end_record;
};

layout(binding = 0, std430) readonly buffer Lights {
    Light lights[];
};
// xyz: a vertex in radii from its light's centre; w: 1 for a move, 0 for a line.
layout(binding = 1, std430) readonly buffer LightVertices {
    vec4 light_vertices[];
};
// tables/ggx-32.ktx2: layer 0 holds matrices, layer 1 amplitudes.
layout(binding = 2) uniform sampler2DArray ggx_table;
layout(binding = 3, std140) uniform Camera {
    vec3 camera;
};

layout(location = 0) in vec3 point;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec4 color;

// Four numbers of the table, blended.
vec4 ggx_numbers(TableCell column, TableCell row, int layer) {
    ivec3 texel = ivec3(column.texel, row.texel, layer);
    return bilinear(
        texelFetch(ggx_table, texel, 0),
        texelFetch(ggx_table, texel + ivec3(1, 0, 0), 0),
        texelFetch(ggx_table, texel + ivec3(0, 1, 0), 0),
        texelFetch(ggx_table, texel + ivec3(1, 1, 0), 0),
        column.fraction,
        row.fraction
    );
}

// Radiance towards the unit vector `view` from all lights, unshadowed. `diffuse` is the Lambertian
// albedo, `f0` the reflectance at normal incidence.
vec3 light_from_polygons(
    vec3 position,
    vec3 unit_normal,
    vec3 view,
    vec3 diffuse,
    vec3 f0,
    float perceptual_roughness
) {
    // Once for a point: its lobes.
    float cos_view = dot(unit_normal, view);
    uvec2 size = uvec2(textureSize(ggx_table, 0).xy);
    vec2 coordinates = ltc_table_coordinates(perceptual_roughness, cos_view);
    TableCell column = table_cell(coordinates.x, size.x);
    TableCell row = table_cell(coordinates.y, size.y);
    LtcSum lobes = ggx_lobes(
        ggx_numbers(column, row, 0),
        ggx_numbers(column, row, 1),
        perceptual_roughness,
        cos_view
    );
    PreparedLtc prepared = prepare_ltc(lobes.lobe.shading_to_cosine, unit_normal, view);
    vec3 f90 = vec3(1.0);
    vec3 by_lobe = reflectance(lobes.lobe.amplitude, lobes.lobe.schlick, f0, f90);
    vec3 by_cosine = reflectance(lobes.cosine_amplitude, lobes.cosine_schlick, f0, f90);

    vec3 reflected = vec3(0.0);
    for (uint index = 0u; index < uint(lights.length()); index++) {
        IrradianceSum irradiance_sum =
            begin_irradiance(lights[index].polygon, position, unit_normal);
        LtcFormFactorSum lobe_sum =
            begin_ltc_form_factor(lights[index].polygon, position, prepared);
        for (uint i = lights[index].first_record; i < lights[index].end_record; i++) {
            vec4 record = light_vertices[i];
            if (record.w != 0.0) {
                irradiance_sum = irradiance_move_to(irradiance_sum, record.xyz);
                lobe_sum = ltc_form_factor_move_to(lobe_sum, record.xyz);
            } else {
                irradiance_sum = irradiance_line_to(irradiance_sum, record.xyz);
                lobe_sum = ltc_form_factor_line_to(lobe_sum, record.xyz);
            }
        }
        float share = form_factor(irradiance_sum);
        vec3 specular = by_lobe * ltc_form_factor(lobe_sum) + by_cosine * share;
        reflected += lights[index].radiance * (diffuse * share + specular);
    }
    return reflected;
}

void main() {
    vec3 view = normalize(camera - point);
    vec3 unit_normal = normalize(normal);
    color = vec4(light_from_polygons(point, unit_normal, view, vec3(0.5), vec3(0.04), 0.3), 1.0);
}
