"""Hold the memory for the view of one part of the lens, which all parts use in turn."""

from dataclasses import dataclass

from heatlens.render.defocus.far_guess import WORD_BYTES
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.overlap_zones import PartSurfaces
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.gpu.device import Buffer, StorageBuffer, Texture

_LINK_BYTES = 12  # bytes for each surface in lib/part_link.lib.glsl
_PIXEL_BYTES = 24  # bytes for the two surfaces of each pixel in lib/pixel_surface.lib.glsl


@dataclass(frozen=True)
class FrontMemory:
    """The memory for the pixels taken apart, and for what a part sees in front of the focus.

    pixels  the surfaces of each pixel (part_pixels.comp.glsl), the same for all parts
    view   RGBA, rgb times coverage, a coverage; then the same, blurred
    state  RG, diameter of the part's disc in pixels and coverage, as that of a `Layer`
    coc    that diameter, extended beyond the surfaces
    rows   scratch memory of `CocFillPass`
    """

    pixels: Buffer
    view: Texture
    state: Texture
    coc: Texture
    rows: tuple[Buffer, Buffer]

    @staticmethod
    def of(size: tuple[int, int], scratch: Scratch) -> "FrontMemory":
        """Return the memory for a view of the size of the picture."""
        row_bytes = CocFillPass.rows_bytes(size)
        return FrontMemory(
            pixels=scratch.buffer("pixel surfaces", _PIXEL_BYTES * size[0] * size[1]),
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
    links  for each surface, the previous one of its list
    """

    view: Texture
    coc: Texture
    heads: Buffer
    links: Buffer
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
            front=FrontMemory.of((width, height), scratch) if surfaces.has_all_depths else None,
        )

    @property
    def list_buffers(self) -> dict[str, StorageBuffer]:
        """The lists of the surfaces that have moved to each cell."""
        return {"head_block": self.heads, "link_block": self.links}

    @property
    def surface_buffers(self) -> dict[str, StorageBuffer]:
        """The lists, and the surfaces of the pixels if these are taken apart."""
        if self.front is None:
            return self.list_buffers
        return self.list_buffers | {"pixel_surface_block": self.front.pixels}

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
