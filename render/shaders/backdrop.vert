#version 450 core
// A grey studio wall with a soft spot behind the head, behind everything: a grid of kAcross x kDown rectangles, so that only
// corners have to work out the light and pixels mix it. No buffers: six corners a rectangle.
out vec3 wall;   // as the picture stores it, sRGB-encoded
const int kAcross = 16, kDown = 16;
void main() {
    const int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
    const ivec2 at = ivec2(cell % kAcross, cell / kAcross) + ivec2(corner == 1 || corner == 2 || corner == 4, corner == 2 || corner >= 4);
    const vec2 place = vec2(at) / vec2(kAcross, kDown) * 2.0 - 1.0;
    const vec2 from_spot = (place - vec2(0.12, 0.10)) * vec2(0.80, 0.75);
    const float spot = exp2(-1.3 * dot(from_spot, from_spot));
    const vec3 light = mix(vec3(0.022, 0.024, 0.028), vec3(0.150, 0.155, 0.160), spot) * (0.88 + 0.12 * smoothstep(-1.0, 0.4, place.y));
    wall = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
    gl_Position = vec4(place, 1, 1);
}
