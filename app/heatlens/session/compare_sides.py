"""A and B of the comparison: B by another method is rendered while it is seen, and only then."""

from dataclasses import replace

from heatlens.model.settings import Method
from heatlens.model.shot import Shot
from heatlens.model.view import Against, Compare, ViewState
from heatlens.preview.shown import Shown
from heatlens.render import FrameRenderer
from heatlens.session.live_picture import FIRST_PLATE, LivePicture, PlateVersion

_LEAST = 0.25  # of the time for a picture, for B, however much A took


class CompareSides:
    """Renders A, the picture through the lens, and B, the same shot by another method.

    Passes share scratch memory, so that one picture is finished before the other goes on; what was
    half done when the other came between begins anew.
    """

    def __init__(self, renderer: FrameRenderer) -> None:
        self._renderer = renderer
        self.a = LivePicture(renderer)
        self.b = LivePicture(renderer, first_slot=2, cost=self.a.cost)
        self._b_wish: Shot | None = None  # B's, while it is rendered
        self._is_turn_of_b = False

    @property
    def pictures(self) -> tuple[Shown | None, Shown | None]:
        """The finished pictures of A and B; each finished picture is another object."""
        return self.a.shown, self.b.shown

    @property
    def plate(self) -> int | None:
        """The number of the plate that A was last asked for; None: nothing was asked for."""
        return self.a.wished_plate

    @property
    def rendered(self) -> tuple[LivePicture, ...]:
        """The sides that are rendered: A, and B while it is seen as another method."""
        return (self.a,) if self._b_wish is None else (self.a, self.b)

    @property
    def turn(self) -> int:
        """The index in `rendered` of the side whose turn it is."""
        return 1 if self._is_turn_of_b and self._b_wish is not None else 0

    def restart(self) -> None:
        """Begin anew: another plate lies on the GPU."""
        self.a.restart()
        self.b.restart()

    def wish(
        self,
        view: ViewState,
        shot: Shot,
        frame: int,
        budget_s: float,
        plate: PlateVersion = FIRST_PLATE,
    ) -> None:
        """Show `shot` at `frame` as `view` compares it: A first, B in what is left of the time."""
        other = self._b_of(view, shot)
        self._b_wish = None if other == shot else other
        spent_s = 0.0
        if self.a.wish(shot, frame, budget_s, plate):
            self.b.pause()
            self._is_turn_of_b = False
            spent_s = 0.0 if self.a.shown is None else self.a.shown.seconds
        if self._b_wish is None:
            return
        left_s = max(budget_s - spent_s, _LEAST * budget_s)
        if self.b.wish(self._b_wish, frame, left_s, plate):
            self.a.pause()

    def _b_of(self, view: ViewState, shot: Shot) -> Shot | None:
        """Return the shot that B shows; None where B is no picture through a lens."""
        if is_look_b(view):
            look = next((look for look in shot.looks if look.name == view.b_look), None)
            return None if look is None else shot.through(look)
        method = method_of_b(view, self._renderer.has_many_views)
        return (
            None if method is None else replace(shot, defocus=replace(shot.defocus, method=method))
        )

    def work(self, side: int, slice_s: float, is_plate_whole: bool = True) -> None:
        """Go on with the picture of a side; once it is finished, it is the other's turn."""
        live = self.rendered[side]
        before = live.shown
        live.work(slice_s, is_plate_whole)
        if live.shown is not before:
            self._is_turn_of_b = live is self.a

    def of_method(self, view: ViewState) -> Shown | None:
        """Return B's picture where B is a method or a look, once it is there; else None."""
        if is_look_b(view):
            side = self.a if self._b_wish is None else self.b
            return side.shown
        method = method_of_b(view, self._renderer.has_many_views)
        for side in (self.a, self.b):
            if side.shown is not None and side.shown.shot.defocus.method is method:
                return side.shown
        return None


def is_look_b(view: ViewState) -> bool:
    """Return True where B is seen, and is the frame through a look."""
    return view.compare is not Compare.OFF and view.against is Against.LOOK


def method_of_b(view: ViewState, has_many_views: bool) -> Method | None:
    """Return how B is rendered; None where it is not seen, or needs a scene that is not open."""
    if view.compare is Compare.OFF or view.against is not Against.METHOD:
        return None
    return view.b_method if has_many_views or not view.b_method.needs_scene else None
