"""Run the passes of the blur in their order, in textures that they share.

A picture is rendered in steps, each named after its pass, so that a window can handle input in
between. The comment below describes what each pass of a film frame does, and why it is there.
"""

# The method is that of M. Kass, A. Lefohn and J. Owens, "Interactive Depth of Field Using Simulated
# Diffusion on a GPU" (Pixar Technical Memo 06-01, 2006). Color is heat that spreads along rows and
# then along columns of a plate whose conductance is the square of the circle of confusion (coc).
# Where a pixel is in focus nothing flows, so that the blur stops dead at a sharp silhouette, and
# the cost of a pixel does not depend on the size of its blur. Three things depart from the paper:
#
# - The disc. One implicit step turns a point of light into a four-pointed star. Any rational
#   function of the Laplacian insulates as well, and one of a few complex poles makes a flat disc
#   (`kernels.py`, fitted by `fit_kernels.py`). FLIP of two plates of spheres against path-traced
#   truth, in a prototype: .098 and .142 with the paper's step, .031 and .042 with four poles.
#   Beyond the frame the pixel at the border goes on; the paper's lines end there.
# - The layers. The paper blurs what is in front over what is behind it. Here the picture is cut in
#   the gaps between its depths (`layer_cuts.py`), pixels of silhouettes are taken apart first, and
#   the hidden background follows the structures that end at the silhouette.
# - The solver. The paper's cyclic reduction goes through memory log2(n) times. Here a line stays in
#   registers and shared memory (`line_solver.py`), and only active tiles are solved.
#
# The passes of `pass_list.py` in their order, with what they read -> what they write:
#
# proxy              color and depth -> the same, smaller, for previews. Depth is the sample in the
#                    middle of a pixel: a mean of two depths would be a surface that is not there.
# coc                depth -> signed diameter of the disc of each pixel, negative before the focus.
#                    It is the only pass that knows the lens; all later ones read coc alone.
# alpha              alpha -> a picture of its own, blurred before the color in the same way.
# highlights found   color, coc -> the highlights, to draw, and the rest, to diffuse. The ripple of
#                    a sum of exponentials is a few per cent, and a few per cent of a lamp that is
#                    300 times as bright as the wall behind it are rings. Surroundings are at half
#                    size.
# highlights listed  highlights -> at most 8,192 discs. Beyond that they go back to the rest.
# far parts          lists of surfaces (known, or guessed by `far_guess.py`) -> the mean of the
#                    views of parts of the lens behind the focus. Only for the quality final: in one
#                    layer, surfaces of different blur keep light from each other.
# fragments          color, coc -> for each pixel of a silhouette its nearer and its farther
#                    color and the coverage. Anti-aliasing has mixed both, and depth knows one of
#                    them; unsplit, the nearer color leaks into the blurred background as streaks.
# tiles              coc, fragments -> the tiles in which each layer can be seen. A layer is solved
#                    in these alone, which is why empty or hidden layers cost next to nothing.
#
# Then for each layer, far to near, because each is composited over those behind it:
#
# layer split        fragments -> color times coverage, coverage and coc of one layer, at the size
#                    that its blur allows; and the list of its pixels that nearer layers hide.
# hidden fill        visible pixels of the layer -> a guess of the hidden ones, which the blur of
#                    nearer layers uncovers. Known surfaces are taken before a guess.
# coc fill           coc of the layer -> coc also beyond its content, so that a near layer spreads
#                    with its own blur (the paper's section 4, "blurring underneath").
# blur               color, coc -> the diffused layer. One that is as large as the picture is
#                    composited by the last solve itself, which saves a pass over memory.
# composite          a smaller layer -> the picture, enlarged.
#
# And once more for the picture:
#
# whole parts        lists of known surfaces -> the mean of the views of parts of the lens, of all
#                    depths, around wide surfaces before the focus. Layers cannot tell which part
#                    of the lens sees past a near edge. Only for the quality final.
# highlights drawn   the list of discs -> added over all layers. They come last because a disc is
#                    hidden by a ray from each point of the lens, which layers cannot tell.
# limits             the picture of one layer -> light not below 0, which the ripple of a kernel
#                    falls below. With layers, each composition does that (`lib/over.lib.glsl`).
# colours            the channel that was in focus for this color -> the picture. With axial color
#                    everything from coc on runs three times, each with a focus of its own.

