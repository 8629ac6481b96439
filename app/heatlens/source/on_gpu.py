"""The protocol of a source on the GPU, through which the renderer uses every kind of source."""

from typing import Protocol

import moderngl

from heatlens.defocus.steps import Steps
from heatlens.model.shot.framing import Pose
from heatlens.model.shot.settings import Method
from heatlens.model.shot.shot import Shot
from heatlens.scene.scene import Scene
from heatlens.source.pinhole import Pinhole


class SourceOnGpu(Protocol):
    """A source on the GPU."""

    @property
    def scene(self) -> Scene | None:
        """The 3D scene; None for plates and streams."""

    @property
    def has_many_views(self) -> bool:
        """True if it can be seen from many points of the lens, by accumulation or ray tracing."""

    def size(self, shot: Shot) -> tuple[int, int]:
        """Return width and height of its picture in pixels. Raises InputError if it has none."""

    def check_method(self, method: Method) -> None:
        """Raise InputError for a method that needs more than this source has."""

    def look(
        self, shot: Shot, frame: int, views: int | None, is_for_file: bool = False
    ) -> Steps[Pinhole]:
        """Make the pinhole picture of `frame` in short steps, and return it.

        `views` is the number of samples a pixel of a scene; None accepts an existing picture with
        any number. With `is_for_file`, hidden surfaces are listed for the pixels of the picture,
        although small pictures are blurred in finer ones. Abandoned steps leave the previous
        picture.
        """

    def through_lens(
        self, shot: Shot, frame: int, size: tuple[int, int], out: moderngl.Texture
    ) -> Steps[None]:
        """Draw `frame` from many points of the lens at `size` into `out`, RGBA float32."""

    def pose_at(self, shot: Shot, frame: float) -> Pose | None:
        """Return the position and direction of the camera; None if only a picture is known."""

    def depth_m_at(self, shot: Shot, frame: float, x: int, y: int) -> float:
        """Return the distance in metres at a pixel of any frame, as a click to focus finds it.

        Raises InputError outside the picture, and if only the loaded frame is known.
        """

    def pace(self, share: float) -> None:
        """Set the share, 1 at most, of its usual work that each step does, if anything is drawn."""

    def beside(self) -> "SourceOnGpu":
        """Return a source for other frames that shares the content on the GPU with this one.

        It is valid until this one is released. Raises InputError if there is nothing to share.
        """

    def release(self) -> None:
        """Free the memory on the GPU."""
