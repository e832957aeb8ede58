#version 450 core
// x = neutral + mean + components * w, then eyes by gaze, then the head pose: model::evaluate, one vertex an invocation.
layout(local_size_x = 64) in;

layout(std430, binding = 0) buffer Positions { float positions[]; };           // 3 V
layout(std430, binding = 1) readonly buffer Base { float base[]; };            // 3 V: neutral + mean
layout(binding = 4) uniform samplerBuffer components;                          // columns of V
layout(std430, binding = 3) readonly buffer Weights { float weights[]; };      // k
layout(std430, binding = 4) readonly buffer EyeOf { uint eye_of[]; };          // V: 0 none, 1 right, 2 left

uniform int vertex_count;
uniform int first_component;   // of this buffer of components
uniform int component_count;   // in this buffer
uniform int starts;            // 1: start from `base`, 0: go on from `positions`
uniform int ends;              // 1: eyes and pose follow
uniform mat3 eye_turn[2];
uniform vec3 eye_centre[2];
uniform mat3 rotation;
uniform vec3 translation;

void main() {
    const uint v = gl_GlobalInvocationID.x;
    if (v >= uint(vertex_count)) return;
    const uint at = 3u * v;
    vec3 x = starts == 1 ? vec3(base[at], base[at + 1u], base[at + 2u])
                         : vec3(positions[at], positions[at + 1u], positions[at + 2u]);
    for (int c = 0; c < component_count; ++c) x += weights[first_component + c] * texelFetch(components, c * vertex_count + int(v)).xyz;
    if (ends == 1) {
        const uint eye = eye_of[v];
        if (eye != 0u) x = eye_centre[eye - 1u] + eye_turn[eye - 1u] * (x - eye_centre[eye - 1u]);
        x = rotation * x + translation;
    }
    positions[at] = x.x;
    positions[at + 1u] = x.y;
    positions[at + 2u] = x.z;
}
