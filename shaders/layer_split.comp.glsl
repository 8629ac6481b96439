// One layer's own pixels: colour times coverage, coverage, and the circle of confusion.
//
// Where little else than nearer layers is seen this layer is hidden and has to be guessed, the rest
// of the way (hidden_fill); where something farther is seen, it covers nothing.
//
// Inputs
//   color_tx      scene-linear rgb
//   coc_tx        signed coc, pixels
//   kind_tx, far_tx, near_tx   fragments of rim pixels (fragments_far, fragments_near)
// Outputs
//   out_layer_img rgb times coverage, a coverage, marked if hidden (lib/hidden.lib.glsl)
//   out_state_img r diameter |coc|, g how far there is content, 0..1
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
    float solid;  // how far it counts as content, 0..1
};

Content whole_of(vec3 x, float coc, float visible) {
    float own = membership(coc);
    return Content(x, abs(coc), own / visible, solidity(own));
}

// The two fragments of a far rim pixel: in one layer they are the pixel, else each its own colour.
Content far_rim_of(vec3 x, float coc, vec4 far, vec4 near, float visible) {
    float own = membership(coc), own_near = membership(near.a);
    float solid = solidity(own), solid_near = solidity(own_near), only_near = solid_near * (1.0 - solid);
    vec3 color = mix(mix(far.rgb, x, solid_near), near.rgb, only_near);
    float cover = own / visible;
    cover = mix(cover, max(cover, far.a * own_near), 1.0 - solid);
    float diameter = mix(abs(coc), abs(near.a), only_near);
    return Content(color, diameter, cover, max(solid, solidity(far.a * own_near)));
}

// A near rim pixel: without what shines through, as far as that belongs to another layer.
Content near_rim_of(vec3 x, float coc, vec4 clean, float coc_through, float visible) {
    Content content = whole_of(x, coc, visible);
    float same_layer = solidity(membership(coc_through));
    content.color = mix(clean.rgb, x, same_layer);
    content.cover *= mix(clean.a, 1.0, same_layer);
    return content;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    float coc = texelFetch(coc_tx, at, 0).r;
    vec3 x = texelFetch(color_tx, at, 0).rgb;
    vec4 far = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
    float seen = visibility(coc), visible = max(seen, THIN);
    float kind = texelFetch(kind_tx, at, 0).r;
    Content content = whole_of(x, coc, visible);
    if (kind == FAR_RIM) content = far_rim_of(x, coc, far, near, visible);
    if (kind == NEAR_RIM) content = near_rim_of(x, coc, far, near.a, visible);
    float cover = is_farthest ? 1.0 : clamp(content.cover, 0.0, 1.0);
    bool has_near = kind == FAR_RIM && far.a * membership(near.a) > THIN;
    bool hidden = solidity(seen) < 1.0 && !has_near;
    if (hidden) list_append(at);
    imageStore(out_layer_img, at, vec4(content.color * cover, hidden ? hidden_mark(cover) : cover));
    imageStore(out_state_img, at, vec4(content.diameter, content.solid, 0.0, 0.0));
}
