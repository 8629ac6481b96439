"""A kit of lenses: their focal lengths, widest stops and close focus distances.

A kit limits the lens of a shot in the way the lenses on a set do. The shot stores it as a value, so
that the shot is the same on a machine that does not have the kit.
"""

import math
from dataclasses import dataclass, field, replace

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.lens import Lens, as_measured_m, from_pupil_m
from heatlens.core.model.lens.opening_fields import OpeningFields
from heatlens.core.model.option import Values

# Limits of the values of a lens in a kit.
_LENGTHS_MM = (1.0, 5000.0)
_STOPS = (0.5, 64.0)
_CLOSE_M = (0.01, 100.0)
_NEAREST_FOCUS = 1.1  # in focal lengths; at 1 the image is infinitely far away
_BREATHING = (0.5, 1.5)


@dataclass(frozen=True, slots=True)
class KitLens:
    """One lens of a kit.

    focal_length_mm   of a prime; the shortest of a zoom
    f_stop            the widest
    close_focus_m     the nearest focus, from where the lens of the shot is measured
    longest_mm        of a zoom; None for a prime
    t_stop            the widest T-stop; None if unknown
    breathing         width of the view at close focus over that at infinity, at the same length

    Raises InputError naming the value and what it may be.
    """

    focal_length_mm: float
    f_stop: float
    close_focus_m: float
    longest_mm: float | None = None
    t_stop: float | None = None
    breathing: float = 1.0

    def __post_init__(self) -> None:
        _check("focal length", self.focal_length_mm, *_LENGTHS_MM, "mm")
        _check("f-stop", self.f_stop, *_STOPS)
        _check("close focus", self.close_focus_m, *_CLOSE_M, "m")
        _check("breathing", self.breathing, *_BREATHING)
        if self.longest_mm is not None:
            _check("longest focal length", self.longest_mm, self.focal_length_mm, 5000.0, "mm")
        if self.t_stop is not None:
            _check("T-stop", self.t_stop, self.f_stop, _STOPS[1])
        if self.close_focus_m * 1e3 <= self.longest_length_mm:
            raise InputError(
                f"A lens of {self.longest_length_mm:g} mm cannot focus at {self.close_focus_m:g} "
                "m: the "
                "close focus must be beyond the focal length."
            )

    @property
    def longest_length_mm(self) -> float:
        """The longest focal length in mm."""
        return self.focal_length_mm if self.longest_mm is None else self.longest_mm

    @property
    def name(self) -> str:
        """The length as people say it: "50 mm", "24-70 mm"."""
        zoom = "" if self.longest_mm is None else f"-{self.longest_mm:g}"
        return f"{self.focal_length_mm:g}{zoom} mm"

    @property
    def words(self) -> str:
        """The widest stop and the close focus, in words."""
        stop_text = f"f/{self.f_stop:g}" + (f" (T{self.t_stop:g})" if self.t_stop else "")
        return f"opens to {stop_text}, focuses from {self.close_focus_m:g} m"

    def length_near(self, focal_length_mm: float) -> float:
        """Return the length of this lens that is nearest to another."""
        return min(max(focal_length_mm, self.focal_length_mm), self.longest_length_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class LensCharacter(OpeningFields):
    """The out-of-focus character of a kit. Raises InputError for an impossible opening."""

    def __post_init__(self) -> None:
        try:
            Aperture(**self.opening)
        except LensError as error:
            raise InputError(str(error)) from None


@dataclass(frozen=True, slots=True)
class LensKit:
    """Lenses that belong together.

    name       in one word, for the command line
    words      a description for people
    lenses     sorted by focal length
    character  the look of all of them out of focus

    Raises InputError for a kit without a name or without lenses, and for two lenses of one length.
    """

    name: str
    words: str
    lenses: tuple[KitLens, ...]
    character: LensCharacter = field(default_factory=LensCharacter)

    def __post_init__(self) -> None:
        if not self.name or any(letter.isspace() or letter in ":/\\" for letter in self.name):
            raise InputError(
                f"The name of a kit is one word without colons and slashes, not {self.name!r}."
            )
        if not self.lenses:
            raise InputError(f"The kit {self.name} has no lenses: give it at least one.")
        names = [lens.name for lens in self.lenses]
        repeated_name = next((name for name in names if names.count(name) > 1), None)
        if repeated_name is not None:
            raise InputError(
                f"The kit {self.name} has {repeated_name} twice: keep one, or give them names."
            )

    def nearest(self, focal_length_mm: float) -> KitLens:
        """Return the lens whose length has the smallest ratio to this one."""
        return min(
            self.lenses,
            key=lambda lens: abs(
                math.log(lens.length_near(focal_length_mm) / max(focal_length_mm, 1e-3))
            ),
        )

    def mount(self, lens: Lens, kit_lens: KitLens) -> Lens:
        """Return `lens` limited to what `kit_lens` can do, with the character of the kit."""
        return replace(_limit_to_kit_lens(lens, kit_lens), **self.character.opening)

    def limit_lens(self, lens: Lens) -> Lens:
        """Return the lens of the kit that comes nearest to `lens`."""
        return self.mount(lens, self.nearest(lens.focal_length_mm))

    def limit_change(self, previous_lens: Lens | None, requested_lens: Lens) -> Lens:
        """Return the lens after a change to `requested_lens`, limited to the kit.

        Values equal to those of `previous_lens` stay, even outside the kit's limits, as keys of an
        earlier lens may be. If it is None, all values are new.
        """
        limited_lens = _limit_to_kit_lens(
            requested_lens, self.nearest(requested_lens.focal_length_mm)
        )
        if previous_lens is None or requested_lens.focal_length_mm != previous_lens.focal_length_mm:
            return limited_lens
        names = ("focal_length_mm", "f_stop", "focus_distance_m")
        unchanged_values = {
            name: getattr(requested_lens, name)
            for name in names
            if getattr(requested_lens, name) == getattr(previous_lens, name)
        }
        return replace(limited_lens, **unchanged_values)

    def missing_length_message(self, focal_length_mm: float) -> str:
        """Return the sentence which says that the kit has no lens of this length."""
        lengths = ", ".join(lens.name.removesuffix(" mm") for lens in self.lenses)
        return f"The kit {self.name} has no {focal_length_mm:.4g} mm, only {lengths} mm."

    def refusal_message(self, requested_lens: Lens) -> str:
        """Return a sentence on the requested values that the kit cannot provide, or ""."""
        kit_lens = self.nearest(requested_lens.focal_length_mm)
        if requested_lens.focal_length_mm != kit_lens.length_near(requested_lens.focal_length_mm):
            return self.missing_length_message(requested_lens.focal_length_mm)
        subject = f"The {kit_lens.name} of the kit {self.name}"
        if requested_lens.f_stop < kit_lens.f_stop:
            return (
                f"{subject} opens to f/{kit_lens.f_stop:g}, not to f/{requested_lens.f_stop:.3g}."
            )
        if requested_lens.focus_distance_m < _close_focus_m(requested_lens, kit_lens):
            requested_m = as_measured_m(requested_lens, requested_lens.focus_distance_m)
            limit_text = f"{kit_lens.close_focus_m:g} m, not from {requested_m:.3g} m"
            return f"{subject} focuses from {limit_text}."
        return ""


def _limit_to_kit_lens(lens: Lens, kit_lens: KitLens) -> Lens:
    """Return `lens` within what one lens of a kit can do; its character stays."""
    close_focus_m = _close_focus_m(lens, kit_lens)
    limited_values: Values = {
        "focal_length_mm": kit_lens.length_near(lens.focal_length_mm),
        "f_stop": max(lens.f_stop, kit_lens.f_stop),
        "focus_distance_m": max(lens.focus_distance_m, close_focus_m),
        "close_focus_m": close_focus_m,
        "widest_f_stop": kit_lens.f_stop,
    }
    if lens.breathing != 1.0:
        limited_values["breathing"] = kit_lens.breathing
    return replace(lens, **limited_values)


def _close_focus_m(lens: Lens, kit_lens: KitLens) -> float:
    """Return the close focus of a lens of a kit, from the entrance pupil.

    The kit's value is measured from the same point as `lens`. No lens focuses within its own
    length.
    """
    least_m = _NEAREST_FOCUS * 1e-3 * kit_lens.length_near(lens.focal_length_mm)
    return max(from_pupil_m(lens, kit_lens.close_focus_m), least_m)


def _check(words: str, value: float, least: float, most: float, unit: str = "") -> None:
    """Raise InputError if a value of a lens lies outside its limits."""
    if not least <= value <= most:
        limits = f"{least:g} to {most:g} {unit}".strip()
        raise InputError(f"The {words} of a lens in a kit must be {limits}, not {value:g}.")
