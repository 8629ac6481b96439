// A slice of a list of pixels or tiles. A pass runs slice by slice, so that the window stays responsive.

#define PIXELS_PER_GROUP 64u  // in a workgroup of a pass over a list of pixels
#define GROUPS_MAX 65535u     // what OpenGL promises; longer lists are walked in strides

uniform ivec2 list_slice;  // number of this slice, and of slices; 0, 0 for the whole list

// Index at which a slice of a list of `count` items begins; `slice` is its number.
uint slice_at(uint count, int slice) {
    uint slices = uint(max(list_slice.y, 1));  // divided first: a product of count and slice may need more than 32 bits
    return count / slices * uint(slice) + min(uint(slice), count % slices);
}
uint slice_start(uint count) { return slice_at(count, list_slice.x); }
uint slice_end(uint count) { return slice_at(count, list_slice.x + 1); }
