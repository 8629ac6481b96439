"""Blur one layer of a picture: split it off, fill hidden pixels, extend the coc, and diffuse."""

import math
from collections.abc import Iterator

import moderngl

from heatlens.defocus.blur_pass import BlurTargets, Diffusion, Over
from heatlens.defocus.fragment_pass import Fragments
from heatlens.defocus.layer_passes import HiddenScratch, Layer, block_size
from heatlens.defocus.layer_plan import LayerPlan
from heatlens.defocus.optics import Optics
from heatlens.defocus.passes import DefocusPasses
from heatlens.defocus.pixel_list import list_bytes
from heatlens.defocus.quality import kernel_for
from heatlens.defocus.scratch import Scratch
from heatlens.defocus.steps import Steps
from heatlens.defocus.tile_pass import LayerTiles
from heatlens.gpu.buffer_parts import BufferPart
from heatlens.model.shot.settings import DefocusSettings


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
    ) -> Steps[tuple[Layer, moderngl.Texture]]:
        """Return a layer with hidden pixels filled, and its coc, in the active tiles."""
        size, scratch, reduction = plan.size(picture.coc.size), self._scratch, plan.reduction
        hidden = scratch.buffer("hidden list", list_bytes(picture.coc.size))
        color = scratch.texture("layer", size, 4, reduction=reduction)
        state = scratch.texture("layer state", size, 2, reduction=reduction)
        told = None
        if picture.lists is not None:
            told = scratch.texture("told", size, 2, "f2", reduction)
        layer = Layer(color, state, where.mask, where.listed, told)
        split = self._passes.split.steps(picture, plan, hidden, layer)
        yield from self._scratch.named("layer split", split)
        if not plan.cut.is_nearest:
            yield from self._scratch.named(
                "hidden fill", self._hidden_fill(layer, hidden, plan, picture, where.seen)
            )
        self._scratch.passed("hidden fill")
        layer_coc = scratch.texture("layer coc", size, 1, reduction=reduction)
        between = self._passes.solver.between_size(picture.coc.size)
        rows = scratch.texture("coc fill rows", between, 2)
        extend = self._passes.coc_fill.steps(
            layer.state, plan.cut, optics.disc.spreads, rows, layer_coc, layer.mask
        )
        yield from self._scratch.named("coc fill", extend)
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
            self._scratch.buffer("hidden blocks", list_bytes(whole)),
            self._scratch.texture("hidden cost", blocks, 4, reduction=plan.reduction),
            self._scratch.texture("hidden match", blocks, 4, reduction=plan.reduction)
            if picture.lists is not None and not picture.lists.is_exact
            else None,
        )
        reach_px = math.ceil(plan.uncovered_px / plan.reduction)
        around = picture.around if plan.is_in_focus and plan.reduction == 1 else None
        return self._passes.hidden.steps(layer, hidden, work, reach_px, around)
