// Random numbers without a state: four counters are hashed to four numbers, by pcg4d of Jarzynski and Olano 2020,
// "Hash Functions for GPU Rendering". Neighboring counters give independent numbers.

uvec4 hash_counters(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}

// Four numbers, each from 0 to just below 1, with the 24 bits that a float holds.
vec4 random4(uvec4 counts) {
    return vec4(hash_counters(counts) >> 8u) * (1.0 / 16777216.0);
}
