"""Plates and scenes that can be rendered through a lens to arrays."""

import os
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from heatlens.api.engine import ENGINE
from heatlens.closing import Closing
from heatlens.errors import InputError
from heatlens.frame_cache.reader import SequenceReader
from heatlens.gpu.textures import FloatArray
from heatlens.model.aperture import APERTURE_FIELDS
from heatlens.model.lens import Lens
from heatlens.model.lens_model import LensModel
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.model.shot import LensCurves, Shot
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.header_lens import plate_lens
from heatlens.plate.opening_picture import read_opening_image
from heatlens.plate.plate import Plate
from heatlens.render import FrameRenderer
from heatlens.scene.first_shot import FirstShot
from heatlens.source.plate_source import PlateSource

Choice = TypeVar("Choice", bound=StrEnum)
_BLUR: dict[str, type[StrEnum]] = {"bokeh": Bokeh, "quality": Quality, "method": Method}


class Source(Closing):
    """The source in front of the lens: a plate, a sequence of plates, or a 3D scene."""

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
        **more: Any,
    ) -> FloatArray:
        """Return the picture with the lens.

        (H, W, 4) float32, scene-linear, premultiplied, row 0 top.

        Give `lens`, or single values of it; values that are not given come from the shot file, the
        header or the scene's camera. `lens_model` is "photographic" or "renderer". `focus_at` is a
        pixel (x, y) of the picture to focus on. `frame` is that of a sequence, a shot or a scene
        (default: the first). `more` takes the fields of `Aperture`: squeeze, blades,
        blade_rotation_deg, blade_curvature, cat_eye, rim, axial_colour_mm, aperture_image (a
        path); and those of `DefocusSettings`: quality="draft", bokeh, layers, proxy, method, views.

        Raises HeatlensError for a lens value that is missing, a file that cannot be read, and a
        picture too large for this machine.
        """
        values = {
            "focal_length_mm": focal_length_mm,
            "sensor_width_mm": sensor_width_mm,
            "f_stop": f_stop,
            "focus_distance_m": focus_distance_m,
        }
        opening = {name: more.pop(name) for name in APERTURE_FIELDS if name in more}
        if isinstance(opening.get("aperture_image"), str | os.PathLike):
            opening["aperture_image"] = read_opening_image(opening["aperture_image"])
        given = {} if lens is None else _values_of(lens)
        given |= {name: float(value) for name, value in values.items() if value is not None}
        given |= {name: value for name, value in opening.items() if value is not None}
        if lens_model is not None:
            given["model"] = _known(LensModel, "lens_model", lens_model)
        if focus_at is not None and focus_distance_m is not None:
            raise InputError("Give focus_distance_m or focus_at, not both.")
        shot, at = self._shot_on(ENGINE.renderer(), _Request(frame, given, focus_at))
        defocus = _settings(shot.defocus, more)
        return ENGINE.renderer().pixels(replace(shot, defocus=defocus), at)

    @abstractmethod
    def _shot_on(self, renderer: FrameRenderer, request: "_Request") -> tuple[Shot, int]:
        """Load the source for a request. Return the shot with its lens, and the frame."""

    def close(self) -> None:
        """Release the pixels; the next `render` reads and loads them again."""
        ENGINE.forget(self)


@dataclass(frozen=True)
class _Request:
    """The arguments of a `render` call.

    frame     None for the first frame
    given     fields of Lens
    focus_at  a pixel (x, y) to focus on; None if the focus is given, or comes from the source
    """

    frame: int | None
    given: dict[str, Any]
    focus_at: tuple[int, int] | None

    def lens(self, plate: Plate, told: Mapping[str, Any] = MappingProxyType({})) -> Lens:
        """Return the lens in front of a plate; `told` are the values of its shot file."""
        values = {**told, **self.given}
        if self.focus_at is not None:
            values["focus_distance_m"] = depth_at_m(plate, *self.focus_at)
        return plate_lens(plate, values).lens


