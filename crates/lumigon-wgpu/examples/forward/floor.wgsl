// Someone's forward renderer: a floor, seen from above. What is new is the loop over the lights.

@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
@group(0) @binding(1) var<uniform> eye: vec4f;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varying {
    let corner = vec2f(vec2u(index & 1u, index >> 1u)) * 6.0 - 3.0;
    let position = vec3f(corner.x, 0.0, corner.y);
    return Varying(clip_from_world * vec4f(position, 1.0), position);
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    let normal = vec3f(0.0, 1.0, 0.0);
    let view = normalize(eye.xyz - in.position);
    let albedo = vec3f(0.5);
    let perceptual_roughness = 0.3;

    let ggx = lookup_ggx(perceptual_roughness, dot(normal, view));
    let lobe = prepare_ltc(ggx.lobe.shading_to_cosine, normal, view);
    let f0 = vec3f(0.04);
    let specular = reflectance(ggx.lobe.amplitude, ggx.lobe.schlick, f0, vec3f(1.0));
    let cosine = reflectance(ggx.cosine_amplitude, ggx.cosine_schlick, f0, vec3f(1.0));
    var radiance = vec3f(0.0);
    for (var i = 0u; i < lights.count; i++) {
        let form_factor = irradiance_from(i, in.position, normal) / 3.14159265;
        let lit = (albedo + cosine) * form_factor
            + specular * ltc_form_factor_from(i, in.position, lobe);
        radiance += lights.list[i].radiance * lit;
    }
    return vec4f(radiance, 1.0);
}
