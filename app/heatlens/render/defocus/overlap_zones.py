"""Find where surfaces of different blur overlap, for parts of the lens."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from heatlens.render.defocus.far_guess import FAR_PARTS, FRAGMENT_BYTES, GUESSED_FROM_PX
from heatlens.render.defocus.listed_fragments import ListedFragments
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.quality import GUESSED_PARTS
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.tile_mask import SegmentPass, TileMask
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.defocus.view_tiles import ViewTiles, list_tiles, tiles_near
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, blocks_for, pixel_groups
from heatlens.render.gpu.resources import StorageBuffer, Texture
from heatlens.render.gpu.shader_constants import FAR_BLOCK, FAR_WHOLE_PX_2

_MARGIN_PX = 4.0  # as in overlap_edges.comp.glsl
_FEATHER_PX = 2 * FAR_BLOCK  # part_over.comp.glsl uses the parts so far beyond a zone
# Least coc of both surfaces at an edge that makes a zone, and coc below which layers show thin
# surfaces better: a guess is worth less, and knows nothing of what a thin surface hides.
_KNOWN_EDGES: dict[str, object] = {"nearest_px": 0.0, "thin_coc_px": 4.5}
_GUESSED_EDGES: dict[str, object] = {"nearest_px": GUESSED_FROM_PX, "thin_coc_px": 16.0}
# reach^2 - distance^2 from which zones have grown. Until then, layers are blurred with the far
# field and without it; with FAR_WHOLE_PX_2 here, that was so for every coc up to 14.6 px.
_GROWN_PX_2 = 48.0
FRONT_FROM_PX = 4.0  # least coc of a wide surface in front of the focus whose edge makes a zone
NEAR_ZONES = "near zones"  # name of the pass that finds zones around wide near surfaces
WHOLE_PARTS = "whole parts"  # name of the step for views of all surfaces
_ALL_PX = -1e30  # smaller than every coc
# Share of what the lens sees around a block that must be seen in the picture, for a guess to be
# used at all, and to be used wholly.
_SURE_FROM, _SURE_TO = 0.8, 1.0


@dataclass(frozen=True)
class PartSurfaces:
    """The surfaces that the parts of the lens see: those in the picture, and those behind them.

    color       RGBA of the picture without highlights
    coc         signed coc of the picture, pixels
    lists       the surfaces behind those in the picture
    least_px    coc from which a surface is seen; None for all surfaces
    is_guessed  the lists are guessed, not known
    unmixed     the picture with its silhouettes unmixed, if all surfaces are seen
    """

    color: Texture
    coc: Texture
    lists: ListedFragments
    least_px: float | None
    is_guessed: bool = False
    unmixed: UnmixedPicture | None = None

    @property
    def front_first(self) -> int:
        """The index of the first pixel of the picture; indices of fragments come before it."""
        return self.lists.packed_lists.words.size // FRAGMENT_BYTES

    @property
    def has_all_depths(self) -> bool:
        """True if all surfaces are seen, and not only those behind the focus."""
        return self.least_px is None

    @property
    def name(self) -> str:
        """The name of the memory of their views."""
        return "whole" if self.has_all_depths else "far"

    @property
    def pass_name(self) -> str:
        """The name of the pass that draws their views."""
        return WHOLE_PARTS if self.has_all_depths else FAR_PARTS

    @property
    def defines(self) -> dict[str, object]:
        """The version of the programs."""
        return {"ALL_DEPTHS": 1} if self.has_all_depths else {}

    def widest_px(self, optics: Optics) -> float:
        """Return the largest coc of the surfaces, pixels."""
        return max(optics.farthest_px, -optics.nearest_px if self.has_all_depths else 0.0)

    @property
    def textures(self) -> dict[str, Texture]:
        """The textures of part_surfaces.comp.glsl."""
        if self.unmixed is not None:
            return self.unmixed.textures()
        return {"coc_tx": self.coc, "color_tx": self.color}

    @property
    def surface_count(self) -> int:
        """The number of surfaces; with pixels taken apart, each pixel has two."""
        width, height = self.coc.size
        return self.front_first + width * height * (2 if self.has_all_depths else 1)

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms of lib/part_surfaces.lib.glsl."""
        return self.lists.uniforms | {
            "least_px": _ALL_PX if self.least_px is None else self.least_px
        }

    @property
    def number_uniforms(self) -> dict[str, object]:
        """The uniforms of lib/surface_numbers.lib.glsl."""
        return self.uniforms | {"front_first": self.front_first}


