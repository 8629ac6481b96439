// The word of a tile: bit l if layer l has content there, and bit OPEN_BITS + l if the layer is open: some pixel
// is known there as far back as the layer or farther, but nothing opaque in it. Where a layer is not open, it
// covers all that is behind it, once what is hidden of it is guessed. Layers are numbered from the farthest on.

#define OPEN_BITS 16  // at least LAYERS_MAX

bool has_content(uint word, int layer) { return (word >> layer & 1u) != 0u; }
bool is_layer_open(uint word, int layer) { return (word >> OPEN_BITS + layer & 1u) != 0u; }
