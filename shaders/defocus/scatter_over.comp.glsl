// Composites the summed discs of one bin over the bins behind it, and clears the sums for the next bin.
//
// In and out
//   light_img       rgba of the bin times its cover
//   cover_img       how much of each pixel the bin's discs cover: more than 1 where discs overlap
//   out_color_img   rgba so far times its cover; after the nearest bin the picture
//   out_cover_img   cover so far: less than 1 where hidden surfaces should appear

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform bool is_farthest;
uniform bool is_nearest;
layout(rgba32f) uniform image2D light_img;
layout(r32f) uniform image2D cover_img;
layout(rgba32f) uniform image2D out_color_img;
layout(r32f) uniform image2D out_cover_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(light_img)))) return;
    vec4 light = imageLoad(light_img, at);
    float cover = imageLoad(cover_img, at).r;
    imageStore(light_img, at, vec4(0.0));
    imageStore(cover_img, at, vec4(0.0));
    light /= max(cover, 1.0);
    cover = min(cover, 1.0);
    if (!is_farthest) {
        light += (1.0 - cover) * imageLoad(out_color_img, at);
        cover += (1.0 - cover) * imageLoad(out_cover_img, at).r;
    }
    if (is_nearest) light /= cover;  // a pixel's own disc covers it: never 0
    imageStore(out_color_img, at, light);
    imageStore(out_cover_img, at, vec4(cover));
}
