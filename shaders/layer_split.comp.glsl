// One layer's own pixels: colour times coverage, coverage, and the circle of confusion.
//
// Where only nearer layers are seen this layer is hidden (coverage HIDDEN) and has to be guessed;
// where something farther is seen, it covers nothing.
//
// Inputs
//   color_tx      scene-linear rgb
//   coc_tx        signed coc, pixels
//   kind_tx, far_tx, near_tx   fragments of rim pixels (fragments_far, fragments_near)
// Outputs
//   out_layer_img rgb times coverage, a coverage or HIDDEN
//   out_state_img r diameter |coc|, g 1 where the layer has content, else 0
//   pixel list    what is hidden

#define PIXEL_LIST_BINDING 0
#include "lib/hidden.lib.glsl"
#include "lib/layer.lib.glsl"
#include "lib/pixel_list.lib.glsl"
#include "lib/silhouette.lib.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D color_tx;
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
uniform bool is_farthest;  // it covers everything that is seen
layout(rgba32f) uniform writeonly image2D out_layer_img;
layout(rg32f) uniform writeonly image2D out_state_img;

struct Content {
    vec3 color;
    float diameter;
    float cover;
    bool exists;
};

Content whole_of(vec3 x, float coc, float visible) {
    float own = membership(coc);
    return Content(x, abs(coc), own / visible, own > THIN);
}

// The two fragments of a far rim pixel.
Content far_rim_of(vec3 x, float coc, vec4 far, vec4 near, float visible) {
    float own = membership(coc), own_near = far.a * membership(near.a);
    bool has_far = own > THIN, has_near = own_near > THIN;
    if (has_far) return Content(has_near ? x : far.rgb, abs(coc), own / visible, true);
    if (has_near) return Content(near.rgb, abs(near.a), max(own / visible, own_near), true);
    return Content(far.rgb, abs(coc), own / visible, false);
}

// A near rim pixel: without what shines through, if that belongs to another layer.
Content near_rim_of(vec3 x, float coc, vec4 clean, float coc_through, float visible) {
    float own = membership(coc);
    if (membership(coc_through) > THIN) return whole_of(x, coc, visible);
    return Content(clean.rgb, abs(coc), own / visible * clean.a, own > THIN);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    float coc = texelFetch(coc_tx, at, 0).r;
    vec3 x = texelFetch(color_tx, at, 0).rgb;
    vec4 far = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
    float seen = 1.0 - nearer_than(cut_near_px, coc);  // what no nearer layer takes
    float visible = max(seen, THIN);
    float kind = texelFetch(kind_tx, at, 0).r;
    Content content = whole_of(x, coc, visible);
    if (kind == FAR_RIM) content = far_rim_of(x, coc, far, near, visible);
    if (kind == NEAR_RIM) content = near_rim_of(x, coc, far, near.a, visible);
    bool hidden = seen <= THIN && !content.exists;
    float cover = is_farthest ? 1.0 : clamp(content.cover, 0.0, 1.0);
    if (hidden) list_append(at);
    imageStore(out_layer_img, at, hidden ? vec4(HIDDEN) : vec4(content.color * cover, cover));
    imageStore(out_state_img, at, vec4(content.diameter, !hidden && content.exists ? 1.0 : 0.0, 0.0, 0.0));
}
