// The surface behind a near rim, where fragment lists know it. Include lib/rim.lib.glsl first.

#include "lib/fragment_list.lib.glsl"

#define OPAQUE 0.9995  // a surface of this coverage or more is the only one seen past the rim

// False if nothing behind the surface of a pixel is known, or the next thing is partly transparent.
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
