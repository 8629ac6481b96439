// The footprint of a pixel of a smaller version of a picture: the part of the whole picture that the pixel covers.
// `at` and `size` are in pixels of the smaller picture, `whole_size` in those of the whole one.

struct Footprint {
    vec2 low, high;     // its corners, in pixels of the whole picture
    ivec2 first, last;  // the first and the last pixel that it touches, across and down
};

// The footprint of pixel `at` of the smaller picture.
Footprint footprint_of(ivec2 at, ivec2 size, ivec2 whole_size) {
    vec2 whole = vec2(whole_size), step = whole / vec2(size);
    vec2 low = vec2(at) * step, high = min(low + step, whole);
    return Footprint(low, high, ivec2(floor(low)), ivec2(ceil(high)) - 1);
}

// The pixel of the whole picture at the center of a pixel of the smaller one.
ivec2 center_of(ivec2 at, ivec2 size, ivec2 whole_size) {
    vec2 step = vec2(whole_size) / vec2(size);
    return ivec2(vec2(at) * step + 0.5 * step);
}

// Share of the footprint that lies in a pixel; the shares sum to 1.
float share_in(Footprint footprint, ivec2 pixel) {
    vec2 shared_px = min(footprint.high, vec2(pixel + 1)) - max(footprint.low, vec2(pixel));
    vec2 extent = footprint.high - footprint.low;
    return shared_px.x * shared_px.y / (extent.x * extent.y);
}
