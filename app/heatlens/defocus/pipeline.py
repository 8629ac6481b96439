"""Order of the passes; owns every texture between them and reuses it.

A picture comes about in steps, each named after its pass, so that a window can answer in between.

plate -> proxy -> coc -> fragments -> each layer, far to near, in the tiles where it shows and at
the size that its blur allows: split, fill what is hidden, extend its coc, blur, composite -> out
"""

import math
from collections.abc import Callable, Generator, Iterator
from typing import TypeVar, assert_never

import moderngl

from heatlens.defocus.blur_pass import PACKED, BlurPass, BlurTargets, Diffusion, pole_layers
from heatlens.defocus.fragment_pass import FragmentPass, Fragments
from heatlens.defocus.highlight_pass import (
    HighlightBuffers,
    HighlightDrawPass,
    HighlightListPass,
    HighlightSplitPass,
    ListsWithoutHighlights,
    Surroundings,
)
from heatlens.defocus.kernels import Kernel
from heatlens.defocus.layer_cuts import layer_cuts
from heatlens.defocus.layer_passes import (
    CocFillPass,
    CompositePass,
    HiddenFillPass,
    HiddenScratch,
    Layer,
    LayerSplitPass,
    LimitsPass,
    block_size,
)
from heatlens.defocus.layer_plan import LayerPlan, layer_plans
from heatlens.defocus.line_solver import LineSolver
from heatlens.defocus.listed_fragments import FragmentBuffers, ListedFragments, listed_through
from heatlens.defocus.optics import Optics
from heatlens.defocus.other_methods import OtherMethods
from heatlens.defocus.pixel_list import list_bytes
from heatlens.defocus.plate_passes import AlphaPass, CocPass, ProxyPass, proxy_size
from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.defocus.tile_mask import TileList, TileMask
from heatlens.defocus.tile_pass import TilePass
from heatlens.gpu.textures import TexturePool
from heatlens.model.settings import Bokeh, DefocusSettings, Method

_NOTHING = (0.0, 0.0, 0.0, 0.0)
_NO_COST = (-1.0, -1.0, -1.0, -1.0)  # as hidden_fill.comp.glsl takes it, for what is seen
Result = TypeVar("Result")
Steps = Generator[str, None, Result]  # names of passes as their work is issued, then the result


class DefocusPasses:
    """Every pass with its programs; pipelines share them."""

    def __init__(self, ctx: moderngl.Context, solver: LineSolver) -> None:
        self.proxy = ProxyPass(ctx)
        self.coc = CocPass(ctx)
        self.alpha = AlphaPass(ctx)
        self.fragments = FragmentPass(ctx)
        self.solver = solver
        self.tiles = TilePass(ctx)
        self.split = LayerSplitPass(ctx)
        self.hidden = HiddenFillPass(ctx)
        self.coc_fill = CocFillPass(solver)
        self.blur = BlurPass(solver)
        self.composite = CompositePass(ctx)
        self.limits = LimitsPass(ctx)
        self.split_lamps = HighlightSplitPass(ctx, self.blur)
        self.list_lamps = HighlightListPass(ctx)
        self.draw_lamps = HighlightDrawPass(ctx)
        self.others = OtherMethods(ctx)


