"""Import a camera, aperture image, grade or framing lines: on a thread, one undo step each.

The lines of a framing decision list are drawn with the guides of the view.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Generic, TypeVar

from heatlens.core.base.background import Background
from heatlens.core.base.messages import report_errors
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import Canvas, frame_lines_for
from heatlens.core.model.view.picture_view import PictureView
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.camera.into_shot import with_camera
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import match_by_timecode
from heatlens.media.color.grade_file import read_grade
from heatlens.media.documents.frame_line_file import read_canvases
from heatlens.media.plate.opening_picture import read_opening_image
from heatlens.studio.session.shared import Commands, Shared

Imported = TypeVar("Imported")


class _Import(Commands, Generic[Imported]):
    """Reads one file at a time, and reports the result or what is wrong with the file."""

    def __init__(
        self,
        shared: Shared,
        read_file: Callable[[Path], Imported],
        apply: Callable[[Imported, Path], tuple[Shot, str]],
    ) -> None:
        """Create it; `apply` returns the shot with the imported values, and a sentence on them."""
        super().__init__(shared)
        self._read, self._apply = read_file, apply
        self._reader: Background[Imported] = Background(self._wake)
        self._path = Path()

    def begin(self, path: Path) -> None:
        """Begin to read the file on a thread; `poll` applies the result."""
        self._path = path
        self._reader.start(partial(self._read, path))

    def poll(self) -> None:
        """Apply what was read to the shot; call this once a frame. Notifies the user."""
        with report_errors(self._notify):
            if (imported := self._reader.poll()) is not None:
                shot, sentence = self._apply(imported, self._path)
                self._editing.do(shot)
                self._notify(sentence)


def camera_import(shared: Shared) -> _Import[CameraSamples]:
    """Return the import of the lens of a camera file, with keys for what moves."""

    def apply_camera(camera: CameraSamples, path: Path) -> tuple[Shot, str]:
        """Return the shot with the camera's lens, and a sentence on it."""
        shot = shared.editing.shot
        start = shared.source.timecode_at(shot, shared.editing.frame)
        camera = match_by_timecode(camera, start, shot.frames_per_second, shot.span)
        sentence = f"The lens is that of {camera.name} in {path.name}. {' '.join(camera.notes)}"
        return with_camera(shot, camera), sentence.strip()

    return _Import(shared, read_file=lambda path: read_camera(str(path)), apply=apply_camera)


def opening_import(shared: Shared) -> _Import[OpeningImage]:
    """Return the import of a picture that takes the place of the blades."""

    def apply_opening(image: OpeningImage, _path: Path) -> tuple[Shot, str]:
        shot = shared.editing.shot
        sentence = f"The opening of the lens is {Path(image.path).name}. {' '.join(image.notes)}"
        return replace(shot, lens=replace(shot.lens, aperture_image=image)), sentence.strip()

    return _Import(shared, read_file=read_opening_image, apply=apply_opening)


def grade_import(shared: Shared) -> _Import[Grade]:
    """Return the import of a grade of the shot."""

    def apply_grade(grade: Grade, path: Path) -> tuple[Shot, str]:
        return replace(shared.editing.shot, grade=grade), f"The grade is that of {path.name}."

    return _Import(shared, read_file=read_grade, apply=apply_grade)


class FramingImport(Commands):
    """Reads a file on a thread, and gives its lines to the view."""

    def __init__(self, shared: Shared, view: PictureView) -> None:
        super().__init__(shared)
        self._view = view
        self._reader: Background[tuple[Canvas, ...]] = Background(self._wake)

    def begin(self, path: Path) -> None:
        """Begin to read the framing lines of a file on a thread; `poll` shows them."""
        self._reader.start(partial(read_canvases, path))

    def poll(self) -> None:
        """Draw what was read; call this once a frame. Notifies the user."""
        with report_errors(self._notify):
            if (imported := self._reader.poll()) is not None:
                state = self._view.state
                self._view.state = replace(state, guides=replace(state.guides, canvases=imported))
                self._notify(self._lines_message(imported))

    def _lines_message(self, canvases: tuple[Canvas, ...]) -> str:
        """Return the message about the framing lines for a picture of this shape."""
        shape = self._source.picture_shape(self._editing.shot)
        lines = frame_lines_for(canvases, shape.width_px, shape.height_px)
        if lines:
            return f"Framing lines: {', '.join(line.name for line in lines)}."
        known_shapes = ", ".join(f"{canvas.width:g}x{canvas.height:g}" for canvas in canvases)
        return (
            f"No canvas of the framing lines has the shape of this picture, {shape.width_px}x"
            f"{shape.height_px}: they are for {known_shapes}."
        )
