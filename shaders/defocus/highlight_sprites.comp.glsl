// Merges the highlights of each block of 8 x 8 pixels into sprites, one block an invocation. A sprite is a disc that is
// drawn for one or several highlights of similar coc (signed circle of confusion, diameter in pixels); a higher level
// merges more of them (lib/highlights.lib.glsl).
//
// Built twice. With COUNT, the pass counts the sprites of every level; LEVELS_AT_ONCE levels run in neighboring
// invocations. Without COUNT, after highlight_plan.comp.glsl, it writes the sprites of the chosen level, in the order
// of the picture.
//
// Inputs
//   pixel list         the blocks with highlights (highlight_blocks.comp.glsl)
//   highlight_tx, lit_buf   rgb removed light, a coc, of the pixels with a highlight (highlight_split.comp.glsl)
//   positions_tx       if `has_positions` (proxy.comp.glsl): rg position of the light in its pixel, in pixels from
//                      the middle, b its variance along an axis
// Outputs with COUNT
//   tally_buf          number of sprites of each block at each level
//   row_buf            the same for each row of blocks, added up
//   plan               the sums of the picture: number and area of the sprites at each level
// Inputs without COUNT
//   tally_buf, plan    as above, with the level that highlight_plan.comp.glsl has chosen
//   row_buf            number of sprites in all rows before each row, at that level
// Output without COUNT
//   sprite_buf         the sprites

#define SOFT_RIM
#include "lib/aperture.lib.glsl"  // Cover, aperture_reach, aperture_least_reach, aperture_light
#include "lib/highlights.lib.glsl"  // AREA_UNITS, Sprite, Plan, tally_index, row_index, MERGE_SHARE, SURFACE_SHARE
#include "lib/lit_bits.lib.glsl"  // is_lit
#include "lib/pixel_cover.lib.glsl"  // pixel_coverage
#include "lib/pixel_list.lib.glsl"  // FOR_EACH_LISTED, PIXELS_PER_GROUP

#ifndef LEVELS_AT_ONCE
#define LEVELS_AT_ONCE 1
#endif
layout(local_size_x = PIXELS_PER_GROUP, local_size_y = LEVELS_AT_ONCE) in;

uniform sampler2D highlight_tx;
uniform sampler2D positions_tx;
uniform bool has_positions;

#ifdef COUNT
layout(std430) writeonly buffer tally_block { uint tally_buf[]; };
layout(std430) buffer row_block { uint row_buf[]; };
layout(std430) buffer plan_block { Plan plan; };
uniform float area_max;  // largest area to draw, pixels
#else
layout(std430) readonly buffer tally_block { uint tally_buf[]; };
layout(std430) readonly buffer row_block { uint row_buf[]; };
layout(std430) readonly buffer plan_block { Plan plan; };
layout(std430) writeonly buffer sprite_block { Sprite sprite_buf[]; };
#endif

// Pixels belong to one highlight if their coc differ by at most SAME_COC_PX, or SAME_COC_SHARE of
// the coc.
#define SAME_COC_PX 0.5
#define SAME_COC_SHARE 0.05
#define RIM_OFFSET 0.4    // 1/2 for a straight rim; less suits the corners of small highlights as well
#define OFFSET_FULL_PX 0.75  // coc from which the light's position in its pixel moves the disc in full
#define NUMERIC_PX 8.0     // discs up to this radius are summed pixel by pixel: light is kept exactly

ivec2 size, corner;  // size of the picture, and first pixel of the block
float energy[HIGHLIGHT_BLOCK * HIGHLIGHT_BLOCK];  // r + g + b of the highlight in each pixel of the block; 0 for none
float coc[HIGHLIGHT_BLOCK * HIGHLIGHT_BLOCK];     // coc of the highlight in each pixel that has one
uint merged_bits[2];  // bit i is set if pixel i of the block is in a sprite already
int lit_count;  // pixels of the block that have light

// Pixel i of the block in the picture; the removed light of a pixel, 0 if it has no highlight.
ivec2 pixel(int i) { return corner + ivec2(i % HIGHLIGHT_BLOCK, i / HIGHLIGHT_BLOCK); }
vec4 highlight_at(ivec2 at) {
    at = clamp(at, ivec2(0), size - 1);
    return is_lit(at, size) ? texelFetch(highlight_tx, at, 0) : vec4(0.0);
}
float sum_of(vec3 c) { return c.r + c.g + c.b; }
bool is_merged(int i) { return (merged_bits[i / 32] >> (i % 32) & 1u) == 1u; }

// Coc of a highlight: that of the brightest of 3 x 3 pixels, because the mixed rim of a highlight has the depth of the
// wall behind it.
float highlight_coc(ivec2 at) {
    float top = 0.0, result = 0.0;
    for (int k = 0; k < 9; ++k) {
        vec4 highlight = highlight_at(at + ivec2(k % 3, k / 3) - 1);
        if (sum_of(highlight.rgb) > top) {
            top = sum_of(highlight.rgb);
            result = highlight.a;
        }
    }
    return result;
}

