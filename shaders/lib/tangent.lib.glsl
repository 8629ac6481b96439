// Tangents of instances.

// A mirrored instance mirrors its pictures too, which the cross product of what it turned would not.
vec4 in_world(vec4 tangent, mat3 to_world) {
    return vec4(to_world * tangent.xyz, determinant(to_world) < 0.0 ? -tangent.w : tangent.w);
}
