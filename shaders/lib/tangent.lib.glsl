// Tangents of instances.

// A mirrored instance mirrors its maps too; the cross product of transformed vectors does not, hence the sign.
vec4 in_world(vec4 tangent, mat3 to_world) {
    return vec4(to_world * tangent.xyz, determinant(to_world) < 0.0 ? -tangent.w : tangent.w);
}
