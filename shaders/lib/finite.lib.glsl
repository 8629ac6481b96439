// Tells NaN and infinity by their bits: Metal's compiler takes both for impossible where it sees them by arithmetic.

bvec3 is_nan(vec3 v) { return greaterThan(floatBitsToUint(v) & 0x7fffffffu, uvec3(0x7f800000u)); }

bool is_infinite(float v) { return (floatBitsToUint(v) & 0x7fffffffu) == 0x7f800000u; }
