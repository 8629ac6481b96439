// Finds the first and the last set bit of a word, -1 where none is set.
//
// GLSL's own functions return a signed number for an unsigned word. Compilers for other devices do not take that, so
// the word is made signed first.

int lowest_bit(uint bits) { return findLSB(int(bits)); }

// For a negative number findMSB would find the first 0.
int highest_bit(uint bits) { return bits > 0x7fffffffu ? 31 : findMSB(int(bits)); }