class DefocusPipeline:
    """Colour and depth to a picture with depth of field, in textures of its own."""

    def __init__(self, ctx: moderngl.Context, passes: DefocusPasses) -> None:
        self._ctx = ctx
        self._passes = passes
        self.pool = TexturePool(ctx)
        self._proxy_held = 1.0  # the size at which the plate lies in the pool; 1: at none
        self.on_layer: Callable[[int, int], None] | None = None  # layers done, of all

    def steps(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool = False,
        fragments: FragmentBuffers | None = None,
    ) -> Steps[moderngl.Texture]:
        """The picture with depth of field, RGBA float32, proxy size; the next run overwrites it.

        `color` is RGBA, `depth` metres, or signed coc in pixels if `optics.line` is None. Without
        `has_alpha` the result's alpha is 1. `fragments` tell what lies behind the plate; methods of
        one layer do not ask.
        """
        if settings.proxy < 1.0:
            color, depth = yield from self._at_proxy_size(color, depth, optics, settings.proxy)
            optics = optics.scaled(settings.proxy)
        coc = depth
        if optics.line is not None:
            coc = self.pool.texture("coc", depth.size, 1)
            self._passes.coc.run(depth, optics.line, coc)
            yield "coc"
        if layers_for(settings) == 1:
            blurred = yield from self._in_one_layer(color, coc, optics, settings)
            self._passes.limits.run(blurred, is_opaque=not has_alpha)
            yield "limits"
            return blurred
        lamps = settings.bokeh is Bokeh.DISC
        lists = listed_through(fragments, optics, settings.proxy == 1.0)
        if not has_alpha:
            return (yield from self._layered(color, coc, optics, settings, "out", lamps, lists))
        alpha_color = self.pool.texture("alpha plate", color.size, 4)
        self._passes.alpha.as_color(color, alpha_color)
        yield "alpha"
        alpha = yield from self._layered(alpha_color, coc, optics, settings, "alpha out", False)
        out = yield from self._layered(color, coc, optics, settings, "out", lamps, lists)
        self._passes.alpha.join(alpha, out)
        yield "alpha"
        return out

    def _in_one_layer(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
    ) -> Steps[moderngl.Texture]:
        """Diffusion without layers, or another method, which sees to depth itself or not at all."""
        others, work = self._passes.others, (color, coc, optics, self.pool)
        blurred = self.pool.texture("blurred", color.size, 4)
        match settings.method:
            case Method.GATHER:
                yield from _named("gather", others.gather(*work))
            case Method.SCATTER:
                yield from _named("scatter", others.scatter(*work))
            case Method.PYRAMID:
                yield from _named("pyramid", others.pyramid(*work))
            case Method.DIFFUSION | Method.HEAT:
                what = Diffusion(color, coc, kernel_for(settings), optics.disc.spreads)
                targets = BlurTargets(self._poles(color.size, what.kernel), blurred)
                yield from _named("blur", self._passes.blur.steps(what, targets))
            case Method.ACCUMULATION | Method.RAYTRACED:
                raise ValueError(f"{settings.method} draws a scene; a plate cannot be blurred so.")
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
        lamps: bool,
        lists: ListedFragments | None = None,
    ) -> Steps[moderngl.Texture]:
        """Layers far to near, blurred and put over each other in the texture called `name`."""
        kernel = kernel_for(settings)
        listed = None
        if lamps:
            split = None if lists is None else self._room_for_low(lists)
            color, listed = yield from self._without_lamps(color, coc, kernel, optics, split)
            lists = None if split is None else split.diffused
        picture = self._fragmented(color, coc, optics, lists)
        yield "fragments"
        cuts = layer_cuts(optics.occupied_px, layers_for(settings), settings.proxy)
        plans = layer_plans(cuts, optics, color.size)
        out = self.pool.filled(name, color.size, (0.0, 0.0, 0.0, 1.0))
        found = self._passes.tiles.look_through(picture, plans, self.pool)
        for number, plan in enumerate(plans):
            self._tell_progress(number, len(plans))
            where = self._passes.tiles.find(found, plans, number, optics, self.pool)
            yield "tiles"
            layer, layer_coc = yield from self._layer(picture, plan, where, optics)
            what = Diffusion(
                layer.color,
                layer_coc,
                kernel,
                optics.disc.spreads,
                resampled_px_2=plan.resampled_px_2,
            )
            targets = BlurTargets(self._poles(picture.coc.size, kernel), layer.color)
            yield from _named("blur", self._passes.blur.steps(what, targets, layer.mask))
            self._passes.composite.run(layer.color, plan, layer.listed, out)
            yield "composite"
        if listed is not None:
            drawn = self._passes.draw_lamps.steps(listed, picture, optics, out)
            yield from _named("lamps drawn", drawn)
        return out

    def _tell_progress(self, done: int, layers: int) -> None:
        """Only who listens waits for the GPU at each layer."""
        if self.on_layer is not None:
            self._ctx.finish()
            self.on_layer(done, layers)

    def _at_proxy_size(
        self, color: moderngl.Texture, depth: moderngl.Texture, optics: Optics, proxy: float
    ) -> Steps[tuple[moderngl.Texture, moderngl.Texture]]:
        """The plate at proxy size, which no lens changes: made again for another size or plate."""
        size = proxy_size(color.size, proxy)
        out_color = self.pool.texture("proxy colour", size, 4)
        out_depth = self.pool.texture("proxy depth", size, 1)
        if self._proxy_held != proxy:
            scale = proxy if optics.line is None else 1.0
            self._passes.proxy.run(color, depth, scale, out_color, out_depth)
            self._proxy_held = proxy
            yield "proxy"
        return out_color, out_depth

    def forget_plate(self) -> None:
        """The plate's textures hold another plate now."""
        self._proxy_held = 1.0

    def _room_for_low(self, lists: ListedFragments) -> ListsWithoutHighlights:
        words = self.pool.buffer("low fragments", lists.held.words.size)
        return ListsWithoutHighlights(lists, words)

    def _without_lamps(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        kernel: Kernel,
        optics: Optics,
        lists: ListsWithoutHighlights | None,
    ) -> Steps[tuple[moderngl.Texture, HighlightBuffers]]:
        size, pool = color.size, self.pool
        low, high = pool.texture("low", size, 4), pool.texture("layer", size, 4)
        sizes = HighlightBuffers.sizes(size)
        lamps = HighlightBuffers(**{name: pool.buffer(name, sizes[name]) for name in sizes})
        half = Surroundings.half_size(size)
        scratch = Surroundings(
            pool.texture("cost", half, 4),  # dead before there are costs, or layers of half size
            pool.texture("layer coc / 2", half, 1),
            BlurTargets(self._poles(size, kernel), pool.texture("layer / 2", half, 4)),
        )
        split = self._passes.split_lamps.steps(color, coc, optics, scratch, low, high, lists)
        yield from _named("lamps found", split)
        listed = self._passes.list_lamps.steps(high, optics, lamps, low, coc, lists)
        yield from _named("lamps listed", listed)
        return low, lamps

    def _fragmented(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        lists: ListedFragments | None,
    ) -> Fragments:
        size, pool = color.size, self.pool
        picture = Fragments(
            color,
            coc,
            pool.texture("kind", size, 1, "f2"),
            pool.texture("far", size, 4, "f2"),
            pool.texture("near", size, 4, "f2"),
            lists,
        )
        pixels = pool.buffer("pixels", list_bytes(size))
        self._passes.fragments.run(picture, optics.at_infinity_px, pixels)
        return picture

    def _layer(
        self,
        picture: Fragments,
        plan: LayerPlan,
        where: tuple[TileMask, TileList],
        optics: Optics,
    ) -> Steps[tuple[Layer, moderngl.Texture]]:
        """A layer without holes, and its coc, in the tiles that are to be worked on."""
        size, pool = plan.size(picture.coc.size), self.pool
        pixels = pool.buffer("pixels", list_bytes(picture.coc.size))
        color = pool.filled(_of_size("layer", plan), size, _NOTHING)  # also where enlarging looks
        told = None
        if picture.lists is not None:
            told = pool.texture(_of_size("told", plan), size, 2, "f2")
        layer = Layer(color, pool.texture(_of_size("state", plan), size, 2), *where, told)
        yield from _named("layer split", self._passes.split.steps(picture, plan, pixels, layer))
        if not plan.cut.is_nearest:
            hidden = self._passes.hidden.steps(
                layer,
                pixels,
                HiddenScratch(
                    pool.buffer("bits", HiddenFillPass.bits_bytes(picture.coc.size)),
                    pool.buffer("blocks", list_bytes(picture.coc.size)),
                    pool.filled(_of_size("cost", plan), block_size(size), _NO_COST),
                ),
                math.ceil(plan.uncovered_px / plan.reduction),
            )
            yield from _named("hidden fill", hidden)
        layer_coc = pool.texture(_of_size("layer coc", plan), size, 1)
        between = self._passes.solver.between_size(picture.coc.size)
        rows = pool.texture("fill rows", between, 2)
        scales = optics.disc.spreads
        extend = self._passes.coc_fill.steps(
            layer.state, plan.cut, scales, rows, layer_coc, layer.mask
        )
        yield from _named("coc fill", extend)
        return layer, layer_coc

    def _poles(self, picture_size: tuple[int, int], kernel: Kernel) -> moderngl.TextureArray:
        """What lies between the rows and the columns of a blur; layers of any size share it."""
        between = self._passes.solver.between_size(picture_size)
        return self.pool.array("poles", between, pole_layers(kernel), 4, PACKED)


def _of_size(name: str, plan: LayerPlan) -> str:
    """Layers of each size have textures of their own, or each would be made anew for the next."""
    return name if plan.reduction == 1 else f"{name} / {plan.reduction}"


def _named(name: str, steps: Iterator[None]) -> Iterator[str]:
    return (name for _ in steps)
