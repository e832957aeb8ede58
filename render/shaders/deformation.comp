#version 450 core
// Deformation vectors S of all markers (Ma et al. 2008, equation 2): model::DeformationMeter::measure, one marker an invocation;
// drawn back where (d1, d2) is longer than training had it, as in model::domain_parameters.
layout(local_size_x = 64) in;

struct Marker {
    uint corner[3];
    float share[3];      // place on the mesh
    float neutral[3];
    float u[3];
    float v[3];          // tangents
    float spread[2];     // standard deviations at neutral
    float q[5];
    float r[5];          // axes
    float extent;        // longest (d1, d2)
    uint near_begin;
    uint near_end;       // N2
};
layout(std430, binding = 0) readonly buffer Positions { float positions[]; };   // 3 V, posed
layout(std430, binding = 1) readonly buffer Markers { Marker markers[]; };      // M
layout(std430, binding = 2) readonly buffer Near { uint near[]; };
layout(std430, binding = 3) writeonly buffer Deformations { float S[]; };       // 5 M

uniform int marker_count;
uniform mat3 rotation;      // the head pose, which shape.comp has applied
uniform vec3 translation;

vec3 place(uint m) {
    vec3 sum = vec3(0);
    for (int k = 0; k < 3; ++k) {
        const uint at = 3u * markers[m].corner[k];
        sum += markers[m].share[k] * vec3(positions[at], positions[at + 1u], positions[at + 2u]);
    }
    return transpose(rotation) * (sum - translation);
}

void main() {
    const uint m = gl_GlobalInvocationID.x;
    if (m >= uint(marker_count)) return;
    const vec3 here = place(m);
    const vec3 u = vec3(markers[m].u[0], markers[m].u[1], markers[m].u[2]);
    const vec3 v = vec3(markers[m].v[0], markers[m].v[1], markers[m].v[2]);
    vec2 sum = vec2(0), squares = vec2(0);
    const float n = float(markers[m].near_end - markers[m].near_begin);
    for (uint i = markers[m].near_begin; i < markers[m].near_end; ++i) {
        const vec3 arm = place(near[i]) - here;
        const vec2 along = vec2(dot(arm, u), dot(arm, v));
        sum += along;
        squares += along * along;
    }
    const vec2 mean = sum / n;
    const vec2 spread = sqrt(max(squares / n - mean * mean, 0.0));
    const float own[5] = float[5](here.x - markers[m].neutral[0], here.y - markers[m].neutral[1], here.z - markers[m].neutral[2],
                                  sqrt(n) * (spread.x - markers[m].spread[0]), sqrt(n) * (spread.y - markers[m].spread[1]));
    vec2 d = vec2(0);
    for (int k = 0; k < 5; ++k) d += own[k] * vec2(markers[m].q[k], markers[m].r[k]);
    const float shrink = min(1.0, markers[m].extent / max(length(d), 1e-20));
    for (int k = 0; k < 5; ++k) S[5u * m + uint(k)] = shrink * own[k];
}
