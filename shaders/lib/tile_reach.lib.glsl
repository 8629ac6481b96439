// Tiles of one layer and how far to look from each.

#define FAR_AWAY 65535

uniform ivec2 tiles;      // across, down
uniform int reach_tiles;  // content farther away than this has no effect
