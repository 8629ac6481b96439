// Sharpens a small picture before it is enlarged, to make up for the softening of bilinear enlargement. A preview is
// then no softer than its resolution requires.
//
// Input
//   picture_tx   rgb display values
// Output
//   out_img      rgb display values, sharpened, alpha 1; the same size

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D picture_tx;
writeonly uniform image2D out_img;

#define SHARPER 0.5  // share of the difference from the local mean to add; gives previews the lowest mean FLIP error

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_img);
    if (any(greaterThanEqual(at, size))) return;
    vec3 mean = vec3(0.0);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            ivec2 tap = clamp(at + ivec2(x, y), ivec2(0), size - 1);
            mean += float((2 - abs(x)) * (2 - abs(y))) * texelFetch(picture_tx, tap, 0).rgb / 16.0;
        }
    vec3 picture = texelFetch(picture_tx, at, 0).rgb;
    imageStore(out_img, at, vec4(picture + SHARPER * (picture - mean), 1.0));
}
