// Packs one fragment of a list in three words.
//   word 0   red and green, half floats
//   word 1   blue and coverage, half floats
//   word 2   dioptres (1 / meters), a float

#define WORDS 3u
#define HALF_MOST 65504.0  // the largest half

uvec3 fragment_words(vec3 color, float cover, float dioptres) {
    vec3 light = min(color, HALF_MOST);
    return uvec3(packHalf2x16(light.rg), packHalf2x16(vec2(light.b, cover)), floatBitsToUint(dioptres));
}
