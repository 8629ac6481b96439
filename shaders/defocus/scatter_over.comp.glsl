// Composites the summed discs of one bin of depth over the farther bins, and clears the sums for the next bin. Bins are
// drawn far to near.
//
// In and out
//   light_img       rgba of the bin's discs times their share, added up (scatter_draw.frag.glsl); 0 after the pass
//   cover_img       r share of each pixel that the bin's discs cover, more than 1 where they overlap; 0 after the pass
//   out_color_img   rgba so far times its cover; after the nearest bin the blurred picture
//   out_cover_img   r cover so far: less than 1 where hidden surfaces should appear

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform bool is_farthest;  // the first bin: nothing is behind it
uniform bool is_nearest;   // the last bin: the picture is divided by its cover
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
