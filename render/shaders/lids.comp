#version 450 core
// Lids kept on their eyeballs: model::keep_on_eyeball, after shape.comp.
layout(local_size_x = 64) in;

struct Member {
    vec3 centre;   // of the eyeball, mm, head space
    float rest;    // mm from it at neutral
    uint vertex;
    float hold;
};
layout(std430, binding = 0) buffer Positions { float positions[]; };   // 3 V, posed
layout(std430, binding = 1) readonly buffer Members { Member members[]; };

uniform int member_count;
uniform mat3 rotation;      // the head pose, which shape.comp has applied
uniform vec3 translation;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= uint(member_count)) return;
    const Member member = members[i];
    const uint at = 3u * member.vertex;
    const vec3 posed = vec3(positions[at], positions[at + 1u], positions[at + 2u]);
    const vec3 from_centre = posed - (rotation * member.centre + translation);
    const vec3 moved = posed + member.hold * (member.rest / max(length(from_centre), 1e-3) - 1) * from_centre;
    for (int c = 0; c < 3; ++c) positions[at + uint(c)] = moved[c];
}
