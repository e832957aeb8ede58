#version 450 core
in vec3 wall;
layout(location = 0) out vec4 colour;
void main() {
    // One code of ordered noise: eight bits would show the gradient as bands (interleaved gradient noise, Jimenez 2014).
    const float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    colour = vec4(wall + (noise - 0.5) / 255.0, 1);
}
