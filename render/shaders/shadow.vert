#version 450 core
layout(location = 0) in uint vertex;
layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
uniform mat4 light_projection;
void main() {
    gl_Position = light_projection * vec4(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u], 1);
}
