"""Read the camera in a plate's headers, without its pixels."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND
from heatlens.core.model.option import Values
from heatlens.media.camera.placement import Matrix, matrix_of, shortest_decimal
from heatlens.media.camera.samples import LENS_TRACKS, OPENING_TRACKS, CameraSamples, Track, UpAxis
from heatlens.media.plate.header.camera_header import camera_at_header, lens_model_of
from heatlens.media.plate.header.channels import Header
from heatlens.media.plate.header.placement import (
    PLACEMENT,
    are_rigid,
    convert_from_exr,
    find_placement,
)
from heatlens.media.plate.header.timecode import rate_at
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import CameraHeader
from heatlens.media.plate.windows import pixel_aspect_of, read_header_window
from heatlens.media.sequence.names import frames_text
from heatlens.media.sequence.sequence_search import find_sequence

_NOT_IN_HEADERS = ("sensor_height_mm", "squeeze", "nominal_f_stop", *OPENING_TRACKS)
_HEADER_TRACKS = [name for name in LENS_TRACKS if name not in _NOT_IN_HEADERS]


def read_plate_camera(text: str, scene_unit_m: float = 1.0, up_axis: UpAxis = "y") -> CameraSamples:
    """Read the camera from the headers of a picture, or of a sequence's frames.

    Frames without a file are left out. `scene_unit_m` is the length in meters of one unit of the
    world that the headers place the camera in. Raises InputError if a file cannot be read, or only
    some frames have a value.
    """
    sequence = find_sequence(text)
    headers = {
        sequence.path_at(frame): read_headers(sequence.path_at(frame)) for frame in sequence.present
    }
    cameras = {path: camera_at_header(file_headers) for path, file_headers in headers.items()}
    tracks: Values = {name: _collect_track(name, cameras) for name in _HEADER_TRACKS}
    placement, notes = placement_of(list(headers.values()), sequence.present, scene_unit_m)
    width_mm = tracks["sensor_width_mm"]
    if width_mm is not None:
        aspects = [picture_aspect(path, file_headers) for path, file_headers in headers.items()]
        heights = (
            frame_width_mm / aspect
            for frame_width_mm, aspect in zip(width_mm, aspects, strict=True)
        )
        tracks["sensor_height_mm"] = tuple(heights)
    return CameraSamples(
        name=re.sub(r"[._-]+$", "", Path(sequence.form.prefix).stem) or "camera",
        frames=sequence.present,
        **tracks,
        lens_model=lens_model_of(next(iter(cameras.values())))[0],
        world_to_camera=placement,
        up_axis=up_axis,
        frames_per_second=_frames_per_second(next(iter(headers.values()))),
        notes=notes,
    )


def picture_aspect(path: Path, headers: Sequence[Header]) -> float:
    """Return the width of the picture over its height as it is shown.

    All parts of a file share the display window. Raises InputError if it is empty.
    """
    window = read_header_window(headers[0], "displayWindow")
    aspect, _ = pixel_aspect_of(path, headers[0])
    if window.is_empty:
        raise InputError(
            f"{path} has an empty display window, so the shape of the sensor is unknown. Write "
            "the file again."
        )
    return window.width * aspect / window.height


def placement_of(
    headers: Sequence[Sequence[Header]], frames: Sequence[int], scene_unit_m: float
) -> tuple[tuple[Matrix, ...] | None, tuple[str, ...]]:
    """Return the matrix of the camera at each of `frames`, and notes for the user.

    `headers` holds the headers of one file for each frame. The placement is None if any file lacks
    it, because holding the camera still at those frames would be wrong.
    """
    placements = [find_placement(frame_headers) for frame_headers in headers]
    # Pairs of the world-to-camera matrix and whether the world of the headers is left-handed.
    rigid_placements = [
        convert_from_exr(value, scene_unit_m) for value in placements if value is not None
    ]
    if not rigid_placements:
        return None, (f"no {PLACEMENT} in the plate's headers: the camera has no placement.",)
    if len(rigid_placements) < len(frames):
        missing = (frame for frame, value in zip(frames, placements, strict=True) if value is None)
        frame_list = frames_text(tuple(missing))
        return None, (
            f"no usable {PLACEMENT} at frames {frame_list}: the camera has no placement.",
        )
    matrices, are_left_handed = zip(*rigid_placements, strict=True)
    if not are_rigid(np.array(matrices)).all():
        return None, (f"{PLACEMENT} scales or shears: the camera has no placement.",)
    notes = [f"placement from {PLACEMENT} in the plate's headers."]
    if any(are_left_handed):
        notes.append("the plate's world is left-handed: its z is reversed.")
    return tuple(map(matrix_of, matrices)), tuple(notes)


def _collect_track(name: str, cameras: dict[Path, CameraHeader]) -> Track | None:
    """Return a value of the cameras as a track with one entry for each frame.

    Returns None if no camera has it. Raises InputError if only some have it.
    """
    values = {path: getattr(camera, name) for path, camera in cameras.items()}
    missing = [path for path, value in values.items() if value is None]
    if len(missing) == len(values):
        return None
    if missing:
        raise InputError(
            f"{missing[0]}: the header has no {LENS_TRACKS[name]}, but those of other frames do. "
            "Render this frame again, or leave it out with --frames."
        )
    return tuple(shortest_decimal(value) for value in values.values())


def _frames_per_second(headers: Sequence[Header]) -> float:
    """Return the rate of the headers, else the one that OpenEXR assumes."""
    rates = (rate_at(header) for header in headers)
    return next((rate for rate in rates if rate is not None), FRAMES_PER_SECOND)
