"""Edits of the open shot: all go through `Editing`, so that all can be undone."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.base.messages import Problem, passing_message, report_errors
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.history import History
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import LensCurves, Shot

_TRIAL_MESSAGE = "Only a trial at this frame, because auto key is off. Set key keeps it."
_ALL_FRAMES_MESSAGE = "The focus is the same at all frames. After Set key, each change sets a key."
_KEY_MESSAGE = "A key of the focus was set at frame {}: auto key is on."
_GESTURE_REST_S = 0.4  # notches of the wheel and repeated keys closer than this are one gesture


@dataclass
class Performance:
    """The focus while a pull is recorded by hand; its keys are set at the end of the recording.

    focus_distance_m  None until the user moves the focus; until then the keys give the focus
    is_over           the recording has ended but the gesture has not: its changes are ignored
    moved_at          time of the clock at the latest movement
    """

    focus_distance_m: float | None = None
    is_over: bool = False
    moved_at: float = 0.0


class Editing:
    """The undo history of the shot, and the frame that is edited."""

    def __init__(
        self,
        shot: Shot,
        notify: Callable[[str], None],
        is_sequence: Callable[[], bool] = lambda: False,
        other_holder: Callable[[], str] = lambda: "",
        reframe: Callable[[Shot, Shot], Shot] = lambda _, after: after,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Begin with `shot`; `is_sequence` returns True if the source has several frames.

        `other_holder` takes the lens for the user, and returns the name of another user who has it;
        "" if nobody else has. `reframe` returns the shot to have after a change of the lens, from
        the shots before and after it.
        """
        self._is_sequence = is_sequence
        self.history = History.of(shot)
        self.auto_key = True
        self._frame = 0
        self._trial_lens: Lens | None = None  # the lens changed at this frame only, without a key
        # The lens that the keys of a shot give at a frame; drawing the window asks for it often.
        self._keyed_cache: tuple[Shot, int, Lens] | None = None
        self.performance: Performance | None = None  # set while a pull is recorded
        self._has_explained = False  # see `_explain_change`
        self._notify = notify
        self.clock = clock
        self._changed_at = 0.0
        self._other_holder, self._reframe = other_holder, reframe

    @property
    def frame(self) -> int:
        """The edited frame. Setting another one drops lens values that were only tried."""
        return self._frame

    @frame.setter
    def frame(self, frame: int) -> None:
        """Move to a frame; values that were only tried at another one are dropped."""
        if frame != self._frame:
            self._trial_lens = None
        self._frame = frame

    @property
    def shot(self) -> Shot:
        """The current shot."""
        return self.history.current

    @property
    def seen_shot(self) -> Shot:
        """The shot as it is drawn at the frame, with lens values that are only tried there."""
        if self._trial_lens is None and self.performance is None:
            return self.shot
        return replace(self.shot, lens=self.lens, curves=LensCurves())

    @property
    def trial_parameters(self) -> frozenset[LensParameter]:
        """Trial values: the parameter has keys, but none at this frame, and auto key is off."""
        if self._trial_lens is None:
            return frozenset()
        keyed_lens = self._keyed_lens
        return frozenset(
            parameter
            for parameter in LensParameter
            if getattr(self._trial_lens, parameter) != getattr(keyed_lens, parameter)
        )

    @property
    def lens(self) -> Lens:
        """The lens at the frame, with values that are only tried or performed there.

        If the keys give an impossible lens, report that and return the lens without keys.
        """
        lens = self._keyed_lens if self._trial_lens is None else self._trial_lens
        performed_m = None if self.performance is None else self.performance.focus_distance_m
        if performed_m is None:
            return lens
        try:
            return replace(lens, focus_distance_m=performed_m)
        except LensError:  # for example, a keyed zoom has become too long for a near focus
            return lens

    # The lens is kept because each frame of the window needs it 16 times. Together with the other
    # values that a drawn frame needs more than once, keeping it saves 13 % of the processor time of
    # a frame in which nothing changes.
    @property
    def _keyed_lens(self) -> Lens:
        """The lens that the keys give at the frame; without keys if it is impossible."""
        shot, frame = self.shot, self.frame
        cached = self._keyed_cache
        if cached is None or cached[0] is not shot or cached[1] != frame:
            try:
                cached = self._keyed_cache = shot, frame, shot.lens_at(frame)
            except LensError as error:
                self._notify(Problem(error))
                return shot.lens
        return cached[2]

    @property
    def has_lens(self) -> bool:
        """True if the keys give a valid lens at the frame."""
        try:
            self.shot.lens_at(self.frame)
        except LensError:
            return False
        return True

    def begin(self, shot: Shot) -> None:
        """Open another shot with an empty undo history, and drop tried values."""
        self.history, self._trial_lens, self._has_explained = History.of(shot), None, False

    def edit(self, shot: Shot) -> None:
        """Change the shot; the undo step is recorded when the gesture ends."""
        if shot != self.history.current:
            self.history = self.history.with_current(shot)
            self._changed_at = self.clock()

    def edit_lens(self, lens: Lens) -> None:
        """Change the lens at the frame and key the keyed parameters there. Report refused changes.

        Without auto key, a keyed parameter without a key at this frame is only tried: the change
        lasts until the frame changes.
        """
        old_lens = self.lens
        if lens == old_lens:
            return
        if holder := self._other_holder():
            self._notify(f"{holder} moves the lens: wait a moment.")
            return
        with report_errors(self._notify):
            self._check_focus_by_hand(old_lens, lens)
            lens = self._within_kit(old_lens, lens)
            if self.performance is not None:
                lens = self._record_performance(lens, old_lens)
            lens_without_trial = self._without_trial(lens)
            if lens_without_trial != self._keyed_lens:
                self.edit(self._reframe(self.shot, self._with_lens(lens_without_trial)))
            self._trial_lens = None if lens_without_trial == lens else lens
            self._explain_change(old_lens, lens)

    def choose_lens(self, lens: Lens) -> None:
        """Change the lens as `edit_lens` does; this is an undo step of its own."""
        self.settle()
        self.edit_lens(lens)
        self.settle()

    def _check_focus_by_hand(self, old_lens: Lens, lens: Lens) -> None:
        """Raise InputError for a focus by hand while it follows a mark."""
        live = self.shot.curves.live
        if live is not None and lens.focus_distance_m != old_lens.focus_distance_m:
            raise InputError(
                f"The focus follows {live.words}: make keys of it or stop following, in the Marks "
                "tab, to change it by hand."
            )

    def _within_kit(self, old_lens: Lens, requested: Lens) -> Lens:
        """Return the lens within the limits of the shot's kit, and report where they apply."""
        kit = self.shot.kit
        allowed = requested if kit is None else kit.limit_change(old_lens, requested)
        names = ("focal_length_mm", "f_stop", "focus_distance_m")
        changed = [it for it in names if getattr(allowed, it) != getattr(requested, it)]
        if kit is not None and changed:
            self._notify(kit.refusal_message(requested))
        return allowed

    def _record_performance(self, lens: Lens, old_lens: Lens) -> Lens:
        """Record the focus in the performance. Return the lens with the focus unchanged."""
        assert self.performance is not None
        if lens.focus_distance_m != old_lens.focus_distance_m:
            self.performance.moved_at = self.clock()
            if not self.performance.is_over:
                self.performance.focus_distance_m = lens.focus_distance_m
        current_lens = self._keyed_lens if self._trial_lens is None else self._trial_lens
        return replace(lens, focus_distance_m=current_lens.focus_distance_m)

    def _without_trial(self, lens: Lens) -> Lens:
        """Return the lens with the keyed values in place of those that are only tried here."""
        if self.auto_key:
            return lens
        keyed_lens, curves = self._keyed_lens, self.shot.curves
        trial_parameters = (
            parameter
            for parameter in LensParameter
            if curves.of(parameter).keys and curves.of(parameter).key_at(self.frame) is None
        )
        return replace(lens, **{str(it): getattr(keyed_lens, it) for it in trial_parameters})

    def _explain_change(self, old_lens: Lens, new_lens: Lens) -> None:
        """Explain, once per shot of several frames, what a change of the focus does."""
        if self._trial_lens is not None:
            self._notify(passing_message(_TRIAL_MESSAGE, lambda: bool(self.trial_parameters)))
        elif not self._has_explained and self.has_time and self.performance is None:
            if old_lens.focus_distance_m != new_lens.focus_distance_m:
                self._has_explained = True
                has_keys = self.shot.curves.focus_distance_m.keys
                has_none = lambda: not self.shot.curves.focus_distance_m.keys  # noqa: E731
                all_frames_message = passing_message(_ALL_FRAMES_MESSAGE, has_none)
                self._notify(_KEY_MESSAGE.format(self.frame) if has_keys else all_frames_message)

    @property
    def has_time(self) -> bool:
        """True if there are several frames, or keys."""
        return self._is_sequence() or bool(self.shot.key_frames or self.shot.camera_key_frames)

    def key_trial_values(self) -> None:
        """Set keys for the values that are only tried at the frame."""
        trial_parameters, lens = self.trial_parameters, self._trial_lens
        self._trial_lens = None
        shot = self.shot
        for parameter in trial_parameters:
            shot = shot.with_key(self.frame, parameter, getattr(lens, parameter))
        if shot != self.shot:
            self.edit(shot)

    def _with_lens(self, lens: Lens) -> Shot:
        """Return the shot with this lens at the frame.

        Parameters without keys are all set at once, because some values are valid only together,
        such as a long lens and a far focus.
        """
        old_lens, shot = self._keyed_lens, replace(self.shot, lens=lens)
        for parameter in LensParameter:
            value = getattr(lens, parameter)
            if shot.curves.of(parameter).keys and value != getattr(old_lens, parameter):
                shot = shot.with_lens_value(self.frame, parameter, value, self.auto_key)
        return shot

    def do(self, shot: Shot) -> None:
        """Change the shot as an undo step of its own; end a gesture, and drop tried values."""
        self._trial_lens = None
        self.history = self.history.end_gesture().with_current(shot).end_gesture()

    def amend(self, change: Callable[[Shot], Shot]) -> None:
        """Put new measurements into the shot and all steps of undo and redo, without a step."""
        self.history = self.history.changed_by(change)

    def settle(self) -> None:
        """Record the changes so far as an undo step."""
        self.history = self.history.end_gesture()

    def settle_if_resting(self, is_pressed: bool) -> None:
        """End a gesture, as an undo step, and a performance that rest; once a frame."""
        now_s, performance = self.clock(), self.performance
        if not is_pressed and now_s - self._changed_at > _GESTURE_REST_S:
            self.history = self.history.end_gesture()
        if performance is not None and performance.is_over and not is_pressed:
            if now_s - performance.moved_at > _GESTURE_REST_S:
                self.performance = None

    @property
    def is_unsettled(self) -> bool:
        """True while a gesture or a performance has not become an undo step."""
        is_ending = self.performance is not None and self.performance.is_over
        return is_ending or self.history.current != self.history.last_step

    def toggle_auto_key(self) -> None:
        """Turn auto key on or off, with which a change of a keyed parameter sets a key."""
        self.auto_key = not self.auto_key

    def undo(self) -> None:
        """Undo one step, and drop tried values."""
        self._trial_lens = None
        self.history = self.history.undo()

    def redo(self) -> None:
        """Redo one step, and drop tried values."""
        self._trial_lens = None
        self.history = self.history.redo()
