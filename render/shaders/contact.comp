#version 450 core
// Lips or lids held apart: model::hold_apart, after shape.comp. One work group, so that every middle is read before anything moves.
layout(local_size_x = 256) in;  // kMaxContactPairs

struct Member { uint vertex; float hold; };
layout(std430, binding = 0) buffer Positions { float positions[]; };          // 3 V, posed
layout(std430, binding = 1) readonly buffer Pairs { uvec2 pairs[]; };         // at most 256
layout(std430, binding = 2) readonly buffer Members { Member members[]; };

uniform int pair_count;
uniform int member_count;
uniform mat3 rotation;      // the head pose, which shape.comp has applied
uniform vec3 translation;
uniform float reach;        // kContactReach
uniform float softness;     // kContactSoftness

shared vec3 middles[256];   // head space

vec3 in_head(uint v) {
    return transpose(rotation) * (vec3(positions[3u * v], positions[3u * v + 1u], positions[3u * v + 2u]) - translation);
}

float lift(float h) {
    if (h >= softness) return 0;
    if (h <= -softness) return -h;
    return (softness - h) * (softness - h) / (4 * softness);
}

void main() {
    const uint at = gl_LocalInvocationIndex;
    if (at < uint(pair_count)) middles[at] = (in_head(pairs[at].x) + in_head(pairs[at].y)) / 2;
    barrier();
    for (uint i = at; i < uint(member_count); i += 256u) {
        const vec3 p = in_head(members[i].vertex);
        float sum = 0, heights = 0;
        for (int m = 0; m < pair_count; ++m) {
            const vec2 d = middles[m].xz - p.xz;
            const float near = dot(d, d) + reach * reach;
            sum += 1 / (near * near);
            heights += middles[m].y / (near * near);
        }
        const float over = p.y - heights / sum, hold = members[i].hold;
        const vec3 push = rotation[1] * (hold * lift(hold > 0 ? over : -over));
        for (int c = 0; c < 3; ++c) positions[3u * members[i].vertex + uint(c)] += push[c];
    }
}
