#version 450 core
// One face, linear light inside; the framebuffer encodes to sRGB.
in vec3 position;
in vec3 normal;
in vec2 texcoord;
in vec3 light_place;
in float from_behind;
#if SURFACE == EYE || SURFACE == CORNEA || SURFACE == TEETH || SURFACE == MOUTH || SURFACE == LASHES
in vec3 cavity;
in vec3 rest_place;
#endif

layout(location = 0) out vec4 colour;

#ifdef ALBEDO_RGB
layout(binding = 0) uniform sampler2D picture;
#endif
#ifdef ALBEDO_YUV
layout(binding = 0) uniform sampler2D luma;
layout(binding = 1) uniform sampler2D colour_difference;   // Cb, Cr
uniform mat3 to_rgb;
uniform vec3 yuv_offset;
uniform vec4 chroma_place;
#endif
#if defined(ALBEDO_MAP) || defined(FINE)
layout(binding = 2) uniform sampler2D detail_map;   // linear albedo, height in mm
#endif
layout(binding = 3) uniform sampler2DShadow shadow_map;

uniform vec3 eye;
uniform vec3 sky;
uniform vec3 ground;
uniform vec3 light_towards[3];
uniform vec3 light_colour[3];
uniform float specular;
uniform int lit;
uniform vec4 part_left;     // times (position, 1): 0 .. 1 where a bust fades into the wall
uniform mat3 head_rotation;
uniform int shadows;
uniform int wireframe;

// Within 0.42 of an 8-bit code of the sRGB curve everywhere (minimax in codes): a CPU pays much for pow.
vec3 srgb_to_linear(vec3 c) {
    return c * (0.06643344 + c * (0.19501799 + c * (1.76903208 + c * (-1.77720251 + c * 0.75048340))));
}

#if SURFACE == EYE
// No texture covers the eye: sclera, and an iris around where the neutral eye looks (+z).
vec3 plain_eye() {
    const float off_axis = length(rest_place.xy) + (rest_place.z < 0 ? 2.0 : 0.0);
    const float ray = 0.5 + 0.5 * sin(atan(rest_place.y, rest_place.x) * 46.0);
    const vec3 iris = mix(vec3(0.10, 0.15, 0.17), vec3(0.22, 0.27, 0.26), ray * smoothstep(0.18, 0.40, off_axis));
    vec3 c = mix(vec3(0.006), iris, smoothstep(0.16, 0.19, off_axis));
    c *= 1.0 - 0.75 * smoothstep(0.40, 0.475, off_axis);
    return mix(c, vec3(0.66, 0.62, 0.58), smoothstep(0.455, 0.495, off_axis));
}
#endif

#if SURFACE == LASHES
// A card of lashes without a picture of them: strands that fan out from the eye and thin towards their tips.
float strands() {
    const float lash = atan(rest_place.y, rest_place.x) * 19.0;
    const float reach = 0.55 * (0.68 + 0.32 * fract(sin(floor(lash) * 12.9898) * 43758.547));   // no two are of a length
    const float along = clamp((length(rest_place) - 1.0) / reach, 0.0, 1.0);
    const float across = abs(fract(lash) * 2.0 - 1.0);
    const float width = mix(0.50, 0.05, along);
    return 0.70 * (1.0 - smoothstep(width, width + 0.35, across)) * (1.0 - smoothstep(0.75, 1.0, along));
}
#endif

vec3 albedo() {
#if defined(ALBEDO_RGB)
    return texture(picture, texcoord).rgb;
#elif defined(ALBEDO_YUV)
    const vec2 chroma = texcoord * chroma_place.xy + chroma_place.zw;
    const vec3 yuv = vec3(texture(luma, texcoord).r, texture(colour_difference, chroma).rg);
    return srgb_to_linear(clamp(to_rgb * (yuv - yuv_offset), 0.0, 1.0));
#elif defined(ALBEDO_MAP)
    return texture(detail_map, texcoord).rgb;
#elif SURFACE == SKIN || SURFACE == OTHER
    return vec3(0.50, 0.33, 0.26);
#elif SURFACE == EYE
    return plain_eye();
#elif SURFACE == TEETH
    return vec3(0.62, 0.57, 0.48);
#elif SURFACE == MOUTH
    return vec3(0.34, 0.11, 0.10);
#else
    return vec3(0.025, 0.018, 0.015);
#endif
}

#ifdef FINE
// The normal of a surface that stands out by the map's height: Mikkelsen 2010, with the slope taken over a pixel.
vec3 roughened(vec3 n) {
    const vec3 px = dFdx(position), py = dFdy(position);
    const float h = texture(detail_map, texcoord).a;
    const float hx = texture(detail_map, texcoord + dFdx(texcoord)).a - h, hy = texture(detail_map, texcoord + dFdy(texcoord)).a - h;
    const vec3 a = cross(py, n), b = cross(n, px);
    const float area = dot(px, a);
    return normalize(abs(area) * n - sign(area) * (hx * a + hy * b));
}
#endif

