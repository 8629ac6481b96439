"""Commands for the lens at the playhead, its kit, and the quality and shape of its blur.

`KitCommands` choose the lens kit of the shot and the mounted lens of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TypeVar

from heatlens.core.base.background import Background
from heatlens.core.model.lens.lens import Lens, stepped
from heatlens.core.model.lens.lens_kit import KitLens, LensKit
from heatlens.core.model.shot.settings import Bokeh, Quality
from heatlens.core.model.units import format_distance
from heatlens.core.model.value_bins import DepthHistogram
from heatlens.media.documents.lens_kits import KitShelf, kit_shelf
from heatlens.media.plate.coc_line import Surface, focused_at, focused_at_pixel, surfaces_at
from heatlens.media.plate.header.header_lens import StartLens
from heatlens.media.plate.mattes.mattes import has_things, thing_at
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.messages import Problem, reported
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
                self._say(Problem(self._shelf.problems[0]))
        return self._shelf

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all kits; the shot's kit is first if this machine does not have it."""
        kit = self._editing.shot.kit
        missing = () if kit is None or kit.name in self.shelf.kits else (kit.name,)
        return (*missing, *self.shelf.kits)

    @property
    def mounted(self) -> KitLens | None:
        """The mounted lens of the kit; None without a kit."""
        kit = self._editing.shot.kit
        return None if kit is None else kit.nearest(self._editing.lens.focal_length_mm)

    def choose(self, name: str | None) -> None:
        """Choose a kit by its name and mount its closest lens; None removes the kit."""
        kit = None if name is None else self.shelf.kits.get(name)
        if kit is None:
            if name is None:
                self._editing.do(replace(self._editing.shot, kit=None))
                self._say("The lens no longer belongs to a kit.")
            return
        self._mount(kit, kit.nearest(self._editing.lens.focal_length_mm))

    def breathe(self, is_on: bool) -> None:
        """Switch the breathing of the mounted lens on or off."""
        mounted, lens = self.mounted, self._editing.lens
        ratio = mounted.breathing if is_on and mounted is not None else 1.0
        self._editing.edit_lens(replace(lens, breathing=ratio))

    def mount(self, kit_lens: KitLens) -> None:
        """Mount another lens of the kit."""
        kit = self._editing.shot.kit
        if kit is not None:
            self._mount(kit, kit_lens)

    def _mount(self, kit: LensKit, kit_lens: KitLens) -> None:
        editing = self._editing
        with reported(self._say):
            lens = kit.mounted(editing.lens, kit_lens)
            editing.settle()
            editing.edit(replace(editing.shot, kit=kit))
            editing.edit_lens(lens)
            editing.settle()
            self._say(f"The lens is the {kit_lens.name} of {kit.name}: it {kit_lens.words}.")


