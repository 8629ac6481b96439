// Tangents of instances, for normal maps.

// The tangent in world space; w is its sign. A mirrored instance mirrors its maps too. The cross product of transformed
// vectors is not mirrored, so the sign changes.
vec4 in_world(vec4 tangent, mat3 to_world) {
    return vec4(to_world * tangent.xyz, determinant(to_world) < 0.0 ? -tangent.w : tangent.w);
}
