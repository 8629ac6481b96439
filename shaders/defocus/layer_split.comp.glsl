// Extracts one layer of the picture: color times coverage, coverage, and the circle of confusion. A layer is a range of
// signed coc (circle of confusion: diameter in pixels, negative in front of the focus) between two cuts, with smooth
// transitions (lib/layer.lib.glsl).
//
// A layer that is blurred too much to show detail is processed at 1/2, 1/4 or 1/8 size: each of its pixels is the mean
// of the visible picture pixels that it stands for.
//
// Where almost only nearer layers are visible, this layer is hidden, and is guessed later (hidden_fill.comp.glsl).
// Where a farther layer is visible, this one covers nothing.
//
// Words, each a share of a pixel from 0 to 1:
//   seen, visible  what nearer layers leave open; visible is seen, but at least THIN, to divide by
//   known          what needs no guess: its color and coc are given, by the picture or by a list
//   listed         with LISTS: the part of known that only lists give, because a nearer surface hides it
//   cover          coverage: the layer hides what is behind it by this share; in the farthest layer, which hides all,
//                  the weight of the pixel: what nearer layers leave of it
//   solid          weight as content of the layer; 0 for a pixel whose surface belongs to other layers
// Functions of lib/layer.lib.glsl: membership(coc) is the share of a pixel that belongs to this layer, visibility(coc)
// that to this or a farther one; knowledge, coverage and solidity turn such shares into known, cover and solid.
//
// Inputs
//   color_tx      scene-linear rgb
//   coc_tx        r coc
//   kind_tx       r kind of the pixel (lib/kind.lib.glsl)
//   far_tx, near_tx   the two surfaces of edge pixels (unmix_far.comp.glsl, unmix_near.comp.glsl)
// Outputs
//   out_layer_img rgb times cover, a cover; of a hidden pixel a is below 0 and packs its coverage and its known
//                 share (hidden_mark of lib/hidden.lib.glsl)
//   out_state_img r diameter |coc| in pixels of the layer, g share of content (solid), 0..1
//   tile_mask_buf TILE_WITH_HIDDEN for the tiles with hidden pixels (lib/hidden.lib.glsl)
//   pixel list    the hidden pixels; with is_entered, those of the entering surface too (lib/entering.lib.glsl)
// With LISTS, for pictures with fragment lists (lib/fragment_list.lib.glsl), hidden pixels carry their listed share of
// the layer in these images, and there is one more output:
//   out_listed_img r listed share, g depth behind the silhouette to which a lens can see, in pixels of the layer
//
// Steps: add_pixel adds each picture pixel to the sums of its layer pixel; store divides the sums and writes them.

#include "lib/focus_offset.lib.glsl"  // for lib/fragment_list.lib.glsl
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, is_open, Fragment
#endif
#include "lib/hidden.lib.glsl"  // hidden_mark, TILE_WITH_HIDDEN
#include "lib/layer.lib.glsl"  // THIN, solidity, knowledge, coverage, visibility, membership, cut_near_px
#include "lib/pixel_list.lib.glsl"  // list_append
#include "lib/silhouette.lib.glsl"  // set_center, neighbor, coc_at, is_same_surface, coc_tx, infinity_px, UNMIXED ...
#include "lib/tile_list.lib.glsl"  // FOR_EACH_TILE

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform sampler2D color_tx;
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
uniform bool is_farthest;  // it covers everything, with the weights that nearer layers leave
uniform bool is_entered;   // a surface passes into the layer
uniform int reduction;     // side of a pixel of the layer, in pixels of the picture
uniform ivec2 layer_size;  // in pixels of its own; a smaller layer is in the corner of the images
layout(rgba32f) uniform writeonly image2D out_layer_img;
layout(rg32f) uniform writeonly image2D out_state_img;
layout(std430) writeonly buffer tile_mask_block { uint tile_mask_buf[]; };
uniform int tiles_across;  // in the mask
#ifdef LISTS
layout(rg16f) uniform writeonly image2D out_listed_img;
uniform bool is_nearest;  // nothing of the layer is hidden
#endif

