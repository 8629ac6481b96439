// A slice of a list: a pass runs slice by slice, so that the window stays responsive.

uniform ivec2 list_slice;  // which part, of how many; 0 of 0: all of the list

uint slice_at(uint count, int part) {
    uint parts = uint(max(list_slice.y, 1));  // a product of count and part may be too large for 32 bits
    return count / parts * uint(part) + min(uint(part), count % parts);
}
uint slice_start(uint count) { return slice_at(count, list_slice.x); }
uint slice_end(uint count) { return slice_at(count, list_slice.x + 1); }
