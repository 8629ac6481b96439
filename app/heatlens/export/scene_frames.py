"""A 3D scene as what an export is made of: there at every frame, and drawn as it is asked for."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from heatlens.export.frame_source import FrameLoader, Origin, PlannedFrame
from heatlens.model.shot import Shot
from heatlens.paths import unreadable
from heatlens.render import FrameRenderer
from heatlens.scene.scene import Scene
from heatlens.scene.scene_read import files_of_scene
from heatlens.scene.scene_source import is_demo, open_scene
from heatlens.sequence.sequence import MissingPolicy, stamp_of

_STILL_FRAME = 1  # of what stands still


@dataclass(frozen=True)
class SceneFrames:
    """The scene that `text` names. It is opened where that cannot be put off."""

    text: str

    @property
    def files(self) -> Path | None:
        """The scene's file."""
        return None if is_demo(self.text) else Path(self.text)

    @cached_property
    def scene(self) -> Scene:
        """All of it; raises InputError where it cannot be read."""
        return open_scene(self.text)

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """Those that are played, else those in which something moves."""
        return tuple(shot.played or self.scene.frames or (_STILL_FRAME,))

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """A scene has every frame, if it is there."""
        if self.files is not None and not self.files.is_file():
            raise unreadable(self.files)

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """The one scene, whichever frame, with all its files that are known before it is read."""
        if self.files is None:
            return Origin(frame, False, None, None)
        stamps = tuple(stamp_of(path) for path in self.beside)
        return Origin(frame, False, self.files, stamp_of(self.files), stamps)

    @cached_property
    def beside(self) -> tuple[Path, ...]:
        """What the scene's file names. Raises InputError where that cannot be read."""
        return () if self.files is None else files_of_scene(self.files)[1:]

    def loader(
        self, shot: Shot, frames: tuple[PlannedFrame, ...], renderer: FrameRenderer
    ) -> FrameLoader:
        """Takes the scene to the GPU, once for all frames."""
        renderer.load_scene(self.scene)
        return _SceneLoader(shot, renderer)


@dataclass(frozen=True)
class _SceneLoader:
    shot: Shot
    renderer: FrameRenderer

    def load(self, frame: PlannedFrame) -> None:
        """The pinhole picture, which is the plate of the frame."""
        self.renderer.look(self.shot, frame.frame)

    def close(self) -> None:
        """Nothing is read ahead."""
