"""The interactive picture: quick while something is dragged, complete when the input rests.

If the whole picture fits the time of a frame, it is rendered at once. Otherwise a quicker preview
of the same lens is shown (smaller, with simpler discs), and the whole picture is rendered in
slices, so that the window stays responsive. The picture of a scene is refined with more and more
points of the lens. If the first answer to a change takes too long, it continues in slices too.
What needs a program that the driver has not built yet waits until another process has built it.
"""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from typing import NamedTuple

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.known_programs import NewProgramError
from heatlens.render.gpu.program import programs_built
from heatlens.render.gpu.resources import Texture
from heatlens.render.preview.cost_model import CostModel
from heatlens.render.preview.level_choice import needs_few_programs
from heatlens.render.preview.shown import PictureKey, ShownPicture, whole_picture, without_notes
from heatlens.studio.session.pictures.elsewhere import ProcessBuilder, RemoteRenderer
from heatlens.studio.session.pictures.picture_levels import PictureLevels

_REST_S = 0.08  # without a change for this long, the input rests; a drag sends several changes


class PlateVersion(NamedTuple):
    """Identifies the plate that is on the GPU."""

    number: int  # differs for each plate
    is_finer: bool = False  # True for the previous plate with less noise


FIRST_PLATE = PlateVersion(0)


@dataclass
class _Work:
    """A picture that is being rendered in steps."""

    steps: Steps[Texture]
    key: PictureKey  # identifies the request that started it
    settings: DefocusSettings
    slot: int
    views_before: int  # points of the lens that an earlier picture already has
    is_local: bool  # this machine renders it
    programs_before: int  # programs that this process had built when it started
    seconds: float = 0.0


