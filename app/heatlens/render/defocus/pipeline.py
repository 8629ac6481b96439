"""Run the passes of the blur in their order, in textures that they share.

A picture is rendered in steps, each named after its pass, so that a window can handle input in
between.

plate -> proxy -> coc -> layers, far to near (`layered_blur`), or another method -> out
"""

from collections.abc import Callable
from dataclasses import replace
from typing import assert_never

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method
from heatlens.render.defocus.blur_pass import BlurTargets, Diffusion
from heatlens.render.defocus.cutout_pass import SharpPart
from heatlens.render.defocus.layered_blur import LayeredBlur, LayeredPicture
from heatlens.render.defocus.listed_fragments import listed_through
from heatlens.render.defocus.optics import Color, Optics
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.plate_passes import ColorPass
from heatlens.render.defocus.quality import kernel_for, layers_for
from heatlens.render.defocus.reduced_plate import PlateTextures, ReducedPlate
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import ONLY, Steps
from heatlens.render.gpu.device import Device, Texture

# These methods handle a different focus for each colour themselves.
SAMPLING_COLORS = (Method.GATHER, Method.SCATTER)


class DefocusPipeline:
    """Renders a picture with depth of field from colour and depth, in its own textures."""

    def __init__(self, ctx: Device, passes: DefocusPasses) -> None:
        self._ctx = ctx
        self._passes = passes
        self.scratch = Scratch(ctx)
        self._reduced = ReducedPlate(ctx, passes.proxy, passes.proxy_lists)
        self._rounds = ColorRounds(passes.colors)
        self._layered = LayeredBlur(passes, self.scratch, self._tell_progress)
        self.on_layer: Callable[[int, int], None] | None = None  # called with layers done and total

    def steps(
        self,
        plate: PlateTextures,
        optics: Optics,
        settings: DefocusSettings,
        has_alpha: bool = False,
    ) -> Steps[Texture]:
        """Render the picture with depth of field, RGBA float32, at proxy size.

        The next run overwrites it.

        The plate's depth is a signed coc in pixels if `optics.line` is None. Without `has_alpha`
        the result's alpha is 1. Methods with one layer ignore the plate's fragments.
        """
        if plate.cutout is not None:
            plate = replace(plate, color=plate.cutout.rest, depth=plate.cutout.rest_depth)
        self.scratch.begin_picture()
        if settings.proxy < 1.0:
            reduced = yield from self._reduced.steps(plate, optics, settings, self.scratch)
            if plate.fragments is None:  # two surfaces at silhouettes do not suffice for parts
                settings = replace(settings, parts=1)
            plate, optics = reduced, optics.scaled(settings.proxy)

        def blurred(seen: Optics) -> Steps[Texture]:
            ground = None if plate.cutout is None else plate.cutout.ground
            picture = yield from self._blurred(plate, seen, settings, has_alpha or bool(ground))
            if ground is not None:
                self._passes.cutout.over_ground(ground, picture, is_opaque=not has_alpha)
            return picture

        if optics.disc.axial_px == 0.0 or settings.method in SAMPLING_COLORS:
            return (yield from self._rounds.in_one(blurred, optics))
        return (yield from self._rounds.in_three(blurred, optics, plate.color.size, self.scratch))

    def _blurred(
        self, plate: PlateTextures, optics: Optics, settings: DefocusSettings, has_alpha: bool
    ) -> Steps[Texture]:
        """Blur a picture at proxy size, with one focus for all colours."""
        color, cutout, sharp = plate.color, plate.cutout, None
        coc = yield from self._coc("coc", plate.depth, optics)
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
        lists = listed_through(plate.fragments, optics, has_alpha)
        may_guess = lists is None and not has_alpha and settings.proxy == 1.0
        what = LayeredPicture(color, coc, has_highlights, lists, sharp, plate.places, may_guess)
        if not has_alpha:
            return (yield from self._layered.steps(what, optics, settings, "out"))
        return (yield from self._with_alpha(what, optics, settings))

    def _with_alpha(
        self, what: LayeredPicture, optics: Optics, settings: DefocusSettings
    ) -> Steps[Texture]:
        """Blur alpha as a picture of its own, then the colour, and join them."""
        alpha_color = self.scratch.texture("alpha plate", what.color.size, 4)
        self._passes.alpha.as_color(what.color, alpha_color)
        yield self.scratch.passed("alpha")
        covers = LayeredPicture(
            alpha_color,
            what.coc,
            has_highlights=False,
            lists=what.lists and what.lists.of_alpha(),
            sharp=what.sharp and what.sharp.of_alpha(),
        )
        first, then = ONLY.halves
        alpha = yield from self._layered.steps(covers, optics, settings, "alpha out", first)
        out = yield from self._layered.steps(what, optics, settings, "out", then)
        self._passes.alpha.join(alpha, out)
        yield self.scratch.passed("alpha")
        return out

    def _coc(self, name: str, depth: Texture, optics: Optics) -> Steps[Texture]:
        """Return the signed coc of a depth, which may be one already."""
        if optics.line is None and not optics.plate_shift_px:
            return depth
        coc = self.scratch.texture(name, depth.size, 1)
        found = self._passes.coc.steps(depth, optics.line, coc, optics.plate_shift_px)
        yield from self.scratch.named("coc", found)
        return coc

    def _in_one_layer(
        self,
        color: Texture,
        coc: Texture,
        optics: Optics,
        settings: DefocusSettings,
    ) -> Steps[Texture]:
        """Diffuse without layers, or use another method, which may handle depth itself."""
        others, work = self._passes.others, (color, coc, optics, self.scratch)
        blurred = self.scratch.texture("blurred", color.size, 4)
        match settings.method:
            case Method.GATHER:
                yield from self.scratch.named("gather", others.gather(*work))
            case Method.SCATTER:
                yield from self.scratch.named("scatter", others.scatter(*work))
            case Method.PYRAMID:
                yield from self.scratch.named("pyramid", others.pyramid(*work))
            case Method.DIFFUSION | Method.HEAT:
                disc = optics.disc
                what = Diffusion(color, coc, kernel_for(settings), disc.half_extents, shape=disc)
                poles = self._passes.poles(self.scratch, "poles", color.size, what.kernel)
                targets = BlurTargets(poles, blurred)
                yield from self.scratch.named("blur", self._passes.blur.steps(what, targets))
            case Method.ACCUMULATION | Method.RAYTRACED:
                raise ValueError(f"{settings.method} renders a 3D scene and cannot blur a plate.")
            case _:
                assert_never(settings.method)
        return blurred

    def _tell_progress(self, done: int, layers: int) -> None:
        """Report the layers that are done; wait for the GPU only if somebody listens."""
        if self.on_layer is not None:
            self._ctx.finish()
            self.on_layer(self._rounds.done * layers + done, self._rounds.count * layers)

    def forget_plate(self) -> None:
        """Forget the reduced plate, because the plate's textures have new content."""
        self._reduced.forget()


# Blurs the picture with one focus for all colours.
Blurred = Callable[[Optics], Steps[Texture]]


class ColorRounds:
    """Runs a blur once, or once for each colour; `done` of `count` rounds are finished."""

    def __init__(self, color_pass: ColorPass) -> None:
        self._pass = color_pass
        self.done, self.count = 0, 1

    def in_one(self, blurred: Blurred, optics: Optics) -> Steps[Texture]:
        """Blur all colours at once."""
        self.done, self.count = 0, 1
        return (yield from blurred(optics))

    def in_three(
        self, blurred: Blurred, optics: Optics, size: tuple[int, int], scratch: Scratch
    ) -> Steps[Texture]:
        """Blur with the focus of each colour and keep that colour; alpha comes with green."""
        kept = scratch.texture("colours kept", size, 4)
        for done, color in enumerate((Color.RED, Color.BLUE)):
            self.done, self.count = done, 3
            picture = yield from blurred(optics.in_color(color))
            self._pass.take(picture, (color,), kept)
            yield "colours"
        self.done, self.count = 2, 3
        picture = yield from blurred(optics.in_color(Color.GREEN))
        self._pass.take(kept, (Color.RED, Color.BLUE), picture)
        yield scratch.passed("colours")
        return picture
