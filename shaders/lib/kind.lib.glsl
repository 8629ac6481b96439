// The kind of a pixel tells whether the colors of two surfaces are mixed in it. unmix_find.comp.glsl finds it, and
// other passes read it from kind_tx:
//
//   r   the kind, one of the values below
//   g   the signed coc of the nearest surface that covers a part of the pixel: beside a silhouette, of the nearer side
//   b   with fragment lists: the signed coc of the first listed fragment, or slightly less. It decides whether the
//       list is read.

#define UNMIXED 0.0    // no color of another surface is mixed in
#define FAR_EDGE 1.0   // the far side of a silhouette: the color of the nearer surface is mixed in
#define NEAR_EDGE 2.0  // the near side of a silhouette: the color of the farther surface is mixed in
#define LISTED 3.0     // its list begins with the visible surface

#define NO_LIST_PX 65504.0  // the coc of the first fragment of an empty list
