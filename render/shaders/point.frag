#version 450 core
// A marker as a little lit ball.
in vec3 centre;
layout(location = 0) out vec4 colour;
uniform mat4 view;
uniform vec3 light_towards[3];
uniform vec3 light_colour[3];
uniform vec3 sky;
void main() {
    const vec2 p = vec2(gl_PointCoord.x, 1.0 - gl_PointCoord.y) * 2.0 - 1.0;
    const float inside = 1.0 - dot(p, p);
    if (inside < 0.0) discard;
    const vec3 n = transpose(mat3(view)) * vec3(p, sqrt(inside));
    vec3 light = sky;
    for (int i = 0; i < 3; ++i) light += light_colour[i] * max(dot(n, light_towards[i]), 0.0);
    colour = vec4(vec3(0.80, 0.52, 0.30) * light, 1);
}
