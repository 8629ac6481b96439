"""Constants that Python and the shaders share; each is defined only here.

A shader that mentions one of these names gets it as a `#define` (`gpu.shader_source.assemble`), so
its text does not repeat the number.
"""

from collections.abc import Mapping

from heatlens.core.model.focus.coc import COC_MOST_PX
from heatlens.core.model.lens.opening import FIELD_STEPS, RIM_MOST, RIM_POWER
from heatlens.core.model.lens.opening_image import BARREL_STEPS, IMAGE_SIDE
from heatlens.core.model.shot.settings import LAYERS_MAX
from heatlens.core.model.value_bins import BINS as DEPTH_BINS
from heatlens.core.model.view import overlays

# Sides of workgroups: how many invocations work next to each other.
PIXEL_GROUP = 16  # across and down; one pixel for each invocation
TILE_GROUP = 8  # across and down; one tile for each invocation
HIGHLIGHT_GROUP = 8  # across and down; one block of highlights for each invocation
RAY_GROUP = 8  # across and down; one ray for each invocation
ROW_GROUP = 8  # one row or line for each invocation; the vector width of a software rasterizer
WORD_GROUP = 64  # one word of the visibility masks for each invocation
SOLVER_SLOTS = 512  # runs of pixels; 56 bytes each must fit the 32 KiB of shared memory of GL 4.3
SEGMENT_GROUP = 256  # one line of tiles for each invocation

TILE = 16  # side in pixels of the tiles that masks switch on and off
TILE_LIST_HEAD = 7  # words before the tiles of a list, see lib/tile_list.lib.glsl
STRIP_COLUMNS, STRIP_TEXELS = 8, 4096  # lib/strips.lib.glsl
HIDDEN_DIRECTIONS = 4  # directions along which hidden pixels search for visible ones
LINE_NODE = 8  # pixels from one node of a line to the next, see lib/steadiness_system.lib.glsl
PEEL_DRAWS = 3  # draws of a scene's visible surfaces, each with other sample positions
PEEL_GROUPS = 6  # most surfaces in a pixel of a scene
PEEL_LIST_WORDS = 1 + 3 * PEEL_GROUPS  # their number, and three words each
HIGHLIGHT_BLOCK = 8  # side in pixels of the blocks in which highlights are merged
HIGHLIGHT_LEVELS = 5  # levels of merging, see lib/highlights.lib.glsl
FAR_BLOCK = 4  # side in pixels of the blocks in which zones for parts of the lens are found
FAR_WHOLE_PX_2 = 128.0  # reach^2 - distance^2 from which a block is wholly in such a zone
PART_GRID_SIDE = 9  # positions across and down at which the parts of a lens with a barrel are known
PYRAMID_LEVELS_MAX = 15  # no texture is larger than 2^15 on a side
DISC_RAMP_PX = 0.5  # half the width of the rim of a gathered or scattered disc
BVH_DEPTH_MOST = 30  # levels of a tree below its root
MATERIALS_ACROSS = 1024  # materials of a scene side by side in their texture, five texels each
MOST_LIGHTS = 32  # lights of a scene that shine, three vec4 each: a third of the uniforms of GL 4.3

# Scattering: bins of depth, each with SCATTER_GROWTH times the blur of the next one towards the
# focus, and the coc up to which sums of small discs are tabulated.
SCATTER_BINS, SCATTER_MIDDLE = 64, 32
SCATTER_GROWTH, SCATTER_GROWTH_LOG2 = 1.25, 0.321928
SCATTER_STEPS_A_PX, SCATTER_SMALL_PX = 8, 16
SCATTER_DISC_SUMS = SCATTER_STEPS_A_PX * SCATTER_SMALL_PX + 1


def _to_glsl(value: object) -> str:
    """Return a number, a color or a list of colors as GLSL writes it."""
    if not isinstance(value, tuple | list):
        return repr(value)
    kind = "vec3" if isinstance(value, tuple) else f"vec3[{len(value)}]"
    return f"{kind}({', '.join(map(_to_glsl, value))})"


_MODEL_CONSTANTS = {
    "COC_MOST_PX": COC_MOST_PX,
    "LAYERS_MAX": LAYERS_MAX,
    "DEPTH_BINS": DEPTH_BINS,
    "FIELD_STEPS": FIELD_STEPS,
    "RIM_MOST": RIM_MOST,
    "RIM_POWER": RIM_POWER,
    "BARREL_STEPS": BARREL_STEPS,
    "IMAGE_SIDE": IMAGE_SIDE,
}
SHADER_CONSTANTS: Mapping[str, str] = {
    name: _to_glsl(value)
    for name, value in {**globals(), **_MODEL_CONSTANTS}.items()
    if name.isupper() and isinstance(value, int | float)
}


def constants_in(words: frozenset[str]) -> dict[str, str]:
    """Return the constants among the words of a text, by name, as GLSL, in the order of this file.

    The order is fixed, because a driver's cache of compiled shaders finds a shader again only by
    the same text; the order of a set changes with each start. Colors of overlays are included.
    """
    constants = {name: glsl for name, glsl in SHADER_CONSTANTS.items() if name in words}
    tints = (item for overlay in overlays.OVERLAYS for item in overlay.colors.items())
    return constants | {name: _to_glsl(color) for name, color in tints if name in words}
