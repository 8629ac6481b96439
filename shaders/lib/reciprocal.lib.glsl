// Returns 1 / x correctly rounded; GLSL's own division may be off by 2.5 units in the last place.

const int LEADING_BIT = 0x800000;  // 2^23, the first of the 24 bits of a float's mantissa

// 1 / x for 0 < x < 1e37, and 0 for +inf. `m` is the mantissa of x as a whole number of 24 bits, `q` that of the
// result.
float reciprocal(float x) {
    uint bits = floatBitsToUint(x);
    if (bits >= 0x7f800000u) return 0.0;
    int exponent = int(bits >> 23), m = int(bits & 0x7fffffu) | LEADING_BIT;
    if (m == LEADING_BIT) return uintBitsToFloat(uint(254 - exponent) << 23);
    // q = 2^47 / m has 24 bits again, with an error of at most 2.5; the remainder q m - 2^47 fits 32 bits. Each
    // of two rounds moves q by 1 towards the nearest whole number, while the remainder is more than half of m.
    int q = int(140737488355328.0 / float(m));
    int rest = int(uint(q) * uint(m));
    for (int i = 0; i < 2; ++i) {
        int step = int(2 * rest < -m) - int(2 * rest > m);
        q += step;
        rest += step * m;
    }
    return uintBitsToFloat(uint(253 - exponent) << 23 | uint(q) & 0x7fffffu);
}
