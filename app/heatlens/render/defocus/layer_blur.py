"""Blur one layer: split it off, fill its hidden pixels, extend its coc and diffuse it."""

import math
from collections.abc import Iterator

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.defocus.blur_pass import BlurTargets, Diffusion, Over
from heatlens.render.defocus.hidden_fill import Ends, HiddenScratch, Steadiness
from heatlens.render.defocus.layer_passes import CocFillPass, Layer
from heatlens.render.defocus.layer_plan import LayerPlan
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pixel_list import list_bytes
from heatlens.render.defocus.quality import kernel_for
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.steps import Steps
from heatlens.render.defocus.tile_mask import VisiblePixels
from heatlens.render.defocus.tile_pass import LayerTiles
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.program import blocks_for
from heatlens.render.gpu.resources import Buffer, Texture


class LayerBlur:
    """Blurs layers one after the other, in the same textures."""

    def __init__(self, passes: DefocusPasses, scratch: Scratch) -> None:
        self._passes = passes
        self._scratch = scratch

    def steps(
        self,
        picture: UnmixedPicture,
        plan: LayerPlan,
        tiles: LayerTiles,
        optics: Optics,
        settings: DefocusSettings,
        out: Texture,
    ) -> Steps[Layer]:
        """Return the layer of `plan`, blurred, in its active `tiles`.

        If the layer is as large as the picture, the blur itself composites it over `out`; otherwise
        the caller has to.
        """
        layer, layer_coc = yield from self._prepare_layer(picture, plan, tiles, optics)
        is_in_front, rim = plan.cut.is_before_focus, optics.disc.aperture.rim
        diffusion = Diffusion(
            layer.color,
            coc=layer_coc,
            kernel=kernel_for(settings, -rim if is_in_front else rim),
            axis_scales=optics.disc.half_extents,
            resampled_px_2=plan.resampled_px_2,
            shape=optics.disc.scaled(1 / plan.reduction),
            is_in_front=is_in_front,
            corner=layer.size,
        )
        poles = self._passes.poles(self._scratch, "poles", picture.coc.size, kernel_for(settings))
        over = Over(out, plan.cut.is_farthest) if plan.reduction == 1 else None
        blur = self._passes.blur.steps(diffusion, BlurTargets(poles, layer.color, over), layer.mask)
        yield from self._scratch.run_pass("blur", blur)
        return layer

    def _prepare_layer(
        self, picture: UnmixedPicture, plan: LayerPlan, tiles: LayerTiles, optics: Optics
    ) -> Steps[tuple[Layer, Texture]]:
        """Return a layer with its hidden pixels filled, and its diameters, in the active tiles."""
        picture_size, scratch = picture.coc.size, self._scratch
        hidden = scratch.buffer("hidden list", list_bytes(picture_size))
        color = scratch.texture("layer", picture_size, 4)
        state = scratch.texture("layer state", picture_size, 2)
        list_info = (
            None if picture.lists is None else scratch.texture("known", picture_size, 2, "f2")
        )
        layer = Layer(color, state, plan.size(picture_size), tiles.mask, tiles.tile_list, list_info)
        split = self._passes.split.steps(picture, plan, hidden, layer)
        yield from self._scratch.run_pass("layer split", split)
        if not plan.cut.is_nearest:  # nothing hides the nearest layer
            yield from self._scratch.run_pass(
                "hidden fill", self._fill_hidden(layer, hidden, plan, picture)
            )
        self._scratch.end_pass("hidden fill")  # frees the memory of the nearest layer too
        layer_coc = scratch.texture("layer coc", picture_size, 1)
        row_bytes = CocFillPass.rows_bytes(picture_size)
        rows = (
            scratch.buffer("coc fill diameters", row_bytes),
            scratch.buffer("coc fill weights", row_bytes),
        )
        extend = self._passes.coc_fill.steps(
            state, plan.cut, optics.disc.spreads, rows, layer_coc, layer.mask, layer.size
        )
        yield from self._scratch.run_pass("coc fill", extend)
        return layer, layer_coc

    def _fill_hidden(
        self,
        layer: Layer,
        hidden: Buffer,
        plan: LayerPlan,
        picture: UnmixedPicture,
    ) -> Iterator[None]:
        """Guess the pixels of `layer` in the list `hidden`, in short steps."""
        picture_size, blocks = picture.coc.size, blocks_for(picture.coc.size, 2)
        hidden_scratch = HiddenScratch(
            visible=VisiblePixels(
                self._scratch.buffer("visible bits", VisiblePixels.bytes_for(picture_size)),
                self._scratch.buffer("visible words", VisiblePixels.bytes_for(picture_size)),
            ),
            blocks=self._scratch.buffer("hidden blocks", list_bytes(picture_size)),
            cost=self._scratch.texture("hidden cost", blocks, 4),
            match=self._scratch.texture("hidden match", blocks, 4)
            if picture.lists is not None and not picture.lists.is_exact
            else None,
            lines=self._line_memory(picture_size) if plan.follows_lines else None,
        )
        reach_px = math.ceil(plan.uncovered_px / plan.reduction)
        # only a layer in focus, at full size, may hold highlights
        around = picture.around if plan.is_in_focus and plan.reduction == 1 else None
        ends = Ends(picture.coc, plan.cut, plan.is_entered and picture.lists is None)
        return self._passes.hidden.steps(
            layer,
            hidden,
            hidden_scratch,
            reach_px,
            ends,
            around,
            plan.shape_share,
            plan.shows_pixels,
        )

    def _line_memory(self, picture_size: tuple[int, int]) -> Steadiness:
        """Return memory for how steady rows and columns are."""
        rows, columns = Steadiness.sizes(picture_size)
        return Steadiness(
            self._scratch.texture("steady rows", rows, 1),
            self._scratch.texture("steady columns", columns, 1),
        )
