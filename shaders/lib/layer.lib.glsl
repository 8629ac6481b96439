// Layers are cut by signed circle of confusion; membership is smooth and sums to 1 over the layers.

uniform vec2 cut_near_px;  // this layer's limit towards the camera: where, half width of transition
uniform vec2 cut_far_px;   // and away from it

// A membership or coverage below THIN counts as nothing, one above SOLID counts in full. In between it
// counts by degrees, because a rack focus would pop otherwise.
#define THIN 0.02
#define SOLID 0.15

// A surface that passes a cut as the focus moves is handed on in two steps, each over half of the cut's
// transition, so that none of them is a jump: the farther layer takes it in, up to a visibility of KNOWN,
// and only then the nearer one lets go of it, from a membership of COVERS on. Were it the other way
// round, or both at once, the surface would be transparent on the way.
#define KNOWN 0.5
#define COVERS 0.7

// How much of a pixel with this coc is nearer than the cut: 1 near, 0 far.
float nearer_than(vec2 cut_px, float coc_px) {
    return 1.0 - smoothstep(cut_px.x - cut_px.y, cut_px.x + cut_px.y, coc_px);
}

float solidity(float part) { return smoothstep(THIN, SOLID, part); }

// How far a pixel of this visibility is known to the layer, and does not have to be guessed.
float knowledge(float visible) { return smoothstep(THIN, KNOWN, visible); }

// What a pixel of this membership, as a part of its visibility, covers of the layer.
float coverage(float member) { return smoothstep(0.0, COVERS, member); }

// How far a pixel with this coc shows this layer or a farther one, not just nearer ones.
float visibility(float coc_px) { return 1.0 - nearer_than(cut_near_px, coc_px); }

float membership(float coc_px) {
    return clamp(nearer_than(cut_far_px, coc_px) - nearer_than(cut_near_px, coc_px), 0.0, 1.0);
}
