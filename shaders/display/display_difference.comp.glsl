// Shows the difference of two pictures a and b. It is taken in linear light and then converted to display values.
//
// Inputs
//   a_tx              scene-linear rgb, premultiplied
//   b_tx              the same of the other picture. If its size differs, it is stretched over a, with bilinear
//                     interpolation between its pixels.
//   gain              factor on the difference
// Output
//   out_display_img   rgb display values of gain |a - b|, alpha 1; of the size of a

#include "lib/view.lib.glsl"  // finite, to_display

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D a_tx;
uniform sampler2D b_tx;
uniform float gain;
writeonly uniform image2D out_display_img;

// A pixel of b; beyond its border the nearest one.
vec3 b_pixel(ivec2 at) {
    return finite(texelFetch(b_tx, clamp(at, ivec2(0), textureSize(b_tx, 0) - 1), 0).rgb);
}

// Picture b at a pixel of a. It is interpolated here, and not by the texture's filter, so that pictures of equal size
// match pixel by pixel.
vec3 b_at(ivec2 at) {
    vec2 stretch = vec2(textureSize(b_tx, 0)) / vec2(textureSize(a_tx, 0));
    vec2 b_position = (vec2(at) + 0.5) * stretch - 0.5;
    ivec2 corner = ivec2(floor(b_position));
    vec2 fraction = b_position - floor(b_position);
    vec3 upper = mix(b_pixel(corner), b_pixel(corner + ivec2(1, 0)), fraction.x);
    vec3 lower = mix(b_pixel(corner + ivec2(0, 1)), b_pixel(corner + 1), fraction.x);
    return mix(upper, lower, fraction.y);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_display_img)))) return;
    vec3 difference = abs(finite(texelFetch(a_tx, at, 0).rgb) - b_at(at));
    imageStore(out_display_img, at, vec4(to_display(gain * difference), 1.0));
}
