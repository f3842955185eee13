// Light from polygons on a rough dielectric or metal.
#include "lumigon.metal"

using namespace metal;

// A light as the host stores it: 96 bytes.
struct Light {
    lumigon::PolygonLight polygon;
    // Linear RGB.
    packed_float3 radiance;
    // Index of its first record in `light_vertices`.
    uint first_record;
    // One past its last.
    uint end_record;
    uint padding[3];
};

struct Camera {
    packed_float3 position;
    uint light_count;
};

struct Surface {
    float4 clip_position [[position]];
    float3 point;
    float3 normal;
};

// tables/ggx-32.ktx2: layer 0 holds matrices, layer 1 amplitudes.
using Table = texture2d_array<float>;

// Four numbers of the table, blended.
float4 ggx_numbers(Table table, lumigon::TableCell column, lumigon::TableCell row, uint layer) {
    uint2 texel = uint2(column.texel, row.texel);
    return lumigon::bilinear(
        table.read(texel, layer),
        table.read(texel + uint2(1, 0), layer),
        table.read(texel + uint2(0, 1), layer),
        table.read(texel + uint2(1, 1), layer),
        column.fraction,
        row.fraction
    );
}

// Radiance towards the unit vector `view` from all lights, unshadowed. `diffuse` is the Lambertian
// albedo, `f0` the reflectance at normal incidence. The vertices: xyz in radii from their light's
// centre, w 1 for a move, 0 for a line.
float3 light_from_polygons(
    device const Light* lights,
    uint light_count,
    device const float4* light_vertices,
    Table table,
    float3 point,
    float3 normal,
    float3 view,
    float3 diffuse,
    float3 f0,
    float perceptual_roughness
) {
    // Once for a point: its lobes.
    float cos_view = dot(normal, view);
    float2 coordinates = lumigon::ltc_table_coordinates(perceptual_roughness, cos_view);
    lumigon::TableCell column = lumigon::table_cell(coordinates.x, table.get_width());
    lumigon::TableCell row = lumigon::table_cell(coordinates.y, table.get_height());
    lumigon::LtcSum lobes = lumigon::ggx_lobes(
        ggx_numbers(table, column, row, 0),
        ggx_numbers(table, column, row, 1),
        perceptual_roughness,
        cos_view
    );
    lumigon::PreparedLtc prepared =
        lumigon::prepare_ltc(lobes.lobe.shading_to_cosine, normal, view);
    float3 f90 = float3(1.0);
    float3 by_lobe = lumigon::reflectance(lobes.lobe.amplitude, lobes.lobe.schlick, f0, f90);
    float3 by_cosine =
        lumigon::reflectance(lobes.cosine_amplitude, lobes.cosine_schlick, f0, f90);

    float3 reflected = float3(0.0);
    for (uint index = 0; index < light_count; index++) {
        Light light = lights[index];
        lumigon::IrradianceSum irradiance_sum =
            lumigon::begin_irradiance(light.polygon, point, normal);
        lumigon::LtcFormFactorSum lobe_sum =
            lumigon::begin_ltc_form_factor(light.polygon, point, prepared);
        for (uint i = light.first_record; i < light.end_record; i++) {
            float4 record = light_vertices[i];
            if (record.w != 0.0) {
                irradiance_sum = lumigon::irradiance_move_to(irradiance_sum, record.xyz);
                lobe_sum = lumigon::ltc_form_factor_move_to(lobe_sum, record.xyz);
            } else {
                irradiance_sum = lumigon::irradiance_line_to(irradiance_sum, record.xyz);
                lobe_sum = lumigon::ltc_form_factor_line_to(lobe_sum, record.xyz);
            }
        }
        float share = lumigon::form_factor(irradiance_sum);
        float3 specular = by_lobe * lumigon::ltc_form_factor(lobe_sum) + by_cosine * share;
        reflected += float3(light.radiance) * (diffuse * share + specular);
    }
    return reflected;
}

fragment float4 example(
    Surface surface [[stage_in]],
    device const Light* lights [[buffer(0)]],
    device const float4* light_vertices [[buffer(1)]],
    constant Camera& camera [[buffer(2)]],
    Table ggx_table [[texture(0)]]
) {
    float3 view = normalize(float3(camera.position) - surface.point);
    float3 normal = normalize(surface.normal);
    float3 color = light_from_polygons(
        lights, camera.light_count, light_vertices, ggx_table,
        surface.point, normal, view, float3(0.5), float3(0.04), 0.3
    );
    return float4(color, 1.0);
}
