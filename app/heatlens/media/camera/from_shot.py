"""Convert the lens of a shot to a camera, for programs that render depth of field themselves."""

import math
from collections.abc import Sequence as Items
from dataclasses import dataclass, replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.breathing import without_breathing
from heatlens.core.model.lens.filmback import FILMBACKS
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import options_of
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.placement import Matrix, matrix_of
from heatlens.media.camera.plate_camera import picture_aspect, placement_of
from heatlens.media.camera.samples import (
    OPENING_TRACKS,
    PLAIN_OPENING,
    UNSAVED_OPENING_FIELDS,
    CameraSamples,
    UpAxis,
    fields_of,
)
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.header.channels import Header
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.scene.placing import place_scene
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import track_of
from heatlens.media.scene.scene_read import open_scene
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence

_ASSUMED_ASPECT = 16 / 9
_SAME_HEIGHT = 0.005  # relative tolerance: film backs are given in hundredths of a millimeter
_STILL = FrameRange(1, 1)

# The world-to-camera matrix of each frame, or None without a placement; and notes for the user.
_Placement = tuple[tuple[Matrix, ...] | None, tuple[str, ...]]


@dataclass(frozen=True)
class CameraRequest:
    """The choices for writing a shot as a camera.

    frames            the frames to sample; None means those that are played, else all
    sensor_height_mm  None: as wide and high as the picture
    scene_unit_m      the unit of the world around plates, in meters; None: as the plate is read
    up_axis           the up axis of the world around plates; scenes have y up
    """

    name: str
    frames: FrameRange | None = None
    sensor_height_mm: float | None = None
    scene_unit_m: float | None = None
    up_axis: UpAxis = "y"


def camera_before_plates(shot: Shot, request: CameraRequest) -> CameraSamples:
    """Return the lens of `shot` and its placement over the requested frames.

    The height of the sensor follows from the shape of the plate's picture and the placement from
    its headers, if its files are there; the notes say which, or what was assumed.

    Raises InputError if no frames are known, and LensError where the keys of a frame describe no
    possible lens.
    """
    sequence, notes = _plate(shot)
    frames = request.frames or shot.played_frames or _frames_of(sequence)
    if frames is None:
        raise InputError(
            "The shot has no frames: neither its plate nor its keys have any. Give them with "
            "--frames."
        )
    unit_m = request.scene_unit_m
    unit_m = shot.plate_options.scene_unit_m if unit_m is None else unit_m
    placement, placement_notes = _placement(sequence, frames, unit_m)
    height_mm, height_note = _sensor_height_mm(shot, sequence, request.sensor_height_mm)
    return replace(
        _lens_camera(shot, request.name, frames),
        sensor_height_mm=(height_mm,) * frames.count,
        world_to_camera=placement,
        up_axis=request.up_axis,
        notes=(*notes, height_note, *placement_notes, *_opening_notes(shot.lens)),
    )


def camera_in_scene(shot: Shot, request: CameraRequest) -> CameraSamples:
    """Return the lens of `shot` and its placement in its scene over the requested frames.

    Lengths are in meters and y is up, as in the scene. Raises InputError if the scene cannot be
    read, or does not have the camera.
    """
    framing = shot.framing or Framing()
    scene = place_scene(open_scene(shot.source or "", framing.timing), framing)
    frames = request.frames or shot.played_frames or scene.frames or _STILL
    height_mm = request.sensor_height_mm
    origin = "as given"
    if height_mm is None:
        height_mm = shot.lens.sensor_width_mm * framing.height_px / framing.width_px
        origin = f"from a picture of {framing.width_px}x{framing.height_px}"
    return replace(
        _lens_camera(shot, request.name, frames),
        sensor_height_mm=(height_mm,) * frames.count,
        world_to_camera=tuple(_scene_placement(shot, scene, framing, frame) for frame in frames),
        notes=(
            f"sensor height {height_mm:.4g} mm, {origin}.",
            f"placement as in {scene.path}.",
            *_opening_notes(shot.lens),
        ),
    )


def _scene_placement(shot: Shot, scene: Scene, framing: Framing, frame: int) -> Matrix:
    """Return the world-to-camera matrix of the view of a scene at a frame."""
    pose = track_of(scene, framing, shot.lens_at(frame)).pose_at(frame)
    return matrix_of(pose.world_to_camera)


