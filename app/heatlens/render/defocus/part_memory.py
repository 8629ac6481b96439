"""Hold the memory for the view of one part of the lens, which all parts use in turn."""

import math
from dataclasses import dataclass

from heatlens.render.defocus.far_guess import WORD_BYTES
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.overlap_zones import PartSurfaces
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.tile_mask import SegmentPass, TileMask, tile_count
from heatlens.render.gpu.resources import Buffer, StorageBuffer, Texture
from heatlens.render.gpu.textures import BufferParts

_LINK_BYTES = 20  # bytes for each surface in lib/part_link.lib.glsl
_MARK_BYTES = 8  # bytes for each tile in lib/view_marks.lib.glsl


@dataclass(frozen=True)
class FrontMemory:
    """The memory for what a part of the lens sees in front of the focus.

    view   RGBA, rgb times coverage, a coverage; then the same, blurred
    state  RG, diameter of the part's disc in pixels and coverage, as that of a `Layer`
    coc    that diameter, extended beyond the surfaces
    rows   scratch memory of `CocFillPass`
    """

    view: Texture
    state: Texture
    coc: Texture
    rows: tuple[Buffer, Buffer]

    @staticmethod
    def of(size: tuple[int, int], scratch: Scratch) -> "FrontMemory":
        """Return the memory for a view of the size of the picture."""
        row_bytes = CocFillPass.rows_bytes(size)
        return FrontMemory(
            view=scratch.texture("front view", size, 4),
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
    marks  what part_view.comp.glsl finds in each tile (lib/view_marks.lib.glsl)
    masks  the masks of the tiles in which the view, and what is in front of the focus, is blurred
    segments  the runs of the tiles in these
    """

    view: Texture
    coc: Texture
    heads: Buffer
    links: Buffer
    marks: Buffer
    masks: BufferParts
    segments: BufferParts
    front: FrontMemory | None

    @staticmethod
    def of(surfaces: PartSurfaces, scratch: Scratch) -> "ViewMemory":
        """Return the memory for a view of the size of the picture."""
        (width, height), name = surfaces.coc.size, surfaces.name
        return ViewMemory(
            view=scratch.texture(f"{name} view", (width, height), 4),
            coc=scratch.texture(f"{name} coc", (width, height), 1),
            heads=scratch.buffer(f"{name} heads", WORD_BYTES * (width + 1) * (height + 1)),
            links=scratch.buffer(f"{name} links", _LINK_BYTES * surfaces.surface_count),
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
    def drawn_images(self) -> dict[str, Texture]:
        """The outputs of part_view.comp.glsl."""
        images = {"out_view_img": self.view, "out_coc_img": self.coc}
        if self.front is not None:
            images |= {"out_front_img": self.front.view, "out_front_state_img": self.front.state}
        return images

    @property
    def summed_textures(self) -> dict[str, Texture]:
        """The inputs of part_sum.comp.glsl."""
        front = {} if self.front is None else {"front_tx": self.front.view}
        return {"view_tx": self.view} | front
