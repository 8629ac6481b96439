// The view that is built in, for use without OpenColorIO: scene-linear light, clipped to 0..1, to display values by the
// sRGB curve of IEC 61966-2-1.

vec4 view_transform(vec4 light) {
    vec3 shown = clamp(light.rgb, 0.0, 1.0);
    vec3 curve = 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055;
    return vec4(mix(curve, 12.92 * shown, lessThanEqual(shown, vec3(0.0031308))), light.a);
}
