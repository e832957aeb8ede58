#version 450 core
// Corners (a vertex with its texture coordinates) fetch what the compute passes formed.
layout(location = 0) in uint vertex;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 feature;   // eyeball or mouth this corner belongs to: centre and radius, head space, mm

layout(binding = 4) uniform samplerBuffer positions;
layout(binding = 5) uniform samplerBuffer normals;
layout(binding = 6) uniform samplerBuffer neutral;

uniform mat4 view_projection;
uniform mat4 light_projection;
uniform vec3 light_towards[3];
uniform vec3 middle;    // of all that is drawn
uniform mat3 head_rotation;
uniform vec3 head_translation;

out vec3 position;
out vec3 normal;
out vec2 texcoord;
out vec3 light_place;
out float from_behind;   // share of the rim light that arrives
#if SURFACE == EYE || SURFACE == CORNEA || SURFACE == TEETH || SURFACE == MOUTH || SURFACE == LASHES
out vec3 cavity;        // place in the eyeball or mouth, head axes, in its radii
out vec3 rest_place;    // the same at neutral: where the iris is
#endif

void main() {
    const int at = int(vertex);
    position = texelFetch(positions, at).xyz;
    normal = texelFetch(normals, at).xyz;
    texcoord = vec2(uv.x, 1.0 - uv.y);
    // Off the surface along its normal, so that a surface does not shade itself.
#if SURFACE == TEETH && defined(ALBEDO_MAP)
    const float off = 0.2;   // shut lips are no farther off than that
#else
    const float off = 1.1;
#endif
    // The sides of nose and lips face a light behind the head, but the cheeks are in its way: it reaches what the head as a
    // whole turns to it.
    from_behind = smoothstep(-0.55, -0.20, dot(normalize(position - middle), light_towards[2]));
    light_place = (light_projection * vec4(position + off * normal, 1)).xyz * 0.5 + 0.5;
#if SURFACE == EYE || SURFACE == CORNEA || SURFACE == TEETH || SURFACE == MOUTH || SURFACE == LASHES
    const vec3 head = (position - head_translation) * head_rotation;   // transposed: back into head space
    cavity = (head - feature.xyz) / feature.w;
    rest_place = (texelFetch(neutral, at).xyz - feature.xyz) / feature.w;
#endif
    gl_Position = view_projection * vec4(position, 1);
}