// Where the light of a pixel is: xy its middle from that of the pixel, z its variance along an axis, in pixels. At a
// highlight's rim it lies towards the brighter pixels, closer to them and narrower if less of the pixel is covered. The
// coverage follows from the brightness relative to the brightest pixel around. A pixel alone has a point of light.
vec3 light_in_pixel(ivec2 at, float coc_px) {
    float own = sum_of(highlight_at(at).rgb), most = own, around = -own;
    vec2 towards = vec2(0.0);
    for (int k = 0; k < 9; ++k) {
        ivec2 neighbor_offset = ivec2(k % 3, k / 3) - 1;
        float neighbor_light = sum_of(highlight_at(at + neighbor_offset).rgb);
        most = max(most, neighbor_light);
        around += neighbor_light;
        towards += neighbor_light * vec2(neighbor_offset);
    }
    float steepest = max(abs(towards.x), abs(towards.y)), cover = own / most;
    float offset = RIM_OFFSET * (1.0 - cover) * smoothstep(0.0, OFFSET_FULL_PX, abs(coc_px));
    float width = cover * min(around / most, 1.0);
    return vec3(offset * towards / max(steepest, 1e-30), width * width / 12.0);
}

// Reads the highlights of the block into the arrays above.
void load_block() {
    lit_count = 0;
    for (int i = 0; i < HIGHLIGHT_BLOCK * HIGHLIGHT_BLOCK; ++i) {
        ivec2 at = pixel(i);
        energy[i] = all(lessThan(at, size)) ? sum_of(highlight_at(at).rgb) : 0.0;
        lit_count += energy[i] > 0.0 ? 1 : 0;
        if (energy[i] > 0.0) coc[i] = highlight_coc(at);
    }
}

// The brightest pixel that is not merged yet in a square of the block; -1 if there is none.
int brightest(ivec2 block_corner, int side) {
    int top = -1;
    for (int k = 0; k < side * side; ++k) {
        int i = (block_corner.y + k / side) * HIGHLIGHT_BLOCK + block_corner.x + k % side;
        if (energy[i] > 0.0 && !is_merged(i) && (top < 0 || energy[i] > energy[top])) top = i;
    }
    return top;
}

// The sum of the coverage of all pixels by a disc, which the highlight's light is divided by. `ramp` is half the width
// of the disc's soft rim in pixels.
Cover pixels_covered(vec2 center, float radius, float ramp) {
    vec2 reach = aperture_reach(radius, ramp);
    if (aperture_least_reach(radius, ramp) > NUMERIC_PX) return aperture_light(radius, ramp, center);
    Cover sum = Cover(0.0);
    ivec2 first = ivec2(floor(center - reach)), last = ivec2(floor(center + reach));
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            sum += pixel_coverage(vec2(x, y) + 0.5 - center, radius, ramp, center);
    return sum;
}

// Merges all highlights in a square of the block that are not merged yet and share the coc of pixel `top` into one
// sprite. Its center is the mean position, weighted by energy.
Sprite merge_around(ivec2 block_corner, int side, int top) {
    float limit = max(SAME_COC_PX, SAME_COC_SHARE * abs(coc[top]));
    vec3 light = vec3(0.0);
    vec2 moment = vec2(0.0);
    float weight = 0.0, moment_2 = 0.0;
    for (int k = 0; k < side * side; ++k) {
        int i = (block_corner.y + k / side) * HIGHLIGHT_BLOCK + block_corner.x + k % side;
        if (energy[i] <= 0.0 || is_merged(i) || abs(coc[i] - coc[top]) > limit) continue;
        merged_bits[i / 32] |= 1u << (i % 32);
        // Position and variance of the light in its pixel are measured or estimated.
        bool is_known = energy[i] > 0.0 && has_positions;  // not the uniform alone: see lib/shaped_aperture.lib.glsl
        vec3 inside = is_known ? texelFetch(positions_tx, pixel(i), 0).xyz : light_in_pixel(pixel(i), coc[top]);
        vec2 position = vec2(i % HIGHLIGHT_BLOCK, i / HIGHLIGHT_BLOCK) + 0.5 + inside.xy;
        light += texelFetch(highlight_tx, pixel(i), 0).rgb;
        weight += energy[i];
        moment += energy[i] * position;
        moment_2 += energy[i] * (dot(position, position) + 2.0 * inside.z);
    }
    vec2 center = moment / weight;
    // The disc of several highlights has a soft rim: as wide as the group of them, at least a pixel. A pixel's own
    // variance along an axis is 1/12, and a linear ramp of half the width `ramp` has ramp^2 / 3.
    float variance = max(0.5 * (moment_2 / weight - dot(center, center)), 0.0);
    float ramp = sqrt(3.0 * (1.0 / 12.0 + variance));
    center += vec2(corner);
    float radius = 0.5 * coc[top];
    Cover covered = pixels_covered(center, radius, ramp);
    return Sprite(vec4(center, coc[top], ramp), vec4(light / max(covered, 1e-6), 0.0), vec4(0.0));
}

