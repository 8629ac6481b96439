"""Blur a picture in layers, which are composited far to near, and draw its highlights as discs.

1. Split the picture into highlights and the light to diffuse.
2. Unmix the pixels of silhouettes.
3. Find the zones around wide surfaces before the focus, and the far field outside them.
4. For each layer, in its visible tiles and at the size that its blur allows: blur (`LayerBlur`:
   split it off, fill hidden pixels, extend the coc, diffuse) and composite.
5. In the zones, replace that by views of parts of the lens.
6. Draw the highlights.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.defocus.blur_pass import BlurTargets
from heatlens.render.defocus.cutout_pass import SharpPart
from heatlens.render.defocus.highlights.highlight_list import HighlightBuffers
from heatlens.render.defocus.highlights.highlight_shadow import RayMemory, nodes_bytes
from heatlens.render.defocus.highlights.highlight_split import (
    ListsWithoutHighlights,
    Surroundings,
    WithoutHighlights,
)
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.layer_blur import LayerBlur
from heatlens.render.defocus.layer_cuts import FAR_FROM_PX, LayerCut, layer_cuts, with_far_cut
from heatlens.render.defocus.layer_plan import LayerPlan, layer_plans
from heatlens.render.defocus.listed_fragments import ListedFragments
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.part_fields import PartFields, SeenSurfaces
from heatlens.render.defocus.part_views import PartViews
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pixel_list import list_bytes
from heatlens.render.defocus.quality import kernel_for, layers_for
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import ONLY, Steps, Turn
from heatlens.render.defocus.tile_mask import tile_count
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.program import blocks_for
from heatlens.render.gpu.resources import Texture


@dataclass(frozen=True, eq=False)
class LayeredPicture:
    """A picture to blur in layers.

    color, coc      RGBA, and signed coc in pixels
    has_highlights  bright pixels are drawn as discs
    lists           the surfaces behind the visible ones; None if none are known
    sharp           the part that stays sharp; None if all is blurred
    positions       RGBA, subpixel positions of the light; None if they are not known
    may_guess       surfaces behind the focus may be guessed for parts of the lens
    enlarged        how many times the blurred picture is enlarged before discs are drawn
    """

    color: Texture
    coc: Texture
    has_highlights: bool
    lists: ListedFragments | None = None
    sharp: SharpPart | None = None
    positions: Texture | None = None
    may_guess: bool = False
    enlarged: int = 1


def _plan_layers(
    optics: Optics, settings: DefocusSettings, far: PartViews | None, size: tuple[int, int]
) -> list[LayerPlan]:
    """Return the layers of a picture of this size, with a cut before the far field if any."""
    cuts = layer_cuts(optics.occupied_px, optics.gaps_px, layers_for(settings), settings.proxy)
    if far is not None:
        cuts = with_far_cut(cuts, settings.proxy)
    return layer_plans(cuts, optics, size)


def _nearest_coc_px(cut: LayerCut) -> float:
    """Return the coc in pixels up to which a layer holds surroundings of the sharp part."""
    return -math.inf if cut.is_nearest else cut.near.at_px + cut.near.half_width_px


class LayeredBlur:
    """Blurs pictures in layers; calls `report_layers` with the layers done and their number."""

    def __init__(
        self, passes: DefocusPasses, scratch: Scratch, report_layers: Callable[[int, int], None]
    ) -> None:
        self._passes = passes
        self._scratch = scratch
        self._report_layers = report_layers
        self._layer = LayerBlur(passes, scratch)
        self._parts = PartFields(passes, scratch)

    def steps(
        self,
        source: LayeredPicture,
        optics: Optics,
        settings: DefocusSettings,
        name: str,
        turn: Turn = ONLY,
    ) -> Steps[Texture]:
        """Return the blurred picture, RGBA, in the texture called `name`, as `turn` of all work."""
        color, coc, lists, sharp = source.color, source.coc, source.lists, source.sharp
        highlights = around = None
        if source.has_highlights:
            split = self._allocate_split(color.size, lists)
            kernel = kernel_for(settings)
            highlights = yield from self._split_highlights(source, kernel, optics, split)
            color, around = split.diffuse, split.around
            lists = None if split.lists is None else split.lists.lists_to_diffuse
        picture = yield from self._split_silhouettes(color, coc, optics, lists, around)
        find_near = self._parts.find_near_zone(picture, optics, settings)
        near = (yield from find_near) if sharp is None else None
        surfaces = SeenSurfaces(color, coc, lists)
        far = yield from self._parts.far_field(surfaces, optics, settings, source.may_guess, near)
        # While the far field fades in, a picture without it is mixed in: its start must not jump.
        fading_far = far if far is not None and far.zone.growth < 1.0 else None
        first_turn, second_turn = turn.halves if fading_far else (turn, turn)
        out = yield from self._composite_layers(
            picture, optics, settings, far, sharp, name, first_turn
        )
        if fading_far is not None:
            without_far = yield from self._composite_layers(
                picture, optics, settings, None, sharp, "without far", second_turn
            )
            self._passes.part_views.mix(without_far, fading_far, out)
            yield self._scratch.end_pass("composite")
        if near is not None:
            yield from self._parts.replace_around_near_surfaces(near, optics, settings, out)
        if highlights is not None:
            out = self._enlarge(out, source.enlarged)
            yield from self._draw_highlights(highlights, picture, optics, out, sharp)
        self._scratch.end_pass("highlights drawn")  # without highlights too; no work, so no step
        return out

    def _composite_layers(
        self,
        picture: UnmixedPicture,
        optics: Optics,
        settings: DefocusSettings,
        far: PartViews | None,
        sharp: SharpPart | None,
        name: str,
        turn: Turn,
    ) -> Steps[Texture]:
        """Blur the layers of a picture, and composite them in the texture called `name`.

        With `far`, the far field replaces the layers behind the focus in its zones. `sharp` is
        composited among the layers. Return the texture.
        """
        out = self._scratch.texture(name, picture.color.size, 4)
        plans = _plan_layers(optics, settings, far, out.size)
        sized_plans = [sized_plan for plan in plans for sized_plan in plan.sized_plans]
        content = self._passes.tiles.find_content(picture, sized_plans, self._scratch)
        active = self._passes.tiles.find_active(content, sized_plans, optics, self._scratch)
        self._passes.composite.begin(sized_plans[0], active[0].mask, out)
        yield self._scratch.end_pass("tiles")
        tiles = iter(active)
        farther_px = math.inf  # up to this coc the sharp part has been composited
        for index, plan in enumerate(plans):
            self._report_layers(turn.before * len(plans) + index, turn.pictures * len(plans))
            behind = self._copy_colors(out) if plan.share < 1.0 else out
            for sized_plan, layer_tiles in zip(plan.sized_plans, tiles, strict=False):
                blur_inputs = picture, sized_plan, layer_tiles, optics, settings, out
                layer = yield from self._layer.steps(*blur_inputs)
                if sized_plan.reduction > 1:
                    self._passes.composite.run(layer, sized_plan, behind, out)
                    yield "composite"
            # The last layer behind the cut that `with_far_cut` made.
            if far is not None and plan.cut.near.at_px == FAR_FROM_PX * settings.proxy:
                self._passes.part_views.over(far, out)
            if sharp is not None:
                nearer_px = _nearest_coc_px(plan.cut)
                self._passes.cutout.over_layers(sharp, (nearer_px, farther_px), out)
                farther_px = nearer_px
            self._scratch.end_pass("composite")
        return out

    def _copy_colors(self, picture: Texture) -> Texture:
        """Return a copy of the colors of `picture`."""
        copy = self._scratch.texture("behind", picture.size, 4)
        self._passes.colors.copy_channels(picture, range(3), copy)
        return copy

    def _allocate_split(
        self, size: tuple[int, int], lists: ListedFragments | None
    ) -> WithoutHighlights:
        """Return the memory to split a picture of `size`, and its lists, by highlights."""
        scratch, lists_without_highlights = self._scratch, None
        if lists is not None:
            words = scratch.buffer("rest fragments", lists.packed_lists.words.size)
            lists_without_highlights = ListsWithoutHighlights(lists, words)
        around = scratch.texture("around", blocks_for(size, 2), 1, "f2")
        diffuse, highlights = (scratch.texture(name, size, 4) for name in ("rest", "highlights"))
        lit = scratch.buffer("lit pixels", WithoutHighlights.lit_bytes(size))
        return WithoutHighlights(diffuse, highlights, lit, around, lists_without_highlights)

    # A disc of two pixels is a square or a cross, whatever its coverage, because lamps are far
    # brighter than white. So previews are enlarged before the discs are drawn.
    def _enlarge(self, picture: Texture, enlarged: int) -> Texture:
        """Return the picture, or an enlarged copy of it."""
        if enlarged == 1:
            return picture
        size = enlarged * picture.width, enlarged * picture.height
        out = self._scratch.texture("enlarged out", size, 4)
        self._passes.rescale.enlarge(picture, out)
        return out

    def _split_highlights(
        self, source: LayeredPicture, kernel: Kernel, optics: Optics, out: WithoutHighlights
    ) -> Steps[HighlightBuffers]:
        """Write the picture without highlights to `out`, and return the list of highlights."""
        size, scratch = source.color.size, self._scratch
        half_size = blocks_for(size, 2)
        poles = self._passes.poles(self._scratch, "surroundings poles", size, kernel)
        luminance = blurred = scratch.texture("surroundings", half_size, 4)
        if source.lists is not None:
            blurred = scratch.texture("surroundings blurred", half_size, 4)
        half_coc = scratch.texture("surroundings coc", size, 1)
        surroundings = Surroundings(luminance, coc=half_coc, targets=BlurTargets(poles, blurred))
        split_steps = self._passes.split_highlights.steps(
            source.color, source.coc, optics, surroundings, out, source.positions is not None
        )
        yield from self._scratch.run_pass("highlights found", split_steps)
        sizes = HighlightBuffers.sizes(size)
        buffers = {name: scratch.buffer(f"highlight {name}", sizes[name]) for name in sizes}
        highlights = HighlightBuffers(**buffers)
        list_steps = self._passes.list_highlights.steps(
            out, optics, highlights, source.coc, source.positions, source.enlarged
        )
        yield from self._scratch.run_pass("highlights listed", list_steps)
        return highlights

    def _draw_highlights(
        self,
        highlights: HighlightBuffers,
        picture: UnmixedPicture,
        optics: Optics,
        out: Texture,
        sharp: SharpPart | None,
    ) -> Steps[None]:
        """Draw the highlights over the blurred picture, among its surfaces."""
        coc_range = self._scratch.texture("tile coc range", tile_count(picture.coc.size), 2)
        size = picture.coc.size
        ranges = self._scratch.texture("highlight ranges", size, 2)
        edges = self._scratch.texture("highlight edges", size, 1)
        nodes = self._scratch.buffer("highlight nodes", nodes_bytes(size))
        rays = RayMemory(ranges, edges, nodes)
        passes, inputs = self._passes, (highlights, picture)
        shade_steps = passes.shade_highlights.steps(*inputs, coc_range, optics, rays)
        draw_steps = passes.draw_highlights.steps(*inputs, optics, rays, out, sharp)
        yield from self._scratch.run_pass("highlights drawn", chain(shade_steps, draw_steps))

    def _split_silhouettes(
        self,
        color: Texture,
        coc: Texture,
        optics: Optics,
        lists: ListedFragments | None,
        around: Texture | None,
    ) -> Steps[UnmixedPicture]:
        """Return the picture with each mixed pixel of its silhouettes split in two surfaces.

        `around` is only passed on, see `UnmixedPicture`.
        """
        size, scratch = color.size, self._scratch
        picture = UnmixedPicture(
            color,
            coc,
            kind=scratch.texture("kind", size, 2 if lists is None else 4, "f2"),
            far=scratch.texture("far", size, 4, "f2"),
            near=scratch.texture("near", size, 4, "f2"),
            lists=lists,
            around=around,
        )
        rim_list, thin_list = (
            scratch.buffer(f"{name} list", list_bytes(size)) for name in ("rim", "thin")
        )
        split_steps = self._passes.unmix.steps(picture, optics, rim_list, thin_list)
        yield from self._scratch.run_pass("fragments", split_steps)
        return picture
