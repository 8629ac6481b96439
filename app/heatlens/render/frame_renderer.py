"""The only renderer: it makes the picture of a shot at a frame, for window, commands and export."""

from collections.abc import Callable
from dataclasses import replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.focus_offset import non_planar_terms
from heatlens.core.model.lens.breathing import plate_ratio, without_breathing
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.media.plate.overscan_need import frame_centre_px, overscan_ratio
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.scene import Scene
from heatlens.render.defocus.focus_offset_survey import FocusOffsetSurvey
from heatlens.render.defocus.line_solver import LineSolver, usual_solver
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.passes import DefocusPasses
from heatlens.render.defocus.pipeline import DefocusPipeline, LayerCallback
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.steps import Result, Steps
from heatlens.render.gpu.context import (
    check_plate_fits,
    check_texture_fits,
    check_work_fits,
    headless_context,
    is_software,
)
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.stopwatch import Stopwatch
from heatlens.render.gpu.textures import FloatArray, download, upload_steps
from heatlens.render.plate_blur import PlateBlur
from heatlens.render.source.pinhole import Pinhole, SourceOnGpu, pinhole_optics
from heatlens.render.source.plate_on_gpu import PlateOnGpu


def headless_renderer() -> "FrameRenderer":
    """Return a renderer without a window."""
    return FrameRenderer(headless_context())


