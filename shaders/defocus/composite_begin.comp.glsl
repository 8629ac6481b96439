// Makes the picture black outside the active tiles of the farthest layer. Inside these tiles nothing needs to be
// cleared: that layer is composited first, and replaces whatever is there.
//
// Input
//   lib/tile_mask.lib.glsl   the active tiles of the farthest layer
// Output
//   out_color_img   rgb 0, a 1 outside the active tiles

#include "lib/tile_mask.lib.glsl"  // is_tile_active

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform int reduction;  // side of a pixel of the layer, in pixels of the picture
layout(rgba32f) uniform writeonly image2D out_color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_tile_active(ivec2(gl_WorkGroupID.xy) / reduction)) return;
    if (all(lessThan(at, imageSize(out_color_img)))) imageStore(out_color_img, at, vec4(0.0, 0.0, 0.0, 1.0));
}
