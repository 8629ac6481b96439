// Layers are ranges of signed circle of confusion; membership is smooth and sums to 1 over the layers.

uniform vec2 cut_near_px;  // this layer's limit towards the camera: position, half width of the transition
uniform vec2 cut_far_px;   // its limit away from the camera: position, half width

// A membership or coverage below THIN is taken as 0, one above SOLID as 1. The transition is smooth, because a
// rack focus would pop otherwise.
#define THIN 0.02
#define SOLID 0.15

// As the focus moves, a surface that crosses a cut changes its layer in two smooth steps, each over half of the cut's
// transition. First the farther layer includes it, up to a visibility of KNOWN; only then does the nearer layer
// release it, from a membership of COVERS on. In the opposite order, or with both at once, the surface would be
// transparent in between, and dark where a third one hides it.
#define KNOWN 0.5
#define COVERS 0.55

// Share of a pixel with this coc that is nearer than the cut: 1 near, 0 far.
float nearer_than(vec2 cut_px, float coc_px) {
    return 1.0 - smoothstep(cut_px.x - cut_px.y, cut_px.x + cut_px.y, coc_px);
}

// Weight of a membership or coverage as content of the layer.
float solidity(float part) { return smoothstep(THIN, SOLID, part); }

// Share of a pixel of this visibility that the layer knows and need not guess.
float knowledge(float visible) { return smoothstep(THIN, KNOWN, visible); }

// Coverage by a pixel of this membership, as a share of its visibility.
float coverage(float member) { return smoothstep(0.0, COVERS, member); }

// Share of a pixel with this coc that shows this layer or a farther one.
float visibility(float coc_px) { return 1.0 - nearer_than(cut_near_px, coc_px); }

float membership(float coc_px) {
    return clamp(nearer_than(cut_far_px, coc_px) - nearer_than(cut_near_px, coc_px), 0.0, 1.0);
}
