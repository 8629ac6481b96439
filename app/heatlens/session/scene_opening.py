"""A scene that has been opened, and what it is called."""

from dataclasses import dataclass
from pathlib import Path

from heatlens.model.shot import Shot
from heatlens.scene.first_shot import FirstShot, first_shot
from heatlens.scene.scene import Scene
from heatlens.scene.scene_read import files_of_scene
from heatlens.scene.scene_source import is_demo
from heatlens.sequence.sequence import Stamp, stamp_of


@dataclass(frozen=True, eq=False)
class OpenedScene:
    """A scene as it was asked for, and the shot that looks at it first."""

    text: str
    first: FirstShot
    stamps: tuple[Stamp | None, ...] = ()  # of its files, as they were before they were read

    @property
    def scene(self) -> Scene:
        """What is looked at."""
        return self.first.scene

    @property
    def shot(self) -> Shot:
        """As it begins."""
        return self.first.shot

    @property
    def frame(self) -> int:
        """The first one."""
        return self.first.frame


def opened_scene(text: str) -> OpenedScene:
    """Read it. Raises InputError naming the file where that fails."""
    stamps = () if is_demo(text) else tuple(map(stamp_of, files_of_scene(Path(text))))
    return OpenedScene(text, first_shot(text), stamps)
