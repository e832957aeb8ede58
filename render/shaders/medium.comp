#version 450 core
// The medium layer on the vertices: each takes the up to four texels of its place in the map (model::MediumSurface).
layout(local_size_x = 64) in;

struct Moved { uint vertex; uint begin; uint end; };
struct Texel { float weight; uint triangle; float b1; float b2; };
layout(std430, binding = 0) buffer Positions { float positions[]; };               // 3 V, posed
layout(std430, binding = 1) readonly buffer MovedVertices { Moved moved[]; };
layout(std430, binding = 2) readonly buffer Texels { Texel texels[]; };
layout(std430, binding = 3) readonly buffer Coefficients { float coefficients[]; };  // per texel: 3 channels of TERMS
layout(std430, binding = 4) readonly buffer Parameters { float parameters[]; };      // 12 per marker triangle

uniform int moved_count;
uniform mat3 rotation;

float quadratic(uint at, float b1, float b2) {
    return parameters[at] + b1 * (parameters[at + 1u] + parameters[at + 3u] * b1 + parameters[at + 4u] * b2) +
           b2 * (parameters[at + 2u] + parameters[at + 5u] * b2);
}

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= uint(moved_count)) return;
    vec3 sum = vec3(0);
    for (uint t = moved[i].begin; t < moved[i].end; ++t) {
        const Texel texel = texels[t];
        const float d1 = quadratic(12u * texel.triangle, texel.b1, texel.b2);
        const float d2 = quadratic(12u * texel.triangle + 6u, texel.b1, texel.b2);
        const float term[10] = float[10](1.0, d1, d2, d1 * d1, d1 * d2, d2 * d2, d1 * d1 * d1, d1 * d1 * d2, d1 * d2 * d2, d2 * d2 * d2);
        vec3 value = vec3(0);
        for (uint k = 0u; k < uint(TERMS); ++k) {
            const uint at = 3u * uint(TERMS) * t + k;
            value += term[k] * vec3(coefficients[at], coefficients[at + uint(TERMS)], coefficients[at + 2u * uint(TERMS)]);
        }
        sum += texel.weight * value;
    }
    const uint at = 3u * moved[i].vertex;
    const vec3 offset = rotation * sum;
    positions[at] += offset.x;
    positions[at + 1u] += offset.y;
    positions[at + 2u] += offset.z;
}
