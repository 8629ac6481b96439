// After disc.lib.glsl: a disc no wider than a pixel is its own pixel and nothing else.
bool is_sharp(float radius) { return radius * max(axis_scales.x, axis_scales.y) <= 0.5; }
