"""Create all passes of the pipeline with their programs."""

from heatlens.render.defocus.blur_pass import PACKED, BlurPass, pole_layers
from heatlens.render.defocus.cutout_pass import CutoutPass
from heatlens.render.defocus.far_guess import FarGuess
from heatlens.render.defocus.hidden_fill import HiddenFillPass
from heatlens.render.defocus.highlights.highlight_draw import HighlightDrawPass
from heatlens.render.defocus.highlights.highlight_list import HighlightListPass
from heatlens.render.defocus.highlights.highlight_shadow import HighlightShadowPass
from heatlens.render.defocus.highlights.highlight_split import HighlightSplitPass
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.layer_passes import (
    CocFillPass,
    CompositePass,
    LayerSplitPass,
    LimitsPass,
)
from heatlens.render.defocus.line_solver import LineSolver
from heatlens.render.defocus.other_methods import OtherMethods
from heatlens.render.defocus.part_views import PartViewsPass
from heatlens.render.defocus.plate_passes import (
    AlphaPass,
    CocPass,
    ColorPass,
    CropPass,
    ProxyPass,
    RescalePass,
)
from heatlens.render.defocus.reduced_plate import ProxyListsPass
from heatlens.render.defocus.scratch import Scratch
from heatlens.render.defocus.tile_pass import TilePass
from heatlens.render.defocus.unmix_pass import UnmixPass
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import TextureArray


class DefocusPasses:
    """Every pass with its programs; pipelines share them."""

    def __init__(self, ctx: Device, solver: LineSolver) -> None:
        self.crop = CropPass(ctx)
        self.rescale = RescalePass(ctx)
        self.proxy = ProxyPass(ctx)
        self.proxy_lists = ProxyListsPass(ctx)
        self.coc = CocPass(ctx)
        self.alpha = AlphaPass(ctx)
        self.colors = ColorPass(ctx)
        self.unmix = UnmixPass(ctx)
        self.solver = solver
        self.tiles = TilePass(ctx)
        self.split = LayerSplitPass(ctx)
        self.hidden = HiddenFillPass(ctx, solver)
        self.coc_fill = CocFillPass(solver)
        self.blur = BlurPass(solver)
        self.far_guess = FarGuess(ctx)
        self.part_views = PartViewsPass(ctx, self.blur, self.coc_fill)
        self.composite = CompositePass(ctx)
        self.cutout = CutoutPass(ctx)
        self.limits = LimitsPass(ctx)
        self.split_highlights = HighlightSplitPass(ctx, self.blur)
        self.list_highlights = HighlightListPass(ctx)
        self.shade_highlights = HighlightShadowPass(ctx)
        self.draw_highlights = HighlightDrawPass(ctx)
        self.others = OtherMethods(ctx)

    def poles(
        self, scratch: Scratch, name: str, picture_size: tuple[int, int], kernel: Kernel
    ) -> TextureArray:
        """Return the image between rows and columns of a blur, which layers of any size share.

        `name` is its name in `scratch`.
        """
        between = self.solver.size_between_axes(picture_size)
        return scratch.array(name, between, pole_layers(kernel), 4, PACKED)
