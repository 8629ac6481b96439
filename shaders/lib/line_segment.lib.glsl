// Runs of active tiles along the lines of a picture (segments), divided into workgroups.
//
// An invocation solves `run` pixels of a line, and a workgroup has SOLVER_SLOTS invocations: a short segment is
// solved in several lines at once, all of one row (or column) of tiles.
//
//   segment_groups, segment_count   the workgroups of glDispatchComputeIndirect, and how many have work
//   segment_buf                     for each workgroup: its first line; its first tile << 16 | its tiles

int runs_in(int tiles, int run) { return (tiles * TILE + run - 1) / run; }

// Lines that a workgroup solves at once.
int lines_at_once(int runs) { return min(SOLVER_SLOTS / runs, TILE); }
