"""Find the source for a name in a shot file or on a command line.

The camera of a shot is found here too, whether its source is a scene or plates.
"""

from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.samples import CameraSamples, UpAxis
from heatlens.render.source.kinds import kind_of
from heatlens.render.source.plate_source import PlateSource, sequence_of_one_size
from heatlens.render.source.source import Source

# A shot keeps the options for its plates; without a shot, they are found from the files.
_AS_FOUND = PlateOptions()


def source_named(
    text: str, options: PlateOptions = _AS_FOUND, timing: SceneTiming | None = None
) -> Source:
    """Return the source called `text`; plates are read with `options`, scenes with `timing`.

    A scene is not opened before it is needed. Raises InputError if no plates are found, and for a
    stream, which only the window can show.
    """
    return kind_of(text).make_source(text, options, timing)


def make_plate_source(
    text: str, options: PlateOptions, timing: SceneTiming | None = None
) -> PlateSource:
    """Return the plates called `text`, a file, a pattern or a folder, to be read with `options`.

    Raises InputError if there are none.
    """
    return PlateSource(text, sequence_of_one_size(text), options)


def single_source(path: Path, options: PlateOptions) -> Source:
    """Return the source for one file alone, even if it is a frame of a sequence.

    The disk is not accessed; a missing file is reported when it is read.
    """
    return kind_of(str(path)).make_single_source(path, options)


def source_of(shot: Shot) -> Source:
    """Return the source of a shot. Raises InputError if it names none, or it is not found."""
    timing = None if shot.framing is None else shot.framing.timing
    return source_named(checked_source(shot), shot.plate_options, timing)


def has_camera(source: str | None) -> bool:
    """Return True if the source of this name has a camera that can move, as a 3D scene has."""
    return source is not None and kind_of(source).has_camera


def checked_source(shot: Shot) -> str:
    """Return the name of a shot's source. Raises InputError if it has none."""
    if shot.source is None:
        raise InputError("The shot names no plate. Give its files with --plate.")
    return shot.source


def camera_of_shot(
    shot: Shot,
    name: str,
    frames: FrameRange | None = None,
    sensor_height_mm: float | None = None,
    scene_unit_m: float | None = None,
    up_axis: UpAxis = "y",
) -> CameraSamples:
    """Return the camera of `shot`, see `CameraRequest`.

    Raises InputError if no frames are known or the scene cannot be read, and LensError if keys lead
    to an impossible lens.
    """
    from heatlens.media.camera.from_shot import CameraRequest

    request = CameraRequest(name, frames, sensor_height_mm, scene_unit_m, up_axis)
    return kind_of(shot.source or "").camera(shot, request)
