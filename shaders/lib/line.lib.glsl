// Lines of a picture: rows when axis is (1, 0), columns when it is (0, 1).
//
// A dispatch works on `line_count` lines from `first_line` on, each `line_length` pixels long. This limits the extra
// memory, which each line needs.

uniform ivec2 axis;
uniform int first_line;
uniform int line_count;
uniform int line_length;

ivec2 pixel_at(int line, int i) { return line * axis.yx + i * axis; }
