// Share of a pixel's detail that a preview shows: all of it if the circle of confusion is smaller than half a
// pixel of the preview, none from one and a half pixels on.

#include "lib/coc.lib.glsl"

uniform bool is_coc;     // the depth is the signed coc in pixels; else metres
uniform float texel_px;  // side of a pixel of the preview, in pixels of the plate

float width_px(float depth, ivec2 at) { return abs(is_coc ? depth : coc_of(depth, at)); }

float share_of(float width_px) { return 1.0 - smoothstep(0.5, 1.5, width_px / texel_px); }

float focus_share(float depth, ivec2 at) { return share_of(width_px(depth, at)); }
