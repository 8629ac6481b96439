"""Decide where a picture is blurred for parts of the lens, and blur it there."""

from dataclasses import dataclass, replace

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.render.defocus.layer_cuts import FAR_FROM_PX
from heatlens.render.defocus.listed_fragments import ListedFragments
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.overlap_zones import (
    FRONT_FROM_PX,
    NEAR_ZONES,
    OverlapZone,
    PartSurfaces,
)
from heatlens.render.defocus.part_views import PartViews
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.quality import GUESSED_PARTS, kernel_for, parts_for
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.resources import Texture

_FEW_PARTS_PX = 8.0  # largest coc behind the focus for which few parts are enough


@dataclass(frozen=True)
class SeenSurfaces:
    """The surfaces of a picture that parts of the lens may see.

    color, coc  RGBA without highlights, and signed coc in pixels
    lists       the surfaces behind those; None if none are known
    """

    color: Texture
    coc: Texture
    lists: ListedFragments | None


@dataclass(frozen=True)
class NearZone:
    """Where views of parts of the lens replace all layers, and the surfaces that they show."""

    surfaces: PartSurfaces
    zone: OverlapZone


class PartFields:
    """Blurs a picture for parts of the lens where surfaces of different blur overlap."""

    def __init__(self, passes: DefocusPasses, scratch: Scratch) -> None:
        self._passes, self._scratch = passes, scratch

    def find_near_zone(
        self, picture: UnmixedPicture, optics: Optics, settings: DefocusSettings
    ) -> Steps[NearZone | None]:
        """Return where views of parts of the lens replace all layers, or None if nowhere.

        These are zones around wide surfaces before the focus, if the settings and the lens allow
        parts. That needs known surfaces: what a near surface hides cannot be guessed well enough.
        """
        lists = picture.lists
        is_near = -optics.nearest_px > FRONT_FROM_PX
        if lists is None or lists.is_open or not (is_near and _can_use_parts(optics, settings)):
            return None
        surfaces = PartSurfaces(picture.color, picture.coc, lists, None, unmixed=picture)
        parts = parts_for(settings)
        zone = self._passes.part_views.find_zone(surfaces, optics, parts, self._scratch)
        yield self._scratch.end_pass(NEAR_ZONES)
        return None if zone is None else NearZone(surfaces, zone)

    # Where views of all depths replace the picture, a far field would be drawn for nothing: a
    # window behind leaves took 10.2 times the processor time of film, and 9.0 without it.
    def far_field(
        self,
        seen: SeenSurfaces,
        optics: Optics,
        settings: DefocusSettings,
        may_guess: bool,
        near: NearZone | None,
    ) -> Steps[PartViews | None]:
        """Return the far field, blurred in parts of the lens; None if it is blurred in layers.

        It is blurred in layers if the settings, the lens or the surfaces do not allow parts, and in
        the zones of `near`. With `may_guess`, surfaces behind those of the picture are guessed
        where none are known.
        """
        least_px, lists = FAR_FROM_PX * settings.proxy, seen.lists
        if not (_can_use_parts(optics, settings) and optics.farthest_px > 2 * least_px):
            return None
        is_guessed = lists is None and may_guess
        if is_guessed:
            guess = self._passes.far_guess
            lists = yield from guess.steps(seen.color, seen.coc, optics, least_px, self._scratch)
        if lists is None or lists.is_open:  # parts need a picture without alpha
            return None
        surfaces = PartSurfaces(seen.color, seen.coc, lists, least_px, is_guessed)
        parts = _far_parts_for(settings, optics, is_guessed)
        zone = self._passes.part_views.find_zone(
            surfaces,
            optics,
            parts,
            self._scratch,
            None if near is None else near.zone,
        )
        yield surfaces.pass_name
        if zone is None:
            self._scratch.end_pass(surfaces.pass_name)
            return None
        return (yield from self._views(surfaces, zone, optics, settings, parts))

    # The views show all surfaces, so that they replace the picture after all layers. Highlights are
    # drawn over them later. FLIP of a window behind leaves, focused on the window: .0710 in layers,
    # .0408 with views; on a person between them .0848 and .0456.
    def replace_around_near_surfaces(
        self, near: NearZone, optics: Optics, settings: DefocusSettings, out: Texture
    ) -> Steps[None]:
        """Replace `out` by views of parts of the lens in the zones of `near`."""
        parts = parts_for(settings)
        field = yield from self._views(near.surfaces, near.zone, optics, settings, parts)
        self._passes.part_views.over(field, out)

    def _views(
        self,
        surfaces: PartSurfaces,
        zone: OverlapZone,
        optics: Optics,
        settings: DefocusSettings,
        parts: int,
    ) -> Steps[PartViews]:
        """Return the mean view of all `parts` of the lens in `zone`.

        The memory of the passes before, and that of the views, is released when it has been used.
        """
        self._scratch.release_unowned()
        draft_kernel = kernel_for(replace(settings, quality=Quality.DRAFT))
        poles = self._passes.poles(
            self._scratch, f"{surfaces.name} poles", surfaces.coc.size, draft_kernel
        )
        steps = self._passes.part_views.steps(
            surfaces, zone, optics, parts, draft_kernel, poles, self._scratch
        )
        views = yield from steps
        self._scratch.release_unowned()
        return views


# Of a window behind leaves, focused on the window, the street behind it has a coc of up to 7.6 px:
# 7 parts and 19 gave the same FLIP, .0395. At 11 and 23 px, 7 parts were worse by .0006 to .0009.
def _far_parts_for(settings: DefocusSettings, optics: Optics, is_guessed: bool) -> int:
    """Return into how many parts the lens is cut for what is behind the focus."""
    parts = parts_for(settings, is_guessed)
    is_small = optics.farthest_px < _FEW_PARTS_PX * settings.proxy
    return min(parts, GUESSED_PARTS) if is_small and settings.parts <= 1 else parts


def _can_use_parts(optics: Optics, settings: DefocusSettings) -> bool:
    """Return whether the settings ask for parts of the lens, and the focus plane is level.

    With a tilted or split focus, surfaces cannot be put in order by their coc.
    """
    is_level = optics.line is None or optics.line.focus_offset.is_level
    return parts_for(settings) > 1 and is_level
