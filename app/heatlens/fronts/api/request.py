"""The arguments of `render`, checked, and what they make of a lens."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.option import Values
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.fronts.api.arguments import BLUR, LENS_VALUES, known, pair, shown, values_of, whole
from heatlens.media.plate.coc_line import depth_at_m, focused_at_pixel
from heatlens.media.plate.header.header_lens import plate_lens
from heatlens.media.plate.opening_picture import opening_notes
from heatlens.media.plate.plate import Plate


@dataclass(frozen=True)
class Request:
    """The checked arguments of a `render` call.

    frame     None for the first frame
    given     fields of Lens
    focus_at  a pixel (x, y) to focus on; None if the focus is given, or comes from the source
    blur      fields of DefocusSettings
    """

    frame: int | None
    given: Values
    focus_at: tuple[int, int] | None
    blur: Values

    @property
    def changes_lens(self) -> bool:
        """Return whether the lens differs from that of the source."""
        return bool(self.given) or self.focus_at is not None

    def lens(self, plate: Plate, known: Mapping[str, Any] = MappingProxyType({})) -> Lens:
        """Return the lens in front of a plate; `told` holds the values of its shot file."""
        values = {**known, **self.given}
        if self.focus_at is not None:
            values["focus_distance_m"] = depth_at_m(plate, *self.focus_at)
        lens = plate_lens(plate, values).lens
        return lens if self.focus_at is None else focused_at_pixel(plate, lens, *self.focus_at)

    def notes(self, plate: Plate) -> tuple[str, ...]:
        """Return sentences on arguments without effect on a plate, and on the aperture image."""
        unused = [name for name in (*LENS_VALUES, "model") if name in self.given]
        said: tuple[str, ...] = ()
        image = self.given.get("aperture_image")
        if image is not None:
            has_blades = any(self.given.get(name) for name in ("blades", "blade_curvature"))
            said = opening_notes(image, has_blades)
        if plate.has_distances or not unused:
            return said
        names = ", ".join("lens_model" if name == "model" else name for name in unused)
        return (*said, f"The plate holds circles of confusion: {names} is not used.")


def request_of(
    lens: Lens | None,
    frame: int | None,
    values: Mapping[str, float | None],
    focus_at: tuple[int, int] | None,
    lens_model: str | None,
    more: Mapping[str, object],
) -> Request:
    """Return the checked arguments. Raises InputError for a value of another type."""
    if not (lens is None or isinstance(lens, Lens)):
        raise InputError(f"lens must be a heatlens.Lens, got {shown(lens)}.")
    given = {} if lens is None else lens_values(lens)
    given |= values_of(Lens, _told({**values, **_among(APERTURE_FIELDS, more)}))
    if lens_model is not None:
        given["model"] = known(LensModel, "lens_model", lens_model)
    if focus_at is not None and values["focus_distance_m"] is not None:
        raise InputError("Give focus_distance_m or focus_at, not both.")
    pixel = None if focus_at is None else pair("focus_at", "a pixel (x, y)", focus_at)
    blur = values_of(DefocusSettings, _among(BLUR, more))
    return Request(None if frame is None else whole("frame", frame), given, pixel, blur)


def _among(names: Iterable[str], given: Mapping[str, object]) -> dict[str, object]:
    return {name: given[name] for name in names if name in given}


def _told(given: Mapping[str, object]) -> dict[str, object]:
    return {name: value for name, value in given.items() if value is not None}


def lens_values(lens: Lens) -> dict[str, object]:
    """Return the fields of a lens that have a value."""
    return _told({field.name: getattr(lens, field.name) for field in fields(lens)})
