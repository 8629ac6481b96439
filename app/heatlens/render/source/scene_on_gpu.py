"""A 3D scene on the GPU, whose pictures are drawn on request."""

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.framing import Framing, Pose
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.coc_line import area_at, middle_m
from heatlens.media.scene.scene import Scene
from heatlens.render.defocus.steps import Steps
from heatlens.render.gpu.context import check_plate_fits
from heatlens.render.gpu.device import Device, Texture
from heatlens.render.scene_gpu.scene_renderer import SceneRenderer
from heatlens.render.source.pinhole import Pinhole


class SceneOnGpu:
    """Holds one scene. Implements `SourceOnGpu`."""

    has_many_views = True

    def __init__(self, ctx: Device, drawer: SceneRenderer) -> None:
        self._ctx = ctx
        self._drawer = drawer
        self._held: Pinhole | None = None

    @property
    def scene(self) -> Scene:
        return self._drawer.scene

    def size(self, shot: Shot) -> tuple[int, int]:
        return (shot.framing or Framing()).size

    def check_method(self, method: Method) -> None:
        """Accept every method, because scenes can be rendered by all of them."""

    def look(
        self, shot: Shot, frame: int, views: int | None, is_for_file: bool = False
    ) -> Steps[Pinhole]:
        """See `SourceOnGpu`; an unchanged picture is returned as the same object."""
        check_plate_fits(self._ctx, *self.size(shot))
        yield from self._drawer.look(shot, frame, views, is_for_file)
        drawn = self._drawer.held
        if self._held is None or self._held.plate is not drawn.plate:
            self._held = Pinhole(
                drawn.plate,
                drawn.color,
                drawn.depth,
                drawn.dioptres,
                overscan=drawn.overscan,
                peeled=drawn.peeled,
            )
        return self._held

    def through_lens(
        self, shot: Shot, frame: int, size: tuple[int, int], out: Texture
    ) -> Steps[None]:
        yield from self._drawer.through_lens(shot, frame, size, out)

    def pose_at(self, shot: Shot, frame: float) -> Pose:
        return self._drawer.pose_at(shot, frame)

    def depth_m_at(self, shot: Shot, frame: float, x: int, y: int) -> float:
        window = Box(0, 0, *self.size(shot))
        return middle_m(self._drawer.depth_in(shot, frame, area_at(x, y, window, window)))

    def pace(self, share: float) -> None:
        self._drawer.pace(share)

    def beside(self) -> "SceneOnGpu":
        return SceneOnGpu(self._ctx, self._drawer.beside())

    def release(self) -> None:
        self._held = None
        self._drawer.release()


def scene_on_gpu(ctx: Device, scene: Scene) -> SceneOnGpu:
    """Upload a scene to the GPU."""
    return SceneOnGpu(ctx, SceneRenderer(ctx, scene))
