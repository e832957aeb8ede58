#version 450 core
// Anti-aliasing of a finished picture: where brightness has an edge, blend along it. Works on encoded values, as the eye
// does; the idea of FXAA (Lottes 2009), cut down to its short form.
layout(binding = 0) uniform sampler2D picture;
layout(location = 0) out vec4 colour;

float luma(vec3 c) { return dot(c, vec3(0.299, 0.587, 0.114)); }

void main() {
    const ivec2 at = ivec2(gl_FragCoord.xy);
    const ivec2 last = textureSize(picture, 0) - 1;
    const vec3 middle = texelFetch(picture, at, 0).rgb;
    const float m = luma(middle);
    const float up = luma(texelFetch(picture, min(at + ivec2(0, 1), last), 0).rgb);
    const float down = luma(texelFetch(picture, max(at - ivec2(0, 1), ivec2(0)), 0).rgb);
    const float right = luma(texelFetch(picture, min(at + ivec2(1, 0), last), 0).rgb);
    const float left = luma(texelFetch(picture, max(at - ivec2(1, 0), ivec2(0)), 0).rgb);
    const float low = min(m, min(min(up, down), min(left, right))), high = max(m, max(max(up, down), max(left, right)));
    colour = vec4(middle, 1);
    if (high - low < max(0.035, 0.125 * high)) return;

    // Along the edge: at right angles to the gradient, at most 4 pixels to each side, 1 where it runs with the grid.
    const vec2 size = 1.0 / vec2(last + 1);
    const vec2 here = gl_FragCoord.xy * size;
    const float ne = luma(texture(picture, here + vec2(0.5, 0.5) * size).rgb), nw = luma(texture(picture, here + vec2(-0.5, 0.5) * size).rgb);
    const float se = luma(texture(picture, here + vec2(0.5, -0.5) * size).rgb), sw = luma(texture(picture, here + vec2(-0.5, -0.5) * size).rgb);
    // The gradient is (right - left, up - down); turned by a quarter it lies along the edge.
    vec2 along = vec2(-((nw + ne) - (sw + se)), (ne + se) - (nw + sw));
    const float steepness = 1.0 / (min(abs(along.x), abs(along.y)) + 1.0 / 128.0);
    along = clamp(along * steepness, -4.0, 4.0) * size;
    const vec3 near = 0.5 * (texture(picture, here + along * (1.0 / 3.0 - 0.5)).rgb + texture(picture, here + along * (2.0 / 3.0 - 0.5)).rgb);
    const vec3 wide = 0.5 * near + 0.25 * (texture(picture, here - 0.5 * along).rgb + texture(picture, here + 0.5 * along).rgb);
    const float w = luma(wide);
    colour = vec4(w < low || w > high ? near : wide, 1);
}
