// The mean of the samples of each pixel.
//
// Inputs
//   sum_tx, done_tx, has_done   see antialias_add
//   views                       samples in each pixel that is not done
// Output
//   mean_img   rgb, alpha 1

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D sum_tx;
uniform sampler2D done_tx;
uniform float views;
uniform bool has_done;
writeonly uniform image2D mean_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(mean_img)))) return;
    float done = has_done ? texelFetch(done_tx, at, 0).r : 0.0;
    imageStore(mean_img, at, vec4(texelFetch(sum_tx, at, 0).rgb / (done > 0.0 ? done : views), 1.0));
}
