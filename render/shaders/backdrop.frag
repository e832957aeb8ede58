#version 450 core
// A grey studio wall with a soft spot behind the head.
in vec2 place;
layout(location = 0) out vec4 colour;
void main() {
    const vec2 from_spot = (place - vec2(0.12, 0.10)) * vec2(0.80, 0.75);
    const float spot = exp2(-1.3 * dot(from_spot, from_spot));
    vec3 wall = mix(vec3(0.022, 0.024, 0.028), vec3(0.150, 0.155, 0.160), spot);
    wall *= 0.88 + 0.12 * smoothstep(-1.0, 0.4, place.y);
    // Half a code of ordered noise: eight bits would show the gradient as bands (interleaved gradient noise, Jimenez 2014).
    const float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    colour = vec4(wall + (noise - 0.5) * 0.0026, 1);
}