struct Content {
    vec3 color;
    float diameter;  // |coc| in pixels
    float cover;
    float solid;  // weight as content of the layer, 0..1
};

// How far nearer layers have taken a surface of this visibility, 0..1.
float taken_of(float visible) { return coverage(1.0 - visible); }

#define LEAST_LEFT 0.03  // the blur ripples, and a weight as small as its ripples would be none to divide by

// The weight that nearer layers leave a pixel of the farthest layer, if they have taken the share `taken` of a surface
// that covers the share `cover` of it. The blurred layer is divided by its blurred weight, so that with what nearer
// layers cover it sums to the blur of the whole surface, however much of it has passed.
float weight_left(float cover, float taken) { return max(1.0 - cover * taken, LEAST_LEFT); }

// The content of this layer in a pixel with one surface, of the color x.
Content whole_of(vec3 x, float coc, float visible) {
    float own = membership(coc);
    float cover = is_farthest ? weight_left(1.0, taken_of(visible)) : coverage(own / visible);
    return Content(x, abs(coc), cover, solidity(own));
}

// What is left to this layer of a surface that covers the share `cover` of its pixel, if nearer layers cover the share
// `taken` of that: together they cover what the surface covers. An opaque surface is in both layers.
float left_cover(float cover, float taken) {
    float open = max(1.0 - taken, 1e-4);
    return cover * open / (1.0 - cover * (1.0 - open));
}

// The content of this layer in a far edge pixel (far: rgb of the far surface, a coverage of the near one; near: rgb of
// the near surface, a its coc). The near surface lies over the far one; if both are in this layer in full, it is the
// plain pixel.
Content far_edge_of(vec3 x, float coc, vec4 far, vec4 near, float visible) {
    float own = membership(coc), own_near = membership(near.a), visible_near = visibility(near.a);
    float taken = taken_of(visible_near);
    float cover_far = coverage(own / visible), cover_near = coverage(own_near / max(visible_near, THIN));
    float both = cover_far * cover_near * (1.0 - taken);
    float share_near = left_cover(far.a, taken) * cover_near, share_far = cover_far * (1.0 - share_near);
    if (is_farthest) {  // all that nearer layers leave of both, once this layer knows the near one
        share_near = far.a * knowledge(visible_near);
        share_far = (1.0 - share_near) * weight_left(1.0, taken_of(visible));
        share_near *= 1.0 - taken;
    }
    float cover = share_near + share_far;
    vec3 color = (share_near * near.rgb + share_far * far.rgb) / max(cover, 1e-6);
    float diameter = mix(abs(coc), abs(near.a), solidity(own_near) * (1.0 - cover_far));
    return Content(mix(color, x, both), diameter, cover, max(solidity(own), solidity(far.a * own_near)));
}

// The content of this layer in a near edge pixel, without the light that shines through from another layer (clean: rgb
// own color, a its coverage; coc_through: coc of the surface that shines through).
Content near_edge_of(vec3 x, float coc, vec4 clean, float coc_through, float visible) {
    Content content = whole_of(x, coc, visible);
    float same_layer = solidity(membership(coc_through));  // 1 if the other surface is in this layer too
    float taken = taken_of(visible);
    if (is_farthest) {  // so is the other surface
        content.cover = weight_left(clean.a, taken);
        content.color = max(x - taken * clean.a * clean.rgb, 0.0) / content.cover;
        return content;
    }
    content.color = mix(clean.rgb, x, same_layer);
    content.cover *= mix(left_cover(clean.a, taken), 1.0, same_layer);
    return content;
}

#define VISIBLE_ENOUGH 0.25  // share of visible picture pixels from which no guess is needed
#define LEAST_SOLID 1e-6     // added to solid as the weight of a diameter: without content there is a diameter too

struct Sum {
    vec4 layer;      // rgb times coverage, a coverage, times the known share
    float diameter;  // times solid + LEAST_SOLID, times known
    float solid;     // times known
    float known;
    float count;     // picture pixels added
    float ends;      // those that are ends of the guess in full
#ifdef LISTS
    float listed;
    float depth_px;  // depth behind the silhouette to which a lens can see, times listed
#endif
};

