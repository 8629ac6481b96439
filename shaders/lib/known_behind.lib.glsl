// The surface behind a near edge, from fragment lists. A near edge is a pixel at a silhouette whose depth was sampled on
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
