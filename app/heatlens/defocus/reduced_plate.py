"""Reduce a plate to proxy size, and keep the reduced plate while lens and settings change."""

from dataclasses import dataclass, replace

import moderngl

from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.defocus.optics import Optics
from heatlens.defocus.plate_passes import ProxyPass, proxy_size
from heatlens.defocus.proxy_lists import (
    FRAGMENT_BYTES,
    ProxyListRoom,
    ProxyListsPass,
    proxy_list_capacity,
)
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.steps import Steps

_NOTHING_HELD = 1.0


@dataclass(frozen=True)
class PlateTextures:
    """A plate on the GPU.

    color      RGBA, scene-linear
    depth      metres, or signed coc in pixels for a plate that has no distances
    fragments  the surfaces along the ray of each pixel; None if the plate has no lists
    places     RGBA, subpixel positions of the light; None if they are not known
    """

    color: moderngl.Texture
    depth: moderngl.Texture
    fragments: FragmentBuffers | None = None
    places: moderngl.Texture | None = None


class ReducedPlate:
    """The plate at proxy size, in textures that live from picture to picture."""

    def __init__(
        self, ctx: moderngl.Context, plate_pass: ProxyPass, lists_pass: ProxyListsPass
    ) -> None:
        self._ctx = ctx
        self._pass = plate_pass
        self._lists_pass = lists_pass
        self._held = _NOTHING_HELD  # the proxy scale of the reduced plate that is kept

    def steps(
        self, whole: PlateTextures, optics: Optics, proxy: float, scratch: Scratch
    ) -> Steps[PlateTextures]:
        """Return the plate at the scale `proxy`; reduce it only if that has not been done yet."""
        size = proxy_size(whole.color.size, proxy)
        color = scratch.texture("proxy colour", size, 4)
        depth = scratch.texture("proxy depth", size, 1)
        places = scratch.texture("proxy places", size, 4, "f2")
        room = None if whole.fragments is None else self._room(whole.fragments, size, scratch)
        if self._held != proxy:
            scale = proxy if optics.line is None else 1.0
            self._pass.run(whole.color, whole.depth, scale, color, depth, places)
            if whole.fragments is not None and room is not None:
                self._lists_pass.run(whole.color, whole.depth, whole.fragments, room, depth)
            self._held = proxy
            yield scratch.passed("proxy")
        return PlateTextures(color, depth, None if room is None else room.held, places)

    def _room(
        self, fragments: FragmentBuffers, size: tuple[int, int], scratch: Scratch
    ) -> ProxyListRoom:
        capacity = proxy_list_capacity(self._ctx, fragments, size)
        starts = scratch.buffer("proxy starts", 4 * (size[0] * size[1] + 1))
        words = scratch.buffer("proxy fragments", FRAGMENT_BYTES * capacity)
        held = replace(fragments, starts=starts, words=words, size=size, origin=(0, 0), stride=0)
        return ProxyListRoom(held, capacity, scratch.buffer("proxy fragment count", 4))

    def forget(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._held = _NOTHING_HELD
