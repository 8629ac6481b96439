// One layer's own pixels: colour times coverage, coverage, and the circle of confusion.
//
// Where only nearer layers are seen this layer is hidden (coverage HIDDEN) and has to be guessed;
// where something farther is seen, it covers nothing.
//
// Inputs
//   color_tx      scene-linear rgb
//   far_tx        rgb far fragment, a coverage of the near fragment (fragments.comp.glsl)
//   near_tx       rgb near fragment, a its signed coc
//   coc_tx        signed coc, pixels
// Outputs
//   out_layer_img rgb times coverage, a coverage or HIDDEN
//   out_state_img r diameter |coc|, g 1 where the layer has content, else 0
//   pixel list    what is hidden

#define PIXEL_LIST_BINDING 0
#include "lib/hidden.lib.glsl"
#include "lib/layer.lib.glsl"
#include "lib/pixel_list.lib.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D color_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
uniform sampler2D coc_tx;
uniform bool is_farthest;  // it covers everything that is seen
layout(rgba32f) uniform writeonly image2D out_layer_img;
layout(rg32f) uniform writeonly image2D out_state_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    float coc = texelFetch(coc_tx, at, 0).r;
    vec4 far = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
    float own = membership(coc);                       // of the pixel, or its far fragment
    float own_near = far.a * membership(near.a);       // of its near fragment
    float seen = 1.0 - nearer_than(cut_near_px, coc);  // what no nearer layer takes
    bool has_far = own > THIN, has_near = own_near > THIN;
    bool only_near = has_near && !has_far;
    vec3 color = far.rgb;
    if (has_far && has_near) color = texelFetch(color_tx, at, 0).rgb;
    if (only_near) color = near.rgb;
    float diameter = only_near ? abs(near.a) : abs(coc);
    float cover = clamp(own / max(seen, THIN), 0.0, 1.0);
    if (only_near) cover = max(cover, own_near);
    if (is_farthest) cover = 1.0;
    bool hidden = seen <= THIN && !only_near;
    if (hidden) list_append(at);
    imageStore(out_layer_img, at, hidden ? vec4(HIDDEN) : vec4(color * cover, cover));
    bool content = !hidden && (has_far || only_near);
    imageStore(out_state_img, at, vec4(diameter, content ? 1.0 : 0.0, 0.0, 0.0));
}
