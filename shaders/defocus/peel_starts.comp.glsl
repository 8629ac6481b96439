// Turns the lengths of a band's lists into start offsets, after those of earlier bands (a prefix sum).
// One workgroup; each invocation handles a run of pixels.
//
// In and out
//   start_buf   twice the length, then twice the start, of each list, plus a bit that stays
//   total_buf   fragments of earlier bands, then of this one too; more than `capacity` if they do not fit
// Input
//   capacity    number of fragments that fit; lists for which there is no memory left are empty
//   has_end     also write the word after the last list, unless it holds the length of the next one

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(std430) buffer start_block { uint start_buf[]; };
layout(std430) buffer total_block { uint total_buf[]; };
uniform int first_pixel;
uniform int pixel_count;
uniform int capacity;
uniform bool has_end;

shared uint sums_sh[WORKERS];

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
