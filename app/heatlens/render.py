"""The one way through: (shot, frame) in, picture out. Window, command line and export call this."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import moderngl
import numpy as np
import numpy.typing as npt

from heatlens.defocus.line_solver import LineSolver
from heatlens.defocus.optics import Optics
from heatlens.defocus.pipeline import DefocusPasses, DefocusPipeline, Result, Steps
from heatlens.defocus.plate_passes import proxy_size
from heatlens.defocus.solver_choice import fastest_solver
from heatlens.errors import InputError
from heatlens.gpu.context import check_plate_fits, check_work_fits
from heatlens.gpu.stopwatch import Stopwatch
from heatlens.gpu.textures import FloatArray, download, new_texture, uploading
from heatlens.model.boxes import Box
from heatlens.model.coc import axis_scales, coc_line
from heatlens.model.framing import Framing, Pose
from heatlens.model.lens import Lens
from heatlens.model.shot import Shot
from heatlens.model.value_bins import ValueBins, bins_of
from heatlens.plate.focus_pick import area_at, middle_m
from heatlens.plate.plate import Plate
from heatlens.scene.scene import Scene

if TYPE_CHECKING:
    from heatlens.scene_gpu.scene_renderer import SceneRenderer


@dataclass(frozen=True, eq=False)
class LoadedPlate:
    """A plate on the GPU."""

    plate: Plate
    color: moderngl.Texture  # RGBA, premultiplied
    depth: moderngl.Texture  # metres, or signed coc in pixels where the plate brings that
    bins: ValueBins  # where its surfaces lie, see `bins_of_plate`

    @property
    def occupied(self) -> npt.NDArray[np.float64]:
        """Ends of the bins that hold a surface, ascending."""
        return self.bins.occupied


class FrameRenderer:
    """Holds one plate or scene on the GPU and renders it through any lens.

    Pictures in different slots, 0, 1 and so on, exist at the same time: one is looked at while the
    next comes about.
    """

    def __init__(self, ctx: moderngl.Context, solver: LineSolver | None = None) -> None:
        """`solver` None: the one that is fastest here, by measurement."""
        self.ctx = ctx
        self.stopwatch = Stopwatch(ctx)
        self.solver = solver or fastest_solver(ctx)
        self._passes = DefocusPasses(ctx, self.solver)
        self._pipelines: dict[int, DefocusPipeline] = {}  # by slot, made when first used
        self._on_layer: Callable[[int, int], None] | None = None
        self._loaded: LoadedPlate | None = None
        self._of_scene: SceneRenderer | None = None
        self._checked_size = (0, 0)

    @property
    def loaded(self) -> LoadedPlate:
        """The plate, or the scene's pinhole picture; InputError before there is one."""
        if self._loaded is None:
            raise InputError("No plate is loaded.")
        return self._loaded

    def beside(self) -> "FrameRenderer":
        """Another renderer with the same solver, which rounds alike, and with nothing loaded.

        What the one renders does not disturb what the other has half done.
        """
        return FrameRenderer(self.ctx, type(self.solver)(self.ctx))

    def load(self, plate: Plate) -> None:
        """Take a plate to the GPU; once a file, not once a frame."""
        drained(self.loading(plate, bins_of_plate(plate)))

    def loading(self, plate: Plate, bins: ValueBins) -> Steps[None]:
        """`load` in short steps, with the plate's `bins_of_plate`.

        Steps that are not taken to their end leave nothing loaded.
        """
        size = (plate.data_window.width, plate.data_window.height)
        check_plate_fits(self.ctx, *size)
        self._forget_scene()
        color, depth = self._textures(size)
        self._loaded = None
        try:
            for texture, pixels in ((color, plate.color), (depth, _depth_or_coc(plate))):
                for _ in uploading(texture, pixels):
                    yield "upload"
            self._take(LoadedPlate(plate, color, depth, bins))
        finally:
            if self._loaded is None:
                color.release()
                depth.release()

    def load_scene(self, scene: Scene) -> None:
        """Take a scene to the GPU; its pictures are drawn as they are asked for."""
        from heatlens.scene_gpu.scene_renderer import SceneRenderer  # plates do without

        of_scene = SceneRenderer(self.ctx, scene)
        self.let_go()
        self._of_scene = of_scene

    def load_scene_of(self, other: "FrameRenderer") -> None:
        """Look at the scene that another renderer of this context holds, without a second copy.

        Once the other has let go of the scene, this one can only let go of it too.
        """
        if other._of_scene is None:
            raise InputError("No scene is loaded.")
        of_scene = other._of_scene.beside()
        self.let_go()
        self._of_scene = of_scene

    def let_go(self) -> None:
        """Give back plate or scene and all the room for work on them; programs stay."""
        self._forget_scene()
        if self._loaded is not None:
            self._loaded.color.release()
            self._loaded.depth.release()
            self._loaded = None
        for pipeline in self._pipelines.values():
            pipeline.forget_plate()
            pipeline.pool.release()

    @property
    def scene(self) -> Scene | None:
        """The scene, where one is loaded."""
        return None if self._of_scene is None else self._of_scene.scene

    def look(self, shot: Shot, frame: int = 0, views: int | None = None) -> LoadedPlate:
        """The plate; of a scene its pinhole picture at `frame`, which is `loaded` from now on.

        `views` None: one that is there already is taken, of however few views it was made.
        """
        drained(self.looking(shot, frame, views))
        return self.loaded

    def pose_at(self, shot: Shot, frame: float) -> Pose | None:
        """Where the camera stands in the scene; None for a plate."""
        return None if self._of_scene is None else self._of_scene.pose_at(shot, frame)

    def scene_depth_m(self, shot: Shot, frame: float, x: int, y: int) -> float:
        """How far away the scene is at a pixel of its picture, at any frame, as a click finds it.

        Raises InputError outside the picture, and where no scene is loaded.
        """
        if self._of_scene is None:
            raise InputError("No scene is loaded.")
        window = Box(0, 0, *(shot.framing or Framing()).size)
        return middle_m(self._of_scene.depth_in(shot, frame, area_at(x, y, window, window)))

    def looking(self, shot: Shot, frame: int, views: int | None = None) -> Steps[None]:
        """`look` in short steps; before the last of them all is as it was."""
        if self._of_scene is None:
            return
        size = (shot.framing or Framing()).size
        check_plate_fits(self.ctx, *size)
        yield from self._of_scene.look(shot, frame, views)
        held = self._of_scene.held
        if self._loaded is None or self._loaded.plate is not held.plate:
            self._take(LoadedPlate(held.plate, held.color, held.depth, held.dioptres))

    def _take(self, loaded: LoadedPlate) -> None:
        for pipeline in self._pipelines.values():
            pipeline.forget_plate()
        self._loaded = loaded

    def _forget_scene(self) -> None:
        if self._of_scene is not None:
            self._of_scene.release()
            self._of_scene = self._loaded = None

    def _textures(self, size: tuple[int, int]) -> tuple[moderngl.Texture, moderngl.Texture]:
        """Those of the plate before where they fit, else new ones in their place."""
        if self._loaded is not None:
            if self._loaded.color.size == size:
                return self._loaded.color, self._loaded.depth
            self._loaded.color.release()
            self._loaded.depth.release()
            self._loaded = None
        return (
            new_texture(self.ctx, size, 4, label="plate colour"),
            new_texture(self.ctx, size, 1, label="plate depth"),
        )

    def render(self, shot: Shot, frame: int = 0) -> moderngl.Texture:
        """The picture through the shot's lens at `frame`: RGBA float32, premultiplied, proxy size.

        The texture is the renderer's own; the next render overwrites it.
        """
        return drained(self.steps(shot, frame))

    def steps(self, shot: Shot, frame: int = 0, slot: int = 0) -> Steps[moderngl.Texture]:
        """`render` in short steps, each the name of a pass; the last one returns the picture.

        Pictures in different slots do not disturb each other, and steps that are not taken to their
        end cost nothing more. Nothing else may be loaded in between.
        """
        if self._of_scene is None:
            self._check(shot, self.loaded.color.size)
        else:
            self._check(shot, (shot.framing or Framing()).size)
        if self.stopwatch.on:  # its times are those of one picture, the latest
            self.stopwatch.times.clear()
        return self.stopwatch.timed(self._steps(shot, frame, self._pipeline(slot)))

    def _steps(self, shot: Shot, frame: int, pipeline: DefocusPipeline) -> Steps[moderngl.Texture]:
        yield from self.looking(shot, frame)
        loaded = self.loaded
        if self._of_scene is not None and shot.defocus.method.needs_scene:
            size = proxy_size(loaded.color.size, shot.defocus.proxy)
            out = pipeline.pool.texture("out", size, 4)
            yield from self._of_scene.through_lens(shot, frame, size, out)
            return out
        return (
            yield from pipeline.steps(
                loaded.color,
                loaded.depth,
                self.optics(shot, frame),
                shot.defocus,
                loaded.plate.has_alpha,
            )
        )

    def _pipeline(self, slot: int) -> DefocusPipeline:
        if slot not in self._pipelines:
            self._pipelines[slot] = DefocusPipeline(self.ctx, self._passes)
            self._pipelines[slot].on_layer = self._on_layer if slot == 0 else None
        return self._pipelines[slot]

    def optics(self, shot: Shot, frame: int = 0) -> Optics:
        """The shot's lens at `frame` in front of the loaded plate, in its full-size pixels."""
        return optics_of(self.loaded.plate, self.loaded.occupied, shot.lens_at(frame))

    def _check(self, shot: Shot, full_size: tuple[int, int]) -> None:
        """Refuse what is too large for this machine, and a method that this source cannot have."""
        if shot.defocus.method.needs_scene and self._of_scene is None:
            raise InputError(
                f"The method {shot.defocus.method} looks at a 3D scene from many points of the "
                f"lens; {self.loaded.plate.path.name} is a picture from one."
            )
        size = proxy_size(full_size, shot.defocus.proxy)
        if size != self._checked_size:
            check_work_fits(self.ctx, *size)
            self._checked_size = size

    def listen(self, on_layer: Callable[[int, int], None] | None) -> None:
        """Have `on_layer(done, layers)` called as a picture comes about; it costs a wait each."""
        self._on_layer = self._pipeline(0).on_layer = on_layer

    def pixels(self, shot: Shot, frame: int = 0) -> FloatArray:
        """`render` read back: (H, W, 4) float32."""
        return download(self.render(shot, frame))


def drained(steps: Steps[Result]) -> Result:
    """What `steps` return at their end."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value  # type: ignore[no-any-return]


def _depth_or_coc(plate: Plate) -> FloatArray:
    depth = plate.depth_m if plate.depth_m is not None else plate.coc_px
    assert depth is not None
    return np.ascontiguousarray(depth, np.float32)


def bins_of_plate(plate: Plate) -> ValueBins:
    """Where the plate's surfaces lie: dioptres, or pixels of coc where it brings these."""
    if plate.coc_px is not None:
        return bins_of(plate.coc_px)
    assert plate.depth_m is not None
    return bins_of(np.float32(1.0) / plate.depth_m)


def optics_of(plate: Plate, occupied: npt.NDArray[np.float64], lens: Lens) -> Optics:
    """The lens in front of this plate, in pixels of its display window."""
    scales = axis_scales(lens.squeeze, plate.pixel_aspect_ratio)
    if plate.coc_px is not None:
        return Optics(None, occupied, scales)
    line = coc_line(lens, plate.display_window.width)
    coc = line.at_infinity_px + line.per_dioptre_px * occupied
    return Optics(line, coc[::-1], scales)  # more dioptres, less coc