@dataclass(frozen=True)
class OverlapZone:
    """Where parts of the lens replace layers.

    blocks  for each block, the square of the reach of edges less the squared distance to them,
            pixels^2 (part_over.comp.glsl)
    tiles   the tiles in which the view of a part is needed
    listed  the tiles on which the passes of a view run
    growth  how far the zones have grown since they appeared, above 0 up to 1
    disc_radius_px  radius of the largest disc of a part
    least_shares  (rows, columns) of blocks, 0 to 1: the least weight of the view in each block
    """

    blocks: Texture
    tiles: TileMask
    listed: ViewTiles
    growth: float
    disc_radius_px: float
    least_shares: NDArray[np.float32]

    @property
    def buffers(self) -> dict[str, StorageBuffer]:
        """The buffer of lib/tile_mask.lib.glsl."""
        return {"tile_mask_block": self.tiles.words}


class OverlapZones:
    """Finds the zones in which parts of the lens replace layers."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._edges = ComputeProgram(ctx, "defocus/overlap_edges.comp.glsl")
        self._zone = ComputeProgram(ctx, "defocus/overlap_zone.comp.glsl")

    def find(
        self,
        surfaces: PartSurfaces,
        optics: Optics,
        parts: int,
        scratch: Scratch,
        covering: OverlapZone | None = None,
    ) -> OverlapZone | None:
        """Return the zones for `parts` parts of the lens, or None if there are none.

        Zones fade out where those of `covering` replace the picture in any case. It waits for the
        GPU.
        """
        blocks, seen = self._spread_edges(surfaces, optics, parts, scratch)
        radius_px = max(optics.disc.half_extents) * surfaces.widest_px(optics) / 2
        excess_px_2 = _floats(blocks, 2)
        if covering is not None:
            excess_px_2[..., 0] *= 1.0 - covering.least_shares
            blocks.write(excess_px_2.tobytes())
        if surfaces.is_guessed:
            sure = guess_shares(_floats(seen, 1)[..., 0], round(radius_px / FAR_BLOCK))
            excess_px_2[..., 0] = np.minimum(excess_px_2[..., 0], FAR_WHOLE_PX_2) * sure
            blocks.write(excess_px_2.tobytes())
        in_zone = (excess_px_2[..., 0] > 0.0) & (excess_px_2[..., 1] < FAR_WHOLE_PX_2)
        if not in_zone.any():
            return None
        growth = min(float(excess_px_2[..., 0].max()) / _GROWN_PX_2, 1.0)
        needed = tiles_near(in_zone, _FEATHER_PX)
        tiles = self._mask_tiles(needed, surfaces, scratch)
        listed = list_tiles(needed, radius_px, surfaces.name, scratch)
        disc_px = radius_px * _part_scale(surfaces, parts)
        return OverlapZone(blocks, tiles, listed, growth, disc_px, least_shares(excess_px_2))

    # Parts are used in zones only, because for the whole picture they were worse than layers where
    # surfaces do not overlap (a corridor: FLIP .0261, in zones .0174, in layers alone .0167). The
    # reach of an edge is stored as its square less the squared distance: rows and columns one after
    # the other then give round zones. The reach is multiplied by how far the blur and its step have
    # passed their limits; zones that begin as whole blocks made a slow focus pull flash by up to
    # 14.6 levels.
    def _spread_edges(
        self, surfaces: PartSurfaces, optics: Optics, parts: int, scratch: Scratch
    ) -> tuple[Texture, Texture]:
        """Find the edges of surfaces of different blur, and spread their reach over the blocks.

        Return RG of a pixel for each block of FAR_BLOCK x FAR_BLOCK pixels: the square of the reach
        of edges less the squared distance to them, pixels^2; red for wide surfaces, green for thin.
        Return also R for each block: the share of it, 0 to 1, that shows surfaces behind the focus.
        """
        size = blocks_for(surfaces.coc.size, FAR_BLOCK)
        name = surfaces.name
        zone, zone_rows = (scratch.texture(f"{name} {it}", size, 2) for it in ("zone", "zone rows"))
        seen = scratch.texture(f"{name} seen", size, 1)
        self._edges.version(**surfaces.defines).dispatch(
            pixel_groups(size),
            textures={"coc_tx": surfaces.coc},
            images={"out_zone_img": zone, "out_seen_img": seen},
            buffers=surfaces.lists.buffers,
            uniforms=surfaces.uniforms
            | {"part_scale": _part_scale(surfaces, parts)}
            | _edge_uniforms(surfaces),
        )
        widest_px = -optics.nearest_px if surfaces.has_all_depths else optics.farthest_px
        reach_px = max(optics.disc.half_extents) * widest_px / 2 + _MARGIN_PX
        reach = {"reach_blocks": min(math.ceil(reach_px / FAR_BLOCK), max(size))}
        for source, target, direction in ((zone, zone_rows, (1, 0)), (zone_rows, zone, (0, 1))):
            self._zone.dispatch(
                pixel_groups(size),
                textures={"zone_tx": source},
                images={"out_zone_img": target},
                uniforms=reach | {"axis": direction},
            )
        return zone, seen

    def _mask_tiles(
        self, needed: NDArray[np.bool_], surfaces: PartSurfaces, scratch: Scratch
    ) -> TileMask:
        """Return the mask of the `needed` tiles of the picture."""
        size, name = surfaces.coc.size, surfaces.name
        words = scratch.parts(f"{name} tiles", 1, TileMask.bytes_for(size))
        words.whole.write(needed.astype(np.uint32).tobytes())
        segment_memory = scratch.parts(f"{name} segments", 2, SegmentPass.bytes_for(size))
        (mask,) = self._segments.find([size], words, segment_memory)
        return mask

    @cached_property
    def _segments(self) -> SegmentPass:
        return SegmentPass(self._ctx)


def _floats(blocks: Texture, channels: int) -> NDArray[np.float32]:
    """Return the values (rows, columns, channels) of a texture of float32."""
    values = np.frombuffer(blocks.read(), np.float32)
    return values.reshape(*blocks.size[::-1], channels).copy()


# A guess extends what is seen, and layers mix what is seen: where near things hide much, things
# behind the focus that they hide are missing from the guess, and its picture was worse. Of scenes
# of grass and flowers, FLIP by a guess was up to .0089 above that of layers, with these limits
# nowhere; its largest gains, .023 and .025, stay.
def guess_shares(seen_shares: NDArray[np.float32], reach: int) -> NDArray[np.float32]:
    """Return for each block (rows, columns) how far a guess may be used, 0 to 1.

    `seen_shares` (rows, columns) is the share of each block that shows surfaces behind the focus.
    The mean over all blocks up to `reach` away, to the sides and up and down, decides.
    """
    rows, columns = seen_shares.shape
    sums = np.pad(seen_shares.astype(np.float64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    (top, bottom), (left, right) = (
        np.clip(np.arange(count) + np.array([[-reach], [reach + 1]]), 0, count)
        for count in (rows, columns)
    )
    in_rows = sums[bottom] - sums[top]
    areas = np.outer(bottom - top, right - left)
    means = (in_rows[:, right] - in_rows[:, left]) / areas
    sure = np.clip((means - _SURE_FROM) / (_SURE_TO - _SURE_FROM), 0.0, 1.0)
    return np.asarray(sure, np.float32)


def least_shares(excess_px_2: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return for each block (rows, columns) the least weight, 0 to 1, of the views at its pixels.

    `excess_px_2` (rows, columns, 2) is what `OverlapZone.blocks` has. A pixel's weight is a mean
    over blocks up to two away (part_over.comp.glsl), so that it is at least the least of these.
    """
    wide, thin = np.moveaxis(np.clip(excess_px_2 / FAR_WHOLE_PX_2, 0.0, 1.0), -1, 0)
    shares = wide * (1.0 - thin)
    for axis in (0, 1):
        padded = np.pad(shares, [(2, 2) if axis == it else (0, 0) for it in (0, 1)], mode="edge")
        shares = sliding_window_view(padded, 5, axis=axis).min(axis=-1)
    return np.asarray(shares)


def _edge_uniforms(surfaces: PartSurfaces) -> dict[str, object]:
    """Return the limits at which the edges of surfaces make zones."""
    if surfaces.has_all_depths:
        return {"nearest_px": FRONT_FROM_PX}
    return _GUESSED_EDGES if surfaces.is_guessed else _KNOWN_EDGES


def _part_scale(surfaces: PartSurfaces, parts: int) -> float:
    """Return the diameter of a part of the lens over that of the lens, for finding zones.

    Zones of guessed surfaces are found for at most GUESSED_PARTS parts.
    """
    return float(min(parts, GUESSED_PARTS if surfaces.is_guessed else parts) ** -0.5)
