#version 450 core
layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
layout(std430, binding = 1) readonly buffer Presence { uint presence[]; };
uniform mat4 view_projection;
uniform mat4 view;
uniform float radius;        // mm
uniform float pixels_per_slope;   // picture height / (2 tan(fov / 2))
out vec3 centre;             // in the camera's space
void main() {
    const uint at = 3u * uint(gl_VertexID);
    const vec4 position = vec4(positions[at], positions[at + 1u], positions[at + 2u], 1);
    centre = (view * position).xyz;
    gl_PointSize = max(2.0, 2.0 * radius * pixels_per_slope / -centre.z);
    gl_Position = presence[gl_VertexID] != 0u ? view_projection * position : vec4(0, 0, 2, 1);   // outside when missing
}
