// A list of tiles of TILE x TILE pixels, for a pass that has one workgroup for each (`TileBands` in
// render/defocus/pixel_list.py).

layout(std430) readonly buffer tile_number_block { uint tile_number_buf[]; };  // x + 65536 y of each tile
uniform int first_tile;  // of the list, for this dispatch

// The pixel of this invocation, in the tile of its workgroup.
ivec2 listed_pixel() {
    uint tile = tile_number_buf[first_tile + int(gl_WorkGroupID.x)];
    return ivec2(tile & 0xffffu, tile >> 16) * TILE + ivec2(gl_LocalInvocationID.xy);
}
