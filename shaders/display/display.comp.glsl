// Converts a picture to display values, over black.
//
// Input
//   picture_tx        scene-linear rgb, premultiplied; its alpha does not count
// Output
//   out_display_img   display values, alpha 1; rounded to the image's own format

#include "lib/view.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D picture_tx;
writeonly uniform image2D out_display_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_display_img)))) return;
    imageStore(out_display_img, at, vec4(to_display(texelFetch(picture_tx, at, 0).rgb), 1.0));
}