// Number of pixels touched by drawing a sprite.
float area_inside(Sprite sprite) {
    vec2 reach = aperture_reach(0.5 * sprite.disc.z, sprite.disc.w) + 1.0;
    vec2 lower = max(sprite.disc.xy - reach, 0.0), upper = min(sprite.disc.xy + reach, vec2(size));
    return (upper.x - lower.x) * (upper.y - lower.y);
}

// True if most of the block has light, as on a bright surface.
bool is_surface() { return lit_count > HIGHLIGHT_BLOCK * HIGHLIGHT_BLOCK / 2; }

// True if the block is part of a bright surface and its single disc at the last level would be too small
// for the block: such discs would show as a grid of spots. The light of such a block is diffused
// instead (highlight_restore.comp.glsl).
bool is_put_back(int level) {
    if (level < HIGHLIGHT_LEVELS - 1 || !is_surface()) return false;
    merged_bits[0] = merged_bits[1] = 0u;
    float widest = abs(coc[brightest(ivec2(0), HIGHLIGHT_BLOCK)]);
    return float(HIGHLIGHT_BLOCK) > SURFACE_SHARE * widest;
}

// Merges the highlights of the block at a level, squares of halved sides one after the other. Returns the number of
// sprites and their area in pixels; without COUNT, the sprites are written from `offset` on.
uint make_sprites(int level, uint offset, out float area) {
    uint count = 0u;
    area = 0.0;
    if (is_put_back(level)) return 0u;
    float share = is_surface() ? min(MERGE_SHARE[level], SURFACE_SHARE) : MERGE_SHARE[level];
    merged_bits[0] = merged_bits[1] = 0u;
    for (int side = HIGHLIGHT_BLOCK; side >= 1; side /= 2)
        for (int k = 0; k < HIGHLIGHT_BLOCK * HIGHLIGHT_BLOCK / (side * side); ++k) {
            ivec2 block_corner = side * ivec2(k % (HIGHLIGHT_BLOCK / side), k / (HIGHLIGHT_BLOCK / side));
            int top = brightest(block_corner, side);
            if (top < 0 || (side > 1 && float(side) > share * abs(coc[top]))) continue;
            Sprite sprite = merge_around(block_corner, side, top);
            area += area_inside(sprite);
#ifndef COUNT
            sprite_buf[offset + count] = sprite;
#endif
            ++count;
        }
    return count;
}

#ifdef COUNT
// Adds a block to the sums, which are whole numbers: the order of the blocks does not matter. The
// invocation that exceeds the allowed area marks the level as too large, before the sum can
// overflow.
void tally(int level, ivec2 block, ivec2 blocks, uint sprites, float area) {
    tally_buf[tally_index(level, block, blocks)] = sprites;
    if (sprites == 0u) return;
    atomicAdd(row_buf[row_index(level, block.y, blocks)], sprites);
    atomicAdd(plan.sprites[level], sprites);
    uint units = uint(ceil(min(area / area_max, 1.0) * float(AREA_UNITS)));
    if (atomicAdd(plan.area[level], units) + units > AREA_UNITS) atomicOr(plan.too_large, 1u << level);
}
#else
// Number of sprites of all blocks before this one, row by row.
uint sprites_before(ivec2 block, ivec2 blocks, int level) {
    uint before = row_buf[row_index(level, block.y, blocks)];
    for (int x = 0; x < block.x; ++x) before += tally_buf[tally_index(level, ivec2(x, block.y), blocks)];
    return before;
}
#endif

// Merges a block: counts the sprites of its levels, or writes those of the chosen one.
void merge_block(ivec2 block) {
    corner = block * HIGHLIGHT_BLOCK;
    ivec2 blocks = (size + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    float area;
    load_block();
#ifdef COUNT
    for (int level = int(gl_LocalInvocationID.y); level < HIGHLIGHT_LEVELS; level += LEVELS_AT_ONCE) {
        uint sprites = make_sprites(level, 0u, area);
        tally(level, block, blocks, sprites, area);
    }
#else
    int level = int(plan.level);
    if (level < HIGHLIGHT_LEVELS) make_sprites(level, sprites_before(block, blocks, level), area);
#endif
}

void main() {
    size = textureSize(highlight_tx, 0);
    FOR_EACH_LISTED(merge_block)
}
