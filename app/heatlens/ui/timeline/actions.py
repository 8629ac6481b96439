"""Build the actions of the timeline."""

from collections.abc import Callable
from functools import partial

from imgui_bundle import imgui

from heatlens.model.interpolation import Interpolation
from heatlens.session.session import Session
from heatlens.ui.actions import CTRL, SHIFT, Action

_K = imgui.Key
_BOTH = CTRL | SHIFT


def play_actions(session: Session, open_frames: Callable[[], None]) -> list[Action]:
    """Return the actions of the playhead and of rendered frames."""
    time, pull = session.time.timeline, session.time.pull
    return [
        Action("Play or stop", "Play", partial(time.play, 1), _K.space),
        Action("Play backwards", "Play", partial(time.play, -1), _K.space | SHIFT),
        Action("Next frame", "Play", partial(time.step, 1), _K.right_arrow, repeats=True),
        Action("Previous frame", "Play", partial(time.step, -1), _K.left_arrow, repeats=True),
        Action("First frame", "Play", partial(time.go_to_end, -1), _K.home),
        Action("Last frame", "Play", partial(time.go_to_end, 1), _K.end),
        Action("Next key", "Play", partial(time.go_to_key, 1), _K.down_arrow),
        Action("Previous key", "Play", partial(time.go_to_key, -1), _K.up_arrow),
        Action("Set in point", "Play", time.set_in, _K.i),
        Action("Set out point", "Play", time.set_out, _K.o),
        Action("Clear in and out", "Play", time.clear_in_out, _K.i | SHIFT),
        Action(
            "Render frames ahead", "Play", pull.switch,
            is_on=lambda: session.preferences.now.keep_frames,
        ),
        Action("Clear rendered frames", "Play", pull.clear),
        Action("Rendered frames...", "Play", open_frames),
    ]  # fmt: skip


def key_actions(session: Session, open_pull: Callable[[], None]) -> list[Action]:
    """Return the actions on keys: the selected ones, or those at the playhead if none are."""
    editing, keys, rows = session.editing, session.time.keys, session.time.keys.rows
    later, earlier = _K.right_arrow | _BOTH, _K.left_arrow | _BOTH
    return [
        Action("Set key", "Animate", keys.set_here, _K.k),
        Action("Delete keys", "Animate", keys.delete, _K.delete),
        Action("Set mark here", "Animate", session.time.marks.set_here, _K.m),
        Action("Pull focus...", "Animate", open_pull, _K.m | SHIFT),
        Action("Reverse the pull", "Animate", session.time.marks.reverse_pull),
        Action(
            "Record a pull", "Animate", session.lens.recording.arm, _K.r | SHIFT,
            barred=lambda: session.lens.recording.why_not,
        ),
        Action("Hold the focus from here", "Animate", session.time.marks.hold_focus, _K.h),
        Action(
            "Auto key", "Animate", editing.toggle_auto_key, _K.a, is_on=lambda: editing.auto_key
        ),
        Action("Select all keys", "Animate", keys.choose_all, _K.a | _BOTH),
        Action("Copy keys", "Animate", keys.copy, _K.c | _BOTH),
        Action("Paste keys", "Animate", keys.paste, _K.v | _BOTH),
        Action("Move keys later", "Animate", partial(keys.move, 1), later, repeats=True),
        Action("Move keys earlier", "Animate", partial(keys.move, -1), earlier, repeats=True),
        *(
            Action(f"Interpolate {how} after key", "Animate", partial(keys.interpolate, how))
            for how in Interpolation
        ),
        Action(
            "Show curve", "Animate", rows.toggle_curve, _K.c | SHIFT,
            is_on=lambda: rows.shows_curve,
        ),
    ]  # fmt: skip
