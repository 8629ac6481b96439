// Layers are cut by signed circle of confusion; membership is smooth and sums to 1 over the layers.

uniform float cut_near_px;  // this layer's limit towards the camera, -1e30 for the nearest
uniform float cut_far_px;   // and away from it, 1e30 for the farthest

// Half width of a cut's transition, as a part of its distance from focus: wide enough to be smooth in
// a rack focus, narrow enough that few objects live in two layers.
#define NEAR_SOFTNESS 0.1
#define FAR_SOFTNESS 0.2
#define THIN 0.02  // a membership or coverage below this is nothing

// How much of a pixel with this coc is nearer than the cut: 1 near, 0 far.
float nearer_than(float cut_px, float coc_px) {
    float half_width = abs(cut_px) * (cut_px < 0.0 ? NEAR_SOFTNESS : FAR_SOFTNESS);
    return 1.0 - smoothstep(cut_px - half_width, cut_px + half_width, coc_px);
}

float membership(float coc_px) {
    return clamp(nearer_than(cut_far_px, coc_px) - nearer_than(cut_near_px, coc_px), 0.0, 1.0);
}
