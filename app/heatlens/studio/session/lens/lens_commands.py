"""Commands for the lens at the playhead, its kit, and the quality and shape of its blur.

`KitCommands` choose the lens kit of the shot and the mounted lens of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TypeVar

from heatlens.core.base.background import Background
from heatlens.core.base.messages import Problem, report_errors
from heatlens.core.model.lens.lens import Lens, step_f_stop
from heatlens.core.model.lens.lens_kit import KitLens, LensKit
from heatlens.core.model.shot.settings import Bokeh, Quality
from heatlens.core.model.units import format_distance
from heatlens.media.documents.lens_kits import KitShelf, kit_shelf
from heatlens.media.plate.coc_line import (
    Surface,
    focused_at,
    focused_at_pixel,
    nudge_lens,
    surfaces_at,
)
from heatlens.media.plate.header.header_lens import StartLens
from heatlens.media.plate.mattes.mattes import has_things, thing_at
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.shared import Commands, Shared


class KitCommands(Commands):
    """Chooses kits and their lenses; each choice is one undo step."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._shelf: KitShelf | None = None

    @property
    def shelf(self) -> KitShelf:
        """All lens kits, read at the first access; damaged files are reported."""
        if self._shelf is None:
            self._shelf = kit_shelf()
            if self._shelf.problems:
                self._notify(Problem(self._shelf.problems[0]))
        return self._shelf

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all kits; the shot's kit is first if this machine does not have it."""
        kit = self._editing.shot.kit
        missing = () if kit is None or kit.name in self.shelf.kits else (kit.name,)
        return (*missing, *self.shelf.kits)

    @property
    def mounted_lens(self) -> KitLens | None:
        """The mounted lens of the kit; None without a kit."""
        kit = self._editing.shot.kit
        return None if kit is None else kit.nearest(self._editing.lens.focal_length_mm)

    def choose(self, name: str | None) -> None:
        """Choose a kit by its name and mount its closest lens; None removes the kit."""
        kit = None if name is None else self.shelf.kits.get(name)
        if kit is None:
            if name is None:
                self._editing.do(replace(self._editing.shot, kit=None))
                self._notify("The lens no longer belongs to a kit.")
            return
        self._mount(kit, kit.nearest(self._editing.lens.focal_length_mm))

    def breathe(self, is_on: bool) -> None:
        """Switch the breathing of the mounted lens on or off."""
        mounted_lens, lens = self.mounted_lens, self._editing.lens
        ratio = mounted_lens.breathing if is_on and mounted_lens is not None else 1.0
        self._editing.edit_lens(replace(lens, breathing=ratio))

    def mount(self, kit_lens: KitLens) -> None:
        """Mount another lens of the shot's kit; do nothing for a shot without a kit."""
        kit = self._editing.shot.kit
        if kit is not None:
            self._mount(kit, kit_lens)

    def _mount(self, kit: LensKit, kit_lens: KitLens) -> None:
        """Choose a kit and mount one of its lenses, as one undo step, and notify the user."""
        editing = self._editing
        with report_errors(self._notify):
            lens = kit.mount(editing.lens, kit_lens)
            editing.settle()
            editing.edit(replace(editing.shot, kit=kit))
            editing.edit_lens(lens)
            editing.settle()
            self._notify(f"The lens is the {kit_lens.name} of {kit.name}: it {kit_lens.words}.")


Choice = TypeVar("Choice", bound=StrEnum | None)


@dataclass(frozen=True)
class Aim:
    """Where the last click or the loupe was, what was seen there, and the lens since then."""

    plate: Plate
    pixel: tuple[int, int]
    surfaces: tuple[Surface, ...]
    lens: Lens


