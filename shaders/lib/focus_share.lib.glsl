// Share of the plate's detail at a pixel that a preview, which is smaller than the plate, shows. It is 1 if the circle
// of confusion (coc) is smaller than half a pixel of the preview, and 0 from one and a half of its pixels on.

#include "lib/coc.lib.glsl"  // coc_of

uniform bool is_coc;     // `depth` is the signed coc in pixels; else it is in meters
uniform float texel_px;  // side of a pixel of the preview, in pixels of the plate

// The signed coc at a pixel of the plate, and its diameter, in pixels of the plate.
float signed_px(float depth, ivec2 at) { return is_coc ? depth : coc_of(depth, at); }
float width_px(float depth, ivec2 at) { return abs(signed_px(depth, at)); }

float share_of(float width_px) { return 1.0 - smoothstep(0.5, 1.5, width_px / texel_px); }

float focus_share(float depth, ivec2 at) { return share_of(width_px(depth, at)); }
