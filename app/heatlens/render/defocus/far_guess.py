"""Guess what lies behind surfaces behind the focus, where it is not known, for parts of the lens.

The picture is cut in gaps of its depths. What is farther than a cut is extended under all that is
nearer by a pyramid: its levels are means of what is known, and fill each other's holes from coarse
to fine (pull and push; Gortler, Grzeszczuk, Szeliski and Cohen, "The Lumigraph", 1996).
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from heatlens.render.defocus.listed_fragments import FragmentBuffers, ListedFragments
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.other_methods import LevelRect, layout_levels, pyramid_size
from heatlens.render.defocus.pixel_list import PixelBands
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, pixel_groups
from heatlens.render.gpu.resources import Texture

FAR_PARTS = "far parts"  # name of the step
GUESSED_FROM_PX = 12.0  # least coc of both surfaces at an edge where a guess is used
FRAGMENT_BYTES, WORD_BYTES = 12, 4  # bytes of a fragment in a list, and of the start of a list


def cuts_behind(optics: Optics, least_px: float) -> list[float]:
    """Return the signed coc in the middle of each gap behind the focus, near to far, in pixels.

    Gaps up to `least_px`, and those beyond the farthest surface, are left out.
    """
    middles = (float(ends.mean()) for ends in optics.gaps_px)
    return [px for px in middles if least_px < px < optics.farthest_px]


# A guess serves edges between two wide surfaces that are both much blurred, and nothing else. Used
# wherever blurs overlap, 7 parts by a guess were worse for thin things (FLIP of a portrait with
# hair .0957 -> .1105, of a wire fence .1010 -> .1212). As a fill behind surfaces in front of the
# focus a guess was worse than following structures (.0723 -> .0835), because it loses the bars of a
# window.
class FarGuess:
    """Makes fragment lists with a guess behind each cut, for the same step."""

    def __init__(self, ctx: Device) -> None:
        self._bands = PixelBands(ctx)
        self._lists, self._pull, self._push = (
            ComputeProgram(ctx, f"defocus/guess_{name}.comp.glsl")
            for name in ("lists", "pull", "push")
        )

    def steps(
        self, color: Texture, coc: Texture, optics: Optics, least_px: float, scratch: Scratch
    ) -> Steps[ListedFragments | None]:
        """Return lists with one fragment for each cut at each pixel; each fragment is a guess.

        `color` is the picture, RGBA, and `coc` its signed coc in pixels. Surfaces whose coc is at
        most `least_px` are not behind the focus. Return None if the plate has no distances
        (`optics.line` is None), or no gap with a coc above GUESSED_FROM_PX.
        """
        cuts_px = cuts_behind(optics, least_px)
        if optics.line is None or not cuts_px or cuts_px[-1] <= GUESSED_FROM_PX:
            return None
        coc_line = optics.line.at_infinity_px, optics.line.per_dioptre_px
        lists = ListedFragments(_allocate_lists(coc.size, len(cuts_px), scratch), optics.line)
        level_rects = layout_levels(coc.size, math.inf)
        levels = scratch.texture("guess levels", pyramid_size(level_rects), 4)
        for cut, cut_px in enumerate(cuts_px):
            yield from self._fill_levels(color, coc, cut_px, levels, level_rects)
            list_steps = self._bands.run(
                self._lists,
                coc.size,
                {
                    "coarser_rect": level_rects[0],
                    "cut": cut,
                    "cuts": len(cuts_px),
                    "cut_px": cut_px,
                }
                | {"least_px": least_px, "coc_line": coc_line},
                textures={"coc_tx": coc, "levels_tx": levels},
                buffers=lists.buffers,
            )
            for _ in list_steps:
                yield FAR_PARTS
        return lists

    def _fill_levels(
        self,
        color: Texture,
        coc: Texture,
        cut_px: float,
        levels: Texture,
        level_rects: list[LevelRect],
    ) -> Iterator[str]:
        """Fill all levels of the pyramid with the surfaces whose coc is above `cut_px`.

        First each level takes the mean of what is known of the finer one (pull). Then each level
        takes what it lacks from the coarser one (push). `levels` has all levels of the pyramid, at
        `level_rects`, fine to coarse.
        """
        self._pull.version(FIRST=True).dispatch(
            pixel_groups(level_rects[0][2:]),
            textures={"color_tx": color, "coc_tx": coc},
            images={"out_levels_img": levels},
            uniforms={"out_rect": level_rects[0], "cut_px": cut_px},
        )
        for finer_rect, rect in pairwise(level_rects):
            self._pull.dispatch(
                pixel_groups(rect[2:]),
                textures={"levels_tx": levels},
                images={"out_levels_img": levels},
                uniforms={"finer_rect": finer_rect, "out_rect": rect},
            )
        yield FAR_PARTS
        for rect, coarser_rect in reversed(list(pairwise(level_rects))):
            self._push.dispatch(
                pixel_groups(rect[2:]),
                textures={"levels_tx": levels},
                images={"levels_img": levels},
                uniforms={"rect": rect, "coarser_rect": coarser_rect},
            )
        yield FAR_PARTS


def _allocate_lists(size: tuple[int, int], cuts: int, scratch: Scratch) -> FragmentBuffers:
    """Return the memory for lists with `cuts` fragments at each pixel of a picture of `size`."""
    pixels = size[0] * size[1]
    starts = scratch.buffer("guess starts", WORD_BYTES * (pixels + 1))
    words = scratch.buffer("guess words", FRAGMENT_BYTES * pixels * cuts)
    return FragmentBuffers(starts, words, size, is_measured=False)