class OnePlate(Source):
    """A plate in memory, without frames."""

    def __init__(self, plate: Plate) -> None:
        self._plate = plate

    def _shot_on(self, renderer: FrameRenderer, request: _Request) -> tuple[Shot, int]:
        if request.frame is not None:
            raise InputError("An array is one picture: leave frame out.")
        ENGINE.load(self, self._plate, renderer.load)
        return Shot(request.lens(self._plate)), 0


class Plates(Source):
    """A sequence of files; `shot` has the lens if a shot file was opened."""

    def __init__(self, source: PlateSource, shot: Shot | None) -> None:
        self._sequence = source.sequence
        self._reader = SequenceReader(source.options, source.first_file)
        self._shot = shot
        self._read: tuple[Path, Plate] | None = None

    def _shot_on(self, renderer: FrameRenderer, request: _Request) -> tuple[Shot, int]:
        at = self._sequence.present[0] if request.frame is None else request.frame
        plate = self._plate(self._sequence.path_at(at))
        ENGINE.load(self, plate, renderer.load)
        if self._shot is None:
            return Shot(request.lens(plate)), at
        return _with_lens(self._shot, request.lens(plate, _values_of(self._shot.lens_at(at)))), at

    def close(self) -> None:
        """See `Source.close`."""
        self._read = None
        super().close()

    def _plate(self, path: Path) -> Plate:
        """Read a plate and keep it, because the lens changes more often than the frame."""
        if self._read is None or self._read[0] != path:
            self._read = (path, self._reader(path))
        return self._read[1]


class Scene(Source):
    """A 3D scene, through one of its cameras."""

    def __init__(self, first: FirstShot, text: str) -> None:
        self._first = first
        self._text = text

    def _shot_on(self, renderer: FrameRenderer, request: _Request) -> tuple[Shot, int]:
        first = self._first
        at = first.frame if request.frame is None else request.frame
        ENGINE.load(self, first.scene, renderer.load_scene)
        shot = _with_values(first.shot, at, request.given)
        if request.focus_at is not None:
            found_m = depth_at_m(renderer.look(shot, at).plate, *request.focus_at)
            return _with_values(shot, at, {"focus_distance_m": found_m}), at
        needed = {"f_stop", "focus_distance_m"} & first.assumed - set(request.given)
        if needed:
            missing = " and ".join(sorted(needed))
            raise InputError(
                f"{self._text}: the scene does not define the whole lens: give {missing}."
            )
        return shot, at


def _with_values(shot: Shot, frame: int, given: Mapping[str, Any]) -> Shot:
    """Return the shot at one frame, its lens there changed by the given values."""
    if not given:
        return shot
    return _with_lens(shot, replace(shot.lens_at(frame), **given))


def _with_lens(shot: Shot, lens: Lens) -> Shot:
    """Return the shot with a lens that does not change over time."""
    return replace(shot, lens=lens, curves=LensCurves())


def _values_of(lens: Lens) -> dict[str, Any]:
    values = {field.name: getattr(lens, field.name) for field in fields(lens)}
    return {name: value for name, value in values.items() if value is not None}


def _settings(before: DefocusSettings, blur: Mapping[str, Any]) -> DefocusSettings:
    """Return `before` with the given fields. Raises InputError for a name that is no field."""
    check_names(blur, DefocusSettings)
    values: dict[str, Any] = dict(blur)
    for name, kind in _BLUR.items():
        if name in values:
            values[name] = _known(kind, name, values[name])
    return replace(before, **values)


def _known(kind: type[Choice], name: str, value: Any) -> Choice:
    """Return the choice called `value`. Raises InputError if there is none."""
    try:
        return kind(value)
    except ValueError:
        known = ", ".join(kind)
        raise InputError(f"{name} is one of {known}, got {value!r}.") from None


def check_names(given: Mapping[str, Any], kind: Any) -> None:
    """Raise InputError for a name that is no field of the dataclass `kind`."""
    known = [field.name for field in fields(kind)]
    for name in given:
        if name not in known:
            raise InputError(f"There is no {name!r}; there are {', '.join(known)}.")
