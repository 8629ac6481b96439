"""Hold the memory for the view of one part of the lens, which all parts use in turn."""

import math
from dataclasses import dataclass

from heatlens.render.defocus.blur_pass import PackedPicture
from heatlens.render.defocus.far_guess import WORD_BYTES
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.overlap_zones import PartSurfaces
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.tile_mask import SegmentPass, TileMask, tile_count
from heatlens.render.gpu.resources import Buffer, StorageBuffer, Texture
from heatlens.render.gpu.textures import BufferParts

_LINK_BYTES = 20  # bytes for each surface in lib/part_link.lib.glsl
_LIMIT_BYTES = 8  # bytes for each pixel in part_surfaces.comp.glsl
_SUM_BYTES = 16  # bytes for each pixel in part_sum.comp.glsl
_MARK_BYTES = 8  # bytes for each tile in lib/view_marks.lib.glsl


@dataclass(frozen=True)
class FrontMemory:
    """The memory for what a part of the lens sees in front of the focus.

    view   RGBA, rgb times coverage, a coverage; then the same, blurred
    state  RG, diameter of the part's disc in pixels and coverage, as that of a `Layer`
    coc    that diameter, extended beyond the surfaces
    rows   scratch memory of `CocFillPass`
    """

    view: PackedPicture
    state: Texture
    coc: Texture
    rows: tuple[Buffer, Buffer]

    @staticmethod
    def of(size: tuple[int, int], scratch: Scratch) -> "FrontMemory":
        """Return the memory for a view of the size of the picture."""
        row_bytes = CocFillPass.rows_bytes(size)
        return FrontMemory(
            view=_packed_picture("front view", size, scratch),
            state=scratch.texture("front state", size, 2),
            coc=scratch.texture("front coc", size, 1),
            rows=(
                scratch.buffer("front fill diameters", row_bytes),
                scratch.buffer("front fill weights", row_bytes),
            ),
        )


@dataclass(frozen=True)
class ViewMemory:
    """The memory for the view of one part of the lens, which all parts use in turn.

    view   RGBA of the view; then the same, blurred
    coc    diameter of the part's disc at each pixel, in pixels
    front  what is in front of the focus, if the views show that too
    heads  the last surface in the list of each pixel (part_links.comp.glsl)
    links  the surfaces, each with the next one of its list (lib/part_link.lib.glsl)
    limits  two limits of each pixel (part_surfaces.comp.glsl)
    marks  what part_view.comp.glsl finds in each tile (lib/view_marks.lib.glsl)
    masks  the masks of the tiles in which the view, and what is in front of the focus, is blurred
    segments  the runs of the tiles in these
    """

    view: PackedPicture
    coc: Texture
    heads: Buffer
    links: Buffer
    limits: Buffer
    marks: Buffer
    masks: BufferParts
    segments: BufferParts
    front: FrontMemory | None

    @staticmethod
    def of(surfaces: PartSurfaces, scratch: Scratch) -> "ViewMemory":
        """Return the memory for a view of the size of the picture."""
        (width, height), name = surfaces.coc.size, surfaces.name
        return ViewMemory(
            view=_packed_picture(f"{name} view", (width, height), scratch),
            coc=scratch.texture(f"{name} coc", (width, height), 1),
            heads=scratch.buffer(f"{name} heads", WORD_BYTES * (width + 1) * (height + 1)),
            links=scratch.buffer(f"{name} links", _LINK_BYTES * surfaces.surface_count),
            limits=scratch.buffer(f"{name} limits", _LIMIT_BYTES * width * height),
            marks=scratch.buffer(
                f"{name} marks", _MARK_BYTES * math.prod(tile_count((width, height)))
            ),
            masks=scratch.parts(f"{name} masks", 2, TileMask.bytes_for((width, height))),
            segments=scratch.parts(f"{name} runs", 4, SegmentPass.bytes_for((width, height))),
            front=FrontMemory.of((width, height), scratch) if surfaces.has_all_depths else None,
        )

    @property
    def list_buffers(self) -> dict[str, StorageBuffer]:
        """The lists of the surfaces that have moved to each cell."""
        return {"head_block": self.heads, "link_block": self.links}

    @property
    def view_buffers(self) -> dict[str, StorageBuffer]:
        """The pictures that part_view.comp.glsl draws, and part_sum.comp.glsl adds."""
        front = {} if self.front is None else {"front_block": self.front.view.words}
        return {"view_block": self.view.words, **front}

    @property
    def drawn_images(self) -> dict[str, Texture]:
        """The diameters of the discs in these pictures."""
        front = {} if self.front is None else {"out_front_state_img": self.front.state}
        return {"out_coc_img": self.coc, **front}


def sum_memory(surfaces: PartSurfaces, scratch: Scratch) -> Buffer:
    """Return the memory for the sum of all views."""
    width, height = surfaces.coc.size
    return scratch.buffer(f"{surfaces.name} sum", _SUM_BYTES * width * height)


def _packed_picture(name: str, size: tuple[int, int], scratch: Scratch) -> PackedPicture:
    """Return the memory called `name` for a picture of `size`."""
    return PackedPicture(scratch.buffer(name, PackedPicture.bytes_for(size)), size)
