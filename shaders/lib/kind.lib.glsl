// The kind of a pixel, in the first channel of kind_tx. With fragment lists the second channel holds the
// signed coc of the first listed fragment, or slightly less, which decides whether the list is read.

#define WHOLE 0.0     // one colour
#define FAR_RIM 1.0   // the far side of a silhouette: the colour of the nearer surface is mixed in
#define NEAR_RIM 2.0  // the near side of a silhouette: the colour of the farther surface is mixed in
#define LISTED 3.0    // its list begins with the visible surface

#define NO_LIST_PX 65504.0  // the coc of the first fragment of an empty list
