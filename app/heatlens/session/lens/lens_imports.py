"""Import a camera file or an aperture image: read on a thread, applied as one undo step."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from heatlens.base.background import Background
from heatlens.base.errors import HeatlensError
from heatlens.camera.camera_file import read_camera
from heatlens.camera.into_shot import with_camera
from heatlens.camera.samples import CameraSamples
from heatlens.camera.shoot_timecode import at_timecode
from heatlens.model.opening_image import OpeningImage
from heatlens.plate.opening_picture import read_opening_image
from heatlens.session.loop.messages import Problem
from heatlens.session.opened.open_source import OpenSource
from heatlens.session.shot.editing import Editing


class CameraImport:
    """Reads one camera at a time and reports the result, or what is wrong with the file."""

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        say: Callable[[str], None],
        wake: Callable[[], None],
    ) -> None:
        self._source = source
        self._editing = editing
        self._say = say
        self._reader: Background[CameraSamples] = Background(wake)
        self._path = Path()

    def begin(self, path: Path) -> None:
        """Begin to read the camera of `path`."""
        self._path = path
        self._reader.start(partial(read_camera, str(path)))

    def poll(self) -> None:
        """Apply the camera that was read to the shot; call this once a frame."""
        try:
            camera = self._reader.poll()
            if camera is None:
                return
            shot = self._editing.shot
            here = self._source.timecode_at(shot, self._editing.frame)
            camera = at_timecode(camera, here, shot.frames_per_second, shot.span)
            self._editing.do(with_camera(shot, camera))
        except HeatlensError as error:
            self._say(Problem(error))
            return
        told = " ".join(camera.notes)
        self._say(f"The lens is that of {camera.name} in {self._path.name}. {told}".strip())


class OpeningImageImport:
    """Reads one picture at a time, and reports the result or what is wrong with the file."""

    def __init__(
        self, editing: Editing, say: Callable[[str], None], wake: Callable[[], None]
    ) -> None:
        self._editing = editing
        self._say = say
        self._reader: Background[OpeningImage] = Background(wake)

    def begin(self, path: Path) -> None:
        """Begin to read the picture of `path`."""
        self._reader.start(partial(read_opening_image, path))

    def poll(self) -> None:
        """Apply the picture that was read to the lens; call this once a frame."""
        try:
            image = self._reader.poll()
        except HeatlensError as error:
            self._say(Problem(error))
            return
        if image is None:
            return
        shot = self._editing.shot
        self._editing.do(replace(shot, lens=replace(shot.lens, aperture_image=image)))
        told = " ".join(image.notes)
        self._say(f"The opening of the lens is {Path(image.path).name}. {told}".strip())
