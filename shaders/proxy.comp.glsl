// The picture at a smaller size to work on: colour is averaged over each pixel's footprint, depth is
// the one sample at its centre (a mean of two depths would be a surface that is not there).
//
// Inputs
//   color_tx, depth_tx            full size
// Outputs
//   out_color_img, out_depth_img  proxy size

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform float depth_scale;  // 1 for metres, the proxy's scale where depth_tx holds pixels of coc
layout(rgba32f) uniform writeonly image2D out_color_img;
layout(r32f) uniform writeonly image2D out_depth_img;

vec4 footprint_mean(vec2 low, vec2 high) {
    ivec2 first = ivec2(floor(low)), last = ivec2(ceil(high)) - 1;
    vec4 sum = vec4(0.0);
    for (int y = first.y; y <= last.y; ++y) {
        float h = min(high.y, float(y + 1)) - max(low.y, float(y));
        for (int x = first.x; x <= last.x; ++x) {
            float w = min(high.x, float(x + 1)) - max(low.x, float(x));
            sum += w * h * texelFetch(color_tx, ivec2(x, y), 0);
        }
    }
    vec2 extent = high - low;
    return sum / (extent.x * extent.y);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_color_img);
    if (any(greaterThanEqual(at, size))) return;
    vec2 full = vec2(textureSize(color_tx, 0)), step = full / vec2(size);
    vec2 low = vec2(at) * step, high = min(low + step, full);
    imageStore(out_color_img, at, footprint_mean(low, high));
    float depth = texelFetch(depth_tx, ivec2(low + 0.5 * step), 0).r;
    imageStore(out_depth_img, at, vec4(depth * depth_scale));
}
