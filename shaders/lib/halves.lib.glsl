// Four channels as half floats in two words. They are rounded here, because drivers differ (Mesa truncates, which
// darkens), and limited, because an infinity would spread.

vec4 round_to_half(vec4 v) {
    v = uintBitsToFloat(floatBitsToUint(v) + 0x1000u & 0xffffe000u);
    return clamp(v, -65504.0, 65504.0);
}

uvec2 halves_of(vec4 v) {
    v = round_to_half(v);
    return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw));
}

vec4 floats_of(uvec2 v) { return vec4(unpackHalf2x16(v.x), unpackHalf2x16(v.y)); }
