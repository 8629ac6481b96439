// A disc of light under a squeeze: an ellipse whose rim is a ramp of the same width all around.

uniform vec2 axis_scales;  // diameter along x, y / coc

// How much of the pixel at an offset (pixels) from the centre is covered. `radius` is of the coc, in
// pixels before the squeeze; `ramp` half the rim's width in pixels of the picture. The distance to the
// rim is to first order: implicit function over the length of its gradient.
float disc_profile(vec2 offset, float radius, float ramp) {
    vec2 unsqueezed = offset / axis_scales;
    float from_centre = max(length(unsqueezed), 1e-6);
    float gradient = length(unsqueezed / axis_scales) / from_centre;
    if (from_centre <= 1e-6) gradient = 1.0 / min(axis_scales.x, axis_scales.y);
    float to_rim = (radius - from_centre) / gradient;
    return clamp((to_rim + ramp) / (2.0 * ramp), 0.0, 1.0);
}

// Half the size of the box that holds it.
vec2 disc_reach(float radius, float ramp) { return radius * axis_scales + ramp; }