#ifdef LISTS
// A seam is where the surface of the picture crosses the cut towards the camera, and so passes into the nearer layer.
// Between these distances from it, as shares of the cut's coc, listed surfaces behind it begin to be used.
#define SEAM_FROM 0.5
#define SEAM_TO 1.5

// Steepest step of the coc from a pixel to a neighbor on the same surface, pixels.
float slope_at(ivec2 at, float coc) {
    float slope = 0.0;
    for (int k = 1; k < 9; k += 2) {
        float other = coc_at(neighbor(at, k));
        if (is_same_surface(coc, other)) slope = max(slope, abs(other - coc));
    }
    return slope;
}

// Weight of the listed surfaces behind a pixel, 0 to 1, by its distance from a seam. The surface of the picture
// continues in this layer, underneath itself: within its own blur of the seam a guess extends it, and nothing behind
// it is visible.
float beyond_seam(ivec2 at, float coc) {
    float reach = max(abs(cut_near_px.x), 1.0), edge = cut_near_px.x - cut_near_px.y;
    float to_seam = (edge - coc) / max(slope_at(at, coc), 1e-4);
    return smoothstep(SEAM_FROM * reach, SEAM_TO * reach, to_seam);
}

// Adds the share `known` of a pixel, of which the share `seen` is open to view. The rest is added as listed: a lens
// uncovers it only near a silhouette, deeper if the blurs differ more (`behind_coc` is the difference in coc).
void add_known(inout Sum sum, Content content, float cover, float known, float seen, float behind_coc) {
    float solid = known * content.solid, listed = known - min(seen, known);
    sum.layer += known * cover * vec4(content.color, 1.0);
    sum.diameter += (solid + LEAST_SOLID * known) * content.diameter;
    sum.solid += solid;
    sum.known += known;
    sum.listed += listed;
    sum.depth_px += listed * max(behind_coc, 0.0) / 2.0;
}

#define OPAQUE 0.9995  // a surface of this coverage or more hides everything behind it

// The remaining coverage of a fragment that is partly in the nearer layer. An opaque one continues underneath itself.
float remaining_cover(float cover, float in_view) {
    return cover >= OPAQUE ? knowledge(in_view) : left_cover(cover, taken_of(in_view));
}

// Adds the fragments of a list that are in this layer. `front_coc` is the coc of the visible surface, `seen` the share
// of the pixel that nearer surfaces leave open, `unknown` the share of which nothing is known yet. In a plate
// with alpha, the end of a list is empty space: farthest, without light, blurred like the last fragment.
void add_list(inout Sum sum, List list, float front_coc, float seen, float unknown) {
    Fragment fragment;
    float left = 1.0;  // the weight that nearer layers leave of what lies behind a pixel
    for (uint i = list.first; i < list.end && unknown > 0.0; ++i) {
        fragment = fragment_of(i);
        float in_view = visibility(fragment.coc);
        Content content = whole_of(fragment.color, fragment.coc, max(in_view, THIN));
        float own_left = list.has_front ? 1.0 : left * weight_left(fragment.cover, taken_of(in_view));
        if (fragment.cover < OPAQUE) left = own_left;  // behind an opaque one nothing is taken
        float cover = is_farthest ? own_left : clamp(content.cover, 0.0, 1.0);
        float rest_cover = remaining_cover(fragment.cover, in_view), known = unknown * rest_cover;
        add_known(sum, content, cover, known, seen * rest_cover, fragment.coc - front_coc);
        unknown -= known;
        seen *= 1.0 - fragment.cover;
    }
    if (!is_open || list.first == list.end || unknown <= 0.0) return;
    Content nothing = whole_of(vec3(0.0), fragment.coc, max(visibility(fragment.coc), THIN));
    add_known(sum, nothing, is_farthest ? left : 0.0, unknown, seen, infinity_px - front_coc);
}
#endif

