// From the length of each list of a band to where it starts, behind those of the bands before. One
// workgroup; each invocation has a run of pixels.
//
// In and out
//   start_buf   twice the length, then twice the start, of each list, plus a bit that stays
//   total_buf   fragments of the bands before, then of this one too; more than `capacity` if they do not fit
// Input
//   capacity    fragments that there is room for; later lists are empty
//   has_end     the word behind the last list is written too; not where that is the length of the next one

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
        uint word = start_buf[i], room = uint(capacity);
        // A list that is cut off at its end must not begin with what is seen, which would be left out.
        bool fits = start + (word >> 1) <= room;
        start_buf[i] = 2u * min(start, room) + (fits ? word & 1u : 0u);
        start += word >> 1;
    }
    barrier();
    if (worker == WORKERS - 1) {
        total_buf[0] = start;
        if (has_end) start_buf[first_pixel + pixel_count] = 2u * min(start, uint(capacity));
    }
}
