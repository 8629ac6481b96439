"""The one way through: (shot, frame) in, picture out. Window, command line and export call this."""

from collections.abc import Callable

import moderngl
import numpy as np
import numpy.typing as npt

from heatlens.defocus.line_solver import LineSolver
from heatlens.defocus.optics import Optics, occupied_values
from heatlens.defocus.pipeline import DefocusPipeline
from heatlens.defocus.plate_passes import proxy_size
from heatlens.defocus.solver_choice import fastest_solver
from heatlens.errors import InputError
from heatlens.gpu.context import check_plate_fits, check_work_fits
from heatlens.gpu.stopwatch import Stopwatch
from heatlens.gpu.textures import FloatArray, download, new_texture, upload
from heatlens.image.plate import Plate
from heatlens.model.coc import axis_scales, coc_line
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot


class FrameRenderer:
    """Holds one plate on the GPU and renders it through any lens."""

    def __init__(self, ctx: moderngl.Context, solver: LineSolver | None = None) -> None:
        """`solver` None: the one that is fastest here, by measurement."""
        self.ctx = ctx
        self.stopwatch = Stopwatch(ctx)
        self.solver = solver or fastest_solver(ctx)
        self._pipeline = DefocusPipeline(ctx, self.solver, self.stopwatch)
        self._plate: Plate | None = None
        self._occupied = np.zeros(0)
        self._checked_size = (0, 0)
        self._color: moderngl.Texture | None = None
        self._depth: moderngl.Texture | None = None

    def load(self, plate: Plate) -> None:
        """Take a plate to the GPU; once a file, not once a frame."""
        size = (plate.data_window.width, plate.data_window.height)
        check_plate_fits(self.ctx, *size)
        if self._color is None or self._depth is None or self._color.size != size:
            for texture in (self._color, self._depth):
                if texture is not None:
                    texture.release()
            self._color = new_texture(self.ctx, size, 4, label="plate colour")
            self._depth = new_texture(self.ctx, size, 1, label="plate depth")
        upload(self._color, plate.color)
        upload(self._depth, _depth_or_coc(plate))
        self._occupied = occupied_of(plate)
        self._plate = plate

    def render(self, shot: Shot, frame: int = 0) -> moderngl.Texture:
        """The picture through the shot's lens at `frame`: RGBA float32, premultiplied, proxy size.

        The texture is the renderer's own; the next render overwrites it.
        """
        if self._plate is None or self._color is None or self._depth is None:
            raise InputError("No plate is loaded.")
        self._check_work(proxy_size(self._color.size, shot.defocus.proxy))
        optics = self.optics(shot, frame)
        return self._pipeline.run(
            self._color, self._depth, optics, shot.defocus, self._plate.has_alpha
        )

    def optics(self, shot: Shot, frame: int = 0) -> Optics:
        """The shot's lens at `frame` in front of the loaded plate, in its full-size pixels."""
        if self._plate is None:
            raise InputError("No plate is loaded.")
        return optics_of(self._plate, self._occupied, shot.lens_at(frame))

    def _check_work(self, size: tuple[int, int]) -> None:
        if size != self._checked_size:
            check_work_fits(self.ctx, *size)
            self._checked_size = size

    def listen(self, on_layer: Callable[[int, int], None] | None) -> None:
        """Have `on_layer(done, layers)` called as a picture comes about; it costs a wait each."""
        self._pipeline.on_layer = on_layer

    def pixels(self, shot: Shot, frame: int = 0) -> FloatArray:
        """`render` read back: (H, W, 4) float32."""
        return download(self.render(shot, frame))


def _depth_or_coc(plate: Plate) -> FloatArray:
    depth = plate.depth_m if plate.depth_m is not None else plate.coc_px
    assert depth is not None
    return np.ascontiguousarray(depth, np.float32)


def occupied_of(plate: Plate) -> npt.NDArray[np.float64]:
    """Where the plate's surfaces lie: dioptres, or pixels of coc where it brings these."""
    if plate.coc_px is not None:
        return occupied_values(plate.coc_px)
    assert plate.depth_m is not None
    return occupied_values(np.float32(1.0) / plate.depth_m)


def optics_of(plate: Plate, occupied: npt.NDArray[np.float64], lens: Lens) -> Optics:
    """The lens in front of this plate, in pixels of its display window."""
    scales = axis_scales(lens.squeeze, plate.pixel_aspect_ratio)
    if plate.coc_px is not None:
        return Optics(None, occupied, scales)
    line = coc_line(lens, plate.display_window.width)
    coc = line.at_infinity_px + line.per_dioptre_px * occupied
    return Optics(line, coc[::-1], scales)  # more dioptres, less coc
