"""Blur surfaces behind the focus for each part of the lens, where different blurs overlap.

The lens is cut into parts of equal area. The view of each part behind the focus is assembled from
the known surfaces, so that they hide each other correctly, and diffused by the small disc of that
part. The mean of all views replaces the layers behind the focus near the edges of such surfaces.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import moderngl
import numpy as np
from numpy.typing import NDArray

from heatlens.defocus.blur_pass import BlurPass, BlurTargets, Diffusion
from heatlens.defocus.far_guess import FAR_PARTS, FRAGMENT_BYTES, GUESSED_FROM_PX, WORD_BYTES
from heatlens.defocus.kernels import Kernel
from heatlens.defocus.layer_cuts import Cut, LayerCut
from heatlens.defocus.lens_parts import lens_parts
from heatlens.defocus.listed_fragments import ListedFragments
from heatlens.defocus.optics import Optics
from heatlens.defocus.pixel_list import PixelBands
from heatlens.defocus.quality import GUESSED_PARTS, parts_for
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.steps import Steps
from heatlens.gpu.program import ComputeProgram, groups_for, pixel_groups
from heatlens.gpu.shader_constants import FAR_BLOCK, FAR_WHOLE
from heatlens.model.shot.settings import LAYERS_MAX, DefocusSettings

FAR_FROM_PX = 1.5  # coc of the whole picture from which a surface is behind the focus
_SOFTNESS = 0.2
_MARGIN_PX = 4.0  # as in far_edges.comp.glsl
_LINK_BYTES = 8
_NO_PART = np.zeros((1, 4))
# Least coc of both surfaces at an edge that makes a zone, and coc below which layers show thin
# surfaces better: a guess is worth less, and knows nothing of what a thin surface hides.
_KNOWN_EDGES: dict[str, object] = {"nearest_px": 0.0, "thin_coc_px": 4.5}
_GUESSED_EDGES: dict[str, object] = {"nearest_px": GUESSED_FROM_PX, "thin_coc_px": 16.0}


def is_in_parts(optics: Optics, settings: DefocusSettings) -> bool:
    """Return whether the far field is blurred in parts, if its surfaces are known or guessed."""
    is_far = optics.farthest_px > 2 * FAR_FROM_PX * settings.proxy
    is_level = optics.line is None or optics.line.lean.is_level
    return parts_for(settings) > 1 and is_far and is_level


def with_far_cut(cuts: list[LayerCut], proxy: float) -> list[LayerCut]:
    """Return the layers, far to near, with an additional cut where the far field begins."""
    at_px = FAR_FROM_PX * proxy
    cut = Cut(at_px, at_px * _SOFTNESS)
    number = next((i for i, layer in enumerate(cuts) if layer.near.at_px < at_px), None)
    if number is None:  # everything is farther
        return [*cuts[:-1], replace(cuts[-1], near=cut)]
    far, near = replace(cuts[number], near=cut), replace(cuts[number], far=cut)
    before, after = cuts[:number], cuts[number + 1 :]
    if before and far.far.at_px < 2 * at_px:  # too close to the next cut, which it replaces
        before, far = before[:-1], replace(before[-1], near=cut)
    if len(before) + 2 + len(after) > LAYERS_MAX:
        before, far = before[:-1], replace(far, far=before[-1].far)
    return [*before, far, near, *after]


@dataclass(frozen=True)
class FarField:
    """The view of the parts of the lens behind the focus.

    total  rgb times the known share, and that share: the mean of all parts
    zone   blocks in which it is used (far_zone.comp.glsl)
    """

    total: moderngl.Texture
    zone: moderngl.Texture


@dataclass(frozen=True)
class FarSurfaces:
    """The picture without highlights, the surfaces behind it, and the coc where far begins."""

    color: moderngl.Texture
    coc: moderngl.Texture
    lists: ListedFragments
    least_px: float
    is_guessed: bool = False  # the surfaces behind it

    @property
    def front_first(self) -> int:
        """The number of the first pixel, after those of all fragments."""
        return self.lists.held.words.size // FRAGMENT_BYTES

    @property
    def textures(self) -> dict[str, moderngl.Texture]:
        """The textures of lib/far_fragments.lib.glsl."""
        return {"color_tx": self.color, "coc_tx": self.coc}

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms of lib/far_fragments.lib.glsl."""
        own: dict[str, object] = {"least_px": self.least_px, "front_first": self.front_first}
        return self.lists.uniforms | own


@dataclass(frozen=True)
class _Room:
    """The memory for the view of one part."""

    view: moderngl.Texture
    coc: moderngl.Texture
    heads: moderngl.Buffer
    links: moderngl.Buffer

    @staticmethod
    def of(what: FarSurfaces, scratch: Scratch) -> "_Room":
        width, height = what.coc.size
        surfaces = what.front_first + width * height
        return _Room(
            scratch.texture("far view", (width, height), 4),
            scratch.texture("far coc", (width, height), 1),
            scratch.buffer("far heads", WORD_BYTES * (width + 1) * (height + 1)),
            scratch.buffer("far links", _LINK_BYTES * surfaces),
        )


