// Converts a picture over black to display values, by the view's transform (lib/view.lib.glsl).
//
// Input
//   picture_tx        scene-linear rgb, premultiplied; its alpha is not used
// Output
//   out_display_img   rgb display values, alpha 1; rounded to the format of the image

#include "lib/view.lib.glsl"  // to_display

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D picture_tx;
writeonly uniform image2D out_display_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_display_img)))) return;
    imageStore(out_display_img, at, vec4(to_display(texelFetch(picture_tx, at, 0).rgb), 1.0));
}