// Adds a pixel of the picture to a pixel of the layer.
void add_pixel(inout Sum sum, ivec2 at) {
    float coc = texelFetch(coc_tx, at, 0).r;
#ifdef LISTS
    List list = list_at(at);
    set_center(at);
#endif
    vec3 x = texelFetch(color_tx, at, 0).rgb;
    float seen = visibility(coc), visible = max(seen, THIN), has_near = 0.0;
    Content content = whole_of(x, coc, visible);
    float kind = texelFetch(kind_tx, at, 0).r;
    if (kind != UNMIXED) {
        vec4 far = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
        if (kind == FAR_EDGE) content = far_edge_of(x, coc, far, near, visible);
        if (kind == NEAR_EDGE) content = near_edge_of(x, coc, far, near.a, visible);
        has_near = kind == FAR_EDGE && far.a * membership(near.a) > THIN ? 1.0 : 0.0;
    }
    float cover = clamp(content.cover, 0.0, 1.0);
    float known = max(knowledge(seen), has_near);
#ifdef LISTS  // a list that begins with the visible surface is complete, and then replaces the pixel itself
    // Both cases share one call of add_list, because a software rasterizer runs both sides of a branch.
    float unknown = list.has_front ? 1.0 : 1.0 - known;
    if (list.has_front) known = 0.0;
    if (unknown > 0.0 && !list.has_front) unknown *= beyond_seam(at, coc);
    add_list(sum, list, coc, list.has_front ? 1.0 : 0.0, unknown);
#endif
    float solid = known * content.solid;
    sum.layer += known * cover * vec4(content.color, 1.0);
    sum.diameter += (solid + LEAST_SOLID * known) * content.diameter;
    sum.solid += solid;
    sum.known += known;
    sum.count += 1.0;
    sum.ends += step(END, max(seen, has_near));
}

// Writes a pixel of the layer from its sums, and lists it if it is hidden.
void store(ivec2 at, Sum sum) {
#ifdef LISTS
    if (is_nearest) {  // nothing is guessed: the layer is empty where its fragments end
        sum.known = sum.count;
        sum.listed = 0.0;
    }
#endif
    // known becomes the share that needs no guess and is open to view; of_known divides by all that is known.
    float known = sum.known / sum.count, of_known = 1.0 / max(sum.known, 1e-12);
#ifdef LISTS
    float listed = sum.listed / sum.count;
    float depth_px = sum.depth_px / max(sum.listed, 1e-12) / float(reduction);
    known -= min(listed, known);
    imageStore(out_listed_img, at, vec4(listed, depth_px, 0.0, 0.0));
#endif
#ifdef REDUCED
    known = min(known / VISIBLE_ENOUGH, 1.0);
#endif
    bool hidden = known < 1.0 || is_entered && sum.ends < sum.count;
    if (hidden) list_append(at);
    if (hidden) tile_mask_buf[at.y / TILE * tiles_across + at.x / TILE] = TILE_WITH_HIDDEN;
    vec4 layer = sum.layer * of_known;
    float diameter = sum.diameter / max(sum.solid + LEAST_SOLID * sum.known, 1e-18) / float(reduction);
    imageStore(out_layer_img, at, vec4(layer.rgb, hidden ? hidden_mark(layer.a, known) : layer.a));
    imageStore(out_state_img, at, vec4(diameter, sum.solid * of_known, 0.0, 0.0));
}

// Extracts the pixels of a tile of the layer, one an invocation.
void split_tile(ivec2 tile) {
    ivec2 at = tile * TILE + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(at, layer_size))) return;
    Sum sum;
    sum.layer = vec4(0.0);
    sum.diameter = sum.solid = sum.known = sum.count = sum.ends = 0.0;
#ifdef LISTS
    sum.listed = sum.depth_px = 0.0;
#endif
#ifdef REDUCED
    ivec2 first = at * reduction, end = min(first + reduction, textureSize(coc_tx, 0));
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) add_pixel(sum, ivec2(x, y));
#else
    add_pixel(sum, at);
#endif
    store(at, sum);
}

void main() { FOR_EACH_TILE(split_tile) }
