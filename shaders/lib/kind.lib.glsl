// What a pixel is, in kind_tx.

#define WHOLE 0.0     // one colour
#define FAR_RIM 1.0   // beside a nearer surface: its colour is mixed with that one's
#define NEAR_RIM 2.0  // beside a farther surface only: that one's colour shines into it