// Light that enters skin on the lit side leaves beyond the terminator, red farthest.
#if SURFACE == SKIN || SURFACE == OTHER || SURFACE == HAIR
const vec3 kWrap = vec3(0.25, 0.18, 0.15);
#elif SURFACE == TEETH || SURFACE == MOUTH
const vec3 kWrap = vec3(0.30, 0.22, 0.18);
#else
const vec3 kWrap = vec3(0.15);
#endif

vec3 diffuse(float facing) {
    return clamp((facing + kWrap) / ((1.0 + kWrap) * (1.0 + kWrap)), 0.0, 1.0);
}

// A lobe exp(n (cos - 1)) around the half vector: a Blinn-Phong lobe as a spherical Gaussian, one exp2 instead of a pow.
float lobe(float sharpness, float cosine) { return exp2(1.442695 * sharpness * (cosine - 1.0)); }

// Part of the key light that arrives. Beyond the terminator light comes through the skin and not past it: the shadow map
// has no say there, and is not asked.
float key_visibility(float facing) {
    if (shadows == 0 || facing <= 0.0) return 1.0;
    const float reach = 2.5 / 1024.0;
    float sum = texture(shadow_map, light_place + vec3(reach, 0.4 * reach, 0));
    sum += texture(shadow_map, light_place + vec3(-0.4 * reach, reach, 0));
    sum += texture(shadow_map, light_place + vec3(-reach, -0.4 * reach, 0));
    sum += texture(shadow_map, light_place + vec3(0.4 * reach, -reach, 0));
    return mix(1.0, 0.25 * sum, smoothstep(0.0, 0.3, facing));
}

// Identity up to 0.8, then a soft shoulder towards 1.
vec3 shoulder(vec3 c) { return mix(c, 1.0 - 0.2 * exp2(-(c - 0.8) * (1.442695 / 0.2)), greaterThan(c, vec3(0.8))); }