from collections.abc import Callable
from dataclasses import replace
from typing import assert_never

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method
from heatlens.render.defocus.blur_pass import BlurTargets, Diffusion
from heatlens.render.defocus.color_rounds import ColorRounds
from heatlens.render.defocus.cutout_pass import SharpPart
from heatlens.render.defocus.layered_blur import LayeredBlur, LayeredPicture
from heatlens.render.defocus.listed_fragments import listed_through
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.quality import kernel_for, layers_for
from heatlens.render.defocus.reduced_plate import PlateTextures, ReducedPlate
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import ONLY, Steps
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture

# These methods handle a different focus for each color themselves.
SAMPLING_COLORS = (Method.GATHER, Method.SCATTER)
_ENLARGED_PROXY, _ENLARGED_MOST = 0.5, 3  # size that previews are enlarged to, and how far at most
LayerCallback = Callable[[int, int], None]  # called with the layers done and their number


class DefocusPipeline:
    """Renders a picture with depth of field from color and depth, in its own textures."""

    def __init__(
        self,
        ctx: Device,
        passes: DefocusPasses,
        layer_callback: Callable[[], LayerCallback | None] = lambda: None,
    ) -> None:
        """Create it; `layer_callback` returns what to call after each layer, None for nothing."""
        self._ctx = ctx
        self._passes = passes
        self.scratch = Scratch(ctx)
        self._reduced = ReducedPlate(ctx, plate_pass=passes.proxy, lists_pass=passes.proxy_lists)
        self._color_rounds = ColorRounds(passes.colors)
        self._layered = LayeredBlur(passes, self.scratch, self._report_progress)
        self._layer_callback = layer_callback

    def steps(
        self,
        plate: PlateTextures,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool = False,
        enlarges: bool = False,
    ) -> Steps[Texture]:
        """Render the picture with depth of field, and return it: RGBA float32, at proxy size.

        With `enlarges` a small picture may be larger, so that its highlights are round. The next
        run overwrites the returned texture. The plate's depth is a signed coc in pixels if
        `optics.line` is None. Without `has_alpha` the result's alpha is 1. Methods with one layer
        ignore the plate's fragments.
        """
        if plate.cutout is not None:
            plate = replace(plate, color=plate.cutout.clean_color, depth=plate.cutout.clean_depth)
        self.scratch.begin_picture()
        if settings.proxy < 1.0:
            reduced = yield from self._reduced.steps(plate, optics, settings, self.scratch)
            # Without known surfaces a reduced plate lists only the two at each silhouette. They do
            # not suffice for blurring the far field in parts of the lens.
            if plate.fragments is None:
                settings = replace(settings, parts=1)
            plate, optics = reduced, optics.scaled(settings.proxy)

        def blur_once(color_optics: Optics) -> Steps[Texture]:
            # The ground goes behind the blurred picture, which needs its alpha for that.
            backdrop = None if plate.cutout is None else plate.cutout.backdrop
            needs_alpha = has_alpha or bool(backdrop)
            picture = yield from self._blur(plate, color_optics, settings, needs_alpha, enlarges)
            if backdrop is not None:
                self._passes.cutout.over_backdrop(backdrop, picture, is_opaque=not has_alpha)
            return picture

        if optics.disc.axial_px == 0.0 or settings.method in SAMPLING_COLORS:
            return (yield from self._color_rounds.run_once(blur_once, optics))
        return (
            yield from self._color_rounds.run_for_each_color(
                blur_once, optics, plate.color.size, self.scratch
            )
        )

    def _blur(
        self,
        plate: PlateTextures,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool,
        enlarges: bool,
    ) -> Steps[Texture]:
        """Return the blurred picture at proxy size or enlarged, with one focus for all colors."""
        color, cutout, sharp = plate.color, plate.cutout, None
        coc = yield from self._compute_coc("coc", plate.depth, optics)
        if cutout is not None:
            sharp_coc = yield from self._compute_coc("cutout coc", cutout.depth, optics)
            sharp = SharpPart(cutout.light, cutout.alpha, sharp_coc)
        if layers_for(settings) == 1:
            blurred = yield from self._blur_in_one_layer(color, coc, optics, settings)
            if sharp is not None:
                self._passes.cutout.on_top(sharp, coc, blurred)
            self._passes.limits.run(blurred, is_opaque=not has_alpha)
            yield self.scratch.end_pass("limits")
            return blurred
        has_highlights = settings.bokeh is Bokeh.DISC
        lists = listed_through(plate.fragments, optics, has_alpha)
        may_guess = lists is None and not has_alpha and settings.proxy == 1.0
        # Alpha, cutouts and single colors are joined with pictures of the proxy size.
        is_joined = has_alpha or sharp is not None or optics.disc.axial_px != 0.0
        enlarged = _enlargement(settings) if enlarges and not is_joined else 1
        source = LayeredPicture(
            *(color, coc, has_highlights, lists, sharp, plate.positions, may_guess, enlarged)
        )
        if not has_alpha:
            return (yield from self._layered.steps(source, optics, settings, "out"))
        return (yield from self._blur_with_alpha(source, optics, settings))

    def _blur_with_alpha(
        self, source: LayeredPicture, optics: Optics, settings: DefocusSettings
    ) -> Steps[Texture]:
        """Blur alpha as a picture of its own, then the color; return both joined, RGBA."""
        alpha_color = self.scratch.texture("alpha plate", source.color.size, 4)
        self._passes.alpha.as_color(source.color, alpha_color)
        yield self.scratch.end_pass("alpha")
        alpha_source = LayeredPicture(
            alpha_color,
            source.coc,
            has_highlights=False,
            lists=source.lists and source.lists.of_alpha(),
            sharp=source.sharp and source.sharp.of_alpha(),
        )
        first_turn, second_turn = ONLY.halves
        alpha = yield from self._layered.steps(
            alpha_source, optics, settings, "alpha out", first_turn
        )
        out = yield from self._layered.steps(source, optics, settings, "out", second_turn)
        self._passes.alpha.join(alpha, out)
        yield self.scratch.end_pass("alpha")
        return out

    def _compute_coc(self, name: str, depth: Texture, optics: Optics) -> Steps[Texture]:
        """Return the signed coc in pixels for a depth texture, which may contain coc already.

        `name` is the name of the new texture in the scratch memory.
        """
        if optics.line is None and not optics.plate_shift_px:
            return depth
        coc = self.scratch.texture(name, depth.size, 1)
        steps = self._passes.coc.steps(depth, optics.line, coc, optics.plate_shift_px)
        yield from self.scratch.run_pass("coc", steps)
        return coc

    def _blur_in_one_layer(
        self, color: Texture, coc: Texture, optics: Optics, settings: DefocusSettings
    ) -> Steps[Texture]:
        """Diffuse without layers, or use another method, which may handle depth itself."""
        others, inputs = self._passes.others, (color, coc, optics, self.scratch)
        blurred = self.scratch.texture("blurred", color.size, 4)
        match settings.method:
            case Method.GATHER:
                yield from self.scratch.run_pass("gather", others.gather(*inputs))
            case Method.SCATTER:
                yield from self.scratch.run_pass("scatter", others.scatter(*inputs))
            case Method.PYRAMID:
                yield from self.scratch.run_pass("pyramid", others.pyramid(*inputs))
            case Method.DIFFUSION | Method.HEAT:
                disc = optics.disc
                diffusion = Diffusion(
                    color, coc, kernel_for(settings), disc.half_extents, shape=disc
                )
                poles = self._passes.poles(self.scratch, "poles", color.size, diffusion.kernel)
                targets = BlurTargets(poles, blurred)
                yield from self.scratch.run_pass(
                    "blur", self._passes.blur.steps(diffusion, targets)
                )
            case Method.ACCUMULATION | Method.RAYTRACED:
                raise ValueError(f"{settings.method} renders a 3D scene and cannot blur a plate.")
            case _:
                assert_never(settings.method)
        return blurred

    def _report_progress(self, done: int, layers: int) -> None:
        """Report the layers that are done; wait for the GPU only if there is a callback."""
        on_layer = self._layer_callback()
        if on_layer is not None:
            self._ctx.finish()
            on_layer(self._color_rounds.done * layers + done, self._color_rounds.count * layers)

    def forget_plate(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._reduced.forget()


def _enlargement(settings: DefocusSettings) -> int:
    """Return how many times as large as the proxy the discs of highlights are drawn."""
    return min(max(round(_ENLARGED_PROXY / settings.proxy), 1), _ENLARGED_MOST)
