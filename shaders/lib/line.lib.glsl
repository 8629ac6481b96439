// The lines of a picture that a dispatch works on: `line_count` lines from `first_line` on, each `line_length` pixels
// long. They are rows if `axis` is (1, 0), columns if it is (0, 1). Each line needs extra memory, so
// the number of lines is limited.

uniform ivec2 axis;
uniform int first_line;
uniform int line_count;
uniform int line_length;

// The position of pixel i of a line.
ivec2 pixel_at(int line, int i) { return line * axis.yx + i * axis; }
