"""The lens of a shot before plates as a camera, for programs that render it for real."""

from dataclasses import replace

from heatlens.camera.placement import Matrix
from heatlens.camera.plate_camera import picture_aspect, placement_of
from heatlens.camera.samples import CameraSamples, UpAxis
from heatlens.camera.shot_lens import lens_camera
from heatlens.errors import InputError
from heatlens.model.filmback import FILMBACKS
from heatlens.model.frames import FrameRange
from heatlens.model.shot import Shot
from heatlens.plate.header_read import read_headers
from heatlens.sequence.sequence import Sequence, find_sequence

_ASSUMED_ASPECT = 16 / 9

_Placement = tuple[tuple[Matrix, ...] | None, tuple[str, ...]]


def camera_before_plates(
    shot: Shot,
    name: str,
    frames: FrameRange | None = None,
    sensor_height_mm: float | None = None,
    scene_unit_m: float | None = None,
    up_axis: UpAxis = "y",
) -> CameraSamples:
    """Return the lens of `shot` over `frames`, else over those that are played.

    The height of the sensor is that of the plate's picture, the placement that of its headers,
    where the plate is there; the notes say which, or what was assumed. `scene_unit_m` None takes
    the unit that the shot reads the plate with. Raises InputError where no frames are known,
    LensError where keys make no lens.
    """
    sequence, notes = _plate(shot)
    frames = frames or shot.played or _frames_of(sequence)
    if frames is None:
        raise InputError(
            "The shot has no frames: neither its plate nor keys tell any. Give them with --frames."
        )
    unit_m = shot.plate_options.scene_unit_m if scene_unit_m is None else scene_unit_m
    camera = lens_camera(shot, name, frames)
    placement, placement_notes = _placement(sequence, frames, unit_m)
    height_mm, height_note = _height_mm(shot, sequence, sensor_height_mm)
    return replace(
        camera,
        sensor_height_mm=(height_mm,) * frames.count,
        world_to_camera=placement,
        up_axis=up_axis,
        notes=(*notes, height_note, *placement_notes),
    )


def _plate(shot: Shot) -> tuple[Sequence | None, tuple[str, ...]]:
    """The plate's files, or why there are none."""
    if shot.source is None:
        return None, ()
    try:
        return find_sequence(shot.source), ()
    except InputError as error:
        return None, (f"the plate has no files: {error}",)


def _frames_of(sequence: Sequence | None) -> FrameRange | None:
    """Those of the plate; a still has none."""
    if sequence is None or sequence.is_single:
        return None
    return FrameRange(sequence.first, sequence.last)


def _height_mm(shot: Shot, sequence: Sequence | None, given_mm: float | None) -> tuple[float, str]:
    """Height of the part of the sensor that the picture shows, and where it is from."""
    width_mm = shot.lens.sensor_width_mm
    if given_mm is not None:
        return given_mm, f"sensor height {given_mm:g} mm, as given."
    if sequence is not None:
        path = sequence.path_at(sequence.present[0])
        height_mm = width_mm / picture_aspect(path, read_headers(path))
        return height_mm, f"sensor height {height_mm:.4g} mm, from the shape of {path.name}."
    backs = [back for back in FILMBACKS if back.width_mm == width_mm]
    if len({back.height_mm for back in backs}) == 1:
        height_mm = backs[0].height_mm
        return height_mm, f"sensor height {height_mm:g} mm, assumed: film back {backs[0].name}."
    height_mm = width_mm / _ASSUMED_ASPECT
    return height_mm, f"sensor height {height_mm:.4g} mm, assumed: a picture of 16:9."


def _placement(sequence: Sequence | None, frames: FrameRange, scene_unit_m: float) -> _Placement:
    """Where the camera stands at each frame; a still tells it once for all."""
    if sequence is None:
        return None, ("without a plate the camera has no placement.",)
    if sequence.is_single:
        headers = [read_headers(sequence.path_at(sequence.first))] * frames.count
    else:
        headers = [
            read_headers(sequence.path_at(frame)) if sequence.has(frame) else [] for frame in frames
        ]
    return placement_of(headers, tuple(frames), scene_unit_m)
