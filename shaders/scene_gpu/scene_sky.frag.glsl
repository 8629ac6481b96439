// Draws the sky where nothing is in front of it.
//
// Input
//   direction   viewing direction, not unit
// Output
//   color       scene-linear rgb; alpha 1, or with PEEL the dioptres of the sky: 0

#include "lib/scene.lib.glsl"  // unit_or
#include "lib/shading.lib.glsl"  // MOST_LIGHT, sky

in vec3 direction;

out vec4 color;

void main() {
    vec3 light = sky(unit_or(direction, vec3(0.0, 1.0, 0.0)));
#ifdef PEEL
    color = vec4(clamp(light, 0.0, MOST_LIGHT), 0.0);
#else
    color = vec4(clamp(light, 0.0, MOST_LIGHT), 1.0);
#endif
}
