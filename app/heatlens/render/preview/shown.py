"""A finished picture seen through the lens, and a key of all that decides its pixels."""

from dataclasses import dataclass, replace

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.gpu.resources import Texture


@dataclass(frozen=True)
class PictureKey:
    """Everything that decides a picture: pictures with equal keys are the same.

    plate     a number that changes whenever another plate is loaded to the GPU
    frame     the frame of the shot
    shot      the shot, which names the source
    settings  the settings used for rendering: the shot's own for the whole picture
    """

    plate: int
    frame: int
    shot: Shot
    settings: DefocusSettings


def without_notes(shot: Shot) -> Shot:
    """Return the shot without marks, looks and in and out points, which change no picture."""
    return replace(shot, marks=(), looks=(), in_out=None)


def whole_picture(shot: Shot, frame: int, plate: int) -> PictureKey:
    """Return the key of the whole picture, which `heatlens render` would make; no preview."""
    return PictureKey(plate, frame, shot, shot.defocus)


@dataclass(frozen=True, eq=False)
class ShownPicture:
    """A picture on the GPU.

    texture   scene-linear light
    shot      the requested shot, at `frame`
    settings  the settings used for rendering: cheaper ones while something moves
    seconds   render time
    plate     the number of the plate that it was made of
    diffused  the light of the plate without highlights, see `light_without_highlights` of
              `FrameRenderer`
    """

    texture: Texture
    shot: Shot
    frame: int
    settings: DefocusSettings
    seconds: float
    plate: int = 0
    diffused: Texture | None = None

    @property
    def picture_key(self) -> PictureKey:
        """The key of all that decides the pixels of this picture."""
        return PictureKey(self.plate, self.frame, self.shot, self.settings)

    @property
    def is_whole(self) -> bool:
        """True if it equals the picture of `heatlens render`, and is not a preview."""
        return self.settings == self.shot.defocus
