"""The pictures that are rendered for a comparison: A, and B or several looks while visible."""

import math
from collections.abc import Mapping
from dataclasses import replace
from math import ceil, log2

from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.compared_looks import is_look_b, is_shot_b, method_of_b, visible_looks
from heatlens.core.model.view.view import Compare, ViewState
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.context import is_software
from heatlens.render.preview.cost_model import GPU_WORK_POWER, CostModel
from heatlens.render.preview.shown import ShownPicture, without_notes
from heatlens.studio.session.pictures.elsewhere import ProcessBuilder, RemoteRenderer
from heatlens.studio.session.pictures.live_picture import FIRST_PLATE, LivePicture, PlateVersion
from heatlens.studio.session.pictures.look_pictures import LookPictures
from heatlens.studio.session.pictures.rehearsal import Rehearsal

_MIN_B_SHARE = 0.25  # share of the time budget that B gets, however long A took
_MIN_SCALE = 0.25  # the smallest scale at which pictures of the grid are rendered


Side = LivePicture | LookPictures  # pictures that are rendered in short time slices


class CompareSides:
    """Renders A, the picture through the lens, and the pictures that it is compared with.

    That is B, the same shot by another method or through a look, or several looks. Passes share
    scratch memory, so one picture is finished before the other continues; an unfinished picture
    starts again if the other interrupts it.
    """

    def __init__(
        self,
        renderer: FrameRenderer,
        remote: RemoteRenderer | None = None,
        builder: ProcessBuilder | None = None,
    ) -> None:
        """Render on this machine; `remote` may render the whole picture of A instead.

        `builder` may build programs in place of this process.
        """
        self._renderer = renderer
        # A small picture does not fill a GPU, so times grow more slowly than the number of pixels.
        # A linear model would choose smaller levels than the GPU can render; see `GPU_WORK_POWER`.
        power = 1.0 if is_software(renderer.ctx) else GPU_WORK_POWER
        self.a = LivePicture(
            renderer, cost=CostModel(work_power=power), remote=remote, builder=builder
        )
        self.rehearsal = Rehearsal(renderer, self.a)
        self.b = LivePicture(renderer, first_slot=2, cost=self.a.cost, builder=builder)
        self.looks = LookPictures(renderer, self.b)
        self.other_shot: Shot | None = None  # what B shows where it is another shot
        self._b_request: Shot | None = None  # the shot of B, while it is rendered
        self._has_looks = False  # several looks are rendered
        self._is_turn_of_b = False
        self._same_as_a: frozenset[str] = frozenset()  # names of the looks that A shows

    @property
    def outputs(self) -> tuple[object, ...]:
        """The finished pictures of both sides; each finished picture is a new object."""
        return self.a.output, self.b.output, self.looks.output

    @property
    def active_sides(self) -> tuple[Side, ...]:
        """The sides that are rendered: A, and B or the looks while they are visible."""
        if self._has_looks:
            return self.a, self.looks
        return (self.a,) if self._b_request is None else (self.a, self.b)

    @property
    def turn_index(self) -> int:
        """The index in `rendered` of the side whose turn it is."""
        return 1 if self._is_turn_of_b and len(self.active_sides) > 1 else 0

    def restart(self) -> None:
        """Start again, because another plate is on the GPU."""
        self.a.restart()
        self.looks.restart()

    # Counted from the change, the rest was over when a slow frame was drawn: between two changes of
    # a drag a piece of a better picture was rendered, up to 0.17 s long, and thrown away.
    def begin_rest(self) -> None:
        """Count the rest of both sides from now: their answers are on the screen."""
        self.a.begin_rest()
        self.b.begin_rest()

    def request(
        self,
        view: ViewState,
        shot: Shot,
        frame: int,
        budget_s: float,
        plate: PlateVersion = FIRST_PLATE,
        zoom: float = 1.0,
        within_s: float = math.inf,
    ) -> None:
        """Show `shot` at `frame` as `view` compares it: A first, then B in the remaining time.

        A picture that takes longer than `within_s` continues in `work`, and B waits for A. `zoom`,
        in screen pixels per picture pixel, decides how large a grid is rendered.
        """
        looks, current_shot = visible_looks(view, shot), without_notes(shot)
        same_names = (
            look.name for look in looks if without_notes(shot.with_look(look)) == current_shot
        )
        self._same_as_a = frozenset(same_names)
        requests = {
            look.name: _shot_through(shot, look, view, zoom)
            for look in looks
            if look.name not in self._same_as_a
        }
        b_shot = self._shot_of_b(view, shot)
        self._b_request = None if b_shot == shot else b_shot
        self._has_looks, spent_s = bool(requests), 0.0
        if self.a.request(shot, frame, budget_s, plate, within_s):
            self.b.drop_work()
            self._is_turn_of_b = False
            spent_s = 0.0 if self.a.output is None else self.a.output.seconds
        if self.a.is_answering:
            return
        remaining_s = max(budget_s - spent_s, _MIN_B_SHARE * budget_s)
        if self._request_b_side(requests, frame, remaining_s, plate, within_s):
            self.a.drop_work()

    def _request_b_side(
        self,
        looks: Mapping[str, Shot],
        frame: int,
        budget_s: float,
        plate: PlateVersion,
        within_s: float,
    ) -> bool:
        """Request the pictures beside A. Return True if anything was rendered."""
        has_rendered = self.looks.request(looks, frame, budget_s, plate)
        if self._b_request is not None:
            has_rendered = self.b.request(self._b_request, frame, budget_s, plate, within_s)
        return has_rendered

    def _shot_of_b(self, view: ViewState, shot: Shot) -> Shot | None:
        """Return the shot with the method of B, or the lens of another shot; else None."""
        if is_shot_b(view) and self.other_shot is not None:
            return _with_lens_of(shot, self.other_shot)
        method = method_of_b(view, self._renderer.has_many_views)
        return (
            None if method is None else replace(shot, defocus=replace(shot.defocus, method=method))
        )

    def work(self, side: int, slice_s: float, is_plate_whole: bool = True) -> None:
        """Continue the picture of a side; once it is finished, it is the other side's turn."""
        side_picture = self.active_sides[side]
        old_output = side_picture.output
        side_picture.work(slice_s, is_plate_whole)
        if side_picture.output != old_output:
            self._is_turn_of_b = side_picture is self.a

    def picture_of_b(self, view: ViewState) -> ShownPicture | None:
        """Return the picture of B if B is rendered: a method, a look, a shot; None otherwise."""
        if is_look_b(view):
            return self.picture_of_look(view.b_look)
        if is_shot_b(view):
            return self.a.output if self._b_request is None else self._picture_of_other_shot()
        method = method_of_b(view, self._renderer.has_many_views)
        for side in (self.a, self.b):
            if side.output is not None and side.output.shot.defocus.method is method:
                return side.output
        return None

    def _picture_of_other_shot(self) -> ShownPicture | None:
        """Return the latest picture of the other shot; None before there is one."""
        picture, other = self.b.output, self.other_shot
        if picture is None or other is None:
            return None
        is_of_other = _with_lens_of(picture.shot, other) == picture.shot
        return picture if is_of_other else None

    def picture_of_a(self, view: ViewState) -> ShownPicture | None:
        """Return the picture of A if A is a look and it is rendered; None otherwise."""
        return self.picture_of_look(view.a_look) if is_look_b(view) and view.a_look else None

    def picture_of_look(self, name: str) -> ShownPicture | None:
        """Return the latest picture of a visible look; None before there is one."""
        return self.a.output if name in self._same_as_a else self.looks.picture_of(name)

    def is_unfinished(self, name: str) -> bool:
        """Return True while the whole picture of a look is not finished."""
        return name not in self._same_as_a and self.looks.is_unfinished(name)


def _with_lens_of(shot: Shot, other: Shot) -> Shot:
    """Return the shot with the lens, the keys and the blur of another one."""
    return replace(
        shot, lens=other.lens, curves=other.curves, defocus=other.defocus, marks=other.marks
    )


def _shot_through(shot: Shot, look: Look, view: ViewState, zoom: float) -> Shot:
    """Return the shot with a look applied; in the grid, scaled to the size on the screen."""
    look_shot = without_notes(shot.with_look(look))
    if view.compare is not Compare.GRID or shot.defocus.method.needs_scene:
        return look_shot
    scale = min(max(2.0 ** ceil(log2(max(zoom, _MIN_SCALE))), _MIN_SCALE), 1.0)
    proxy = min(shot.defocus.proxy, scale)
    return replace(look_shot, defocus=replace(look_shot.defocus, proxy=proxy))