_NUDGE = 1 / 250  # one notch, as a share of the length of the focus bar

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
        self._things = ThingsHere(shared.wake)
        self._aim: Aim | None = None
        self.start_lens: StartLens | None = None  # the lens of the open source, and its origin

    def focus_at(self, pixel: tuple[int, int]) -> None:
        """Focus on what is seen at a pixel of the display window; do nothing outside the picture.

        A press takes something near whose blur covers the pixel; a drag goes on with what the
        pinhole picture has.
        """
        plate, before, lens = self._source.plate, self._aim, self._editing.lens
        pixel = self._source.plate_px(lens, self._editing.shot, pixel)
        if plate is None or not plate.shows(*pixel):
            return
        is_held = before is not None and before.lens == lens and self._editing.is_unsettled
        if is_held and before is not None and before.pixel == pixel:
            return
        with reported(self._say):
            surfaces = surfaces_at(plate, lens, *pixel)
            self._take(plate, pixel, surfaces[-1:] if is_held else surfaces)

    def look_at(self, pixel: tuple[int, int]) -> tuple[Surface, ...]:
        """Return what a click at a pixel of the display window takes, and the other surface there.

        `focus_on_other` then takes that one. Return nothing outside the picture.
        """
        plate, lens = self._source.plate, self._editing.lens
        pixel = self._source.plate_px(lens, self._editing.shot, pixel)
        if plate is None or not (plate.has_distances and plate.shows(*pixel)):
            return ()
        aim = self._aim
        is_same = aim is not None and aim.plate is plate and (aim.pixel, aim.lens) == (pixel, lens)
        if aim is None or not is_same:
            aim = self._aim = Aim(plate, pixel, surfaces_at(plate, lens, *pixel), lens)
        return aim.surfaces

    def names_of(self, surfaces: Sequence[Surface]) -> tuple[str, ...]:
        """Return the names that mattes give to what `look_at` returned; "" until they are known."""
        plate = self._source.plate
        if plate is None:
            return ("",) * len(surfaces)
        with reported(self._say):
            return self._things.names(plate, surfaces)
        return ("",) * len(surfaces)

    def focus_on_other(self) -> None:
        """Focus on the other thing that was seen where the last click was, or under the loupe."""
        aim, plate = self._aim, self._source.plate
        if aim is None or plate is None or len(aim.surfaces) < 2 or aim.lens != self._editing.lens:
            self._say("There is no other surface here, or where you clicked last.")
            return
        with reported(self._say):
            self._take(plate, aim.pixel, aim.surfaces[::-1])

    def _take(self, plate: Plate, pixel: tuple[int, int], surfaces: tuple[Surface, ...]) -> None:
        """Focus on the first of the surfaces that are seen at a pixel, and tell the other."""
        x, y = surfaces[0].x, surfaces[0].y
        self._editing.edit_lens(focused_at_pixel(plate, self._editing.lens, x, y))
        self._aim = Aim(plate, pixel, surfaces, self._editing.lens)
        if len(surfaces) > 1:
            taken, other = (format_distance(surface.depth_m) for surface in surfaces)
            self._say(f"Focus at {taken}. The other surface here is at {other}: Y takes it.")

    def focus(self, distance_m: float) -> None:
        """Focus at a distance in m."""
        self._editing.edit_lens(replace(self._editing.lens, focus_distance_m=distance_m))

    def nudge_focus(self, notches: float) -> None:
        """Focus nearer (positive) or farther by a number of notches of the focus bar."""
        histogram = self._source.picture.histogram
        if histogram is not None:
            self._editing.edit_lens(nudged(self._editing.lens, histogram, notches))

    def focus_at_infinity(self) -> None:
        """Focus at infinity if the plate has distances."""
        if self._source.picture.histogram is not None:
            self._editing.edit_lens(focused_at(self._editing.lens, 0.0))

    def step_f_stop(self, steps: int) -> None:
        """Close the aperture by a number of thirds of a stop; a negative number opens it."""
        lens = self._editing.lens
        self._editing.edit_lens(replace(lens, f_stop=stepped(lens.f_stop, steps)))

    def reset(self) -> None:
        """Reset the lens to that of the plate's header or of the command line."""
        if self.start_lens is not None:
            self._editing.edit_lens(self.start_lens.lens)

    def next_quality(self) -> None:
        """Switch to the next quality tier; the first follows the last."""
        shot = self._editing.shot
        defocus = replace(shot.defocus, quality=_next([None, *Quality], shot.defocus.quality))
        self._editing.edit(replace(shot, defocus=defocus))

    def next_bokeh(self) -> None:
        """Switch to the next shape of the blur; the first follows the last."""
        shot = self._editing.shot
        defocus = replace(shot.defocus, bokeh=_next(list(Bokeh), shot.defocus.bokeh))
        self._editing.edit(replace(shot, defocus=defocus))


def nudged(lens: Lens, histogram: DepthHistogram, notches: float) -> Lens:
    """Return the lens focused nearer (positive) or farther by `notches` of the focus bar."""
    step = notches * _NUDGE * histogram.most_dioptres
    return focused_at(lens, max(1.0 / lens.focus_distance_m + step, 0.0))


def _next(choices: Sequence[Choice], now: Choice) -> Choice:
    return choices[(choices.index(now) + 1) % len(choices)]


_Names = tuple[str, ...]


class ThingsHere:
    """The name of each of the surfaces asked for last, "" until it is known."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._asked: tuple[Plate, tuple[Surface, ...]] | None = None
        self._names: _Names = ()
        self._reader: Background[_Names] = Background(wake)

    def names(self, plate: Plate, surfaces: Sequence[Surface]) -> _Names:
        """Return the names of surfaces, or begin to look for them."""
        place, before = (plate, tuple(surfaces)), self._asked
        if before is None or before[0] is not plate or before[1] != place[1]:
            self._asked, self._names = place, ("",) * len(surfaces)
            self._reader.cancel()
            if has_things(plate):
                self._reader.start(lambda: tuple(_name(plate, it) for it in place[1]))
        self._names = self._reader.poll() or self._names
        return self._names


def _name(plate: Plate, surface: Surface) -> str:
    return (thing_at(plate, surface.x, surface.y) or "").partition(":")[2]
