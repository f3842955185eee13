#version 300 es
// Light from one polygon on a rough dielectric or metal, for WebGL 2 and OpenGL ES 3.0.
precision highp float;
precision highp int;
precision highp sampler2D;

// There is no #include in WebGL: put the file's text in place of this line.
#include "lumigon.glsl"

const int MOST_RECORDS = 64;

uniform PolygonLight light;
// Linear RGB.
uniform vec3 radiance;
// xyz: a vertex in radii from the light's centre; w: 1 for a move, 0 for a line.
uniform vec4 light_vertices[MOST_RECORDS];
uniform int record_count;
// tables/ggx-32.f16 as RGBA16F (or .f32 as RGBA32F), 64 x 32: a texel's eight numbers are two
// neighbours, the matrix and the amplitudes. NEAREST: the shader blends.
uniform sampler2D ggx_table;
uniform vec3 camera;

in vec3 point;
in vec3 normal;
out vec4 color;

// Four numbers of the table, blended: group 0 is the matrix, group 1 the amplitudes.
vec4 ggx_numbers(TableCell column, TableCell row, int group) {
    ivec2 texel = ivec2(2 * int(column.texel) + group, int(row.texel));
    return bilinear(
        texelFetch(ggx_table, texel, 0),
        texelFetch(ggx_table, texel + ivec2(2, 0), 0),
        texelFetch(ggx_table, texel + ivec2(0, 1), 0),
        texelFetch(ggx_table, texel + ivec2(2, 1), 0),
        column.fraction,
        row.fraction
    );
}

// Radiance towards the unit vector `view`, unshadowed. `diffuse` is the Lambertian albedo, `f0` the
// reflectance at normal incidence.
vec3 light_from_polygon(
    vec3 position,
    vec3 unit_normal,
    vec3 view,
    vec3 diffuse,
    vec3 f0,
    float perceptual_roughness
) {
    // Once for a point: its lobes.
    float cos_view = dot(unit_normal, view);
    vec2 coordinates = ltc_table_coordinates(perceptual_roughness, cos_view);
    TableCell column = table_cell(coordinates.x, 32u);
    TableCell row = table_cell(coordinates.y, 32u);
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

    // For each light:
    IrradianceSum irradiance_sum = begin_irradiance(light, position, unit_normal);
    LtcFormFactorSum lobe_sum = begin_ltc_form_factor(light, position, prepared);
    for (int i = 0; i < record_count; i++) {
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
    return radiance * (diffuse * share + specular);
}

void main() {
    vec3 view = normalize(camera - point);
    vec3 unit_normal = normalize(normal);
    color = vec4(light_from_polygon(point, unit_normal, view, vec3(0.5), vec3(0.04), 0.3), 1.0);
}
