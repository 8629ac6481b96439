"""Blur a picture in layers, far to near: its highlights as discs, what is in front over the rest.

highlights apart -> fragments -> for each layer, in its visible tiles and at the size that its blur
allows: blur (`LayerBlur`: split it off, fill hidden pixels, extend the coc, diffuse), composite ->
highlights drawn
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.render.defocus.blur_pass import BlurTargets, Diffusion, Over
from heatlens.render.defocus.cutout_pass import SharpPart
from heatlens.render.defocus.far_parts import FAR_FROM_PX, FarField, is_in_parts, with_far_cut
from heatlens.render.defocus.far_zones import FarSurfaces
from heatlens.render.defocus.fragment_pass import Fragments
from heatlens.render.defocus.highlight_pass import (
    HighlightBuffers,
    ListsWithoutHighlights,
    Surroundings,
    WithoutHighlights,
)
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.layer_cuts import layer_cuts
from heatlens.render.defocus.layer_passes import CocFillPass, HiddenScratch, Layer
from heatlens.render.defocus.layer_plan import LayerPlan, layer_plans
from heatlens.render.defocus.listed_fragments import ListedFragments
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pixel_list import list_bytes
from heatlens.render.defocus.quality import kernel_for, layers_for, parts_for
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import ONLY, Steps, Turn
from heatlens.render.defocus.tile_mask import tile_count
from heatlens.render.defocus.tile_pass import LayerTiles
from heatlens.render.gpu.device import Buffer, BufferPart, Texture
from heatlens.render.gpu.program import blocks_for


class LayerBlur:
    """Blurs layers one after the other, in the same textures."""

    def __init__(self, passes: DefocusPasses, scratch: Scratch) -> None:
        self._passes = passes
        self._scratch = scratch

    def steps(
        self,
        picture: Fragments,
        plan: LayerPlan,
        where: LayerTiles,
        optics: Optics,
        settings: DefocusSettings,
        out: Texture,
    ) -> Steps[Layer]:
        """Return one layer, blurred; composite it over `out` if it is as large."""
        layer, layer_coc = yield from self._layer(picture, plan, where, optics)
        is_in_front, rim = plan.cut.is_before_focus, optics.disc.aperture.rim
        what = Diffusion(
            layer.color,
            layer_coc,
            kernel_for(settings, -rim if is_in_front else rim),
            optics.disc.half_extents,
            resampled_px_2=plan.resampled_px_2,
            shape=optics.disc.scaled(1 / plan.reduction),
            is_in_front=is_in_front,
            corner=layer.size,
        )
        poles = self._passes.poles(self._scratch, "poles", picture.coc.size, kernel_for(settings))
        over = Over(out, plan.cut.is_farthest) if plan.reduction == 1 else None
        blur = self._passes.blur.steps(what, BlurTargets(poles, layer.color, over), layer.mask)
        yield from self._scratch.named("blur", blur)
        return layer

    def _layer(
        self,
        picture: Fragments,
        plan: LayerPlan,
        where: LayerTiles,
        optics: Optics,
    ) -> Steps[tuple[Layer, Texture]]:
        """Return a layer with hidden pixels filled, and its coc, in the active tiles."""
        whole, scratch = picture.coc.size, self._scratch
        hidden = scratch.buffer("hidden list", list_bytes(whole))
        color = scratch.texture("layer", whole, 4)
        state = scratch.texture("layer state", whole, 2)
        known = None if picture.lists is None else scratch.texture("known", whole, 2, "f2")
        layer = Layer(color, state, plan.size(whole), where.mask, where.listed, known)
        split = self._passes.split.steps(picture, plan, hidden, layer)
        yield from self._scratch.named("layer split", split)
        if not plan.cut.is_nearest:
            yield from self._scratch.named(
                "hidden fill", self._hidden_fill(layer, hidden, plan, picture, where.seen)
            )
        self._scratch.passed("hidden fill")
        layer_coc = scratch.texture("layer coc", whole, 1)
        need = CocFillPass.rows_bytes(whole)
        rows = scratch.buffer("coc fill diameters", need), scratch.buffer("coc fill weights", need)
        extend = self._passes.coc_fill.steps(
            state, plan.cut, optics.disc.spreads, rows, layer_coc, layer.mask, layer.size
        )
        yield from self._scratch.named("coc fill", extend)
        return layer, layer_coc

    def _hidden_fill(
        self,
        layer: Layer,
        hidden: Buffer,
        plan: LayerPlan,
        picture: Fragments,
        seen: BufferPart,
    ) -> Iterator[None]:
        whole, blocks = picture.coc.size, blocks_for(picture.coc.size, 2)
        work = HiddenScratch(
            seen,
            self._scratch.buffer("hidden blocks", list_bytes(whole)),
            self._scratch.texture("hidden cost", blocks, 4),
            self._scratch.texture("hidden match", blocks, 4)
            if picture.lists is not None and not picture.lists.is_exact
            else None,
        )
        reach_px = math.ceil(plan.uncovered_px / plan.reduction)
        around = picture.around if plan.is_in_focus and plan.reduction == 1 else None
        return self._passes.hidden.steps(layer, hidden, work, reach_px, around)


@dataclass(frozen=True, eq=False)
class LayeredPicture:
    """A picture to blur in layers.

    color, coc      RGBA, and signed coc in pixels
    has_highlights  they are drawn as discs
    lists           the surfaces behind the visible ones; None if none are known
    sharp           what is kept from the blur
    places          RGBA, subpixel positions of the light; None if they are not known
    may_guess       surfaces behind the focus may be guessed for parts of the lens
    """

    color: Texture
    coc: Texture
    has_highlights: bool
    lists: ListedFragments | None = None
    sharp: SharpPart | None = None
    places: Texture | None = None
    may_guess: bool = False


class LayeredBlur:
    """Blurs pictures in layers; `tell` is called with layers done and their number."""

    def __init__(
        self, passes: DefocusPasses, scratch: Scratch, tell: Callable[[int, int], None]
    ) -> None:
        self._passes = passes
        self._scratch = scratch
        self._tell = tell
        self._layer = LayerBlur(passes, scratch)

    def steps(
        self,
        what: LayeredPicture,
        optics: Optics,
        settings: DefocusSettings,
        name: str,
        turn: Turn = ONLY,
    ) -> Steps[Texture]:
        """Blur layers far to near, and composite them in the texture called `name`."""
        color, coc, lists, sharp = what.color, what.coc, what.lists, what.sharp
        listed = around = None
        if what.has_highlights:
            without = self._room_without(color.size, lists)
            kernel = kernel_for(settings)
            listed = yield from self._without_highlights(what, kernel, optics, without)
            color, around = without.low, without.around
            lists = None if without.lists is None else without.lists.diffused
        diffused = replace(what, color=color, lists=lists)
        far = yield from self._far_field(diffused, optics, settings)
        picture = yield from self._fragmented(color, coc, optics, lists, around)
        growing = far if far is not None and far.zone.growth < 1.0 else None
        first, then = turn.halves if growing is not None else (turn, turn)
        out = yield from self._over_each_other(picture, optics, settings, far, sharp, name, first)
        if growing is not None:  # its cut changes the picture everywhere
            alone = yield from self._over_each_other(
                picture, optics, settings, None, sharp, "without far", then
            )
            self._passes.far_parts.mix(alone, growing, out)
            yield self._scratch.passed("composite")
        if listed is not None:
            nearest = self._scratch.texture("tile nearest", tile_count(out.size), 1)
            drawn = self._passes.draw_highlights.steps(listed, picture, nearest, optics, out, sharp)
            yield from self._scratch.named("highlights drawn", drawn)
        self._scratch.passed("highlights drawn")
        return out

    def _over_each_other(
        self,
        picture: Fragments,
        optics: Optics,
        settings: DefocusSettings,
        far: FarField | None,
        sharp: SharpPart | None,
        name: str,
        turn: Turn,
    ) -> Steps[Texture]:
        """Blur the layers of a picture, and composite them in the texture called `name`."""
        out = self._scratch.texture(name, picture.color.size, 4)
        cuts = layer_cuts(optics.occupied_px, optics.gaps_px, layers_for(settings), settings.proxy)
        if far is not None:
            cuts = with_far_cut(cuts, settings.proxy)
        plans = layer_plans(cuts, optics, out.size)
        sizes = [size for plan in plans for size in plan.sizes]
        content = self._passes.tiles.look_through(picture, sizes, self._scratch)
        active = self._passes.tiles.find(content, sizes, optics, self._scratch)
        self._passes.composite.begin(sizes[0], active[0].mask, out)
        yield self._scratch.passed("tiles")
        tiles = iter(active)
        farther_px = math.inf
        for number, plan in enumerate(plans):
            self._tell(turn.before * len(plans) + number, turn.pictures * len(plans))
            behind = self._kept(out) if plan.share < 1.0 else out
            for size, where in zip(plan.sizes, tiles, strict=False):
                layer = yield from self._layer.steps(picture, size, where, optics, settings, out)
                if size.reduction > 1:
                    self._passes.composite.run(layer, size, behind, out)
                    yield "composite"
            if far is not None and plan.cut.near.at_px == FAR_FROM_PX * settings.proxy:
                self._passes.far_parts.over(far, out)
            if sharp is not None:
                near = plan.cut.near  # in the nearest layer that holds some of its surroundings
                nearer_px = -math.inf if plan.cut.is_nearest else near.at_px + near.half_width_px
                self._passes.cutout.over_layers(sharp, (nearer_px, farther_px), out)
                farther_px = nearer_px
            self._scratch.passed("composite")
        return out

    def _kept(self, picture: Texture) -> Texture:
        """Return a copy of the colours of `picture`."""
        kept = self._scratch.texture("behind", picture.size, 4)
        self._passes.colors.take(picture, range(3), kept)
        return kept

    def _far_field(
        self,
        what: LayeredPicture,
        optics: Optics,
        settings: DefocusSettings,
    ) -> Steps[FarField | None]:
        """Blur the far field in parts of the lens; return None if it is blurred in layers."""
        if not is_in_parts(optics, settings):
            return None
        least_px, lists = FAR_FROM_PX * settings.proxy, what.lists
        is_guessed = lists is None and what.may_guess
        if is_guessed:
            guess = self._passes.far_guess
            lists = yield from guess.steps(what.color, what.coc, optics, least_px, self._scratch)
        if lists is None or lists.is_open:
            return None
        draft = kernel_for(replace(settings, quality=Quality.DRAFT))
        poles = self._passes.poles(
            self._scratch, "far poles", what.color.size, kernel_for(settings)
        )
        surfaces = FarSurfaces(what.color, what.coc, lists, least_px, is_guessed)
        return (
            yield from self._passes.far_parts.steps(
                surfaces, optics, parts_for(settings, is_guessed), draft, poles, self._scratch
            )
        )

    def _room_without(
        self, size: tuple[int, int], lists: ListedFragments | None
    ) -> WithoutHighlights:
        scratch, lists_low = self._scratch, None
        if lists is not None:
            words = scratch.buffer("low fragments", lists.held.words.size)
            lists_low = ListsWithoutHighlights(lists, words)
        around = scratch.texture("around", blocks_for(size, 2), 1, "f2")
        low, high = (scratch.texture(name, size, 4) for name in ("low", "high"))
        lit = scratch.buffer("lit pixels", WithoutHighlights.lit_bytes(size))
        return WithoutHighlights(low, high, lit, around, lists_low)

    def _without_highlights(
        self,
        what: LayeredPicture,
        kernel: Kernel,
        optics: Optics,
        out: WithoutHighlights,
    ) -> Steps[HighlightBuffers]:
        """Split the picture into one without highlights and the list of these."""
        size, scratch = what.color.size, self._scratch
        half = blocks_for(size, 2)
        poles = self._passes.poles(self._scratch, "surroundings poles", size, kernel)
        luminance = blurred = scratch.texture("surroundings", half, 4)
        if what.lists is not None:
            blurred = scratch.texture("surroundings blurred", half, 4)
        half_coc = scratch.texture("surroundings coc", size, 1)
        surroundings = Surroundings(luminance, half_coc, BlurTargets(poles, blurred))
        split = self._passes.split_highlights.steps(
            what.color, what.coc, optics, surroundings, out, what.places is not None
        )
        yield from self._scratch.named("highlights found", split)
        sizes = HighlightBuffers.sizes(size)
        buffers = {name: scratch.buffer(f"highlight {name}", sizes[name]) for name in sizes}
        highlights = HighlightBuffers(**buffers)
        listed = self._passes.list_highlights.steps(out, optics, highlights, what.coc, what.places)
        yield from self._scratch.named("highlights listed", listed)
        return highlights

    def _fragmented(
        self,
        color: Texture,
        coc: Texture,
        optics: Optics,
        lists: ListedFragments | None,
        around: Texture | None,
    ) -> Steps[Fragments]:
        size, scratch = color.size, self._scratch
        picture = Fragments(
            color,
            coc,
            scratch.texture("kind", size, 1 if lists is None else 2, "f2"),
            scratch.texture("far", size, 4, "f2"),
            scratch.texture("near", size, 4, "f2"),
            lists,
            around,
        )
        rims, thin = (scratch.buffer(f"{name} list", list_bytes(size)) for name in ("rim", "thin"))
        apart = self._passes.fragments.steps(picture, optics, rims, thin)
        yield from self._scratch.named("fragments", apart)
        return picture
