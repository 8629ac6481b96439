"""The checked arguments of `render`, and the lens that they give for a plate."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.option import Values
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.fronts.api.arguments import (
    BLUR_OPTION_NAMES,
    LENS_VALUES,
    check_choice,
    check_pair,
    check_values,
    check_whole_number,
    short_repr,
)
from heatlens.media.plate.coc_line import depth_at_m, focused_at_pixel
from heatlens.media.plate.header.header_lens import plate_lens
from heatlens.media.plate.opening_picture import opening_notes
from heatlens.media.plate.plate import Plate


@dataclass(frozen=True)
class RenderRequest:
    """The checked arguments of a `render` call.

    frame        None for the first frame
    lens_fields  the given fields of Lens
    focus_at     a pixel (x, y) to focus on; None if the focus is given, or comes from the source
    blur_fields  the given fields of DefocusSettings
    """

    frame: int | None
    lens_fields: Values
    focus_at: tuple[int, int] | None
    blur_fields: Values

    @property
    def changes_lens(self) -> bool:
        """Whether the lens differs from that of the source."""
        return bool(self.lens_fields) or self.focus_at is not None

    def lens(self, plate: Plate, shot_values: Mapping[str, Any] = MappingProxyType({})) -> Lens:
        """Return the lens in front of a plate; `shot_values` holds the lens of its shot file."""
        values = {**shot_values, **self.lens_fields}
        if self.focus_at is not None:
            values["focus_distance_m"] = depth_at_m(plate, *self.focus_at)
        lens = plate_lens(plate, values).lens
        return lens if self.focus_at is None else focused_at_pixel(plate, lens, *self.focus_at)

    def notes(self, plate: Plate) -> tuple[str, ...]:
        """Return sentences on arguments without effect on a plate, and on the aperture image."""
        unused_names = [name for name in (*LENS_VALUES, "model") if name in self.lens_fields]
        image_notes: tuple[str, ...] = ()
        image = self.lens_fields.get("aperture_image")
        if image is not None:
            has_blades = any(self.lens_fields.get(name) for name in ("blades", "blade_curvature"))
            image_notes = opening_notes(image, has_blades)
        if plate.has_distances or not unused_names:
            return image_notes
        names = ", ".join("lens_model" if name == "model" else name for name in unused_names)
        return (*image_notes, f"The plate holds circles of confusion: {names} is not used.")


def check_render_arguments(
    lens: Lens | None,
    frame: int | None,
    values: Mapping[str, float | None],
    focus_at: tuple[int, int] | None,
    lens_model: str | None,
    options: Mapping[str, object],
) -> RenderRequest:
    """Return the checked arguments. Raises InputError for a value of another type."""
    if not (lens is None or isinstance(lens, Lens)):
        raise InputError(f"lens must be a heatlens.Lens, got {short_repr(lens)}.")
    lens_fields = {} if lens is None else lens_values(lens)
    lens_fields |= check_values(
        Lens, _without_none({**values, **_select(APERTURE_FIELDS, options)})
    )
    if lens_model is not None:
        lens_fields["model"] = check_choice(LensModel, "lens_model", lens_model)
    if focus_at is not None and values["focus_distance_m"] is not None:
        raise InputError("Give focus_distance_m or focus_at, not both.")
    pixel = None if focus_at is None else check_pair("focus_at", "a pixel (x, y)", focus_at)
    blur_fields = check_values(DefocusSettings, _select(BLUR_OPTION_NAMES, options))
    return RenderRequest(
        frame=None if frame is None else check_whole_number("frame", frame),
        lens_fields=lens_fields,
        focus_at=pixel,
        blur_fields=blur_fields,
    )


def _select(names: Iterable[str], values: Mapping[str, object]) -> dict[str, object]:
    """Return the values that have one of these names."""
    return {name: values[name] for name in names if name in values}


def _without_none(values: Mapping[str, object]) -> dict[str, object]:
    """Return the values without those that are None."""
    return {name: value for name, value in values.items() if value is not None}


def lens_values(lens: Lens) -> dict[str, object]:
    """Return the fields of a lens that have a value."""
    return _without_none({field.name: getattr(lens, field.name) for field in fields(lens)})
