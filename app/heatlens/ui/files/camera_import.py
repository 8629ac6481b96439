"""The lens of a camera file taken into the shot: read on a thread, one step of undo."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.background import Background
from heatlens.camera.camera_file import read_camera
from heatlens.camera.into_shot import with_camera
from heatlens.camera.samples import CameraSamples
from heatlens.errors import HeatlensError

if TYPE_CHECKING:
    from heatlens.ui.app import App


class CameraImport:
    """One camera at a time; whatever happens is said."""

    def __init__(self, app: "App", wake: Callable[[], None]) -> None:
        self._app = app
        self._reader: Background[CameraSamples] = Background(wake)
        self._path = Path()

    def begin(self, path: Path) -> None:
        """Read the camera of `path`."""
        self._path = path
        self._reader.start(partial(read_camera, str(path)))

    def poll(self) -> None:
        """Once a frame: take what has been read."""
        try:
            camera = self._reader.poll()
            if camera is None:
                return
            self._app.editing.do(with_camera(self._app.shot, camera))
        except HeatlensError as error:
            self._app.say(str(error))
            return
        told = " ".join(camera.notes)
        self._app.say(f"The lens is that of {camera.name} in {self._path.name}. {told}".strip())
