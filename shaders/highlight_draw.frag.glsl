#version 430 core

// A highlight's disc, where the lens sees the lamp. Each pixel of the disc is a point of the lens; the
// ray from there to the lamp crosses nearer depths at places in the picture that move towards the
// pixel in proportion to the difference in coc. What stands there at that depth hides the lamp.

flat in vec4 place;  // centre x, y in pixels; signed coc; half the width of the rim's ramp
flat in vec3 light;

uniform sampler2D coc_tx;
uniform vec2 axis_scales;
uniform float nearest_px;  // least signed coc in the picture

out vec4 out_light;

#define STEPS 16
#define MARGIN_PX 2.0      // what is nearer by less, or by less than
#define MARGIN_PART 0.1    // this part of the lamp's coc, belongs to the lamp
#define SAME_COC_PX 1.0    // a look at the exact depth must meet the same surface: this close, or
#define SAME_COC_PART 0.25 // this part of the difference to the lamp

bool coc_at(vec2 at, out float coc) {
    ivec2 pixel = ivec2(floor(at));
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, textureSize(coc_tx, 0)))) return false;
    coc = texelFetch(coc_tx, pixel, 0).r;
    return true;
}

bool is_hidden(vec2 at, vec2 centre, float coc) {
    float start = coc - max(MARGIN_PX, MARGIN_PART * abs(coc));
    float step_px = (start - nearest_px) / float(STEPS);
    vec2 per_px = (at - centre) / coc;
    for (int k = 0; k < STEPS && step_px > 0.0; ++k) {
        float level = start - (float(k) + 0.5) * step_px, met, again;
        if (!coc_at(centre + per_px * (coc - level), met)) return false;
        if (met >= start || abs(met - level) > step_px) continue;
        if (!coc_at(centre + per_px * (coc - met), again)) continue;
        if (abs(again - met) <= max(SAME_COC_PX, SAME_COC_PART * (coc - met))) return true;
    }
    return false;
}

void main() {
    float coc = place.z, ramp = place.w;
    if (abs(coc) < 1e-3) coc = 1e-3;
    float rim = 0.5 * abs(coc) + ramp - length((gl_FragCoord.xy - place.xy) / axis_scales);
    float inside = clamp(rim / (2.0 * ramp), 0.0, 1.0);
    if (inside == 0.0 || is_hidden(gl_FragCoord.xy, place.xy, coc)) discard;
    out_light = vec4(inside * light, 0.0);
}
