// The kind of a pixel, in the first channel of kind_tx. With fragment lists the second channel holds the
// signed coc of the first listed fragment, or slightly less, to tell if the list needs to be read.

#define WHOLE 0.0     // one colour
#define FAR_RIM 1.0   // beside a nearer surface, whose colour is mixed into it
#define NEAR_RIM 2.0  // beside a farther surface only, whose colour is mixed into it
#define LISTED 3.0    // it has a list that begins with the visible surface

#define NO_LIST_PX 65504.0  // the coc of the first fragment of an empty list
