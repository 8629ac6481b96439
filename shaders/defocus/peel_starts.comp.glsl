// Turns the lengths of fragment lists into their start offsets, by a prefix sum. Each run of the pass handles a band of
// pixels, whose lists follow those of earlier bands. It has one workgroup; each invocation handles a run of pixels.
//
// Inputs
//   capacity    number of fragments for which there is memory; a list that does not fit is cut off or empty
//   has_end     also write the entry after the last list; false if it already holds the first length of the next band
// In and out
//   start_buf   of each list, before: twice its length, plus a bit; after: twice its start, plus the same bit. The bit
//               is 1 if the list begins with the visible surface (lib/fragment_list.lib.glsl)
//   total_buf   number of fragments, before: of earlier bands; after: of this one too, which is more than `capacity` if
//               they do not all fit

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(std430) buffer start_block { uint start_buf[]; };
layout(std430) buffer total_block { uint total_buf[]; };
uniform int first_pixel;  // the band: its first pixel,
uniform int pixel_count;  // and its number of pixels
uniform int capacity;
uniform bool has_end;

shared uint sums_sh[WORKERS];  // number of fragments in the run of each invocation

void main() {
    int worker = int(gl_LocalInvocationID.x), run = (pixel_count + WORKERS - 1) / WORKERS;
    int first = first_pixel + min(worker * run, pixel_count);
    int last = first_pixel + min((worker + 1) * run, pixel_count);
    uint sum = 0u;
    for (int i = first; i < last; ++i) sum += start_buf[i] >> 1;
    sums_sh[worker] = sum;
    barrier();
    uint start = total_buf[0];
    for (int i = 0; i < worker; ++i) start += sums_sh[i];
    for (int i = first; i < last; ++i) {
        uint word = start_buf[i], capacity_words = uint(capacity);
        // A truncated list must not be marked as beginning with the visible surface, which would then be lost.
        bool fits = start + (word >> 1) <= capacity_words;
        start_buf[i] = 2u * min(start, capacity_words) + (fits ? word & 1u : 0u);
        start += word >> 1;
    }
    barrier();
    if (worker == WORKERS - 1) {
        total_buf[0] = start;
        if (has_end) start_buf[first_pixel + pixel_count] = 2u * min(start, uint(capacity));
    }
}
