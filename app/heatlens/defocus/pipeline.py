"""Order of the passes; owns every texture between them and reuses it.

plate -> proxy -> coc -> fragments -> each layer, far to near: split, fill what is hidden,
extend its coc, blur, composite -> picture
"""

from collections.abc import Callable

import moderngl

from heatlens.defocus.blur_pass import BlurPass, BlurTargets, pole_layers
from heatlens.defocus.fragment_pass import FragmentPass, Fragments
from heatlens.defocus.highlight_pass import (
    HighlightBuffers,
    HighlightDrawPass,
    HighlightListPass,
    HighlightSplitPass,
)
from heatlens.defocus.kernels import Kernel
from heatlens.defocus.layer_cuts import LayerCut, layer_cuts
from heatlens.defocus.layer_passes import (
    CocFillPass,
    CompositePass,
    HiddenFillPass,
    Layer,
    LayerSplitPass,
    LimitsPass,
)
from heatlens.defocus.line_solver import LineSolver
from heatlens.defocus.optics import Optics
from heatlens.defocus.pixel_list import list_bytes
from heatlens.defocus.plate_passes import AlphaPass, CocPass, ProxyPass, proxy_size
from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.gpu.stopwatch import Stopwatch
from heatlens.gpu.textures import TexturePool
from heatlens.model.settings import Bokeh, DefocusSettings


