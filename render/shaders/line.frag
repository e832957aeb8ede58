#version 450 core
in float shown;
uniform vec3 tint;
layout(location = 0) out vec4 colour;
void main() {
    if (shown < 0.999) discard;
    colour = vec4(tint, 1);
}