class FarPartsPass:
    """Renders the far field in parts, which replaces layers."""

    def __init__(self, ctx: moderngl.Context, blur: BlurPass) -> None:
        self._ctx, self._blur, self._bands = ctx, blur, PixelBands(ctx)
        self._programs: dict[tuple[str, bool], ComputeProgram] = {}

    def _program(self, name: str, places: int = 1) -> ComputeProgram:
        """Return a program, which is built when it is first used."""
        key = name, places > 1
        if key not in self._programs:
            defines = {"PART_VARIES": 1} if places > 1 else {}
            self._programs[key] = ComputeProgram(self._ctx, f"far_{name}.comp.glsl", defines)
        return self._programs[key]

    def steps(
        self,
        what: FarSurfaces,
        optics: Optics,
        parts: int,
        kernel: Kernel,
        poles: moderngl.TextureArray,
        scratch: Scratch,
    ) -> Steps[FarField | None]:
        """Diffuse the view of each part; return the mean view and the zone for it.

        Return None if there is no zone.
        """
        zone = self._zone(what, optics, parts, scratch)
        yield FAR_PARTS
        if not _has_any(zone):
            scratch.passed(FAR_PARTS)
            return None
        room = _Room.of(what, scratch)
        total = scratch.texture("far sum", what.coc.size, 4)
        yield from self._added(room, total, None)
        for part in lens_parts(optics.disc, what.coc.size, parts):
            yield from self._viewed(what, part, room)
            seen = Diffusion(room.view, room.coc, kernel, optics.disc.half_extents)
            for _ in self._blur.steps(seen, BlurTargets(poles, room.view)):
                yield FAR_PARTS
            yield from self._added(room, total, part)
        yield scratch.passed(FAR_PARTS)
        return FarField(total, zone)

    def _viewed(self, what: FarSurfaces, part: NDArray[np.float64], room: _Room) -> Iterator[str]:
        """Write what one part of the lens sees, and the discs of that part."""
        linked = {"head_block": room.heads, "link_block": room.links}
        images = {"out_view_img": room.view, "out_coc_img": room.coc}
        for name, out in (("links", {}), ("view", images)):
            yield from _named(
                self._bands.run(
                    self._program(name, len(part)),
                    what.coc.size,
                    what.uniforms | _part_uniforms(part),
                    textures=what.textures,
                    images=out,
                    buffers=what.lists.buffers | linked,
                )
            )

    def _added(
        self, room: _Room, total: moderngl.Texture, part: NDArray[np.float64] | None
    ) -> Iterator[str]:
        """Add the blurred view of a part to the sum, or begin one without a part."""
        width, height = total.size
        own = _NO_PART if part is None else part
        return _named(
            self._bands.run(
                self._program("sum", len(own)),
                (width + 1, height + 1),
                _part_uniforms(own) | {"begins": part is None},
                textures={"view_tx": room.view},
                images={"sum_img": total},
                buffers={"head_block": room.heads},
            )
        )

    def _zone(
        self, what: FarSurfaces, optics: Optics, parts: int, scratch: Scratch
    ) -> moderngl.Texture:
        """Find the zones in which surfaces of different blur overlap."""
        size = zone_size(what.coc.size)
        part_scale = min(parts, GUESSED_PARTS if what.is_guessed else parts) ** -0.5
        zone, rows = (scratch.texture(name, size, 2) for name in ("far zone", "far zone rows"))
        groups = pixel_groups(size)
        self._program("edges").dispatch(
            groups,
            textures=what.textures,
            images={"out_zone_img": zone},
            buffers=what.lists.buffers,
            uniforms=what.uniforms
            | {"part_scale": part_scale}
            | (_GUESSED_EDGES if what.is_guessed else _KNOWN_EDGES),
        )
        widest = max(optics.disc.half_extents) * optics.farthest_px / 2 + _MARGIN_PX
        reach = {"reach_blocks": min(math.ceil(widest / FAR_BLOCK), max(size))}
        for one, other, along in ((zone, rows, (1, 0)), (rows, zone, (0, 1))):
            self._program("zone").dispatch(
                groups,
                textures={"zone_tx": one},
                images={"out_zone_img": other},
                uniforms=reach | {"along": along},
            )
        return zone

    def over(self, field: FarField, out: moderngl.Texture) -> None:
        """Write the far field over its zones of `out`, which holds the layers behind the focus."""
        self._program("over").dispatch(
            pixel_groups(out.size),
            textures={"sum_tx": field.total, "zone_tx": field.zone},
            images={"out_color_img": out},
        )


def zone_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return how many blocks cover a picture of `size`."""
    return groups_for(size[0], FAR_BLOCK), groups_for(size[1], FAR_BLOCK)


def _has_any(zone: moderngl.Texture) -> bool:
    """Return whether any block is in a zone, see far_over.comp.glsl; wait for the GPU."""
    wide, thin = np.frombuffer(zone.read(), np.float32).reshape(-1, 2).T
    return bool(((wide > 0.0) & (thin < FAR_WHOLE)).any())


def _part_uniforms(part: NDArray[np.float64]) -> dict[str, object]:
    """Return the uniform of lib/lens_part.lib.glsl."""
    places = [tuple(place) for place in part]
    return {"lens_part": places if len(places) > 1 else places[0]}


def _named(steps: Iterator[None]) -> Iterator[str]:
    for _ in steps:
        yield FAR_PARTS
