#version 450 core
// Anti-aliasing of a finished picture: where brightness has an edge, blend along it. Works on encoded values, as the eye
// does; the idea of FXAA (Lottes 2009), cut down to its short form.
layout(binding = 0) uniform sampler2D picture;
layout(location = 0) out vec4 colour;

float luma(vec3 c) { return dot(c, vec3(0.299, 0.587, 0.114)); }

void main() {
    const vec2 size = 1.0 / vec2(textureSize(picture, 0));
    const vec2 here = gl_FragCoord.xy * size;
    const vec3 middle = texelFetch(picture, ivec2(gl_FragCoord.xy), 0).rgb;
    const float m = luma(middle);
    const float ne = luma(texture(picture, here + vec2(0.5, 0.5) * size).rgb), nw = luma(texture(picture, here + vec2(-0.5, 0.5) * size).rgb);
    const float se = luma(texture(picture, here + vec2(0.5, -0.5) * size).rgb), sw = luma(texture(picture, here + vec2(-0.5, -0.5) * size).rgb);
    const float low = min(m, min(min(nw, ne), min(sw, se))), high = max(m, max(max(nw, ne), max(sw, se)));
    colour = vec4(middle, 1);
    // Means of 2 x 2 pixels show about half the contrast of the pixels themselves.
    if (high - low < max(0.018, 0.0625 * high)) return;

    // Along the edge: at right angles to the gradient, at most 4 pixels to each side, 1 where it runs with the grid.
    // The gradient is (right - left, up - down); turned by a quarter it lies along the edge.
    vec2 along = vec2(-((nw + ne) - (sw + se)), (ne + se) - (nw + sw));
    const float steepness = 1.0 / (min(abs(along.x), abs(along.y)) + 1.0 / 128.0);
    along = clamp(along * steepness, -4.0, 4.0) * size;
    const vec3 near = 0.5 * (texture(picture, here + along * (1.0 / 3.0 - 0.5)).rgb + texture(picture, here + along * (2.0 / 3.0 - 0.5)).rgb);
    const vec3 wide = 0.5 * near + 0.25 * (texture(picture, here - 0.5 * along).rgb + texture(picture, here + 0.5 * along).rgb);
    const float w = luma(wide);
    colour = vec4(w < low || w > high ? near : wide, 1);
}
