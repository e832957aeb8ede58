#version 450 core
layout(location = 0) in uint vertex;
layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
layout(std430, binding = 1) readonly buffer Presence { uint presence[]; };
uniform mat4 view_projection;
out float shown;
void main() {
    const uint at = 3u * vertex;
    shown = presence[vertex] != 0u ? 1.0 : 0.0;
    // A missing marker has no position; fragments towards it fall away because they mix `shown` of both ends.
    gl_Position = shown != 0.0 ? view_projection * vec4(positions[at], positions[at + 1u], positions[at + 2u], 1) : vec4(0, 0, 2, 1);
}
