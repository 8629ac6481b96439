"""Import a picture as the shape of the aperture: read on a thread, applied as one undo step."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from heatlens.base.background import Background
from heatlens.base.errors import HeatlensError
from heatlens.model.opening_image import OpeningImage
from heatlens.plate.opening_picture import read_opening_image
from heatlens.session.loop.messages import Problem
from heatlens.session.shot.editing import Editing


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
        """Put what has been read into the lens; call this once a frame."""
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
