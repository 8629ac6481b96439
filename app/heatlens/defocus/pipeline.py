"""Run the passes of the blur in their order, in textures that they share.

A picture is rendered in steps, each named after its pass, so that a window can handle input in
between.

plate -> proxy -> coc -> fragments -> for each layer, far to near, in its visible tiles and at the
size that its blur allows: split, fill hidden pixels, extend the coc, blur, composite -> out
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import assert_never

import moderngl

from heatlens.defocus.blur_pass import PACKED, BlurTargets, Diffusion, Over, pole_layers
from heatlens.defocus.color_rounds import ColorRounds
from heatlens.defocus.cutout_pass import CutoutTextures, SharpPart
from heatlens.defocus.far_parts import FAR_FROM_PX, FarField, FarSurfaces, is_in_parts, with_far_cut
from heatlens.defocus.fragment_pass import Fragments
from heatlens.defocus.highlight_pass import (
    HighlightBuffers,
    ListsWithoutHighlights,
    Surroundings,
    WithoutHighlights,
)
from heatlens.defocus.kernels import Kernel
from heatlens.defocus.layer_cuts import layer_cuts
from heatlens.defocus.layer_passes import HiddenScratch, Layer, block_size
from heatlens.defocus.layer_plan import LayerPlan, layer_plans
from heatlens.defocus.listed_fragments import FragmentBuffers, ListedFragments, listed_through
from heatlens.defocus.optics import Optics
from heatlens.defocus.passes import DefocusPasses
from heatlens.defocus.pixel_list import list_bytes
from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.defocus.reduced_plate import PlateTextures, ReducedPlate
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.steps import Steps
from heatlens.defocus.tile_pass import LayerTiles
from heatlens.gpu.buffer_parts import BufferPart
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality

# These methods handle a different focus for each colour themselves.
SAMPLING_COLORS = (Method.GATHER, Method.SCATTER)


class DefocusPipeline:
    """Renders a picture with depth of field from colour and depth, in its own textures."""

    def __init__(self, ctx: moderngl.Context, passes: DefocusPasses) -> None:
        self._ctx = ctx
        self._passes = passes
        self.scratch = Scratch(ctx)
        self._places: moderngl.Texture | None = None  # subpixel positions of the light
        self._reduced = ReducedPlate(ctx, passes.proxy, passes.proxy_lists)
        self._rounds = ColorRounds(passes.colors)
        self.on_layer: Callable[[int, int], None] | None = None  # called with layers done and total

    def steps(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool = False,
        fragments: FragmentBuffers | None = None,
        places: moderngl.Texture | None = None,
        cutout: CutoutTextures | None = None,
    ) -> Steps[moderngl.Texture]:
        """Render the picture with depth of field, RGBA float32, at proxy size.

        The next run overwrites it.

        `color` is RGBA, `depth` metres, or signed coc in pixels if `optics.line` is None. Without
        `has_alpha` the result's alpha is 1. `fragments` are the surfaces behind the visible ones;
        methods with one layer ignore them. `places`, RGBA, are subpixel positions of the light.
        `cutout` stays sharp; then its rest is blurred in place of `color` and `depth`.
        """
        if cutout is not None:
            color, depth = cutout.rest, cutout.rest_depth
        self._places = places
        self.scratch.begin_picture()
        if settings.proxy < 1.0:
            whole = PlateTextures(color, depth, fragments, cutout=cutout)
            reduced = yield from self._reduced.steps(whole, optics, settings, self.scratch)
            if fragments is None:  # what is behind silhouettes is not enough for parts of the lens
                settings = replace(settings, parts=1)
            color, depth, fragments = reduced.color, reduced.depth, reduced.fragments
            self._places, cutout = reduced.places, reduced.cutout
            optics = optics.scaled(settings.proxy)

        def blurred(seen: Optics) -> Steps[moderngl.Texture]:
            ground = None if cutout is None else cutout.ground
            with_alpha = has_alpha or ground is not None
            work = color, depth, seen, settings, with_alpha, fragments, cutout
            picture = yield from self._blurred(*work)
            if ground is not None:
                self._passes.cutout.over_ground(ground, picture, is_opaque=not has_alpha)
            return picture

        if optics.disc.axial_px == 0.0 or settings.method in SAMPLING_COLORS:
            return (yield from self._rounds.in_one(blurred, optics))
        return (yield from self._rounds.in_three(blurred, optics, color.size, self.scratch))

    def _blurred(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool,
        fragments: FragmentBuffers | None,
        cutout: CutoutTextures | None,
    ) -> Steps[moderngl.Texture]:
        """Blur a picture at proxy size, with one focus for all colours."""
        coc = yield from self._coc("coc", depth, optics)
        sharp = None
        if cutout is not None:
            sharp_coc = yield from self._coc("cutout coc", cutout.depth, optics)
            sharp = SharpPart(cutout.light, cutout.alpha, sharp_coc)
        if layers_for(settings) == 1:
            blurred = yield from self._in_one_layer(color, coc, optics, settings)
            if sharp is not None:
                self._passes.cutout.on_top(sharp, coc, blurred)
            self._passes.limits.run(blurred, is_opaque=not has_alpha)
            yield self.scratch.passed("limits")
            return blurred
        has_highlights = settings.bokeh is Bokeh.DISC
        lists = listed_through(fragments, optics, has_alpha)
        layered = self._layered(color, coc, optics, settings, "out", has_highlights, lists, sharp)
        if not has_alpha:
            return (yield from layered)
        alpha_color = self.scratch.texture("alpha plate", color.size, 4)
        self._passes.alpha.as_color(color, alpha_color)
        yield self.scratch.passed("alpha")
        covers = None if lists is None else lists.of_alpha()
        shown = None if sharp is None else sharp.of_alpha()
        alpha = yield from self._layered(
            alpha_color, coc, optics, settings, "alpha out", False, covers, shown
        )
        out = yield from layered
        self._passes.alpha.join(alpha, out)
        yield self.scratch.passed("alpha")
        return out

    def _coc(self, name: str, depth: moderngl.Texture, optics: Optics) -> Steps[moderngl.Texture]:
        """Return the signed coc of a depth, which may be one already."""
        if optics.line is None and not optics.plate_shift_px:
            return depth
        coc = self.scratch.texture(name, depth.size, 1)
        found = self._passes.coc.steps(depth, optics.line, coc, optics.plate_shift_px)
        yield from self._named("coc", found)
        return coc

    def _in_one_layer(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
    ) -> Steps[moderngl.Texture]:
        """Diffuse without layers, or use another method, which may handle depth itself."""
        others, work = self._passes.others, (color, coc, optics, self.scratch)
        blurred = self.scratch.texture("blurred", color.size, 4)
        match settings.method:
            case Method.GATHER:
                yield from self._named("gather", others.gather(*work))
            case Method.SCATTER:
                yield from self._named("scatter", others.scatter(*work))
            case Method.PYRAMID:
                yield from self._named("pyramid", others.pyramid(*work))
            case Method.DIFFUSION | Method.HEAT:
                disc = optics.disc
                what = Diffusion(color, coc, kernel_for(settings), disc.half_extents, shape=disc)
                targets = BlurTargets(self._poles("poles", color.size, what.kernel), blurred)
                yield from self._named("blur", self._passes.blur.steps(what, targets))
            case Method.ACCUMULATION | Method.RAYTRACED:
                raise ValueError(f"{settings.method} renders a 3D scene and cannot blur a plate.")
            case _:
                assert_never(settings.method)
        return blurred

    def _layered(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        name: str,
        has_highlights: bool,
        lists: ListedFragments | None = None,
        sharp: SharpPart | None = None,
    ) -> Steps[moderngl.Texture]:
        """Blur layers far to near, and composite them in the texture called `name`."""
        listed = around = None
        if has_highlights:
            without = self._room_without(color.size, lists)
            kernel = kernel_for(settings)
            listed = yield from self._without_highlights(color, coc, kernel, optics, without)
            color, around = without.low, without.around
            lists = None if without.lists is None else without.lists.diffused
        far = yield from self._far_field(color, coc, optics, settings, lists)
        picture = yield from self._fragmented(color, coc, optics, lists, around)
        out = self.scratch.filled(name, color.size, (0.0, 0.0, 0.0, 1.0))
        yield from self._over_each_other(picture, optics, settings, far, sharp, out)
        if listed is not None:
            drawn = self._passes.draw_highlights.steps(listed, picture, optics, out, sharp)
            yield from self._named("highlights drawn", drawn)
        self.scratch.passed("highlights drawn")
        return out

    def _over_each_other(
        self,
        picture: Fragments,
        optics: Optics,
        settings: DefocusSettings,
        far: FarField | None,
        sharp: SharpPart | None,
        out: moderngl.Texture,
    ) -> Steps[None]:
        """Blur the layers of a picture, and composite them over `out`."""
        cuts = layer_cuts(optics.occupied_px, optics.gaps_px, layers_for(settings), settings.proxy)
        if far is not None:
            cuts = with_far_cut(cuts, settings.proxy)
        plans = layer_plans(cuts, optics, out.size)
        sizes = [size for plan in plans for size in plan.sizes]
        found = self._passes.tiles.look_through(picture, sizes, self.scratch)
        tiles = iter(self._passes.tiles.find(found, sizes, optics, self.scratch))
        yield self.scratch.passed("tiles")
        farther_px = math.inf
        for number, plan in enumerate(plans):
            self._tell_progress(number, len(plans))
            behind = self._kept(out) if plan.share < 1.0 else out
            for size, where in zip(plan.sizes, tiles, strict=False):
                layer = yield from self._blurred_layer(picture, size, where, optics, settings, out)
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
            self.scratch.passed("composite")

    def _blurred_layer(
        self,
        picture: Fragments,
        plan: LayerPlan,
        where: LayerTiles,
        optics: Optics,
        settings: DefocusSettings,
        out: moderngl.Texture,
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
        )
        poles = self._poles("poles", picture.coc.size, kernel_for(settings))
        over = Over(out, plan.cut.is_farthest) if plan.reduction == 1 else None
        blur = self._passes.blur.steps(what, BlurTargets(poles, layer.color, over), layer.mask)
        yield from self._named("blur", blur)
        return layer

    def _kept(self, picture: moderngl.Texture) -> moderngl.Texture:
        """Return a copy of the colours of `picture`."""
        kept = self.scratch.texture("behind", picture.size, 4)
        self._passes.colors.take(picture, range(3), kept)
        return kept

    def _far_field(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        lists: ListedFragments | None,
    ) -> Steps[FarField | None]:
        """Blur the far field in parts of the lens; return None if it is blurred in layers."""
        least_px = FAR_FROM_PX * settings.proxy
        if lists is None or not is_in_parts(optics, settings, lists.is_open):
            return None
        draft = kernel_for(replace(settings, quality=Quality.DRAFT))
        poles = self._poles("far poles", color.size, kernel_for(settings))
        what = FarSurfaces(color, coc, lists, least_px)
        return (
            yield from self._passes.far_parts.steps(
                what, optics, settings.parts, draft, poles, self.scratch
            )
        )

    def _tell_progress(self, done: int, layers: int) -> None:
        """Report the layers that are done; wait for the GPU only if somebody listens."""
        if self.on_layer is not None:
            self._ctx.finish()
            self.on_layer(self._rounds.done * layers + done, self._rounds.count * layers)

    def forget_plate(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._reduced.forget()

    def _room_without(
        self, size: tuple[int, int], lists: ListedFragments | None
    ) -> WithoutHighlights:
        scratch, low = self.scratch, None
        if lists is not None:
            words = scratch.buffer("low fragments", lists.held.words.size)
            low = ListsWithoutHighlights(lists, words)
        around = scratch.texture("around", Surroundings.half_size(size), 1, "f2")
        return WithoutHighlights(
            scratch.texture("low", size, 4), scratch.texture("high", size, 4), around, low
        )

    def _without_highlights(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        kernel: Kernel,
        optics: Optics,
        out: WithoutHighlights,
    ) -> Steps[HighlightBuffers]:
        """Split the picture into one without highlights and the list of these."""
        size, scratch, half = color.size, self.scratch, Surroundings.half_size(color.size)
        poles = self._poles("surroundings poles", size, kernel)
        blurred = scratch.texture("surroundings blurred", half, 4, reduction=2)
        surroundings = Surroundings(
            scratch.texture("surroundings", half, 4),  # as large as the blocks of hidden pixels
            scratch.texture("surroundings coc", half, 1, reduction=2),
            BlurTargets(poles, blurred),
        )
        split = self._passes.split_highlights.steps(
            color, coc, optics, surroundings, out, self._places is not None
        )
        yield from self._named("highlights found", split)
        sizes = HighlightBuffers.sizes(size)
        buffers = {name: scratch.buffer(f"highlight {name}", sizes[name]) for name in sizes}
        highlights = HighlightBuffers(**buffers)
        listed = self._passes.list_highlights.steps(out, optics, highlights, coc, self._places)
        yield from self._named("highlights listed", listed)
        return highlights

    def _fragmented(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        lists: ListedFragments | None,
        around: moderngl.Texture | None,
    ) -> Steps[Fragments]:
        size, scratch = color.size, self.scratch
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
        yield from self._named("fragments", apart)
        return picture

    def _layer(
        self,
        picture: Fragments,
        plan: LayerPlan,
        where: LayerTiles,
        optics: Optics,
    ) -> Steps[tuple[Layer, moderngl.Texture]]:
        """Return a layer with hidden pixels filled, and its coc, in the active tiles."""
        size, scratch, reduction = plan.size(picture.coc.size), self.scratch, plan.reduction
        hidden = scratch.buffer("hidden list", list_bytes(picture.coc.size))
        color = scratch.texture("layer", size, 4, reduction=reduction)
        state = scratch.texture("layer state", size, 2, reduction=reduction)
        told = None
        if picture.lists is not None:
            told = scratch.texture("told", size, 2, "f2", reduction)
        layer = Layer(color, state, where.mask, where.listed, told)
        split = self._passes.split.steps(picture, plan, hidden, layer)
        yield from self._named("layer split", split)
        if not plan.cut.is_nearest:
            yield from self._named(
                "hidden fill", self._hidden_fill(layer, hidden, plan, picture, where.seen)
            )
        self.scratch.passed("hidden fill")
        layer_coc = scratch.texture("layer coc", size, 1, reduction=reduction)
        between = self._passes.solver.between_size(picture.coc.size)
        rows = scratch.texture("coc fill rows", between, 2)
        extend = self._passes.coc_fill.steps(
            layer.state, plan.cut, optics.disc.spreads, rows, layer_coc, layer.mask
        )
        yield from self._named("coc fill", extend)
        return layer, layer_coc

    def _hidden_fill(
        self,
        layer: Layer,
        hidden: moderngl.Buffer,
        plan: LayerPlan,
        picture: Fragments,
        seen: BufferPart,
    ) -> Iterator[None]:
        whole, blocks = picture.coc.size, block_size(layer.color.size)
        work = HiddenScratch(
            seen,
            self.scratch.buffer("hidden blocks", list_bytes(whole)),
            self.scratch.texture("hidden cost", blocks, 4, reduction=plan.reduction),
            self.scratch.texture("hidden match", blocks, 4, reduction=plan.reduction)
            if picture.lists is not None and not picture.lists.is_exact
            else None,
        )
        reach_px = math.ceil(plan.uncovered_px / plan.reduction)
        around = picture.around if plan.is_in_focus and plan.reduction == 1 else None
        return self._passes.hidden.steps(layer, hidden, work, reach_px, around)

    def _poles(
        self, name: str, picture_size: tuple[int, int], kernel: Kernel
    ) -> moderngl.TextureArray:
        """Return the intermediate image of a blur, which layers of any size share."""
        between = self._passes.solver.between_size(picture_size)
        return self.scratch.array(name, between, pole_layers(kernel), 4, PACKED)

    def _named(self, name: str, steps: Iterator[None]) -> Iterator[str]:
        """Yield the name for each step of a pass; the pass has ended after the last one."""
        for _ in steps:
            yield name
        self.scratch.passed(name)
