"""A camera as plain numbers: its lens and its position at each frame.

A real lens makes larger discs than a renderer with the same f-stop (see `LensModel`). A renderer
therefore gets a wider f-stop, with which it makes the discs that heatlens showed. The nominal
f-stop is stored beside it.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal, get_args

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import (
    FRAMES_PER_SECOND,
    FrameRange,
    check_frame,
    check_frames_per_second,
)
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import Values, options_of, type_of
from heatlens.core.model.timecode import Timecode
from heatlens.media.camera.placement import Matrix, check_rigid

Track = tuple[float, ...]  # a value at each frame
UpAxis = Literal["y", "z"]

# Replaces infinity in formats that cannot express it. The difference is invisible, and float32 is
# precise enough for it even in millimeters.
INFINITE_M = 1e9

# The values of the opening in a camera, besides the squeeze: every field of `Lens` for it that is a
# number, with its name for the user.
OPENING_TRACKS = {
    name: options_of(Lens)[name].words
    for name in (*APERTURE_FIELDS, "widest_f_stop")
    if name != "squeeze" and type_of(Lens, name) in (float, int, bool)
}
# The opening of a plain lens: the values that a camera with an opening does not state.
PLAIN_OPENING = {
    name: getattr(Lens(50.0, 2.0, 2.0, 36.0), name) for name in (*APERTURE_FIELDS, "widest_f_stop")
}
# Values that no camera file can hold; an aperture image has an entry of its own.
UNSAVED_OPENING_FIELDS = tuple(
    n for n in APERTURE_FIELDS if n not in (*OPENING_TRACKS, "squeeze", "aperture_image")
)
# The tracks of a lens and their names for the user.
LENS_TRACKS = {
    "focal_length_mm": "focal length",
    "f_stop": "f-stop",
    "nominal_f_stop": "nominal f-stop",
    "focus_distance_m": "focus distance",
    "sensor_width_mm": "sensor width",
    "sensor_height_mm": "sensor height",
    "squeeze": "squeeze",
    **OPENING_TRACKS,
}


@dataclass(frozen=True, slots=True)
class CameraSamples:
    """A camera sampled at whole frames; a track that is None is not known.

    name               name of the camera for people
    frames             ascending frame numbers, at least one; a camera with a single frame is still
    f_stop             the f-stop for the program that uses the camera; see `same_discs`
    nominal_f_stop     the f-stop on the lens, if `f_stop` differs from it
    lens_model         the model of the discs at the nominal f-stop; None if unknown
    focus_distance_m   may be infinite
    squeeze            as in `Lens`
    world_to_camera    p_camera = M p_world for columns in meters; the camera has x to the right, y
                       up, and looks along -z
    up_axis            the axis of the world that points up
    notes              sentences for the user
    opening            the tracks of OPENING_TRACKS that are known, as in `Lens`
    aperture_image     as in `Lens`; one that a file names is read by `camera_file.read_camera`
    timecodes          timecode of each frame, if they came with the table of a shoot
    has_focus_unit     False for a shoot table without any unit of the focus, which is then taken
                       as meters

    Raises InputError that names the frame if a value is impossible for a camera.
    """

    name: str
    frames: tuple[int, ...]
    focal_length_mm: Track | None = None
    f_stop: Track | None = None
    focus_distance_m: Track | None = None
    sensor_width_mm: Track | None = None
    sensor_height_mm: Track | None = None
    squeeze: Track | None = None
    nominal_f_stop: Track | None = None
    lens_model: LensModel | None = None
    world_to_camera: tuple[Matrix, ...] | None = None
    up_axis: UpAxis = "y"
    frames_per_second: float = FRAMES_PER_SECOND
    notes: tuple[str, ...] = field(default=(), compare=False)
    opening: Mapping[str, Track] = field(default_factory=dict)
    aperture_image: OpeningImage | None = None
    timecodes: tuple[Timecode, ...] | None = field(default=None, compare=False)
    has_focus_unit: bool = field(default=True, compare=False)

    def __post_init__(self) -> None:
        _check_frames(self.frames)
        check_frames_per_second(self.frames_per_second)
        if self.up_axis not in get_args(UpAxis):
            raise InputError(f"The axis that points up is y or z, not {self.up_axis!r}.")
        for name, track in self.lens_tracks.items():
            _check_track(name, track, self.frames)
        if self.world_to_camera is not None:
            _check_length("placement", len(self.world_to_camera), self.frames)
            check_rigid(self.world_to_camera, self.frames)

    @property
    def lens_tracks(self) -> Mapping[str, Track]:
        """The known tracks, by the names of their fields."""
        tracks = {name: getattr(self, name, None) for name in LENS_TRACKS} | dict(self.opening)
        return {name: track for name, track in tracks.items() if track is not None}

    @property
    def has_opening(self) -> bool:
        """Whether the opening is described; omitted values are as in a plain lens."""
        return bool(self.opening) or self.aperture_image is not None

    @property
    def shaped_fields(self) -> tuple[str, ...]:
        """The fields of the opening that are not as in a plain lens."""
        return tuple(
            name for name, track in self.opening.items() if set(track) != {PLAIN_OPENING[name]}
        )

    @property
    def focus_without_unit_m(self) -> Track:
        """The focus distances that had no unit and were assumed to be in meters."""
        return () if self.has_focus_unit else self.focus_distance_m or ()

    @property
    def identifier(self) -> str:
        """The name as a valid identifier: letters, digits and _, not beginning with a digit."""
        name = re.sub(r"\W", "_", self.name, flags=re.ASCII)
        return f"_{name}" if not name or name[0].isdigit() else name

    @property
    def frame_range(self) -> FrameRange | None:
        """The first and last frame; None for a camera with a single frame."""
        return None if len(self.frames) == 1 else FrameRange(self.frames[0], self.frames[-1])


def fields_of(tracks: Mapping[str, object]) -> Values:
    """Return the fields of `CameraSamples` that hold tracks; a track that is None is not known."""
    opening = {name: tracks[name] for name in OPENING_TRACKS if tracks.get(name) is not None}
    other_tracks = {name: track for name, track in tracks.items() if name not in OPENING_TRACKS}
    return {**other_tracks, "opening": opening}


def is_constant(track: Track) -> bool:
    """Return whether all values of the track are equal."""
    return min(track) == max(track)


def finite_m(distance_m: float) -> float:
    """Return the distance, limited to INFINITE_M, for formats without infinity."""
    return min(distance_m, INFINITE_M)


def _check_frames(frames: tuple[int, ...]) -> None:
    """Raise InputError unless there are frames, all possible and in ascending order."""
    if not frames:
        raise InputError("A camera needs at least one frame.")
    for frame in frames:
        check_frame(frame)
    for frame, next_frame in pairwise(frames):
        if next_frame <= frame:
            if next_frame == frame:
                raise InputError(f"The camera has two entries for frame {frame}: keep one.")
            raise InputError(
                f"Frame {next_frame} comes after frame {frame}: frames must be in order."
            )


def _check_length(name: str, count: int, frames: tuple[int, ...]) -> None:
    """Raise InputError if a track has not one value for each frame."""
    if count != len(frames):
        raise InputError(f"The {name} has {count} values for {len(frames)} frames.")


def _check_track(name: str, track: Track, frames: tuple[int, ...]) -> None:
    """Raise InputError for a wrong number of values, or one that no camera can have."""
    _check_length(LENS_TRACKS[name], len(track), frames)
    for frame, value in zip(frames, track, strict=True):
        is_positive = value > 0 or name in OPENING_TRACKS
        if not is_positive or (not math.isfinite(value) and name != "focus_distance_m"):
            raise InputError(
                f"Frame {frame}: the {LENS_TRACKS[name]} of a camera must be above 0 and finite, "
                f"got {value:g}."
            )


def with_renderer_f_stop(camera: CameraSamples) -> CameraSamples:
    """Return the camera with the f-stop with which a renderer makes the same discs.

    At each frame this is N (1 - f/S) for a nominal f-stop N, focal length f and focus distance S.
    The nominal f-stop is kept beside it, and a note says so. A camera that has these discs
    already, or lacks the f-stop, the focus or the focal length, is returned unchanged.
    """
    f_stops, focal_lengths, focus = camera.f_stop, camera.focal_length_mm, camera.focus_distance_m
    model = camera.lens_model
    if model in (None, LensModel.RENDERER) or camera.nominal_f_stop is not None:
        return camera
    if f_stops is None or focal_lengths is None or focus is None:
        return camera
    renderer_f_stops = tuple(
        n * model.focal_over_image_distance(f_mm, s_m)
        for n, f_mm, s_m in zip(f_stops, focal_lengths, focus, strict=True)
    )
    note = (
        f"f-stop written as {_range_text(renderer_f_stops)}, with which a CG renderer makes the "
        "discs of this "
        f"{model.facts.words} at {_range_text(f_stops)}; the nominal value is kept beside it, and "
        "`--f-stop nominal` writes it instead."
    )
    return replace(
        camera, f_stop=renderer_f_stops, nominal_f_stop=f_stops, notes=(*camera.notes, note)
    )


def with_nominal_f_stop(camera: CameraSamples) -> CameraSamples:
    """Return the camera with only the nominal f-stop, which is marked on the lens."""
    if camera.nominal_f_stop is None:
        return camera
    return replace(camera, f_stop=camera.nominal_f_stop, nominal_f_stop=None)


def _range_text(f_stops: tuple[float, ...]) -> str:
    """Return the f-stop, or the least and the greatest if they differ."""
    ends = f"f/{min(f_stops):.4g}", f"f/{max(f_stops):.4g}"
    return ends[0] if is_constant(f_stops) else f"{ends[0]} to {ends[1]}"
