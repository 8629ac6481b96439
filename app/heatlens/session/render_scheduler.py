"""Who works on the picture for the next moment: the scene is drawn first, then it is blurred."""

from heatlens.model.shot import Shot
from heatlens.model.view import ViewState
from heatlens.session.compare_sides import CompareSides
from heatlens.session.live_picture import PlateVersion
from heatlens.session.open_source import OpenSource

# Work on the whole picture ends so soon, after the step that it is at, for the loop to look for
# input again: every 30 ms with steps of up to 18 ms.
_SLICE_S = 0.012


class RenderScheduler:
    """The plate of the source becomes the pictures of both sides."""

    def __init__(self, source: OpenSource, sides: CompareSides) -> None:
        self._source = source
        self._sides = sides
        self._wished = 0  # version of the plate that the sides know

    @property
    def version(self) -> tuple[int, int]:
        """Another one whenever there is something new to be seen."""
        return self._source.version, self._sides.version

    @property
    def is_working(self) -> bool:
        """The whole picture is not there yet."""
        is_known = self._source.plate is None or self._source.version == self._wished
        return self._sides.is_working or not (self._source.is_whole and is_known)

    def wish(self, view: ViewState, shot: Shot, frame: int, budget_s: float) -> None:
        """Answer a change with a picture that fits the time. Raises HeatlensError."""
        source = self._source
        source.refresh()  # only now: what was saved before is picture and plate of one frame
        source.follow(shot, frame)
        if source.plate is not None and source.is_settled_at(frame):
            plate = PlateVersion(source.version, source.is_finer)
            self._wished = source.version
            self._sides.wish(view, source.seen(shot), frame, budget_s, plate)

    def work(self) -> None:
        """Go on with the whole picture for a moment. Raises HeatlensError."""
        if self._is_blurring:
            self._sides.work(_SLICE_S, self._source.is_whole)
        else:
            self._source.refine(_SLICE_S)

    @property
    def _is_blurring(self) -> bool:
        source = self._source
        has_plate = source.plate is not None and source.is_good
        return has_plate and self._sides.wants_work(source.is_whole)

    def seconds_until_needed(self) -> float | None:
        """How long the loop may sleep; None: until something changes."""
        if self._is_blurring:
            return self._sides.seconds_to_rest()
        return self._source.seconds_until_needed()
