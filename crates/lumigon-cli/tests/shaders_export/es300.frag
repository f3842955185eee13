precision highp sampler2D;

// A row of nine texels a case: the light's four, point, normal, view with the perceptual roughness,
// first and last record, one spare.
uniform sampler2D cases;
// 256 texels a row.
uniform sampler2D records;
// As the README says: the table's eight numbers are two neighbours.
uniform sampler2D ggx_table;
uniform sampler2D ggx_half;

out vec4 color;

vec4 ggx_numbers(sampler2D table, TableCell column, TableCell row, int group) {
    ivec2 texel = ivec2(2 * int(column.texel) + group, int(row.texel));
    return bilinear(
        texelFetch(table, texel, 0),
        texelFetch(table, texel + ivec2(2, 0), 0),
        texelFetch(table, texel + ivec2(0, 1), 0),
        texelFetch(table, texel + ivec2(2, 1), 0),
        column.fraction,
        row.fraction
    );
}

vec4 number(int index) {
    return texelFetch(cases, ivec2(index, int(gl_FragCoord.y)), 0);
}

// Columns of the picture: what is computed.
void main() {
    PolygonLight light;
    light.center = number(0).xyz;
    light.inverse_radius = number(0).w;
    light.normal = number(1).xyz;
    light.doubled_area = number(1).w;
    light.centroid_ = number(2).xyz;
    light.plane_tolerance = number(2).w;
    light.plane_axis = number(3).xyz;
    light.both_sides = uint(number(3).w);
    vec3 point = number(4).xyz;
    vec3 normal = number(5).xyz;
    vec3 view = number(6).xyz;
    float perceptual_roughness = number(6).w;

    float cos_view = dot(normal, view);
    vec2 coordinates = ltc_table_coordinates(perceptual_roughness, cos_view);
    TableCell column = table_cell(coordinates.x, 32u);
    TableCell row = table_cell(coordinates.y, 32u);
    vec4 matrix = ggx_numbers(ggx_table, column, row, 0);
    vec4 amplitudes = ggx_numbers(ggx_table, column, row, 1);
    LtcSum lobes = ggx_lobes(matrix, amplitudes, perceptual_roughness, cos_view);
    PreparedLtc lobe = prepare_ltc(lobes.lobe.shading_to_cosine, normal, view);

    IrradianceSum irradiance_sum = begin_irradiance(light, point, normal);
    LtcFormFactorSum lobe_sum = begin_ltc_form_factor(light, point, lobe);
    SolidAngleSum solid_angle_sum = begin_solid_angle(light, point);
    LightVectorSum vector_sum = begin_light_vector(light, point);
    int end = int(number(7).y);
    for (int i = int(number(7).x); i < end; i++) {
        vec4 record = texelFetch(records, ivec2(i % 256, i / 256), 0);
        if (record.w != 0.0) {
            irradiance_sum = irradiance_move_to(irradiance_sum, record.xyz);
            lobe_sum = ltc_form_factor_move_to(lobe_sum, record.xyz);
            solid_angle_sum = solid_angle_move_to(solid_angle_sum, record.xyz);
            vector_sum = light_vector_move_to(vector_sum, record.xyz);
        } else {
            irradiance_sum = irradiance_line_to(irradiance_sum, record.xyz);
            lobe_sum = ltc_form_factor_line_to(lobe_sum, record.xyz);
            solid_angle_sum = solid_angle_line_to(solid_angle_sum, record.xyz);
            vector_sum = light_vector_line_to(vector_sum, record.xyz);
        }
    }

    int quantity = int(gl_FragCoord.x);
    if (quantity == 0) {
        color = vec4(
            irradiance(irradiance_sum),
            form_factor(irradiance_sum),
            solid_angle(solid_angle_sum),
            ltc_form_factor(lobe_sum)
        );
    } else if (quantity == 1) {
        color = vec4(light_vector(vector_sum), 0.0);
    } else if (quantity == 2) {
        color = lobes.lobe.shading_to_cosine;
    } else if (quantity == 3) {
        color = vec4(
            lobes.lobe.amplitude,
            lobes.lobe.schlick,
            lobes.cosine_amplitude,
            lobes.cosine_schlick
        );
    } else {
        color = abs(ggx_numbers(ggx_half, column, row, quantity - 4));
    }
}
