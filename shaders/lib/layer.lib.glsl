// Divides the picture into layers: ranges of the signed circle of confusion (coc). The limits between layers are cuts.
//
//   membership   share of a pixel that belongs to this layer; smooth, and its sum over all layers is 1
//   visibility   share that belongs to this layer or a farther one, which is what nearer layers leave
//   knowledge    share whose color the layer takes from the pixel, and need not guess
//   coverage     share of the visibility that the layer covers
//   solidity     weight of a pixel as content of the layer

uniform vec2 cut_near_px;  // the cut towards the camera: coc, half width of the transition around it
uniform vec2 cut_far_px;   // the cut away from the camera, in the same form

// A membership or coverage below THIN counts as no content, one above SOLID as content in full. The transition is
// smooth, because a rack focus would pop otherwise.
#define THIN 0.02
#define SOLID 0.15

// As the focus moves, a surface that crosses a cut changes its layer in two smooth steps, each over half of the cut's
// transition. First the farther layer includes it, in full from a visibility of KNOWN on; only then does the nearer
// layer release it, below a membership of COVERS. In the opposite order, or with both at once, the surface would be
// transparent in between, and dark where a third one hides it. The farthest layer gives it only the weight that the
// nearer one releases, and is divided by its weights: a blurred rim that both layers show is covered once. The guess has
// the mean weight of its ends.
#define KNOWN 0.5
#define COVERS 0.55
#define END 0.9  // visibility from which a pixel is an end of the guess in full (lib/entering.lib.glsl)

#define MOST_PX 1e20  // the far cut of the farthest layer lies beyond

// Share of a pixel with this coc that is nearer than the cut: 1 near, 0 far.
float nearer_than(vec2 cut_px, float coc_px) {
    return 1.0 - smoothstep(cut_px.x - cut_px.y, cut_px.x + cut_px.y, coc_px);
}

// Weight of a membership or coverage as content of the layer, 0..1.
float solidity(float share) { return smoothstep(THIN, SOLID, share); }

// Share of a pixel of this visibility that the layer knows and need not guess, 0..1.
float knowledge(float visible) { return smoothstep(THIN, KNOWN, visible); }

// Share of its visibility that a pixel of this membership covers, 0..1.
float coverage(float member) { return smoothstep(0.0, COVERS, member); }

// True in the farthest layer. It covers everything, and its alpha is a weight (layer_split.comp.glsl).
bool has_weights() { return cut_far_px.x > MOST_PX; }

// A pixel of a layer (rgb times coverage, a coverage), with the coverage 1 in place of a weight; 0 if the pixel is empty.
vec4 without_weight(vec4 layer) {
    return has_weights() ? vec4(layer.rgb / max(layer.a, 1e-4), step(1e-4, layer.a)) : layer;
}

// Share of a pixel with this coc that shows this layer or a farther one.
float visibility(float coc_px) { return 1.0 - nearer_than(cut_near_px, coc_px); }

// Share of a pixel with this coc that belongs to this layer.
float membership(float coc_px) {
    return clamp(nearer_than(cut_far_px, coc_px) - nearer_than(cut_near_px, coc_px), 0.0, 1.0);
}
