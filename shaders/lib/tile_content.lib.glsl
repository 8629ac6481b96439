// The word of a tile: bit l if layer l has content there, and bit SEEN_BITS + l if some of it is seen in the
// pinhole picture, not only known behind something nearer.

#define SEEN_BITS 16  // at least 2 * LAYERS_MAX

uint with_seen(uint layers, bool are_seen) { return are_seen ? layers << SEEN_BITS | layers : layers; }
bool has_content(uint word, int layer) { return (word >> layer & 1u) != 0u; }

// True if a nearer blur can uncover a layer there: not where one nearer layer alone is seen, which covers all
// of it. Layers are numbered from the farthest on.
bool is_uncovered(uint word, int layer) {
    uint seen = word >> SEEN_BITS;
    return bitCount(seen) > 1 || (seen & (2u << layer) - 1u) != 0u;
}
