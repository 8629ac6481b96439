// One view more through the lens, and the mean of those there are: Haeberli and Akeley 1990. The
// sum stays as it is, so that more views can follow; the picture can be looked at after each.
//
// Inputs
//   view_tx   rgba, what one point of the lens sees
//   count     views in the sum, this one included
//   is_first  nothing is in the sum yet
//   is_new    view_tx is not in the sum yet
// In and out
//   sum_img   rgba
// Output
//   mean_img  rgba, half or float

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D view_tx;
uniform float count;
uniform bool is_first;
uniform bool is_new;
layout(rgba32f) uniform image2D sum_img;
writeonly uniform image2D mean_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(mean_img)))) return;
    vec4 sum = is_first ? vec4(0.0) : imageLoad(sum_img, at);
    if (is_new) {
        sum += texelFetch(view_tx, at, 0);
        imageStore(sum_img, at, sum);
    }
    imageStore(mean_img, at, sum / count);
}
