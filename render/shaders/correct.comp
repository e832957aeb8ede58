#version 450 core
// Corrections of single points, before the components are added: one entry an invocation, each entry once.
layout(local_size_x = 64) in;

layout(std430, binding = 0) buffer Positions { float positions[]; };                     // 3 V
layout(std430, binding = 1) readonly buffer Corrections { uvec2 corrections[]; };        // entry of positions, bits of a float

uniform int correction_count;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= uint(correction_count)) return;
    positions[corrections[i].x] += uintBitsToFloat(corrections[i].y);
}
