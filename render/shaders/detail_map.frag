#version 450 core
// Polynomial maps at every texel (Ma et al. 2008, equation 1): linear albedo in red, green and blue, height along the normal in alpha.
layout(location = 0) out vec4 value;

layout(binding = 0) uniform sampler2D domain;             // b1, b2, marker triangle (-1: none), share of the map against `still`
layout(binding = 1) uniform samplerBuffer parameters;     // 3 per marker triangle: d1 in 6 numbers, then d2
layout(binding = 2) uniform sampler2DArray coefficients;  // a layer per term
layout(binding = 3) uniform sampler2D still;              // albedo of what no map covers

void main() {
    const ivec2 here = ivec2(gl_FragCoord.xy);
    const vec4 place = texelFetch(domain, here, 0);
    value = vec4(texelFetch(still, here, 0).rgb, 0);
    if (place.z < 0.0) return;
    const int at = 3 * int(place.z);
    const vec4 p = texelFetch(parameters, at), q = texelFetch(parameters, at + 1), r = texelFetch(parameters, at + 2);
    const float b1 = place.x, b2 = place.y;
    const float d1 = p.x + b1 * (p.y + p.w * b1 + q.x * b2) + b2 * (p.z + q.y * b2);
    const float d2 = q.z + b1 * (q.w + r.y * b1 + r.z * b2) + b2 * (r.x + r.w * b2);
    vec4 sum = texelFetch(coefficients, ivec3(here, 0), 0);
#if TERMS > 1
    sum += d1 * texelFetch(coefficients, ivec3(here, 1), 0) + d2 * texelFetch(coefficients, ivec3(here, 2), 0);
#endif
#if TERMS > 3
    sum += d1 * d1 * texelFetch(coefficients, ivec3(here, 3), 0) + d1 * d2 * texelFetch(coefficients, ivec3(here, 4), 0) +
           d2 * d2 * texelFetch(coefficients, ivec3(here, 5), 0);
#endif
#if TERMS > 6
    sum += d1 * d1 * (d1 * texelFetch(coefficients, ivec3(here, 6), 0) + d2 * texelFetch(coefficients, ivec3(here, 7), 0)) +
           d2 * d2 * (d1 * texelFetch(coefficients, ivec3(here, 8), 0) + d2 * texelFetch(coefficients, ivec3(here, 9), 0));
#endif
    value = vec4(mix(value.rgb, max(sum.rgb, 0.0), place.w), sum.a);
}
