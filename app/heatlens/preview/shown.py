"""A finished picture through the lens, and what it was made of."""

from dataclasses import dataclass, replace

import moderngl

from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot


@dataclass(frozen=True)
class PictureKey:
    """What a picture is made of: two pictures with equal keys are the same picture.

    plate     the number of the plate, another whenever another one lies on the GPU
    frame     the frame of the shot
    shot      the shot, which names the source
    settings  those it is made with: the shot's own for the whole picture
    """

    plate: int
    frame: int
    shot: Shot
    settings: DefocusSettings


def without_notes(shot: Shot) -> Shot:
    """Return the shot without what changes no picture of a frame: marks, looks, in and out."""
    return replace(shot, marks=(), looks=(), in_out=None)


def whole_picture(shot: Shot, frame: int, plate: int) -> PictureKey:
    """Return the key of the picture as `heatlens render` would make it."""
    return PictureKey(plate, frame, shot, shot.defocus)


@dataclass(frozen=True, eq=False)
class Shown:
    """A picture on the GPU.

    texture   its light, scene-linear
    shot      the shot that was wished for, at `frame`
    settings  those it was made with: cheaper ones while something moves
    seconds   of rendering
    plate     the number of the plate that it was made of
    """

    texture: moderngl.Texture
    shot: Shot
    frame: int
    settings: DefocusSettings
    seconds: float
    plate: int = 0

    @property
    def picture_key(self) -> PictureKey:
        """What it was made of."""
        return PictureKey(self.plate, self.frame, self.shot, self.settings)

    @property
    def is_whole(self) -> bool:
        """Return True where it is as `heatlens render` would make it."""
        return self.settings == self.shot.defocus
