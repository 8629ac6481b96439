// A surface along the ray of a pixel.
struct Fragment {
    vec3 color;
    float cover;  // 0..1 of the pixel
    float coc;    // signed, pixels
};
