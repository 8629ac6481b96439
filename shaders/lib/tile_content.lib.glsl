// The word that describes a tile of the picture. Layers are numbered from the farthest on.
//
//   bit l               set if layer l has content in the tile
//   bit OPEN_BITS + l   set if layer l is open there: some pixel has a known surface in the layer or farther, but no
//                       opaque one in it. A layer that is not open covers all that is behind it, once its hidden
//                       pixels are guessed.

#define OPEN_BITS 16  // at least LAYERS_MAX

bool has_content(uint word, int layer) { return (word >> layer & 1u) != 0u; }
bool is_layer_open(uint word, int layer) { return (word >> OPEN_BITS + layer & 1u) != 0u; }
