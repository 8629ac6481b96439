// Crops a picture, and reduces the crop: a square of its pixels becomes one pixel.
//
// Inputs
//   from_tx      rgba of the whole picture
//   origin       first pixel of the crop
//   reduction    side of the square, in pixels of the whole picture
//   light_scale  factor for rgb
// Output
//   out_img      the crop, from its first pixel to the size of the image: each pixel is the mean of its square, with
//                rgb times `light_scale`

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D from_tx;
uniform ivec2 origin;
uniform int reduction;
uniform float light_scale;
writeonly uniform image2D out_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_img)))) return;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < reduction * reduction; ++i)
        sum += texelFetch(from_tx, origin + reduction * at + ivec2(i % reduction, i / reduction), 0);
    imageStore(out_img, at, vec4(vec3(light_scale), 1.0) * sum / float(reduction * reduction));
}