class FrameRenderer:
    """Holds one source on the GPU and renders it through any lens.

    Pictures in different slots, 0, 1 and so on, exist at the same time: one is shown while the next
    one is being rendered.
    """

    def __init__(self, ctx: Device, solver: LineSolver | None = None) -> None:
        """Make a renderer; if `solver` is None, with the one for this GPU."""
        self.ctx = ctx
        self.stopwatch = Stopwatch(ctx)
        self.solver = solver or usual_solver(ctx)
        self._passes = DefocusPasses(ctx, self.solver)
        self._pipelines: dict[int, DefocusPipeline] = {}  # one for each slot, made when first used
        self._on_layer: LayerCallback | None = None
        self._plates = PlateOnGpu(ctx)
        self._source: SourceOnGpu = self._plates  # holds no plate yet
        self._loaded: Pinhole | None = None
        self._is_software = is_software(ctx)
        self._focus_offsets = FocusOffsetSurvey(ctx)
        self._checked_size = (0, 0)

    @property
    def loaded(self) -> Pinhole:
        """The plate, or the scene's pinhole picture. Raises InputError before there is one."""
        if self._loaded is None:
            raise InputError("No plate is loaded.")
        return self._loaded

    @property
    def scene(self) -> Scene | None:
        """The scene; None if no scene is loaded."""
        return self._source.scene

    @property
    def has_many_views(self) -> bool:
        """True if the source can be seen from many points of the lens."""
        return self._source.has_many_views

    def size(self, shot: Shot) -> tuple[int, int]:
        """Return width and height of the source's pictures. Raises InputError without a source."""
        return self._source.size(shot)

    @property
    def methods(self) -> tuple[Method, ...]:
        """Every method that the source allows, in the order of `Method`."""
        return tuple(method for method in Method if self.has_many_views or not method.needs_scene)

    def make_sibling(self) -> "FrameRenderer":
        """Return another renderer with the same solver and rounding, and nothing loaded.

        The two do not disturb each other's unfinished pictures.
        """
        return FrameRenderer(self.ctx, type(self.solver)(self.ctx))

    def load(self, plate: Plate) -> None:
        """Upload a plate to the GPU; this is needed once for each file, not for each picture."""
        run_all_steps(self.load_steps(plate))

    def load_steps(self, plate: Plate) -> Steps[None]:
        """Upload a plate to the GPU in short steps.

        If the steps are not completed, nothing is loaded.
        """
        check_plate_fits(self.ctx, plate.data_window.width, plate.data_window.height)
        if self._source is not self._plates:
            self._source.release()
        self._source, self._loaded = self._plates, None
        self._set_loaded((yield from self._plates.load_steps(plate)))

    def load_scene(self, scene: Scene) -> None:
        """Upload a scene to the GPU; its pictures are drawn on request."""
        from heatlens.render.source.scene_on_gpu import SceneOnGpu  # plates do without

        self._replace_source(SceneOnGpu(self.ctx, scene))

    def load_scene_of(self, other: "FrameRenderer") -> None:
        """Share the scene of another renderer of this context, without a second copy.

        After the other has released the scene, this one can only release it too. Raises InputError
        if the other has no scene.
        """
        self._replace_source(other._source.share())

    def settle(self) -> None:
        """Wait for pending commands if a software rasterizer runs them.

        Otherwise it would run them all at a later call.
        """
        if self._is_software:
            self.ctx.finish()

    def set_step_size(self, share: float) -> None:
        """Draw a scene in shorter steps: `share` of the usual length, 1 at most."""
        self._source.set_step_size(share)

    def unload(self) -> None:
        """Release the source and all memory for rendering it, but keep the programs."""
        self._source.release()
        self._source, self._loaded = self._plates, None
        for pipeline in self._pipelines.values():
            pipeline.forget_plate()
            pipeline.scratch.release()

    def load_pinhole(
        self, shot: Shot, frame: int = 0, views: int | None = None, is_for_file: bool = False
    ) -> Pinhole:
        """Return the pinhole picture of `frame`, and keep it as `loaded`.

        A plate has one such picture. For a scene, `views` is the number of views to draw; None
        accepts a picture that exists already, whatever its number of views. `is_for_file`: the
        surfaces behind the picture are described in its own pixels, for a file.
        """
        run_all_steps(self.load_pinhole_steps(shot, frame, views, is_for_file))
        return self.loaded

    def load_pinhole_steps(
        self, shot: Shot, frame: int, views: int | None = None, is_for_file: bool = False
    ) -> Steps[None]:
        """Read or draw the sharp picture of `frame` in short steps; the last one loads it."""
        breathing_shot = self._with_view_of_breathing(shot, frame)
        pinhole = yield from self._source.pinhole_steps(breathing_shot, frame, views, is_for_file)
        if pinhole is not self._loaded:
            self._set_loaded(pinhole)

    def pose_at(self, shot: Shot, frame: float) -> Pose | None:
        """Return the pose of the camera in the scene; None for a plate."""
        return self._source.pose_at(shot, frame)

    def scene_depth_m(self, shot: Shot, frame: float, x: int, y: int) -> float:
        """Return the distance in meters at a pixel of any frame of a scene, for clicks to focus.

        Raises InputError outside the picture, and if no scene is loaded.
        """
        return self._source.depth_m_at(self._with_view_of_breathing(shot, frame), frame, x, y)

    def _replace_source(self, source: SourceOnGpu) -> None:
        """Replace the previous source by one that is ready."""
        self.unload()
        self._source = source

    def _set_loaded(self, pinhole: Pinhole) -> None:
        """Keep `pinhole` as the loaded picture, and have all pipelines forget the previous one."""
        for pipeline in self._pipelines.values():
            pipeline.forget_plate()
        self._loaded = pinhole

    def render(self, shot: Shot, frame: int = 0) -> Texture:
        """Return the picture through the shot's lens at `frame`: RGBA float32, premultiplied.

        Its size is that of the source times the proxy.

        The texture is the renderer's own; the next render overwrites it.
        """
        return run_all_steps(self.steps(shot, frame))

    def steps(
        self, shot: Shot, frame: int = 0, slot: int = 0, enlarges: bool = False
    ) -> Steps[Texture]:
        """Render in short steps that yield the name of a pass, and return the picture.

        With `enlarges` a small picture may be larger than its proxy, so that lamps are round.
        Pictures in different slots do not disturb each other, and steps may be abandoned. Nothing
        else may be loaded in between.
        """
        self._check(shot, frame)
        if self.stopwatch.is_on:  # it holds the times of the latest picture only
            self.stopwatch.times.clear()
        return self.stopwatch.time_steps(
            self._render_with_breathing(shot, frame, self._pipeline(slot), enlarges)
        )

    def light_without_highlights(self, slot: int = 0) -> Texture | None:
        """Return the light that the latest picture of a slot was diffused from, at proxy size.

        It is that of the pinhole picture times its `light_scale`, without what was drawn as discs.
        None if the picture had no highlights to look for.
        """
        return self._pipeline(slot).scratch.kept_texture("rest")

    def upload_steps(self, pixels: FloatArray, slot: int) -> Steps[Texture]:
        """Take a picture that another machine has rendered into a slot, in short steps."""
        height, width = pixels.shape[:2]
        out = self._pipeline(slot).scratch.texture("out", (width, height), 4)
        for _ in upload_steps(out, pixels):
            yield "upload"
        return out

    def _render_with_breathing(
        self, shot: Shot, frame: int, pipeline: DefocusPipeline, enlarges: bool
    ) -> Steps[Texture]:
        """Render, and crop or extend a plate to the view of a breathing lens."""
        breathing_shot = self._with_view_of_breathing(shot, frame)
        picture = yield from self._render_steps(breathing_shot, frame, pipeline, enlarges)
        if self.has_many_views:  # it is drawn as the breathing lens sees it
            return picture
        plate = self.loaded.plate
        ratio = plate_ratio(shot.lens_at(frame), overscan_ratio(plate))
        if ratio == 1.0:
            return picture
        out = pipeline.scratch.texture("frame", picture.size, 4)
        scale = picture.width / plate.data_window.width
        self._passes.rescale.run(picture, frame_centre_px(plate, scale), ratio, out)
        yield "rescale"
        return out

    def _with_view_of_breathing(self, shot: Shot, frame: float) -> Shot:
        """Return the shot with a lens that does not breathe, but has the view of the breathing one.

        That lens is constant: it holds the values of this frame. The shot of a plate is returned as
        it is, because its picture is scaled after the blur.
        """
        is_breathing = shot.lens.breathing != 1.0
        if not self.has_many_views or not is_breathing:  # many views: a scene
            return shot
        return replace(shot, lens=without_breathing(shot.lens_at(frame)), curves=LensCurves())

    def _render_steps(
        self, shot: Shot, frame: int, pipeline: DefocusPipeline, enlarges: bool
    ) -> Steps[Texture]:
        """Render a frame through the lens: many views of a scene, or the blur of one picture."""
        yield from self.load_pinhole_steps(shot, frame)
        if shot.defocus.method.needs_scene:
            size = proxy_size(self.loaded.color.size, shot.defocus.proxy)
            out = pipeline.scratch.texture("out", size, 4)
            yield from self._source.through_lens(shot, frame, size, out)
            return out
        blur = PlateBlur(
            self._passes,
            self._focus_offsets,
            pipeline,
            lens=shot.lens_at(frame),
            settings=shot.defocus,
            check_fits=self._check_fits,
            enlarges=enlarges,
        )
        return (yield from blur.steps(self.loaded))

    def copy(self, picture: Texture, out: Texture) -> None:
        """Copy a picture to a texture of the same size, which later renders do not overwrite."""
        self._passes.crop.run(picture, (0, 0), out)

    def _pipeline(self, slot: int) -> DefocusPipeline:
        """Return the pipeline of a slot, which is made when it is first used."""
        if slot not in self._pipelines:
            layer_callback = lambda: self._on_layer if slot == 0 else None  # noqa: E731
            self._pipelines[slot] = DefocusPipeline(self.ctx, self._passes, layer_callback)
        return self._pipelines[slot]

    def optics(self, shot: Shot, frame: int = 0) -> Optics:
        """Return the optics of the shot's lens at `frame` for the source, in full-size pixels."""
        breathing_shot = self._with_view_of_breathing(shot, frame)
        return pinhole_optics(self._focus_offsets, self.loaded, breathing_shot.lens_at(frame))

    def _check(self, shot: Shot, frame: int) -> None:
        """Refuse pictures too large for this machine, and methods that the source forbids."""
        size = proxy_size(self._source.size(shot), shot.defocus.proxy)
        self._source.check_method(shot.defocus.method)
        non_planar = (
            non_planar_terms(shot.lens_at(frame))
            if shot.defocus.method is Method.ACCUMULATION
            else []
        )
        if non_planar:
            raise InputError(
                "The method accumulation draws whole views, each with one plane of focus, and so "
                f"no {' and no '.join(non_planar)}: use raytraced."
            )
        self._check_fits(size)

    def _check_fits(self, size: tuple[int, int]) -> None:
        """Raise GpuError if this machine cannot blur a picture of `size` (width, height)."""
        if size != self._checked_size:
            check_work_fits(self.ctx, *size)
            check_texture_fits(self.ctx, size, self.solver.size_between_axes(size))
            self._checked_size = size

    def set_layer_callback(self, on_layer: LayerCallback | None) -> None:
        """Call `on_layer(done, layers)` after each layer; each call waits for the GPU."""
        self._on_layer = on_layer

    def pixels(self, shot: Shot, frame: int = 0) -> FloatArray:
        """Return the pixels of `render`: (H, W, 4) float32."""
        return download(self.render(shot, frame))


def run_all_steps(
    steps: Steps[Result], report_step: Callable[[str], None] = lambda _: None
) -> Result:
    """Run all steps and return their result; call `report_step` with the name of each step."""
    while True:
        try:
            report_step(next(steps))
        except StopIteration as end:
            return end.value  # type: ignore[no-any-return]
