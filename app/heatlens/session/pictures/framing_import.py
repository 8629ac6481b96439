"""Import the lines of a framing decision list, which are drawn with the guides of the view."""

from dataclasses import replace
from functools import partial
from pathlib import Path

from heatlens.base.background import Background
from heatlens.documents.frame_line_file import read_canvases
from heatlens.model.view.guides import Canvas, lines_of
from heatlens.session.loop.messages import reported
from heatlens.session.pictures.picture_view import PictureView
from heatlens.session.shared import Commands, Shared


class FramingImport(Commands):
    """Reads a file on a thread, and gives its lines to the view."""

    def __init__(self, shared: Shared, view: PictureView) -> None:
        super().__init__(shared)
        self._view = view
        self._reader: Background[tuple[Canvas, ...]] = Background(self._wake)

    def begin(self, path: Path) -> None:
        """Begin to read the file."""
        self._reader.start(partial(read_canvases, path))

    def poll(self) -> None:
        """Draw what was read; call this once a frame."""
        with reported(self._say):
            found = self._reader.poll()
            if found is not None:
                state = self._view.state
                self._view.state = replace(state, guides=replace(state.guides, canvases=found))
                self._say(self._told(found))

    def _told(self, canvases: tuple[Canvas, ...]) -> str:
        shape = self._source.picture_shape(self._editing.shot)
        lines = lines_of(canvases, shape.width_px, shape.height_px)
        if lines:
            return f"Framing lines: {', '.join(line.name for line in lines)}."
        known = ", ".join(f"{it.width:g}x{it.height:g}" for it in canvases)
        return (
            f"No canvas of the framing lines has the shape of this picture, {shape.width_px}x"
            f"{shape.height_px}: they are for {known}."
        )
