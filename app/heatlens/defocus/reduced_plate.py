"""Reduce a plate to proxy size, and keep the reduced plate while lens and settings change."""

from dataclasses import dataclass, replace

import moderngl

from heatlens.defocus.cutout_pass import CutoutTextures
from heatlens.defocus.listed_fragments import FragmentBuffers
from heatlens.defocus.optics import Optics
from heatlens.defocus.plate_passes import ProxyPass, proxy_size
from heatlens.defocus.proxy_lists import (
    FRAGMENT_BYTES,
    ProxyListRoom,
    ProxyListsPass,
    proxy_list_capacity,
)
from heatlens.defocus.quality import layers_for
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.steps import Steps
from heatlens.model.shot.settings import DefocusSettings

_NOTHING_HELD = 1.0, False


@dataclass(frozen=True)
class PlateTextures:
    """A plate on the GPU.

    color      RGBA, scene-linear
    depth      metres, or signed coc in pixels for a plate that has no distances
    fragments  the surfaces along the ray of each pixel; None if the plate has no lists
    places     RGBA, subpixel positions of the light; None if they are not known
    cutout     what is kept from the blur; None if all is blurred
    """

    color: moderngl.Texture
    depth: moderngl.Texture
    fragments: FragmentBuffers | None = None
    places: moderngl.Texture | None = None
    cutout: CutoutTextures | None = None


class ReducedPlate:
    """The plate at proxy size, in textures that live from picture to picture."""

    def __init__(
        self, ctx: moderngl.Context, plate_pass: ProxyPass, lists_pass: ProxyListsPass
    ) -> None:
        self._ctx = ctx
        self._pass = plate_pass
        self._lists_pass = lists_pass
        self._held = _NOTHING_HELD  # scale of the plate that is kept, and whether it has lists

    def steps(
        self, whole: PlateTextures, optics: Optics, settings: DefocusSettings, scratch: Scratch
    ) -> Steps[PlateTextures]:
        """Return the plate at the scale of `settings`; reduce it only if that has yet to be done.

        A plate without lists gets some at its silhouettes, if its depth and the method allow it.
        """
        proxy = settings.proxy
        size = proxy_size(whole.color.size, proxy)
        color = scratch.texture("proxy colour", size, 4)
        depth = scratch.texture("proxy depth", size, 1)
        places = scratch.texture("proxy places", size, 4, "f2")
        has_lists = optics.line is not None and layers_for(settings) > 1
        room = self._room(whole.fragments, size, scratch) if has_lists else None
        cutout = None if whole.cutout is None else _cutout_room(whole.cutout, size, scratch)
        if self._held != (proxy, has_lists):
            scale = proxy if optics.line is None else 1.0
            self._pass.run(whole.color, whole.depth, scale, color, depth, places)
            if room is not None:
                self._list(whole, places, room, depth)
            if whole.cutout is not None and cutout is not None:
                for light, out in cutout.lights_of(whole.cutout):
                    self._pass.run(light, whole.cutout.depth, scale, out, cutout.depth)
            self._held = proxy, has_lists
            yield scratch.passed("proxy")
        return PlateTextures(color, depth, None if room is None else room.held, places, cutout)

    def _list(
        self,
        whole: PlateTextures,
        places: moderngl.Texture,
        room: ProxyListRoom,
        depth: moderngl.Texture,
    ) -> None:
        if whole.fragments is None:
            self._lists_pass.list_silhouettes(whole.color, whole.depth, places, room, depth)
        else:
            self._lists_pass.merge(whole.color, whole.depth, whole.fragments, room, depth)

    def _room(
        self, fragments: FragmentBuffers | None, size: tuple[int, int], scratch: Scratch
    ) -> ProxyListRoom:
        capacity = proxy_list_capacity(self._ctx, fragments, size)
        starts = scratch.buffer("proxy starts", 4 * (size[0] * size[1] + 1))
        words = scratch.buffer("proxy fragments", FRAGMENT_BYTES * capacity)
        held = FragmentBuffers(
            starts,
            words,
            size,
            is_measured=fragments is None or fragments.is_measured,
            is_exact=fragments is None or fragments.is_exact,
        )
        return ProxyListRoom(held, capacity, scratch.buffer("proxy fragment count", 4))

    def forget(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._held = _NOTHING_HELD


def _cutout_room(whole: CutoutTextures, size: tuple[int, int], scratch: Scratch) -> CutoutTextures:
    """Return a cutout of another size, but with the same rest, which is reduced as a plate is."""
    return replace(
        whole,
        light=scratch.texture("proxy cutout", size, 4),
        alpha=None if whole.alpha is None else scratch.texture("proxy cutout alpha", size, 4),
        depth=scratch.texture("proxy cutout depth", size, 1),
        ground=None if whole.ground is None else scratch.texture("proxy ground", size, 4),
    )