def _lens_camera(shot: Shot, name: str, frames: FrameRange) -> CameraSamples:
    """Return the lens of the shot at each frame, without placement and sensor height.

    A lens that breathes gets its effective focal length, and the f-stop that keeps its opening.

    Raises LensError if the keys of a frame describe no possible lens.
    """
    lenses = [without_breathing(shot.lens_at(frame)) for frame in frames]
    tracks: dict[str, object] = {
        str(parameter): tuple(float(getattr(lens, parameter)) for lens in lenses)
        for parameter in LensParameter
    }
    for field in OPENING_TRACKS:
        values = [getattr(lens, field) for lens in lenses]
        if None not in values:
            tracks[field] = tuple(float(value) for value in values)
    return CameraSamples(
        name,
        tuple(frames),
        **fields_of(tracks),
        sensor_width_mm=(shot.lens.sensor_width_mm,) * frames.count,
        lens_model=shot.lens.model,
        aperture_image=shot.lens.aperture_image,
        frames_per_second=shot.frames_per_second,
    )


def _opening_notes(lens: Lens) -> tuple[str, ...]:
    """Return notes on the values of the opening that a camera cannot hold, and on its image."""
    lost_fields = [
        name for name in UNSAVED_OPENING_FIELDS if getattr(lens, name) != PLAIN_OPENING[name]
    ]
    notes = tuple(
        f"the {options_of(Lens)[name].words} is lost: no camera format can hold it."
        for name in lost_fields
    )
    image = lens.aperture_image
    if image is None:
        return notes
    first_clause = f"the aperture image {image.path} is named beside the lens"
    return *notes, f"{first_clause}. heatlens reads it back; other programs do not render with it."


def _plate(shot: Shot) -> tuple[Sequence | None, tuple[str, ...]]:
    """Return the files of the plate, or None and a note if they cannot be found."""
    if shot.source is None:
        return None, ()
    try:
        return find_sequence(shot.source), ()
    except InputError as error:
        return None, (f"the plate has no files: {error}",)


def _frames_of(sequence: Sequence | None) -> FrameRange | None:
    """Return the range of frames of a sequence; a still has one frame. None without a sequence."""
    return None if sequence is None else FrameRange(sequence.first, sequence.last)


def _sensor_height_mm(
    shot: Shot, sequence: Sequence | None, requested_mm: float | None
) -> tuple[float, str]:
    """Return the height of the sensor's visible part, and a note on its origin."""
    width_mm = shot.lens.sensor_width_mm
    if requested_mm is not None:
        return requested_mm, f"sensor height {requested_mm:g} mm, as given."
    if sequence is not None:
        path = sequence.path_at(sequence.present[0])
        headers = read_headers(path)
        height_mm = width_mm / picture_aspect(path, headers)
        note = f"sensor height {height_mm:.4g} mm, from the shape of {path.name}"
        return height_mm, f"{note}{_header_height_note(headers, height_mm)}."
    backs = [back for back in FILMBACKS if back.width_mm == width_mm]
    if len({back.height_mm for back in backs}) == 1:
        height_mm = backs[0].height_mm
        return height_mm, f"sensor height {height_mm:g} mm, assumed: film back {backs[0].name}."
    height_mm = width_mm / _ASSUMED_ASPECT
    return height_mm, f"sensor height {height_mm:.4g} mm, assumed: a picture of 16:9."


def _header_height_note(headers: Items[Header], height_mm: float) -> str:
    """Return a clause with the height that the headers give if it differs from `height_mm`, or "".

    They differ if the picture shows another part of the sensor.
    """
    header_mm = camera_at_header(headers).sensor_height_mm
    if header_mm is None or math.isclose(header_mm, height_mm, rel_tol=_SAME_HEIGHT):
        return ""
    return f"; its header says {header_mm:.4g} mm, which is not the height of this picture"


def _placement(sequence: Sequence | None, frames: FrameRange, scene_unit_m: float) -> _Placement:
    """Return the placement of the camera at each frame, from headers; a still has one for all."""
    if sequence is None:
        return None, ("without a plate the camera has no placement.",)
    if sequence.is_single:
        headers = [read_headers(sequence.path_at(sequence.first))] * frames.count
    else:
        headers = [
            read_headers(sequence.path_at(frame)) if sequence.has_file(frame) else []
            for frame in frames
        ]
    return placement_of(headers, tuple(frames), scene_unit_m)
