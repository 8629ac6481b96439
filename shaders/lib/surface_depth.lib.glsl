// The depth of a surface by its circle of confusion (coc), and when surfaces count as one.

uniform vec2 fragment_line;   // x signed coc at infinity, y change of coc per dioptre; pixels

#define SAME_SURFACE 1.03  // relative distance within which surfaces add up to one
#define COVERING 0.9       // share of a pixel from which a surface covers it
#define ALL_PX 1e30        // larger than every coc

// Dioptres of a surface with this coc; at least 0.
float dioptres_of(float coc) { return max((coc - fragment_line.x) / fragment_line.y, 0.0); }
