#version 450 core
// Area-weighted vertex normals of the formed shape. Every vertex walks its own ring of triangles, so nothing is written
// by two invocations.
layout(local_size_x = 64) in;

layout(std430, binding = 1) writeonly buffer Normals { float normals[]; };   // 3 V
layout(binding = 4) uniform samplerBuffer positions;                          // V
layout(binding = 5) uniform usamplerBuffer ring_start;                        // V + 1
layout(binding = 6) uniform usamplerBuffer ring;                              // the triangle's other two corners, in order

uniform int vertex_count;

vec3 position(uint v) { return texelFetch(positions, int(v)).xyz; }

void main() {
    const uint v = gl_GlobalInvocationID.x;
    if (v >= uint(vertex_count)) return;
    const vec3 p = position(v);
    vec3 sum = vec3(0);
    const uint end = texelFetch(ring_start, int(v) + 1).x;
    for (uint i = texelFetch(ring_start, int(v)).x; i < end; ++i) {
        const uvec2 corners = texelFetch(ring, int(i)).xy;
        sum += cross(position(corners.x) - p, position(corners.y) - p);
    }
    const float size = length(sum);
    if (size > 0) sum /= size;
    normals[3u * v] = sum.x;
    normals[3u * v + 1u] = sum.y;
    normals[3u * v + 2u] = sum.z;
}
