// A counting sort of the pixels by depth. Each invocation sorts a row of the picture, which makes the order
// deterministic. Compiled twice: COUNT counts the pixels of each bin in each row; otherwise pixels are written to
// the positions given by these counts. A bin spans a quarter of its circle of confusion, or 2 px near focus.
//
// Input
//   coc_tx       signed diameter in pixels
// COUNT output
//   place_buf    pixels of each bin in each row
// Otherwise
//   place_buf    position in pixel_buf at which each row's pixels of each bin begin
//   pixel_buf    y * width + x, by bin

layout(local_size_x = ROW_GROUP) in;

uniform sampler2D coc_tx;
layout(std430) buffer place_block { uint place_buf[]; };
#ifndef COUNT
layout(std430) writeonly buffer pixel_block { uint pixel_buf[]; };
#endif

// 0 is the nearest bin, SCATTER_MIDDLE the one in focus.
int bin_of(float coc) {
    int away = int(ceil(log2(clamp(abs(coc), 1.0, 1e6)) / SCATTER_GROWTH_LOG2));
    return clamp(SCATTER_MIDDLE + (coc < 0.0 ? -away : away), 0, SCATTER_BINS - 1);
}

void main() {
    int row = int(gl_GlobalInvocationID.x);
    ivec2 size = textureSize(coc_tx, 0);
    if (row >= size.y) return;
    uint next[SCATTER_BINS];
#ifdef COUNT
    for (int bin = 0; bin < SCATTER_BINS; ++bin) next[bin] = 0u;
    for (int x = 0; x < size.x; ++x) ++next[bin_of(texelFetch(coc_tx, ivec2(x, row), 0).r)];
    for (int bin = 0; bin < SCATTER_BINS; ++bin) place_buf[row * SCATTER_BINS + bin] = next[bin];
#else
    for (int bin = 0; bin < SCATTER_BINS; ++bin) next[bin] = place_buf[row * SCATTER_BINS + bin];
    for (int x = 0; x < size.x; ++x)
        pixel_buf[next[bin_of(texelFetch(coc_tx, ivec2(x, row), 0).r)]++] = uint(row * size.x + x);
#endif
}
