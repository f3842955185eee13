// Light from polygons on a rough dielectric or metal.
#include "lumigon.hlsl"

// A light as the host stores it: 84 bytes, tightly packed.
struct Light {
    PolygonLight polygon;
    // Linear RGB.
    float3 radiance;
    // Index of its first record in `light_vertices`.
    uint first_record;
    // One past its last.
    uint end_record;
};

StructuredBuffer<Light> lights : register(t0);
// xyz: a vertex in radii from its light's centre; w: 1 for a move, 0 for a line.
StructuredBuffer<float4> light_vertices : register(t1);
// tables/ggx-32.dds: layer 0 holds matrices, layer 1 amplitudes.
Texture2DArray<float4> ggx_table : register(t2);
cbuffer Camera : register(b0) {
    float3 camera;
    uint light_count;
};

// Four numbers of the table, blended.
float4 ggx_numbers(TableCell column, TableCell row, int layer) {
    int4 texel = int4(column.texel, row.texel, layer, 0);
    return bilinear(
        ggx_table.Load(texel),
        ggx_table.Load(texel + int4(1, 0, 0, 0)),
        ggx_table.Load(texel + int4(0, 1, 0, 0)),
        ggx_table.Load(texel + int4(1, 1, 0, 0)),
        column.fraction,
        row.fraction
    );
}

// Radiance towards the unit vector `view` from all lights, unshadowed. `diffuse` is the Lambertian
// albedo, `f0` the reflectance at normal incidence.
float3 light_from_polygons(
    float3 position,
    float3 normal,
    float3 view,
    float3 diffuse,
    float3 f0,
    float perceptual_roughness
) {
    // Once for a point: its lobes.
    float cos_view = dot(normal, view);
    uint width, height, layers;
    ggx_table.GetDimensions(width, height, layers);
    float2 coordinates = ltc_table_coordinates(perceptual_roughness, cos_view);
    TableCell column = table_cell(coordinates.x, width);
    TableCell row = table_cell(coordinates.y, height);
    LtcSum lobes = ggx_lobes(
        ggx_numbers(column, row, 0),
        ggx_numbers(column, row, 1),
        perceptual_roughness,
        cos_view
    );
    PreparedLtc prepared = prepare_ltc(lobes.lobe.shading_to_cosine, normal, view);
    float3 f90 = float3(1.0, 1.0, 1.0);
    float3 by_lobe = reflectance(lobes.lobe.amplitude, lobes.lobe.schlick, f0, f90);
    float3 by_cosine = reflectance(lobes.cosine_amplitude, lobes.cosine_schlick, f0, f90);

    float3 reflected = float3(0.0, 0.0, 0.0);
    for (uint index = 0; index < light_count; index++) {
        Light light = lights[index];
        IrradianceSum irradiance_sum = begin_irradiance(light.polygon, position, normal);
        LtcFormFactorSum lobe_sum = begin_ltc_form_factor(light.polygon, position, prepared);
        for (uint i = light.first_record; i < light.end_record; i++) {
            float4 record = light_vertices[i];
            if (record.w != 0.0) {
                irradiance_sum = irradiance_move_to(irradiance_sum, record.xyz);
                lobe_sum = ltc_form_factor_move_to(lobe_sum, record.xyz);
            } else {
                irradiance_sum = irradiance_line_to(irradiance_sum, record.xyz);
                lobe_sum = ltc_form_factor_line_to(lobe_sum, record.xyz);
            }
        }
        float share = form_factor(irradiance_sum);
        float3 specular = by_lobe * ltc_form_factor(lobe_sum) + by_cosine * share;
        reflected += light.radiance * (diffuse * share + specular);
    }
    return reflected;
}

float4 main(float3 position : POSITION, float3 normal : NORMAL) : SV_Target {
    float3 view = normalize(camera - position);
    float3 diffuse = float3(0.5, 0.5, 0.5);
    float3 f0 = float3(0.04, 0.04, 0.04);
    return float4(light_from_polygons(position, normalize(normal), view, diffuse, f0, 0.3), 1.0);
}
