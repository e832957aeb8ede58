#version 450 core
// The medium layer on the vertices: each takes the up to four texels of its place in the map (model::MediumSurface).
layout(local_size_x = 64) in;

struct Moved { uint vertex; uint begin; uint end; };
layout(std430, binding = 0) buffer Positions { float positions[]; };               // 3 V, posed
layout(std430, binding = 1) readonly buffer MovedVertices { Moved moved[]; };
layout(binding = 4) uniform samplerBuffer texels;        // weight, marker triangle (bits of an integer), b1, b2
layout(binding = 5) uniform samplerBuffer coefficients;  // per texel TERMS of three channels
layout(binding = 6) uniform samplerBuffer parameters;    // 3 per marker triangle: d1 in 6 numbers, then d2

uniform int moved_count;
uniform mat3 rotation;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= uint(moved_count)) return;
    vec3 sum = vec3(0);
    for (uint t = moved[i].begin; t < moved[i].end; ++t) {
        const vec4 texel = texelFetch(texels, int(t));
        const int at = 3 * floatBitsToInt(texel.y);
        const vec4 p = texelFetch(parameters, at), q = texelFetch(parameters, at + 1), r = texelFetch(parameters, at + 2);
        const float b1 = texel.z, b2 = texel.w;
        const float d1 = p.x + b1 * (p.y + p.w * b1 + q.x * b2) + b2 * (p.z + q.y * b2);
        const float d2 = q.z + b1 * (q.w + r.y * b1 + r.z * b2) + b2 * (r.x + r.w * b2);
        const float term[10] = float[10](1.0, d1, d2, d1 * d1, d1 * d2, d2 * d2, d1 * d1 * d1, d1 * d1 * d2, d1 * d2 * d2, d2 * d2 * d2);
        vec3 value = vec3(0);
        for (int k = 0; k < TERMS; ++k) value += term[k] * texelFetch(coefficients, TERMS * int(t) + k).xyz;
        sum += texel.x * value;
    }
    const uint at = 3u * moved[i].vertex;
    const vec3 offset = rotation * sum;
    positions[at] += offset.x;
    positions[at + 1u] += offset.y;
    positions[at + 2u] += offset.z;
}
