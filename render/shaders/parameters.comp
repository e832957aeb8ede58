#version 450 core
// d1 and d2 over every marker triangle as quadratics of the barycentric weights: model::domain_parameters, one triangle an invocation.
layout(local_size_x = 64) in;

struct Marker { uint corner[3]; float share[3]; float neutral[3]; float u[3]; float v[3]; float spread[2]; float q[5]; float r[5]; float extent; uint near_begin; uint near_end; };
layout(std430, binding = 1) readonly buffer Markers { Marker markers[]; };
layout(std430, binding = 2) readonly buffer Triangles { uint corners[]; };       // 3 T
layout(std430, binding = 3) readonly buffer Deformations { float S[]; };         // 5 M
layout(std430, binding = 4) writeonly buffer Parameters { float parameters[]; }; // 12 T: d1, then d2

uniform int triangle_count;

void main() {
    const uint t = gl_GlobalInvocationID.x;
    if (t >= uint(triangle_count)) return;
    const uint a = corners[3u * t], b = corners[3u * t + 1u], c = corners[3u * t + 2u];
    float q[6] = float[6](0, 0, 0, 0, 0, 0), r[6] = q;
    for (uint k = 0u; k < 5u; ++k) {
        const float s0 = S[5u * a + k], s1 = S[5u * b + k] - s0, s2 = S[5u * c + k] - s0;
        const float q0 = markers[a].q[k], q1 = markers[b].q[k] - q0, q2 = markers[c].q[k] - q0;
        const float r0 = markers[a].r[k], r1 = markers[b].r[k] - r0, r2 = markers[c].r[k] - r0;
        q[0] += s0 * q0;
        q[1] += s0 * q1 + s1 * q0;
        q[2] += s0 * q2 + s2 * q0;
        q[3] += s1 * q1;
        q[4] += s1 * q2 + s2 * q1;
        q[5] += s2 * q2;
        r[0] += s0 * r0;
        r[1] += s0 * r1 + s1 * r0;
        r[2] += s0 * r2 + s2 * r0;
        r[3] += s1 * r1;
        r[4] += s1 * r2 + s2 * r1;
        r[5] += s2 * r2;
    }
    for (uint k = 0u; k < 6u; ++k) {
        parameters[12u * t + k] = q[k];
        parameters[12u * t + 6u + k] = r[k];
    }
}
