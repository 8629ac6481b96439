// One fragment of a list, packed in three words: colour and coverage as halfs, dioptres as a float.

#define WORDS 3u
#define HALF_MOST 65504.0  // the largest half

uvec3 fragment_words(vec3 color, float cover, float dioptres) {
    vec3 light = min(color, HALF_MOST);
    return uvec3(packHalf2x16(light.rg), packHalf2x16(vec2(light.b, cover)), floatBitsToUint(dioptres));
}