class LensCommands(Commands):
    """Changes of the lens; each can be undone."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.kits = KitCommands(shared)
        self._surface_names = SurfaceNames(shared.wake)
        self._aim: Aim | None = None
        self.start_lens: StartLens | None = None  # the lens of the open source, and its origin

    def focus_at(self, pixel: tuple[int, int]) -> None:
        """Focus on what is seen at a pixel of the display window; do nothing outside the picture.

        A press focuses on a near object whose blur covers the pixel. A drag continues with the
        surface that the pinhole picture shows there.
        """
        plate, last_aim, lens = self._source.plate, self._aim, self._editing.lens
        pixel = self._source.plate_px(lens, self._editing.shot, pixel)
        if plate is None or not plate.contains_pixel(*pixel):
            return
        is_dragging = last_aim is not None and last_aim.lens == lens and self._editing.is_unsettled
        if is_dragging and last_aim is not None and last_aim.pixel == pixel:
            return
        with report_errors(self._notify):
            surfaces = surfaces_at(plate, lens, *pixel)
            self._focus_on_first(plate, pixel, surfaces[-1:] if is_dragging else surfaces)

    def find_surfaces(self, pixel: tuple[int, int]) -> tuple[Surface, ...]:
        """Return the surface that a click at a pixel focuses on, and the other surface there.

        `pixel` is in the display window. `focus_on_other` then focuses on the other surface. The
        result is empty outside the picture.
        """
        plate, lens = self._source.plate, self._editing.lens
        pixel = self._source.plate_px(lens, self._editing.shot, pixel)
        if plate is None or not (plate.has_distances and plate.contains_pixel(*pixel)):
            return ()
        aim = self._aim
        is_same = aim is not None and aim.plate is plate and (aim.pixel, aim.lens) == (pixel, lens)
        if aim is None or not is_same:
            aim = self._aim = Aim(plate, pixel, surfaces_at(plate, lens, *pixel), lens)
        return aim.surfaces

    def names_of(self, surfaces: Sequence[Surface]) -> tuple[str, ...]:
        """Return the names that mattes give to surfaces; "" until they are known."""
        plate = self._source.plate
        if plate is None:
            return ("",) * len(surfaces)
        with report_errors(self._notify):
            return self._surface_names.names(plate, surfaces)
        return ("",) * len(surfaces)

    def focus_on_other(self) -> None:
        """Focus on the other thing that was seen where the last click was, or under the loupe."""
        aim, plate = self._aim, self._source.plate
        if aim is None or plate is None or len(aim.surfaces) < 2 or aim.lens != self._editing.lens:
            self._notify("There is no other surface here, or where you clicked last.")
            return
        with report_errors(self._notify):
            self._focus_on_first(plate, aim.pixel, aim.surfaces[::-1])

    def _focus_on_first(
        self, plate: Plate, pixel: tuple[int, int], surfaces: tuple[Surface, ...]
    ) -> None:
        """Focus on the first of the surfaces at a pixel, and report the distance of the other."""
        x, y = surfaces[0].x, surfaces[0].y
        self._editing.edit_lens(focused_at_pixel(plate, self._editing.lens, x, y))
        self._aim = Aim(plate, pixel, surfaces, self._editing.lens)
        if len(surfaces) > 1:
            focused, other_distance = (format_distance(surface.depth_m) for surface in surfaces)
            self._notify(
                f"Focus at {focused}. The other surface here is at {other_distance}: Y takes it."
            )

    def focus(self, distance_m: float) -> None:
        """Set the focus distance of the lens, in meters."""
        self._editing.edit_lens(replace(self._editing.lens, focus_distance_m=distance_m))

    def nudge_focus(self, notches: float) -> None:
        """Focus nearer (positive) or farther by a number of notches of the focus bar."""
        histogram = self._source.picture.histogram
        if histogram is not None:
            self._editing.edit_lens(nudge_lens(self._editing.lens, histogram, notches))

    def focus_at_infinity(self) -> None:
        """Focus at infinity if the plate has distances."""
        if self._source.picture.histogram is not None:
            self._editing.edit_lens(focused_at(self._editing.lens, 0.0))

    def step_f_stop(self, steps: int) -> None:
        """Close the aperture by a number of thirds of a stop; a negative number opens it."""
        lens = self._editing.lens
        self._editing.edit_lens(replace(lens, f_stop=step_f_stop(lens.f_stop, steps)))

    def reset(self) -> None:
        """Reset the lens to that of the plate's header or of the command line."""
        if self.start_lens is not None:
            self._editing.edit_lens(self.start_lens.lens)

    def next_quality(self) -> None:
        """Switch to the next quality tier; the first follows the last."""
        shot = self._editing.shot
        defocus = replace(
            shot.defocus, quality=_next_choice([None, *Quality], shot.defocus.quality)
        )
        self._editing.edit(replace(shot, defocus=defocus))

    def next_bokeh(self) -> None:
        """Switch to the next shape of the blur; the first follows the last."""
        shot = self._editing.shot
        defocus = replace(shot.defocus, bokeh=_next_choice(list(Bokeh), shot.defocus.bokeh))
        self._editing.edit(replace(shot, defocus=defocus))


def _next_choice(choices: Sequence[Choice], current: Choice) -> Choice:
    """Return the choice after the current one; the first follows the last."""
    return choices[(choices.index(current) + 1) % len(choices)]


_Names = tuple[str, ...]


class SurfaceNames:
    """Finds the names of surfaces on a thread; a name is "" until it is known."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._request: tuple[Plate, tuple[Surface, ...]] | None = None
        self._names: _Names = ()
        self._reader: Background[_Names] = Background(wake)

    def names(self, plate: Plate, surfaces: Sequence[Surface]) -> _Names:
        """Return the names of surfaces, or begin to look for them."""
        request, last_request = (plate, tuple(surfaces)), self._request
        if last_request is None or last_request[0] is not plate or last_request[1] != request[1]:
            self._request, self._names = request, ("",) * len(surfaces)
            self._reader.cancel()
            if has_things(plate):
                self._reader.start(
                    lambda: tuple(_matte_name(plate, surface) for surface in request[1])
                )
        self._names = self._reader.poll() or self._names
        return self._names


def _matte_name(plate: Plate, surface: Surface) -> str:
    """Return the name of the matte at a surface without its layer; "" if there is none."""
    return (thing_at(plate, surface.x, surface.y) or "").partition(":")[2]
