// Layers are cut by signed circle of confusion; membership is smooth and sums to 1 over the layers.

uniform vec2 cut_near_px;  // this layer's limit towards the camera: where, half width of transition
uniform vec2 cut_far_px;   // and away from it

// A membership or coverage below THIN counts as nothing, one above SOLID counts in full. In between it
// counts by degrees, because a rack focus would pop otherwise.
#define THIN 0.02
#define SOLID 0.15

// How much of a pixel with this coc is nearer than the cut: 1 near, 0 far.
float nearer_than(vec2 cut_px, float coc_px) {
    return 1.0 - smoothstep(cut_px.x - cut_px.y, cut_px.x + cut_px.y, coc_px);
}

float solidity(float part) { return smoothstep(THIN, SOLID, part); }

// How far a pixel with this coc shows this layer or a farther one, not just nearer ones.
float visibility(float coc_px) { return 1.0 - nearer_than(cut_near_px, coc_px); }

float membership(float coc_px) {
    return clamp(nearer_than(cut_far_px, coc_px) - nearer_than(cut_near_px, coc_px), 0.0, 1.0);
}
