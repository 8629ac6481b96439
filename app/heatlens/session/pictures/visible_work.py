"""The state of the visible pictures: the plate on the GPU and the sides rendered from it."""

from heatlens.session.opened.open_source import OpenSource
from heatlens.session.pictures.compare_sides import CompareSides, Side
from heatlens.session.pictures.next_work import PlateState, SideState, is_rendering


class VisibleWork:
    """Determines the work that is left for the visible pictures."""

    def __init__(self, source: OpenSource, sides: CompareSides) -> None:
        self._source = source
        self._sides = sides

    @property
    def is_rendering(self) -> bool:
        """True while a visible picture is not complete."""
        return is_rendering(self.plate, self.sides)

    @property
    def plate(self) -> PlateState:
        """The state of the picture before the lens."""
        source = self._source
        is_asked = source.plate is None or self._sides.a.requested_plate == source.picture.version
        return PlateState(
            is_there=source.plate is not None,
            is_good=source.feed.is_good,
            is_whole=source.feed.is_whole,
            is_asked=is_asked,
            wait_s=source.feed.seconds_until_needed(),
        )

    @property
    def sides(self) -> tuple[SideState, ...]:
        """The states of the pictures through the lens."""
        return tuple(self._state_of(side) for side in self._sides.rendered)

    def _state_of(self, side: Side) -> SideState:
        has_work = side.wants_work(self._source.feed.is_whole)
        wait_s = side.seconds_to_rest()
        return SideState(not side.is_working, has_work, wait_s, side.is_answering)
