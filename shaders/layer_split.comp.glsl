// One layer's own pixels: colour times coverage, coverage, and the circle of confusion.
//
// A layer that is blurred so much that its detail does not show is worked on at 1/2, 1/4 or 1/8 size: a
// pixel is the mean of those of the picture that it stands for, as far as they are seen.
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
//   out_state_img r diameter |coc| in pixels of the layer, g how far there is content, 0..1
//   pixel list    what is hidden

#include "lib/hidden.lib.glsl"
#include "lib/layer.lib.glsl"
#include "lib/pixel_list.lib.glsl"
#include "lib/silhouette.lib.glsl"
#include "lib/tile_list.lib.glsl"

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform sampler2D color_tx;
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
uniform bool is_farthest;  // it covers everything that is seen
uniform int reduction;     // pixels of the picture along a side of one of the layer
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

#define SEEN_PART 0.25  // of the pixels that one stands for: if so many are seen it needs no guess

struct Sum {
    vec4 layer;      // rgb times coverage, a coverage, times how far they are known
    float diameter;  // times solidity, times known
    float solid;     // times known
    float known;
    float count;
};

void add_pixel(inout Sum sum, ivec2 at) {
    float coc = texelFetch(coc_tx, at, 0).r;
    vec3 x = texelFetch(color_tx, at, 0).rgb;
    float seen = visibility(coc), visible = max(seen, THIN), has_near = 0.0;
    Content content = whole_of(x, coc, visible);
    float kind = texelFetch(kind_tx, at, 0).r;
    for (int rim = kind == WHOLE ? 0 : 1; rim > 0; --rim) {  // a loop that no lane enters costs nothing
        vec4 far = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
        if (kind == FAR_RIM) content = far_rim_of(x, coc, far, near, visible);
        if (kind == NEAR_RIM) content = near_rim_of(x, coc, far, near.a, visible);
        has_near = kind == FAR_RIM && far.a * membership(near.a) > THIN ? 1.0 : 0.0;
    }
    float cover = is_farthest ? 1.0 : clamp(content.cover, 0.0, 1.0);
    float known = max(solidity(seen), has_near), solid = known * content.solid;
    sum.layer += known * cover * vec4(content.color, 1.0);
    sum.diameter += (solid + 1e-6 * known) * content.diameter;
    sum.solid += solid;
    sum.known += known;
    sum.count += 1.0;
}

void store(ivec2 at, Sum sum) {
    float known = sum.known / sum.count, of_known = 1.0 / max(sum.known, 1e-12);
#ifdef REDUCED
    known = min(known / SEEN_PART, 1.0);
#endif
    bool hidden = known < 1.0;
    if (hidden) list_append(at);
    vec4 layer = sum.layer * of_known;
    float diameter = sum.diameter / max(sum.solid + 1e-6 * sum.known, 1e-18) / float(reduction);
    imageStore(out_layer_img, at, vec4(layer.rgb, hidden ? hidden_mark(layer.a, known) : layer.a));
    imageStore(out_state_img, at, vec4(diameter, sum.solid * of_known, 0.0, 0.0));
}

void split_tile(ivec2 tile) {
    ivec2 at = tile * TILE + ivec2(gl_LocalInvocationID.xy);
    Sum sum = Sum(vec4(0.0), 0.0, 0.0, 0.0, 0.0);
#ifdef REDUCED
    ivec2 first = at * reduction, end = min(first + reduction, textureSize(coc_tx, 0));
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) add_pixel(sum, ivec2(x, y));
#else
    add_pixel(sum, at);
#endif
    if (all(lessThan(at, imageSize(out_layer_img)))) store(at, sum);
}

void main() { FOR_EACH_TILE(split_tile) }
