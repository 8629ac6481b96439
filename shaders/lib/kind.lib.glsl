// What a pixel is, in the first channel of kind_tx. The second one is there with fragment lists: the signed coc
// of the first fragment of the pixel's list, or a little less, which tells whether the list is worth a look.

#define WHOLE 0.0     // one colour
#define FAR_RIM 1.0   // beside a nearer surface: its colour is mixed with that one's
#define NEAR_RIM 2.0  // beside a farther surface only: that one's colour shines into it
#define LISTED 3.0    // it has a list that begins with what it shows

#define NO_LIST_PX 65504.0  // the coc of the first fragment of an empty list
