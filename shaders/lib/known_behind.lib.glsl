// The surfaces behind near edges, from fragment lists. A near edge is a pixel at a silhouette whose depth was sampled on
// the nearer of two surfaces. Include lib/unmix.lib.glsl first.

#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, Fragment

#define OPAQUE 0.9995  // coverage from which nothing behind a surface is visible

// Finds the first fragment in the list of a pixel that is behind its surface, which has this coc. Returns false if
// there is none or it is partly transparent.
bool find_behind(ivec2 at, float coc, out Fragment behind) {
    List list = list_at(at);
    uint i = list.first;
    bool is_found = false;
    while (i < list.end && !is_found) {
        behind = fragment_of(i++);
        is_found = is_in_front(coc, behind.coc);
    }
    return is_found && behind.cover >= OPAQUE;
}

// Color of the surface with the coc `coc` where a nearer pixel hides it; a its coverage, 0 if it is not listed.
// The loop is a `do ... while`, which costs less on Mesa's llvmpipe (shaders/README.md).
vec4 hidden_surface(ivec2 at, float coc) {
    List list = list_at(at);
    vec4 found = vec4(0.0);
    bool is_searching = !list.has_front && list.first < list.end;
    uint i = list.first;
    do {
        Fragment f = fragment_of(i);
        bool is_match = is_searching && is_same_surface(coc, f.coc);
        found = is_match ? vec4(f.color, f.cover) : found;
        is_searching = is_searching && !is_match;
    } while (is_searching && ++i < list.end);
    return found;
}
