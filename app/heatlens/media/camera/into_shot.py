"""Apply a camera to a shot: its lens, with keys for values that change."""

from collections.abc import Collection
from dataclasses import fields, replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.key_reduction import linear_keys
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.option import Values, type_of
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.samples import (
    PLAIN_OPENING,
    CameraSamples,
    Track,
    is_constant,
    with_nominal_f_stop,
)


def with_camera(shot: Shot, camera: CameraSamples, unchanged_fields: Collection[str] = ()) -> Shot:
    """Return `shot` with the lens of `camera`.

    Fields of Lens named in `unchanged_fields`, and those that the camera does not have, stay as
    they are. If the camera has any value of the opening, the whole opening is replaced. A value
    that changes over the frames gets linear keys on the curve's own scale; a constant one gets
    none.

    Raises InputError for a film back whose width changes, and LensError where the values describe
    no possible lens.
    """
    tracks = lens_tracks(camera, unchanged_fields)
    shot = replace(shot, lens=replace(shot.lens, **first_values(camera, unchanged_fields)))
    for parameter in LensParameter:
        if parameter in tracks:
            curve = shot.curves.of(parameter)
            keys = linear_keys(camera.frames, tracks[parameter], curve.scale)
            shot = shot.with_curve(parameter, replace(curve, keys=keys))
    # Raises LensError for a frame whose values describe no possible lens.
    for frame in camera.frames:
        shot.lens_at(frame)
    return shot


def first_values(camera: CameraSamples, unchanged_fields: Collection[str] = ()) -> Values:
    """Return the values of the camera's fields of Lens at its first frame.

    Fields in `unchanged_fields` are left out.

    Raises InputError for a sensor width that changes.
    """
    plain_opening = PLAIN_OPENING if camera.has_opening else {}
    values = {name: value for name, value in plain_opening.items() if name not in unchanged_fields}
    camera_values: Values = {
        name: track[0] for name, track in lens_tracks(camera, unchanged_fields).items()
    }
    for name in camera_values:
        if type_of(Lens, name) is not float:  # cameras hold floats, even for counts
            camera_values[name] = type_of(Lens, name)(round(camera_values[name]))
    if camera.lens_model is not None and "model" not in unchanged_fields:
        camera_values["model"] = camera.lens_model
    if camera.aperture_image is not None and "aperture_image" not in unchanged_fields:
        camera_values["aperture_image"] = camera.aperture_image
    return values | camera_values


def lens_tracks(camera: CameraSamples, unchanged_fields: Collection[str] = ()) -> dict[str, Track]:
    """Return the camera's tracks that are fields of Lens, without `unchanged_fields`.

    The f-stop is the nominal one, which belongs to the camera's lens model. Raises InputError for a
    sensor width that changes.
    """
    camera = with_nominal_f_stop(camera)
    names = {field.name for field in fields(Lens)}.difference(unchanged_fields)
    tracks = {name: track for name, track in camera.lens_tracks.items() if name in names}
    width_mm = tracks.get("sensor_width_mm")
    if width_mm is not None and not is_constant(width_mm):
        raise InputError(
            f"The sensor of camera {camera.name} is {min(width_mm):g} to {max(width_mm):g} mm "
            "wide, but a shot has one width for all its frames: give the width to use."
        )
    return tracks
