"""The base of all sources that can be rendered through a lens to arrays."""

import os
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Unpack

from heatlens.core.base.closing import Closing
from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import Values
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.options import ExportOptions
from heatlens.fronts.api.arguments import (
    EXPORT_OPTION_NAMES,
    LENS_VALUES,
    check_names,
    check_text,
    check_values,
    check_whole_number,
)
from heatlens.fronts.api.engine import ENGINE
from heatlens.fronts.api.exporting import Progress, request_values, run_export
from heatlens.fronts.api.frame import Frame, FrameFacts, FrameProperties
from heatlens.fronts.api.keywords import ExportKeywords, RenderOptions
from heatlens.fronts.api.notes import Notes, errors_with_python_names
from heatlens.fronts.api.request import RenderRequest, check_render_arguments
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.plate_notes import depth_note
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import FloatArray


class Source(FrameProperties, Closing):
    """The source in front of the lens: a plate, a sequence of plates, or a 3D scene.

    `source[1012]` is a frame, `for frame in source` goes through them, and `len(source)` counts
    them. The properties of `FrameProperties` are those of its first frame.
    """

    def __init__(self) -> None:
        """Begin without notes."""
        self._notes = Notes()
        self._name = ""
        self._reading: Values = {}

    def set_name(self, name: str, reading: Values) -> None:
        """Set the name of the file, and the values of the options with which it is read."""
        self._name, self._reading = name, reading

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of all renderings so far, as sentences.

        They say how the depth was read, and repeat every `HeatlensWarning`: repairs, guesses, and a
        focus, lens and depth that can hardly belong together.
        """
        return self._notes.sentences

    @property
    @abstractmethod
    def frames(self) -> tuple[int, ...]:
        """The numbers of the frames that can be rendered; (1,) for a single picture."""

    @property
    def cameras(self) -> tuple[str, ...]:
        """The names of the cameras of a scene, one of which `open` takes; () for plates."""
        return ()

    @abstractmethod
    def _facts_at(self, frame: int) -> FrameFacts:
        """Return the facts of a frame. Raises InputError if it cannot be read."""

    @abstractmethod
    def _check_frame(self, frame: int) -> None:
        """Raise InputError if there is no such frame."""

    def _facts(self) -> FrameFacts:
        """Return the facts of the first frame. Raises InputError if there is none."""
        if not self.frames:
            raise InputError(
                "None of the shot's plates is on the disk: open the shot with moved, or its plates "
                "by themselves."
            )
        return self._facts_at(self.frames[0])

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.frames)

    def __iter__(self) -> Iterator[Frame]:
        """Go through the frames."""
        return (self[number] for number in self.frames)

    def __getitem__(self, frame: int) -> Frame:
        """Return the frame of this number. Raises HeatlensError if there is none."""
        with errors_with_python_names():
            number = check_whole_number("frame", frame)
            self._check_frame(number)
        return Frame(number, self._facts_at, self.render)

    def render(
        self,
        lens: Lens | None = None,
        *,
        frame: int | None = None,
        focal_length_mm: float | None = None,
        sensor_width_mm: float | None = None,
        f_stop: float | None = None,
        focus_distance_m: float | None = None,
        focus_at: tuple[int, int] | None = None,
        lens_model: str | None = None,
        **more: Unpack[RenderOptions],
    ) -> FloatArray:
        """Return the picture with the lens.

        (H, W, 4) float32, scene-linear, premultiplied, row 0 top.

        Give `lens`, or single values of it; values that are not given come from the shot file, the
        header or the scene's camera. `lens_model` is "photographic" or "renderer". `focus_at` is a
        pixel (x, y) of the picture to focus on. `frame` is a number in a sequence, a shot or a
        scene (default: the first). `more` is the opening of the lens and the blur: see
        `RenderOptions`.

        Doubts are raised as `HeatlensWarning`, once for each source and sentence, and in `notes`.

        Raises HeatlensError for a lens value that is missing, an argument of another name or type,
        a file that cannot be read, a picture too large for this machine, and for doubts if the
        source was opened with `strict=True`.
        """
        lens_arguments = (focal_length_mm, sensor_width_mm, f_stop, focus_distance_m)
        values = dict(zip(LENS_VALUES, lens_arguments, strict=True))
        with errors_with_python_names():
            check_names("render", more)
            request = check_render_arguments(lens, frame, values, focus_at, lens_model, more)
            renderer = ENGINE.renderer()
            shot, shot_frame = self._load_shot(renderer, request)
            pixels = renderer.pixels(shot, shot_frame)
        plate = renderer.loaded.plate
        self._notes.warn(*plate.notes, *filter(None, [plate.surfaces_lost]))
        return pixels

    def export(
        self,
        output: str | os.PathLike[str],
        lens: Lens | None = None,
        *,
        progress: Progress | None = None,
        is_cancelled: Callable[[], bool] | None = None,
        **options: Unpack[ExportKeywords],
    ) -> tuple[Path, ...]:
        """Write the frames to `output`, as `heatlens export` does; return the files.

        `output` is frames.####.exr, one picture, or a movie (.mov, .mp4). `lens` and its single
        values are those of `render`, but a shot file has its own lens, which cannot be replaced.
        The options of the files are in `ExportKeywords`. Finished frames of an earlier export are
        left as they are.

        `progress` is called with each finished frame, an `ExportedFrame`. `is_cancelled` is asked
        after each: if it returns True, the export ends, and a later one goes on. An unfinished
        movie is removed.

        Raises HeatlensError as `render` does, for arrays, which no file names, and for a file that
        cannot be written.
        """
        given: dict[str, Any] = dict(options)
        values = {name: given.get(name) for name in LENS_VALUES}
        with errors_with_python_names():
            check_names("export", given)
            if not self._name:
                raise InputError(
                    "Arrays have no file to export: render them, and write the result."
                )
            request = check_render_arguments(
                lens, None, values, given.get("focus_at"), given.get("lens_model"), given
            )
            given = {name: given[name] for name in EXPORT_OPTION_NAMES if name in given}
            options_of_files = check_values(ExportOptions, given)
            values = {**self._reading, **request_values(request), **options_of_files}
            out = check_text("output", output)
            return run_export(self._name, out, values, progress, is_cancelled)

    @abstractmethod
    def _load_shot(self, renderer: FrameRenderer, request: RenderRequest) -> tuple[Shot, int]:
        """Load the source for a request, and note doubts. Return the shot and the frame."""

    def _note_plate(self, plate: Plate, request: RenderRequest, doubts: Iterable[str]) -> None:
        """Note how a plate was read, and warn of doubts about it and its lens."""
        self._notes.keep(depth_note(plate))
        self._notes.warn(*plate.notes, *request.notes(plate), *doubts)

    def close(self) -> None:
        """Release the pixels; the next `render` reads and loads them again."""
        ENGINE.unload(self)