void main() {
    if (wireframe == 1) {
        colour = vec4(0.03, 0.16, 0.19, 1);
        return;
    }
    const vec3 to_eye = normalize(eye - position);
    vec3 n = normalize(normal);
#ifdef FINE
    n = roughened(n);
#endif
#if SURFACE == SKIN
    // The inside of the head is no skin: what shows through a hole stays dark.
    const float inside = gl_FrontFacing ? 1.0 : 0.12;
#else
    const float inside = 1.0;
#endif
    if (!gl_FrontFacing) n = -n;

#if SURFACE == CORNEA
    const vec3 base = vec3(0);
#else
    const vec3 base = albedo();
#endif
    if (lit == 0) {
#if SURFACE == LASHES
        colour = vec4(base, 1) * strands();
#else
        colour = vec4(base, 1);
#endif
        return;
    }

    float occlusion = inside;
#if SURFACE == EYE
    occlusion *= 1.0 - 0.55 * smoothstep(0.0, 0.50, cavity.y) - 0.30 * smoothstep(0.20, 0.60, -cavity.y);
    occlusion *= 1.0 - 0.50 * smoothstep(0.45, 0.90, abs(cavity.x));
#elif SURFACE == TEETH || SURFACE == MOUTH
    // The deeper behind the front teeth, the less light comes in between the lips.
    // A painted texture has most of that in it.
#ifdef ALBEDO_NONE
    occlusion *= mix(0.12, 0.85, smoothstep(-1.0, 0.15, cavity.z));
#elif defined(ALBEDO_MAP)
    // Colours of a mouth wide open, whatever it does now.
    occlusion *= mix(0.30, 1.0, smoothstep(-1.0, 0.15, cavity.z));
#else
    occlusion *= mix(0.85, 1.0, smoothstep(-1.0, 0.05, cavity.z));
#endif
#endif

    const vec3 facing = vec3(dot(n, light_towards[0]), dot(n, light_towards[1]), dot(n, light_towards[2]));
#if SURFACE == TEETH
    // Light that lips let through and enamel passes on: no hard shadow on a tooth.
    const float unshadowed = key_visibility(facing[0]);
    const float visible = mix(0.30, 1.0, unshadowed);
#ifdef ALBEDO_MAP
    occlusion *= mix(0.35, 1.0, unshadowed);   // behind shut lips
#endif
#else
    const float visible = key_visibility(facing[0]);
#endif
    const vec3 key_shadow = mix(vec3(visible), vec3(sqrt(visible)), vec3(0.6, 0.1, 0.0));
    vec3 light = mix(ground, sky, 0.5 + 0.5 * n.y);
    light += light_colour[0] * diffuse(facing[0]) * key_shadow;
#if SURFACE == MOUTH
    light += 0.35 * light_colour[1] * diffuse(facing[1]);   // it casts no shadow, though cheeks and lips are in its way
#else
    light += light_colour[1] * diffuse(facing[1]);
#endif
#if SURFACE != TEETH && SURFACE != MOUTH
    light += from_behind * light_colour[2] * diffuse(facing[2]);   // from behind, where the head is in the way of what is in it
#endif
    vec3 sum = base * light * occlusion;

    const float towards_eye = dot(n, to_eye);
    const float grazing = 1.0 - max(towards_eye, 0.0);
    const float grazing2 = grazing * grazing;
    const float fresnel = grazing2 * grazing2 * grazing;
    float cover = 1.0;
#if SURFACE == LASHES
    cover = strands();
    sum *= cover;
#elif SURFACE == SKIN || SURFACE == OTHER || SURFACE == HAIR
    // n . (l + v) / |l + v| with what is there already: |l + v|^2 = 2 + 2 l . v of unit vectors.
    const vec3 across = vec3(dot(light_towards[0], to_eye), dot(light_towards[1], to_eye), dot(light_towards[2], to_eye));
    const vec3 halfway = inversesqrt(max(2.0 + 2.0 * across, 1e-6));
    const vec3 cosine = (facing + towards_eye) * halfway;
    const vec3 broad = vec3(lobe(11.0, cosine[0]), lobe(11.0, cosine[1]), lobe(11.0, cosine[2]));
    const float broad2 = broad[0] * broad[0], narrow = broad2 * broad2 * broad[0];   // lobe(55.0, cosine[0])
    const vec3 lit_side = smoothstep(-0.05, 0.25, facing);
    // A broad lobe of the skin's roughness and a narrow one of its oil (two-lobe skin specular, weights 0.8 and 0.2).
    vec3 shine = light_colour[0] * (0.8 * broad[0] + 0.9 * narrow) * visible * lit_side[0];
    shine += light_colour[1] * broad[1] * lit_side[1];
    shine += from_behind * light_colour[2] * broad[2] * lit_side[2] * 1.2;
    shine *= inside * (0.065 + 0.7 * fresnel);
#if SURFACE != HAIR
    shine *= 0.35 + 0.65 * smoothstep(0.01, 0.05, base.r);   // short hair painted on skin scatters what skin, even the darkest, mirrors
#endif
#if SURFACE == HAIR
    // Strands shine in bands across their length (Kajiya and Kay 1989), in two as Marschner et al. 2003 saw: a faint white one
    // towards the root, one of the hair's colour towards the tip. They are combed back on top and hang at the sides.
    const float upward = dot(n, head_rotation[1]);
    const vec3 combed = head_rotation * vec3(0.0, mix(-0.8, 0.5, smoothstep(0.1, 0.6, upward)), -0.7);
    const vec3 strand = normalize(combed - n * dot(combed, n) + 1e-4);
    const float lock = base.g / (base.g + 0.016) - 0.5;   // strands of other colour lie at other angles
    const vec2 along = vec2(dot(strand, light_towards[0] + to_eye), dot(strand, light_towards[2] + to_eye)) * halfway.xz;
    const vec2 first = along - (0.20 + 0.6 * lock) * cosine.xz, second = along + (0.10 - 0.6 * lock) * cosine.xz;
    const vec2 sine = sqrt(max(1.0 - first * first, 0.0)), sine2 = sqrt(max(1.0 - second * second, 0.0));
    const vec3 band0 = vec3(0.012 * lobe(70.0, sine.x)) + 0.9 * base * lobe(16.0, sine2.x);
    const vec3 band2 = vec3(0.020 * lobe(40.0, sine.y)) + 0.9 * base * lobe(16.0, sine2.y);
    const vec3 bands = light_colour[0] * visible * lit_side[0] * band0 + light_colour[2] * lit_side[2] * band2;
    shine = mix(shine, bands, smoothstep(0.36, 0.20, base.r));   // between the first hairs skin shows; red tells even the darkest from hair
#endif
    sum += specular * shine;
    cover = smoothstep(0.0, 1.0, dot(part_left, vec4(position, 1)));
#elif SURFACE == EYE || SURFACE == CORNEA
    // Lashes and lids take the room out of the mirror towards the rim of the eye.
    const float gloss = (1.0 - 0.8 * smoothstep(0.15, 0.50, abs(cavity.y))) * (1.0 - 0.7 * smoothstep(0.5, 0.9, abs(cavity.x)));
    const vec3 mirror = reflect(-to_eye, n);
    const float box = smoothstep(0.955, 0.975, dot(mirror, light_towards[0])) * mix(0.35, 1.0, visible);
    const float strip = smoothstep(0.962, 0.985, dot(mirror, light_towards[1]));
    const vec3 room = mix(ground, sky, smoothstep(-0.4, 0.7, mirror.y)) * (0.035 + 0.5 * fresnel);
    sum += specular * gloss * (0.95 * box * light_colour[0] + 0.22 * strip * light_colour[1] + room);
#if SURFACE == CORNEA
    cover = clamp(0.5 * fresnel, 0.0, 1.0);
#endif
#elif SURFACE == TEETH || SURFACE == MOUTH
    const vec3 h0 = normalize(light_towards[0] + to_eye);
    sum += light_colour[0] * lobe(60.0, dot(n, h0)) * visible * specular * occlusion * (0.22 + 0.5 * fresnel);
#endif
    colour = vec4(shoulder(sum), cover);
}
