// Segments, divided into workgroups. A segment is a row of successive active tiles along the lines of a picture.
//
// An invocation solves a run: `run` pixels of a line. A workgroup has SOLVER_SLOTS invocations. It solves a short
// segment in several lines at once, all of one row (or column) of tiles.
//
//   segment_groups   numbers of workgroups for glDispatchComputeIndirect
//   segment_count    how many of the workgroups have work
//   segment_buf      two words for each workgroup: its first line; its first tile << 16 | number of its tiles

// Number of runs of `run` pixels in this many tiles.
int runs_in(int tiles, int run) { return (tiles * TILE + run - 1) / run; }

// Number of lines that a workgroup solves at once, if each has this many runs.
int lines_at_once(int runs) { return min(SOLVER_SLOTS / runs, TILE); }
