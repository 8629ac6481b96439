// The share of a pixel at a silhouette that a surface covers, from depths alone. A single depth tells whether the middle
// of its pixel is covered; where the edge is between two middles follows from how it goes on, because most edges are
// straight over a few pixels: a slanted one moves by a pixel every few columns, and its mean over these is nearer to it
// than any of its steps.
//
// Include lib/unmix.lib.glsl first.

#define NO_ROW 99          // in place of a row
#define EDGE_COLUMNS 4     // columns to which the edge is followed on each side
#define LEAST_BEYOND 0.25  // what is beyond an edge covers at least 1/32 of the pixel: its color is divided by that

// Weights of 3 x 3 depth samples for the coverage under a box filter; they sum to 1.
const float OUTLINE_WEIGHT[9] =
    float[](0.0625, 0.125, 0.0625, 0.125, 0.25, 0.125, 0.0625, 0.125, 0.0625);

// An edge beside a pixel: on it is the surface that is seen at the pixel's middle, beyond it the other one.
struct Edge {
    ivec2 at;          // the pixel
    float coc;         // its signed circle of confusion in pixels
    bool is_far_edge;  // the other surface is the nearer one
    ivec2 across;      // step towards the other surface, along the axis that is closer to it
    ivec2 along;       // step to the next column
};

// True if a pixel shows the other surface.
bool is_beyond(Edge edge, ivec2 at) {
    float other = coc_at(at);
    return edge.is_far_edge ? is_in_front(other, edge.coc) : is_in_front(edge.coc, other);
}
bool is_beyond(Edge edge, int column, int row) {
    return is_beyond(edge, edge.at + column * edge.along + row * edge.across);
}

// The first row beyond the edge in a column, beside one in which it is `row`; NO_ROW where the edge ends or turns away.
int row_beyond(Edge edge, int column, int row) {
    bool before = is_beyond(edge, column, row - 1), here = is_beyond(edge, column, row);
    int found = before ? row - 1 : here ? row : row + 1;
    bool starts = before ? !is_beyond(edge, column, row - 2) : here || is_beyond(edge, column, row + 1);
    return starts ? found : NO_ROW;
}

// Where the other surface is beside a pixel, by a Sobel filter over 3 x 3 pixels.
Edge edge_beside(ivec2 at, float coc, bool is_far_edge) {
    Edge edge = Edge(at, coc, is_far_edge, ivec2(0), ivec2(0));
    vec2 towards = vec2(0.0);
    for (int k = 0; k < 9; ++k)
        if (is_beyond(edge, neighbor(at, k))) towards += OUTLINE_WEIGHT[k] * vec2(k % 3 - 1, k / 3 - 1);
    bool is_row = abs(towards.x) <= abs(towards.y);
    edge.across = ivec2(sign(is_row ? vec2(0.0, towards.y) : vec2(towards.x, 0.0)));
    edge.along = edge.across.yx;
    return edge;
}

// Share of the pixel that the surface at its middle covers if the edge is `distance` pixels from there on average: under
// a tent filter, for one depth a pixel leaves the edge uncertain by a pixel.
float own_share(float distance) {
    float beyond = clamp(1.0 - distance, LEAST_BEYOND, 1.0);
    return 1.0 - 0.5 * beyond * beyond;
}

// The same beside what has no single edge, as a wire: half the share of the pixels around it, under a box filter.
float own_share_of_thin(Edge edge) {
    float beyond = 0.0;
    for (int k = 0; k < 9; ++k)
        if (is_beyond(edge, neighbor(edge.at, k))) beyond += 0.5 * OUTLINE_WEIGHT[k];
    return 1.0 - beyond;
}

// Share of an edge pixel that the surface at its middle covers, at least a half.
float outline_share(ivec2 at, float coc, bool is_far_edge) {
    Edge edge = edge_beside(at, coc, is_far_edge);
    bool is_one = edge.across != ivec2(0) && !is_beyond(edge, 0, -1);
    int low = is_beyond(edge, 0, 1) ? 1 : is_beyond(edge, 0, 2) ? 2 : NO_ROW, high = low, sum = low, columns = 0;
    if (!is_one || low == NO_ROW) return own_share_of_thin(edge);
    do {
        ++columns;
        low = row_beyond(edge, -columns, low);
        high = row_beyond(edge, columns, high);
        if (max(low, high) < NO_ROW) sum += low + high;
    } while (max(low, high) < NO_ROW && columns < EDGE_COLUMNS);
    if (max(low, high) == NO_ROW) --columns;
    return own_share(float(sum) / float(2 * columns + 1) - 0.5);
}
