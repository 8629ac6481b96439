// A part of a picture as a picture of its own.
//
// Input
//   from_tx   the whole
// Output
//   out_img   the part whose first pixel is `origin`

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D from_tx;
uniform ivec2 origin;
writeonly uniform image2D out_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_img)))) return;
    imageStore(out_img, at, texelFetch(from_tx, at + origin, 0));
}
