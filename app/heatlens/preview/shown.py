"""A finished picture through the lens, and what it was made of."""

from dataclasses import dataclass

import moderngl

from heatlens.model.settings import DefocusSettings
from heatlens.model.shot import Shot


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
    def is_whole(self) -> bool:
        """Return True where it is as `heatlens render` would make it."""
        return self.settings == self.shot.defocus
