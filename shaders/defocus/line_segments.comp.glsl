// Lists the segments, which are runs of active tiles, along the rows and along the columns of all layers. One workgroup
// makes one list. solve_partition.comp.glsl solves the segments, each in several lines of pixels at once.
//
// Inputs
//   tile_mask_buf     masks of the layers (lib/tile_mask.lib.glsl), `tile_words` words each
//   layers            see below
// Output
//   segment_list_buf  lists of `list_words` words (lib/line_segment.lib.glsl): the rows of the first layer, its
//                     columns, the rows of the second layer and so on; in a list, segments are in no particular order
//
// A line is a row or column of tiles here, except where it says line of pixels.

#include "lib/line_segment.lib.glsl"  // runs_in, lines_at_once

#define LIST_HEAD 4         // words before the segments
#define GROUPS_ACROSS 32768u // workgroups side by side; OpenGL promises 65535
#define WORD_TILES 32       // tiles that are read together

layout(local_size_x = SEGMENT_GROUP) in;

// For each layer: x, y tiles across and down; z, w pixels that an invocation solves along rows and along columns.
uniform ivec4 layers[2 * LAYERS_MAX];
uniform int tile_words;  // words of a layer's mask
uniform int list_words;  // words of a list
layout(std430) restrict readonly buffer tile_mask_block { uint tile_mask_buf[]; };
layout(std430) restrict writeonly buffer segment_list_block { uint segment_list_buf[]; };

shared uint count_sh;  // entries of the list so far

// A list, and how the tiles along its lines lie in the mask.
struct List {
    int first_word, first_tile;  // where the list begins in segment_list_buf, and the mask in tile_mask_buf
    int across, along;  // words of the mask to the next line of tiles, and to the next tile of a line
    int count;          // tiles of a line
    int run;            // pixels that an invocation solves
};

// Appends the segment of `tiles` tiles from the tile `first` of a line on: one entry for each workgroup that solves
// lines of pixels in it.
void list_segment(List list, int line, int first, int tiles) {
    int lines = lines_at_once(runs_in(tiles, list.run));
    for (int l = 0; l < TILE; l += lines) {
        int word = list.first_word + LIST_HEAD + 2 * int(atomicAdd(count_sh, 1u));
        segment_list_buf[word] = uint(line * TILE + l);
        segment_list_buf[word + 1] = uint(first) << 16 | uint(tiles);
    }
}

// The active tiles of a line as bits, for WORD_TILES tiles from the tile `first` on.
uint active_bits(List list, int line, int first) {
    uint bits = 0u;
    int word = list.first_tile + line * list.across, last = list.count - 1;
    for (int k = 0; k < WORD_TILES; ++k) {
        uint is_active = tile_mask_buf[word + min(first + k, last) * list.along] != 0u ? 1u : 0u;
        bits |= first + k <= last ? is_active << k : 0u;
    }
    return bits;
}

// Appends all segments of a line. The loops go one tile beyond its end, where the last segment is closed.
void list_line(List list, int line) {
    int segment_start = -1;  // first tile of the current segment; -1 for none
    for (int first = 0; first <= list.count; first += WORD_TILES) {
        uint bits = first < list.count ? active_bits(list, line, first) : 0u;
        for (int k = 0; k < WORD_TILES; ++k) {
            bool is_active = (bits >> k & 1u) != 0u;
            if (is_active && segment_start < 0) segment_start = first + k;
            if (is_active || segment_start < 0) continue;
            list_segment(list, line, segment_start, first + k - segment_start);
            segment_start = -1;
        }
    }
}

// Writes the workgroups of the later pass, across and down, and the number of entries.
void write_head(List list) {
    segment_list_buf[list.first_word] = min(count_sh, GROUPS_ACROSS);
    segment_list_buf[list.first_word + 1] = (count_sh + GROUPS_ACROSS - 1u) / GROUPS_ACROSS;
    segment_list_buf[list.first_word + 2] = 1u;
    segment_list_buf[list.first_word + 3] = count_sh;
}

void main() {
    int number = int(gl_WorkGroupID.x), layer = number / 2, index = int(gl_LocalInvocationIndex);
    bool are_rows = number % 2 == 0;
    ivec4 tiles = layers[layer];
    List list = List(number * list_words, layer * tile_words, are_rows ? tiles.x : 1, are_rows ? 1 : tiles.x,
                     are_rows ? tiles.x : tiles.y, are_rows ? tiles.z : tiles.w);
    if (index == 0) count_sh = 0u;
    barrier();
    for (int line = index; line < (are_rows ? tiles.y : tiles.x); line += SEGMENT_GROUP) list_line(list, line);
    barrier();
    if (index == 0) write_head(list);
}