class DefocusPipeline:
    """Colour and depth to a picture with depth of field."""

    def __init__(self, ctx: moderngl.Context, solver: LineSolver, stopwatch: Stopwatch) -> None:
        self._ctx = ctx
        self._time = stopwatch.measure
        self.on_layer: Callable[[int, int], None] | None = None  # layers done, of all
        self._pool = TexturePool(ctx)
        self._proxy = ProxyPass(ctx)
        self._coc = CocPass(ctx)
        self._alpha = AlphaPass(ctx)
        self._fragments = FragmentPass(ctx)
        self._split = LayerSplitPass(ctx)
        self._hidden = HiddenFillPass(ctx)
        self._coc_fill = CocFillPass(solver)
        self._blur = BlurPass(ctx, solver)
        self._composite = CompositePass(ctx)
        self._limits = LimitsPass(ctx)
        self._split_lamps = HighlightSplitPass(ctx, self._blur)
        self._list_lamps = HighlightListPass(ctx)
        self._draw_lamps = HighlightDrawPass(ctx)

    def run(
        self,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool = False,
    ) -> moderngl.Texture:
        """The picture with depth of field, RGBA float32, proxy size; the next run overwrites it.

        `color` is RGBA, `depth` metres, or signed coc in pixels if `optics.line` is None. Without
        `has_alpha` the result's alpha is 1.
        """
        if settings.proxy < 1.0:
            color, depth = self._at_proxy_size(color, depth, optics, settings.proxy)
            optics = optics.scaled(settings.proxy)
        coc = self._circle_of_confusion(depth, optics)
        if layers_for(settings) == 1:
            blurred = self._blurred(color, coc, kernel_for(settings), optics)
            with self._time("limits"):
                self._limits.run(blurred, is_opaque=not has_alpha)
            return blurred
        if not has_alpha:
            return self._layered(color, coc, optics, settings, "out", settings.bokeh is Bokeh.DISC)
        alpha_color = self._pool.texture("alpha plate", color.size, 4)
        self._alpha.as_color(color, alpha_color)
        alpha = self._layered(alpha_color, coc, optics, settings, "alpha out", lamps=False)
        out = self._layered(color, coc, optics, settings, "out", settings.bokeh is Bokeh.DISC)
        self._alpha.join(alpha, out)
        return out

    def _layered(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        settings: DefocusSettings,
        name: str,
        lamps: bool,
    ) -> moderngl.Texture:
        """Layers far to near, blurred and put over each other in the texture called `name`."""
        kernel = kernel_for(settings)
        out = self._pool.texture(name, color.size, 4)
        listed = None
        if lamps:
            color, listed = self._without_lamps(color, coc, kernel, optics)
        picture = self._fragmented(color, coc, optics)
        cuts = layer_cuts(optics.occupied_px, layers_for(settings))
        for number, cut in enumerate(cuts):
            self._tell_progress(number, len(cuts))
            layer, layer_coc = self._layer(picture, cut, optics)
            blurred = self._blurred(layer.color, layer_coc, kernel, optics)
            with self._time("composite"):
                self._composite.run(blurred, cut.is_farthest, out)
        if listed is not None:
            with self._time("lamps drawn"):
                self._draw_lamps.run(listed, picture, optics, out)
        return out

    def _tell_progress(self, done: int, layers: int) -> None:
        """Only who listens waits for the GPU at each layer."""
        if self.on_layer is not None:
            self._ctx.finish()
            self.on_layer(done, layers)

    def _at_proxy_size(
        self, color: moderngl.Texture, depth: moderngl.Texture, optics: Optics, proxy: float
    ) -> tuple[moderngl.Texture, moderngl.Texture]:
        size = proxy_size(color.size, proxy)
        out_color = self._pool.texture("proxy colour", size, 4)
        out_depth = self._pool.texture("proxy depth", size, 1)
        with self._time("proxy"):
            scale = proxy if optics.line is None else 1.0
            self._proxy.run(color, depth, scale, out_color, out_depth)
        return out_color, out_depth

    def _circle_of_confusion(self, depth: moderngl.Texture, optics: Optics) -> moderngl.Texture:
        if optics.line is None:
            return depth
        coc = self._pool.texture("coc", depth.size, 1)
        with self._time("coc"):
            self._coc.run(depth, optics.line, coc)
        return coc

    def _without_lamps(
        self, color: moderngl.Texture, coc: moderngl.Texture, kernel: Kernel, optics: Optics
    ) -> tuple[moderngl.Texture, HighlightBuffers]:
        size, pool = color.size, self._pool
        low, high = pool.texture("low", size, 4), pool.texture("layer", size, 4)
        sizes = HighlightBuffers.sizes(size)
        lamps = HighlightBuffers(**{name: pool.buffer(name, sizes[name]) for name in sizes})
        with self._time("lamps found"):
            targets = BlurTargets(
                pool.array("poles", size, pole_layers(kernel), 4, "f2"),
                pool.texture("blurred", size, 4),
            )
            luminance = pool.texture("out", size, 4)
            self._split_lamps.run(color, coc, optics, luminance, targets, low, high)
        with self._time("lamps listed"):
            self._list_lamps.run(high, optics, lamps, low)
        return low, lamps

    def _fragmented(
        self, color: moderngl.Texture, coc: moderngl.Texture, optics: Optics
    ) -> Fragments:
        size, pool = color.size, self._pool
        picture = Fragments(
            color,
            coc,
            pool.texture("kind", size, 1, "f2"),
            pool.texture("far", size, 4, "f2"),
            pool.texture("near", size, 4, "f2"),
        )
        with self._time("fragments"):
            pixels = pool.buffer("pixels", list_bytes(size))
            self._fragments.run(picture, optics.at_infinity_px, pixels)
        return picture

    def _layer(
        self, picture: Fragments, cut: LayerCut, optics: Optics
    ) -> tuple[Layer, moderngl.Texture]:
        """A layer without holes, and its coc everywhere."""
        size, pool = picture.coc.size, self._pool
        pixels = pool.buffer("pixels", list_bytes(size))
        layer = Layer(pool.texture("layer", size, 4), pool.texture("state", size, 2))
        with self._time("layer split"):
            self._split.run(picture, cut, pixels, layer)
        if not cut.is_nearest:
            with self._time("hidden fill"):
                self._hidden.run(
                    layer,
                    pixels,
                    pool.buffer("bits", HiddenFillPass.bits_bytes(size)),
                    pool.texture("blurred", size, 4),
                    picture.coc,
                    cut,
                    optics.uncovered_px,
                )
        layer_coc = pool.texture("layer coc", size, 1)
        with self._time("coc fill"):
            self._coc_fill.run(layer.state, pool.texture("fill rows", size, 2), layer_coc)
        return layer, layer_coc

    def _blurred(
        self, color: moderngl.Texture, coc: moderngl.Texture, kernel: Kernel, optics: Optics
    ) -> moderngl.Texture:
        targets = BlurTargets(
            self._pool.array("poles", color.size, pole_layers(kernel), 4, "f2"),
            self._pool.texture("blurred", color.size, 4),
        )
        with self._time("blur"):
            self._blur.run(color, coc, kernel, optics.axis_scales, targets)
        return targets.out_color
