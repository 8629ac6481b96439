// Adds one view through the lens to a running sum, and writes the mean so far, which is a picture with depth of field
// (Haeberli and Akeley 1990). The sum is kept, so that the mean can be shown after each view.
//
// With SHAPED, for an opening that is not an ellipse, each pixel has its own weights for the views.
//
// Inputs
//   view_tx   rgba of the view from one point of the lens
//   count     number of views in the sum, including this one
//   is_first  nothing is in the sum yet
//   is_new    view_tx is not in the sum yet
// Inputs with SHAPED
//   depth_tx         planar depth in that view, meters
//   lens_point       point of the lens from which the view is seen, in radii before the squeeze
//   colors           rgba, 1 for each channel for which the view counts
//   focus_dioptres   1 / distance of focus in the middle of the picture
//   focal_px         focal length of the view, pixels
// In and out
//   sum_img   rgba sum of the views; with SHAPED the layers of lib/sides.lib.glsl instead
// Output
//   mean_img  rgba mean of the views, half or float

#ifdef SHAPED
#define LEAST_WEIGHT 1e-6   // weight of a view that the barrel hides: it counts only if no other view does
#include "lib/aperture.lib.glsl"  // aperture_axes, pinhole_position
#include "lib/focus_offset.lib.glsl"  // focus_offset_at
#include "lib/sides.lib.glsl"  // Sides, no_sides, read_sides, write_sides, add_light, mean_of
#endif

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D view_tx;
uniform float count;
uniform bool is_first;
uniform bool is_new;
writeonly uniform image2D mean_img;

#ifdef SHAPED
uniform sampler2D depth_tx;
uniform float focus_dioptres;
uniform float focal_px;
uniform vec2 lens_point;
uniform vec4 colors;

// Adds the view at a pixel. `dioptres` of the focus, minus those of the surface, are positive behind the focus.
void add_view(ivec2 at, inout Sides sides) {
    float dioptres = focus_dioptres + focus_offset_at(at) - 1.0 / texelFetch(depth_tx, at, 0).r;
    vec2 source_position = pinhole_position(vec2(at) + 0.5, lens_point, focal_px * dioptres, aperture_axes);
    add_light(sides, texelFetch(view_tx, at, 0), lens_point, source_position, dioptres > 0.0, colors);
}

// Adds the view at a pixel if it is new; returns the mean.
vec4 mean_at(ivec2 at) {
    Sides sides = no_sides();
    if (!is_first) sides = read_sides(at);
    if (is_new) {
        add_view(at, sides);
        write_sides(at, sides);
    }
    return mean_of(sides);
}
#else
layout(rgba32f) uniform image2D sum_img;

// Adds the view at a pixel if it is new; returns the mean.
vec4 mean_at(ivec2 at) {
    vec4 sum = is_first ? vec4(0.0) : imageLoad(sum_img, at);
    if (is_new) {
        sum += texelFetch(view_tx, at, 0);
        imageStore(sum_img, at, sum);
    }
    return sum / count;
}
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(mean_img)))) return;
    imageStore(mean_img, at, mean_at(at));
}
