// Sorts the pixels into bins of depth by a counting sort. Each invocation sorts a row of the picture, which makes the
// order of the pixels the same in every run. The width of a bin is a quarter of its circle of confusion, or 2 px near
// the focus.
//
// Built twice. With COUNT, the pass counts the pixels of each bin in each row. The CPU replaces the counts by the
// offsets at which the pixels of each bin and row begin (ScatterPass). Without COUNT, the pass writes the pixels there.
//
// Input
//   coc_tx       r signed coc (circle of confusion, diameter in pixels, negative in front of the focus)
// Output with COUNT
//   offset_buf   number of pixels of each bin in each row
// Input without COUNT
//   offset_buf   index in pixel_buf at which the pixels of each bin in each row begin
// Output without COUNT
//   pixel_buf    the pixels, y * width + x, bin by bin, far to near

layout(local_size_x = ROW_GROUP) in;

uniform sampler2D coc_tx;
layout(std430) buffer offset_block { uint offset_buf[]; };
#ifndef COUNT
layout(std430) writeonly buffer pixel_block { uint pixel_buf[]; };
#endif

// The bin of a coc: 0 is the nearest, SCATTER_MIDDLE the one in focus.
int bin_of(float coc) {
    int away = int(ceil(log2(clamp(abs(coc), 1.0, 1e6)) / SCATTER_GROWTH_LOG2));
    return clamp(SCATTER_MIDDLE + (coc < 0.0 ? -away : away), 0, SCATTER_BINS - 1);
}

void main() {
    int row = int(gl_GlobalInvocationID.x);
    ivec2 size = textureSize(coc_tx, 0);
    if (row >= size.y) return;
    uint next[SCATTER_BINS];  // number of pixels in each bin so far, or where the next one of each bin is written
#ifdef COUNT
    for (int bin = 0; bin < SCATTER_BINS; ++bin) next[bin] = 0u;
    for (int x = 0; x < size.x; ++x) ++next[bin_of(texelFetch(coc_tx, ivec2(x, row), 0).r)];
    for (int bin = 0; bin < SCATTER_BINS; ++bin) offset_buf[row * SCATTER_BINS + bin] = next[bin];
#else
    for (int bin = 0; bin < SCATTER_BINS; ++bin) next[bin] = offset_buf[row * SCATTER_BINS + bin];
    for (int x = 0; x < size.x; ++x)
        pixel_buf[next[bin_of(texelFetch(coc_tx, ivec2(x, row), 0).r)]++] = uint(row * size.x + x);
#endif
}