class LivePicture:
    """Renders the requested shot as well as the time allows."""

    def __init__(
        self,
        renderer: FrameRenderer,
        clock: Callable[[], float] = time.perf_counter,
        first_slot: int = 0,
        cost: CostModel | None = None,
        remote: RemoteRenderer | None = None,
        builder: ProcessBuilder | None = None,
    ) -> None:
        """Use slot `first_slot` of the renderer and the next one for the pictures.

        `cost` is the cost model of this machine, shared with other pictures. `remote` renders whole
        pictures in place of this machine. `builder` builds programs in place of this process.
        """
        self._renderer = renderer
        self._clock = clock
        self.cost = cost or CostModel()
        self.remote, self.builder = remote or RemoteRenderer(), builder or ProcessBuilder()
        self.levels = PictureLevels(renderer, self.cost, self.builder)
        self.output: ShownPicture | None = None
        self._request: PictureKey | None = None
        self._changed_at = 0.0
        self._work: _Work | None = None
        self._slots = first_slot, first_slot + 1  # keys of the shown and the coming picture
        self._budget_s = 0.0
        self._is_refused = False  # the request cannot be rendered, and that was reported
        self.is_answering = False  # the request has no picture yet, not even a quick one
        self.request_s = 0.0  # seconds spent in `request` so far
        self.begun_count = 0  # pictures that were begun so far

    @property
    def device(self) -> Device:
        """What the pictures are rendered on."""
        return self._renderer.ctx

    @property
    def spare_slot(self) -> int:
        """The slot of the renderer that holds no shown picture."""
        return self._slots[1]

    def restart(self) -> None:
        """Drop the work, the request and the picture, because another plate is on the GPU."""
        self.drop_work()
        self._request = self.output = None
        self.is_answering = False

    def drop_work(self) -> None:
        """Drop the picture in progress, because another picture uses the renderer now."""
        self._work = None
        self.remote.cancel()

    # An unfinished answer is finished before the next change is answered. If each change started
    # again, a continuous drag would show no picture at all on a machine whose answers take longer
    # than the time between two changes, which is every machine while its driver builds programs.
    def request(
        self,
        shot: Shot,
        frame: int,
        budget_s: float,
        plate: PlateVersion = FIRST_PLATE,
        within_s: float = math.inf,
    ) -> bool:
        """Show `shot` at `frame`; a change is answered at once with what fits `budget_s`.

        An answer that takes longer than `within_s` goes on in `work`. It is finished before the
        answer to the next change begins, so that a continuous drag shows pictures too.

        If the plate has only become less noisy, its picture stays until the whole new one is
        finished. Return True if anything was rendered. A request that raised is not tried again.
        """
        request = whole_picture(shot, frame, plate.number)
        if request == self._request and self.is_unanswered:
            return self._answer_now(within_s)
        if request == self._request or self._adopt_if_unchanged(request, plate.is_finer):
            return False
        last_request, self._changed_at, self._budget_s = self._request, self._clock(), budget_s
        is_same_plate = self.requested_plate == request.plate
        refinable = self._refinable_picture(shot, frame) if is_same_plate else None
        if last_request is None or last_request.settings != request.settings:
            self.levels.moving = None
        if self.is_answering and not is_same_plate:
            within_s = math.inf  # otherwise a constantly changing plate would never appear
        if refinable is not None or not self.is_answering or within_s == math.inf:
            self.drop_work()
        self._request, self._is_refused, self.is_answering = request, False, refinable is None
        if refinable is not None:
            self.output = refinable
            return False
        return self._answer_now(within_s)

    def _adopt_if_unchanged(self, request: PictureKey, is_finer: bool) -> bool:
        """Adopt a request and return True if it needs no new picture at once.

        That is the case if only marks or looks differ, or if the plate is only less noisy
        (`is_finer`).
        """
        last_request = self._request
        if last_request is None:
            return False
        if _key_without_notes(request) == _key_without_notes(last_request):
            self._update_notes(request)
            return True
        is_same_but_plate = replace(request, plate=last_request.plate) == last_request
        if is_same_but_plate and is_finer and self.output is not None and not self.is_answering:
            self.drop_work()
            self._request = request
            return True
        return False

    def _answer_now(self, within_s: float) -> bool:
        """Answer the request within a frame; return True."""
        start = self._clock()
        self._answer(within_s)
        self.request_s += self._clock() - start
        return True

    def _answer(self, slice_s: float) -> None:
        """Continue the answer in progress, or begin the answer to the request."""
        with self._raise_once():
            if self._work is None:
                assert self._request is not None
                levels, shown_settings = self.levels, self._shown_settings
                levels.moving = levels.while_moving(self._request, shown_settings, self._budget_s)
                self._start(levels.moving)
            self._advance(slice_s)

    def _update_notes(self, request: PictureKey) -> None:
        """Adopt a request for the same picture, of a shot with other marks or looks."""
        if self.output is not None and self._is_of_request(self.output):
            self.output = replace(self.output, shot=request.shot)
        self._request = request

    def _refinable_picture(self, shot: Shot, frame: int) -> ShownPicture | None:
        """Return the shown picture if it only lacks further points of the lens.

        More points refine it, so that no coarser preview is needed first.
        """
        output, settings = self.output, shot.defocus
        if output is None or output.frame != frame or not settings.method.needs_scene:
            return None
        is_same = output.shot == replace(
            shot, defocus=replace(settings, views=output.shot.defocus.views)
        )
        has_fewer_views = output.settings.views <= settings.views
        return replace(output, shot=shot) if is_same and has_fewer_views else None

    @contextmanager
    def _raise_once(self) -> Iterator[None]:
        """Raise the error of a shot that cannot be rendered, once, and do not try again."""
        try:
            yield
        except HeatlensError:
            self.drop_work()
            self._is_refused, self.is_answering = True, False
            raise

    @property
    def is_unanswered(self) -> bool:
        """True if the answer to the latest change has still to be begun."""
        return self.is_answering and self._work is None

    @property
    def is_working(self) -> bool:
        """True while the whole picture is not finished."""
        if self._request is None or self._is_refused:
            return False
        return self.output is None or self.output.picture_key != self._request

    # The line under the picture shows the time spent as a share of the time that such pictures have
    # taken so far, so that the user of a slow machine knows that a better picture is coming.
    @property
    def rendered_share(self) -> float | None:
        """The finished share of the whole picture, judged by its time; None once it is complete."""
        if not self.is_working:
            return None
        work = self._work
        if work is None or work.settings != work.key.settings or not self.cost.seconds_per_px:
            return 0.0
        return min(work.seconds / max(self.levels.predict_s(work.settings), 1e-6), 1.0)

    @property
    def requested_plate(self) -> int | None:
        """The number of the plate of the requested picture; None without a request."""
        return None if self._request is None else self._request.plate

    def begin_rest(self) -> None:
        """Count the rest from now: the answer to the latest change is on the screen."""
        self._changed_at = self._clock()

    def seconds_to_rest(self) -> float:
        """Return the seconds until the whole picture may be started; 0 if it may start now."""
        return 0.0 if self.is_answering else max(0.0, self._changed_at + _REST_S - self._clock())

    def has_work(self, is_plate_whole: bool = True) -> bool:
        """Return True if there is a picture to continue.

        The whole picture is started only if the plate has its final quality.
        """
        if not self.is_working or self.remote.is_waiting:
            return False
        is_begun = self.is_answering or self._work is not None
        return is_begun or self._next_level(is_plate_whole) is not None

    def work(self, slice_s: float, is_plate_whole: bool = True) -> None:
        """Continue with the answer, or if the input rests with a better picture, for a slice."""
        if not self.has_work(is_plate_whole) or self.seconds_to_rest() > 0:
            return
        if self.is_answering:
            self._answer(slice_s)
            return
        with self._raise_once():
            if self._work is None:
                level = self._next_level(is_plate_whole)
                assert level is not None
                self._start(level)
            self._advance(slice_s)

    def _is_of_request(self, picture: ShownPicture) -> bool:
        """Return True for a picture of the requested shot and plate at any quality."""
        key, request = picture.picture_key, self._request
        return request is not None and replace(key, settings=request.settings) == request

    def _next_level(self, is_plate_whole: bool) -> DefocusSettings | None:
        """Return what to render at rest; None if there is nothing better."""
        assert self._request is not None
        return self.levels.at_rest(
            self._request, self._shown_settings, self._budget_s, is_plate_whole
        )

    @property
    def _shown_settings(self) -> DefocusSettings | None:
        """The settings of the shown picture; None before the first."""
        return None if self.output is None else self.output.settings

    def _start(self, settings: DefocusSettings) -> None:
        """Begin the picture of the request with these settings, on another machine if possible."""
        assert self._request is not None
        shot, slot = replace(self._request.shot, defocus=settings), self._slots[1]
        arguments, is_whole = (shot, self._request.frame, slot), settings == self._request.settings
        remote_steps = self.remote.steps(*arguments) if is_whole and not self.is_answering else None
        steps = remote_steps or self._renderer.steps(*arguments, enlarges=not is_whole)
        views = self._views_before(settings)
        program_count = programs_built()
        self.begun_count += 1
        self._work = _Work(
            steps, self._request, settings, slot, views, remote_steps is None, program_count
        )

    def _views_before(self, settings: DefocusSettings) -> int:
        """Return how many points of the lens the renderer continues from; 0: it starts again."""
        output = self.output
        if output is None or not self._is_of_request(output) or not settings.method.needs_scene:
            return 0
        is_refinement = replace(settings, views=output.settings.views) == output.settings
        return (
            output.settings.views if is_refinement and output.settings.views < settings.views else 0
        )

    def _advance(self, slice_s: float) -> None:
        """Render in steps until the time is over; a finished picture becomes the output."""
        assert self._work is not None
        work, start = self._work, self._clock()
        is_first = needs_few_programs(
            work.settings, work.key.settings, self._renderer.loaded.color.size
        )
        try:
            with nullcontext() if is_first else self.builder.refuse_new(work.key.shot):
                while self._clock() - start < slice_s and not self.remote.is_waiting:
                    next(work.steps)
            work.seconds += self._clock() - start
        except NewProgramError:
            self._work = None
            self.levels.note_refused(work.settings)
            self.builder.request(work.key.shot, work.key.frame)
        except StopIteration as end:
            self._renderer.ctx.finish()
            work.seconds += self._clock() - start
            self._learn_cost(work)
            self._finish(work, end.value)

    # The cost model learns the time of a picture, and whether programs were built meanwhile. The
    # first picture of a kind contains seconds of a driver's builds: if the model kept them, the
    # window of an NVIDIA H200 would show a third of the size although the whole picture takes 5 ms.
    # A gathered picture in place of another method says nothing about that method, nor does a
    # picture that another machine has rendered.
    def _learn_cost(self, work: _Work) -> None:
        """Learn the time of a picture that is finished."""
        rendered = replace(work.settings, views=work.settings.views - work.views_before)
        is_same_method = rendered.method is work.key.settings.method
        if work.is_local and (is_same_method or rendered.method is not Method.GATHER):
            has_built = programs_built() > work.programs_before
            self.cost.learn(rendered, self.levels.pixel_count(rendered), work.seconds, has_built)

    def _finish(self, work: _Work, texture: Texture) -> None:
        """Show the picture of `work`."""
        assert self._request is not None
        is_latest = _key_without_notes(work.key) == _key_without_notes(self._request)
        key = self._request if is_latest else work.key
        diffused = self._renderer.light_without_highlights(work.slot)
        shown = key.shot, key.frame, work.settings, work.seconds, key.plate, diffused
        self.output = ShownPicture(texture, *shown)
        self._slots, self._work = self._slots[::-1], None
        self.levels.note_rendered(work.settings)
        self.is_answering = self.is_answering and not is_latest


def _key_without_notes(key: PictureKey) -> PictureKey:
    """Return the key of the same picture without the marks and looks of its shot."""
    return replace(key, shot=without_notes(key.shot))
