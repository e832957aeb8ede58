#version 450 core
// Area-weighted vertex normals of the formed shape. Every vertex walks its own ring of triangles, so nothing is written
// by two invocations.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Positions { float positions[]; };  // 3 V
layout(std430, binding = 1) writeonly buffer Normals { float normals[]; };     // 3 V
layout(std430, binding = 2) readonly buffer RingStart { uint ring_start[]; };  // V + 1
layout(std430, binding = 3) readonly buffer Ring { uvec2 ring[]; };            // the triangle's other two corners, in order

uniform int vertex_count;

vec3 position(uint v) { return vec3(positions[3u * v], positions[3u * v + 1u], positions[3u * v + 2u]); }

void main() {
    const uint v = gl_GlobalInvocationID.x;
    if (v >= uint(vertex_count)) return;
    const vec3 p = position(v);
    vec3 sum = vec3(0);
    for (uint i = ring_start[v]; i < ring_start[v + 1u]; ++i) sum += cross(position(ring[i].x) - p, position(ring[i].y) - p);
    const float size = length(sum);
    if (size > 0) sum /= size;
    normals[3u * v] = sum.x;
    normals[3u * v + 1u] = sum.y;
    normals[3u * v + 2u] = sum.z;
}
