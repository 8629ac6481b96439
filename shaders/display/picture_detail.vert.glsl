// Draws the tiles of a preview in which it shows some detail of the plate. The fragment shader colors their pixels. Most
// of a picture is blurred, and is drawn without detail before, which takes a quarter of the time.
//
// Input
//   shares_tx   a the greatest share of the detail under each pixel of the preview (focus_mean.comp.glsl)

uniform sampler2D shares_tx;
uniform vec2 first_px;   // corners of the picture, in pixels of the screen, y down
uniform vec2 last_px;
uniform vec2 screen_px;  // size of the screen

#define VERTICES 6  // of a tile: two triangles
#define NOWHERE vec4(2.0, 2.0, 0.0, 1.0)

float greatest_share(ivec2 first, ivec2 end) {
    float share = 0.0;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) share = max(share, texelFetch(shares_tx, ivec2(x, y), 0).a);
    return share;
}

void main() {
    ivec2 size = textureSize(shares_tx, 0);
    int across = (size.x + TILE - 1) / TILE, tile = gl_VertexID / VERTICES, vertex = gl_VertexID % VERTICES;
    ivec2 first = TILE * ivec2(tile % across, tile / across), end = min(first + TILE, size);
    // Corners 0 1 2 and 2 1 3, row by row.
    int number = vertex < 3 ? vertex : vertex == 3 ? 2 : vertex == 4 ? 1 : 3;
    vec2 corner = vec2(number % 2 == 0 ? first.x : end.x, number / 2 == 0 ? first.y : end.y) / vec2(size);
    vec2 at = mix(first_px, last_px, corner) / screen_px;
    gl_Position = greatest_share(first, end) > 0.0 ? vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0) : NOWHERE;
}
